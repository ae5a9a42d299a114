"""Whole commands against a bare Python process that asks the manager the same question."""

from __future__ import annotations

from bench.harness import Lines, Row, command, create, manager, paired, process
from bench.query import FLOOR_IS, floor
from rtkit.tree.client import Tree


def _reading() -> Lines:
    with manager() as tree:
        bare = floor(tree)
        rtls = [command("rtls"), "/localhost"]
        long = [command("rtls"), "-l", "/localhost"]
        _fill(tree, 10)
        yield _against_floor("rtls, 10 components", rtls, bare, 1.25)
        yield _against_floor("rtls -l, 10 components", long, bare, None)
        _fill(tree, 1000)
        yield _against_floor("rtls, 1,000 components", rtls, bare, 1.6)
        yield _against_floor("rtls -l, 1,000 components", long, bare, None)


def _creating() -> Lines:
    with manager() as tree:
        rtls = [command("rtls"), "/localhost"]
        _fill(tree, 10)
        yield _create(tree, rtls, "one component, one command, in the manager", "", 1.3)
        yield _create(tree, rtls, "one component, one command, new slave", "&manager_name=s", 1.6)


PARTS = {"reading": _reading, "creating": _creating}


def _fill(tree: Tree, count: int) -> None:
    have = len(tree.listing().rows)
    create(tree, ["ConsoleIn"] * (count - have))


def _against_floor(what: str, ours: list[str], bare: list[str], target: float | None) -> Row:
    measured = paired(lambda: process(ours), lambda: process(bare))
    return Row(f"{what}, whole process", "ms", *measured, target, True, FLOOR_IS)


def _create(tree: Tree, rtls: list[str], what: str, place: str, target: float) -> Row:
    text = f"ConsoleIn?instance_name=New{place}"
    ours = [command("rtmgr"), "/localhost/manager.mgr", "-c", text]

    def create_one() -> float:
        elapsed_ms = process(ours)
        tree.delete("/localhost/New.rtc")
        return elapsed_ms

    measured = paired(create_one, lambda: process(rtls))
    return Row(f"{what}, whole process", "ms", *measured, target, True, "rtls")
