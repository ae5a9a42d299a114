"""Measures ten thousand components in a hundred slaves, and what each further thousand costs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from bench.harness import (
    Lines,
    Missing,
    Row,
    columns,
    command,
    create,
    manager,
    process,
    timed,
    until_listed,
)
from bench.launch import made
from bench.pairs import paired
from bench.query import FLOOR_IS, floor
from rtkit.deployment.actions import Action, Delete, SetParameters
from rtkit.tree import managers
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

COUNT = 10_000
_SLAVES = 100
_STEPS = (0, 1000, 2000, 4000, 6000, 8000, COUNT)
"""How many components there are when further ones are measured."""
_FLAT = 1.3
"""How much more a component may cost than the first ones did."""
_BATCH = 100
_THERE = " others there"
_BAR, _LONGEST_BAR = 20, 60
"""Of a bar: its length where nothing more is taken than by the first component, and at most."""
_PATIENCE_S = 120.0
_OTHER = "few"
_MADE_IS = "the same components made by a plain loop in one process"
_FEW_IS = f"the same at a manager with no others than one in each of {_SLAVES} slaves"


def _launched() -> Lines:
    texts = [_text("N", index) for index in range(COUNT)]
    with manager() as tree:

        def up() -> None:
            create(tree, texts)
            until_listed(tree, COUNT)

        def up_s() -> float:
            elapsed_s = timed(up) / 1e3
            _remove(tree, "N", range(COUNT))
            return elapsed_s

        measured = paired(up_s, lambda: made(COUNT) / 1e3, 2, warm_up=0)
        what = f"{COUNT:,} components in {_SLAVES} slaves"
        yield Row(f"{what}, one call, until all are Inactive", "s", measured, 10.0, False, _MADE_IS)
        up()
        ours, bare = [command("rtls"), "-lR", "/localhost"], floor(tree)

        def after_change_ms() -> float:
            tree.perform(SetParameters("N0", "default", {}))  # no text of before is of use
            return process(ours)

        measured = paired(after_change_ms, lambda: process(bare), 7)
        what = f"rtls -lR, {what}, after a change, whole process"
        yield Row(what, "ms", measured, 600.0, False, FLOOR_IS)


def _curve() -> Lines:
    with manager() as many, _few() as few:
        for tree in (many, few):
            create(tree, [_text("A", index) for index in range(_SLAVES)])
        for before, there in zip((0, *_STEPS), _STEPS, strict=False):
            for begin in range(before, there, 1000):
                create(many, [_text("N", index) for index in range(begin, begin + 1000)])
            yield _flat_row(many, few, f"a component by a call of {_BATCH}", there, _by_call, 7)
            yield _flat_row(many, few, "a component by one rtmgr", there, _by_command, 9)


def _flat_row(
    many: Tree, few: Tree, what: str, there: int, add: Callable[[Tree], float], rounds: int
) -> Row:
    measured = paired(lambda: add(many), lambda: add(few), rounds)
    return Row(f"{what}, {there:,}{_THERE}", "ms", measured, _FLAT, True, _FEW_IS)


def curves(rows: Sequence[Row | Missing]) -> str:
    """Return how the cost of one more component grows, as bars; nothing of nothing."""
    found = [row for row in rows if isinstance(row, Row) and row.what.endswith(_THERE)]
    cells: list[tuple[str, str, str]] = []
    title = ""
    for row in found:
        what, _, there = row.what.removesuffix(_THERE).partition(", ")
        if what != title:
            cells.append((title := what, "", ""))
        bar = "█" * min(round(row.measured.ratio * _BAR), _LONGEST_BAR)
        cells.append((f"{there:>8}", f"{row.measured.ratio:.2f} x", bar))
    return f"\n{columns(cells)}\n" if cells else ""


def _by_call(tree: Tree) -> float:
    """Return how long a component takes, of a hundred in as many slaves [ms]."""
    elapsed_ms = timed(lambda: create(tree, [_text("M", index) for index in range(_BATCH)]))
    _remove(tree, "M", range(_BATCH))
    return elapsed_ms / _BATCH


def _by_command(tree: Tree) -> float:
    """Return how long a whole command takes that makes one component [ms]."""
    path = f"/localhost/{tree.manager}.mgr"
    elapsed_ms = process([command("rtmgr"), "-c", _text("M", 0), path])
    _remove(tree, "M", range(1))
    return elapsed_ms


@contextmanager
def _few() -> Iterator[Tree]:
    """Run a second manager beside the usual one."""
    process([command("rtmgr"), "start", _OTHER, "--no-door"])
    try:
        with connect(_OTHER) as tree:
            yield tree
    finally:
        managers.stop(_OTHER, _PATIENCE_S)


def _text(prefix: str, index: int) -> str:
    return f"ConsoleIn?instance_name={prefix}{index}&manager_name=n{index % _SLAVES}"


def _remove(tree: Tree, prefix: str, numbers: Sequence[int]) -> None:
    actions: list[Action] = [Delete(f"{prefix}{index}") for index in numbers]
    for result in tree.apply(actions, is_ordered=False, timeout_s=_PATIENCE_S):
        result.raise_for_error()


PARTS = {"launched": _launched, "curve": _curve}
