"""Measures TAB completion on a tree of a thousand components and on an empty one."""

from __future__ import annotations

import os
import sys

from bench.harness import Lines, Row, command, create, folders, manager, process
from bench.pairs import paired
from bench.query import FLOOR_IS, floor
from rtkit.tree.client import Tree

_BREAKS = " \t\n\"'><=;|&(:"
_CLICK = [sys.executable, "-c", "import click"]
_CLICK_IS = "python -c: import click"
_COUNT = 1000
_WITHIN_MS = 150.0
_SILENT_MS = 300.0
_LINES = {
    "a component": "rtls /localhost/N98",
    "a port": "rtcat /localhost/N1.rtc:",
    "what fits a port": "rtcon /localhost/N1.rtc:out /localhost/N98",
    "what can be activated": "rtact /localhost/N98",
    "a parameter": "rtconf /localhost/N1.rtc get ",
    "a connector": "rtdis -i ",
}


def _thousand() -> Lines:
    with manager() as tree:
        _fill(tree)
        bare = floor(tree)
        for what, line in _LINES.items():
            yield _row(f"TAB for {what}, 1,000 components", line, bare, _WITHIN_MS, FLOOR_IS)
        line = "rtls --"
        yield _row("TAB for an option", line, _CLICK, _WITHIN_MS, _CLICK_IS)


def _nobody() -> Lines:
    with folders():
        line = "rtls /localhost/"
        # Nothing is offered, so the status is 1: a shell looks at it as little as this does.
        ours = ["/bin/sh", "-c", '"$0" "$@" 2>/dev/null || true', *_asked(line)]
        yield _measured("TAB without a manager", ours, _CLICK, _SILENT_MS, _CLICK_IS)


def _fill(tree: Tree) -> None:
    kinds = ("ConsoleOut", "ConsoleIn")
    create(tree, [f"{kinds[i % 2]}?instance_name=N{i}" for i in range(1, _COUNT + 1)])
    for index in range(1, _COUNT, 10):
        tree.connect(f"/localhost/N{index}.rtc:out", f"/localhost/N{index + 1}.rtc:in")


def _asked(line: str) -> list[str]:
    os.environ["RTKIT_COMPLETION_TIMEOUT"] = "20"
    return [command("rtkit"), "complete", "bash", "9", _BREAKS, line]


def _row(what: str, line: str, bare: list[str], target: float, floor_is: str) -> Row:
    return _measured(what, _asked(line), bare, target, floor_is)


def _measured(what: str, ours: list[str], bare: list[str], target: float, floor_is: str) -> Row:
    measured = paired(lambda: process(ours), lambda: process(bare))
    return Row(f"{what}, whole process", "ms", measured, target, False, floor_is)


PARTS = {"thousand": _thousand, "nobody": _nobody}
