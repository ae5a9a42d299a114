"""Measures whole commands against a bare Python process that asks the manager the same question.

Commands that *read* change nothing and wait for nothing: they show what the manager knows. The
floor of all of them is one question on one connection. Two kinds have more to do:

- those that read a profile (`rtcheck`, dry runs; `rtdoc`, which looks for one of the component):
  their floor parses such a profile with lxml too, which is the least that can be done with it;
- `rtprint` attaches with a port of its own, connects it and awaits a value: the floor of
  these does none of that, so its ratio is the cost of attaching. The source writes 1,000
  values a second, so that waiting for one is no part of it. `rtwatch` and `rttop` wait for what
  the manager tells once a second; waiting takes no processor time.
"""

from __future__ import annotations

import os
import tempfile

from bench.harness import Lines, Row, command, create, manager, process, work
from bench.pairs import paired
from bench.query import FLOOR_IS, PROFILE_IS, floor
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


_TEN = ("ConsoleIn", "ConsoleOut")
_READERS = {
    "rtls": "rtls /localhost",
    "rtls --json": "rtls --json /",
    "rtls -lR": "rtls -lR /",
    "rtfind": "rtfind / -t c",
    "rtcat, a component": "rtcat /localhost/N0.rtc",
    "rtcat -ll": "rtcat -ll /localhost/N0.rtc",
    "rtcat, a port": "rtcat -l /localhost/N0.rtc:out",
    "rtcat --json": "rtcat --json /localhost/N0.rtc",
    "rtcat, the manager": "rtcat /localhost/manager.mgr",
    "rtconf -l": "rtconf -l /localhost/N0.rtc",
    "rtconf get": "rtconf /localhost/N0.rtc get values",
    "rtmgr -r": "rtmgr -r /localhost/manager.mgr",
    "rtmgr status": "rtmgr status",
    "rtcwd": "rtcwd /localhost",
    "rtwait": "rtwait /localhost/N0.rtc active",
    "rtcryo": "rtcryo -o {folder}/again.xml",
    "rtget": "rtget /localhost/N0.rtc.state",
    "rtlisten -n 1": "rtlisten -n 1 /localhost/N0.rtc.state",
    "rtwatch -n 1": "rtwatch -n 1 -f HEARTBEAT /localhost/N0.rtc",
    "rtvlog --no-follow": "rtvlog --no-follow /localhost/manager.mgr",
    "rttop --once": "rttop --once",
    "rtdoctor": "rtdoctor",
    "rtlog --info": "rtlog --info -f {folder}/one.mcap",
    "rtprint -n 1": "rtprint -n 1 /localhost/N0.rtc:out",
}
_PROFILE_READERS = {
    "rtcheck": "rtcheck {profile}",
    "rtcheck --static": "rtcheck --static {profile}",
    "rtdoc": "rtdoc -f text /localhost/N0.rtc",
    "rtstodot": "rtstodot {profile}",
    "rtprofile show": "rtprofile show {profile}",
    "rtstate": "rtstate {profile}",
    "rtplan": "rtplan {profile}",
    "rtapply --dry-run": "rtapply --dry-run {profile}",
    "rtresurrect --dry-run": "rtresurrect --dry-run {profile}",
    "rtstart --dry-run": "rtstart --dry-run {profile}",
    "rtstop --dry-run": "rtstop --dry-run {profile}",
    "rtteardown --dry-run": "rtteardown --dry-run {profile}",
}
_BOUND = 1.35
_ROUNDS = 7


def _readers() -> Lines:
    """Every command that reads, on ten components, in processor time."""
    with manager() as tree, tempfile.TemporaryDirectory() as folder:
        profile = os.path.join(folder, "ten.xml")
        _make_ten(tree)
        for line in (
            f"rtcryo --all -o {profile}",
            f"rtstart {profile}",
            f"rtlog -t 1 -f {folder}/one.mcap /localhost/N0.rtc:out",
        ):
            name, *arguments = line.split()
            work([command(name), *arguments])
        _tell_states(profile)
        for what, line in _READERS.items():
            yield _worked(what, line.format(folder=folder), floor(tree), FLOOR_IS)
        for what, line in _PROFILE_READERS.items():
            yield _worked(what, line.format(profile=profile), floor(tree, profile), PROFILE_IS)


def _make_ten(tree: Tree) -> None:
    rates = [f"&exec_cxt.periodic.rate={1000 if i == 0 else 10}" for i in range(10)]
    create(tree, [f"{_TEN[i % 2]}?instance_name=N{i}{rate}" for i, rate in enumerate(rates)])
    for i in range(2, 10, 2):  # the fast source alone, so that no sink logs all that it writes
        tree.connect(f"/localhost/N{i}.rtc:out", f"/localhost/N{i + 1}.rtc:in")


def _tell_states(profile: str) -> None:
    """Have the system of a profile tell one state, which it is in."""
    told = {"rtkit.states": "on", "rtkit.state.on": "*=Active"}
    lines = [f'<rtsExt:Properties rtsExt:name="{k}" rtsExt:value="{v}"/>' for k, v in told.items()]
    with open(profile, encoding="utf-8") as file:
        text = file.read()
    with open(profile, "w", encoding="utf-8") as file:
        file.write(text.replace("</rts:RtsProfile>", "\n".join([*lines, "</rts:RtsProfile>"])))


def _worked(what: str, line: str, bare: list[str], floor_is: str) -> Row:
    name, *arguments = line.split()
    ours = [command(name), *arguments]
    measured = paired(lambda: work(ours), lambda: work(bare), _ROUNDS)
    return Row(f"{what}, 10 components, processor time", "ms", measured, _BOUND, True, floor_is)


PARTS = {"reading": _reading, "readers": _readers, "creating": _creating}


def _fill(tree: Tree, count: int) -> None:
    have = len(tree.listing().rows)
    create(tree, ["ConsoleIn"] * (count - have))


def _against_floor(what: str, ours: list[str], bare: list[str], target: float | None) -> Row:
    measured = paired(lambda: process(ours), lambda: process(bare))
    return Row(f"{what}, whole process", "ms", measured, target, True, FLOOR_IS)


def _create(tree: Tree, rtls: list[str], what: str, place: str, target: float) -> Row:
    text = f"ConsoleIn?instance_name=New{place}"
    ours = [command("rtmgr"), "/localhost/manager.mgr", "-c", text]

    def create_one() -> float:
        elapsed_ms = process(ours)
        tree.delete("/localhost/New.rtc")
        return elapsed_ms

    measured = paired(create_one, lambda: process(rtls))
    return Row(f"{what}, whole process", "ms", measured, target, True, "rtls")
