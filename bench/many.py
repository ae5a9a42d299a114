"""Measures many components: a thousand in ten processes, one command for a hundred."""

from __future__ import annotations

from collections.abc import Callable

from bench.harness import Lines, Row, command, create, manager, process, remove, timed, until_listed
from bench.launch import made
from bench.pairs import paired
from bench.query import FLOOR_IS, floor
from rtkit.tree.client import Tree

_MADE_IS = "the same components made by a plain loop in one process"
_ONE_IS = "the same command for one of them"


def _thousand() -> Lines:
    texts = [f"ConsoleIn?instance_name=N{i}&manager_name=n{i % 10}" for i in range(1000)]
    with manager() as tree:

        def up() -> None:
            create(tree, texts)
            until_listed(tree, len(texts))

        def up_s() -> float:
            elapsed_s = timed(up) / 1e3
            remove(tree, len(texts))
            return elapsed_s

        measured = paired(up_s, lambda: made(len(texts)) / 1e3, 5)
        what = "1,000 components in 10 slaves, one call, until all are Inactive"
        yield Row(what, "s", measured, 3.0, False, _MADE_IS)
        up()
        ours, bare = [command("rtls"), "-lR", "/localhost"], floor(tree)
        measured = paired(lambda: process(ours), lambda: process(bare))
        what = "rtls -lR, 1,000 components in 10 slaves, whole process"
        yield Row(what, "ms", measured, 2.0, True, FLOOR_IS)


def _state() -> Lines:
    places: tuple[tuple[str, Callable[[int], str]], ...] = (
        ("in the manager", lambda index: ""),
        ("in 10 slaves", lambda index: f"&manager_name=n{index % 10}"),
        ("own slave each", lambda index: f"&manager_name=n{index}"),
    )
    for name, place in places:
        with manager() as tree:
            create(tree, [f"ConsoleIn?instance_name=N{i}{place(i)}" for i in range(100)])
            until_listed(tree, 100)
            yield _state_row(tree, f"rtact and rtdeact of 100 components, {name}, whole process")


def _state_row(tree: Tree, what: str) -> Row:
    paths = [f"/localhost/N{index}.rtc" for index in range(100)]

    def change(paths: list[str]) -> float:
        there, back = process([command("rtact"), *paths]), process([command("rtdeact"), *paths])
        return (there + back) / 2

    measured = paired(lambda: change(paths), lambda: change(paths[:1]), 15)
    return Row(what, "ms", measured, 3.0, True, _ONE_IS)


PARTS = {"thousand": _thousand, "state": _state}
