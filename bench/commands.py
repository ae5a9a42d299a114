"""Whole commands against a bare Python process that asks the manager the same question."""

from __future__ import annotations

import sys
from collections.abc import Iterator

from bench.harness import Row, command, manager, paired, process
from rtkit.deployment.actions import Action, Create
from rtkit.link import keys, places
from rtkit.tree.client import Tree

_FLOOR_IS = "python -c: import click and zenoh, open a client session, one query, close"
_FLOOR = """
import click, zenoh
c = zenoh.Config()
for k, v in (
    ("mode", '"client"'),
    ("connect/endpoints", '["unixsock-stream/{socket}"]'),
    ("scouting/multicast/enabled", "false"),
    ("scouting/gossip/enabled", "false"),
    ("connect/timeout_ms", "0"),
):
    c.insert_json5(k, v)
s = zenoh.open(c)
for r in s.get(
    "{key}",
    handler=zenoh.handlers.FifoChannel(16),
    consolidation=zenoh.ConsolidationMode.NONE,
    timeout=5.0,
):
    print(len(r.ok.payload.to_string()))
s.close()
"""


def rows() -> Iterator[Row]:
    """Measure listing and creating by command."""
    with manager() as tree:
        listing = keys.extension_key(keys.service(tree.host, tree.manager), "listing")
        script = _FLOOR.format(socket=places.manager_socket(tree.manager), key=listing)
        floor = [sys.executable, "-c", script]
        rtls = [command("rtls"), "/localhost"]

        _fill(tree, 10)
        yield _against_floor("rtls, 10 components", rtls, floor, 1.25)
        long = [command("rtls"), "-l", "/localhost"]
        yield _against_floor("rtls -l, 10 components", long, floor, None)
        yield _create(tree, rtls, "one component, one command, in the manager", "", 1.3)
        yield _create(tree, rtls, "one component, one command, new slave", "&manager_name=s", 1.6)
        _fill(tree, 1000)
        yield _against_floor("rtls, 1,000 components", rtls, floor, 1.6)
        yield _against_floor("rtls -l, 1,000 components", long, floor, None)


def _fill(tree: Tree, count: int) -> None:
    have = len(tree.listing().rows)
    actions: list[Action] = [Create("ConsoleIn") for _ in range(count - have)]
    for result in tree.apply(actions, timeout_s=60.0):
        result.raise_for_error()


def _against_floor(what: str, ours: list[str], floor: list[str], target: float | None) -> Row:
    measured = paired(lambda: process(ours), lambda: process(floor))
    return Row(f"{what}, whole process", "ms", *measured, target, True, _FLOOR_IS)


def _create(tree: Tree, rtls: list[str], what: str, place: str, target: float) -> Row:
    text = f"ConsoleIn?instance_name=New{place}"
    ours = [command("rtmgr"), "/localhost/manager.mgr", "-c", text]

    def create() -> float:
        elapsed_ms = process(ours)
        tree.delete("/localhost/New.rtc")
        return elapsed_ms

    measured = paired(create, lambda: process(rtls))
    return Row(f"{what}, whole process", "ms", *measured, target, True, "rtls")
