"""Measures four ways to launch components: the rows of Table 3 of the paper on deployment.

By command, each component by one of its own or all by one; over ssh by hand, which is a login on a
terminal and a command typed for each, and over ssh by script. The operator types without thinking.
Milliseconds per component, until its command is back, which is when it is Inactive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack

from bench.harness import (
    Lines,
    Missing,
    Row,
    columns,
    command,
    folders,
    manager,
    medians,
    process,
    remove,
    timed,
    until_listed,
)
from bench.query import floor
from bench.sshd import Login, NoServer, server
from rtkit.tree.client import Tree

_ROUNDS = 5
_COUNTS = (1, 10)
_EACH, _ALL, _HAND, _SCRIPT = (
    "rtmgr, one command each",
    "rtmgr, one command",
    "ssh, by hand",
    "ssh, by script",
)
_OVER_SSH = (_HAND, _SCRIPT)
_METHODS = (_EACH, _ALL, _HAND, _SCRIPT)
_PLACES = ("same process", "own processes")
_QUERY_IS = "as many bare Python processes that import click and zenoh and ask one query"
_LOGIN_IS = "one ssh login that does nothing, and those"
Cell = tuple[str, str, int]
Launch = Callable[[list[str]], object]


def _cells() -> Iterable[Cell]:
    return ((m, place, count) for m in _METHODS for place in _PLACES for count in _COUNTS)


def _name(cell: Cell) -> str:
    method, place, count = cell
    return f"Table 3: {method}, {place}, {count} component{'s' if count > 1 else ''}, each"


def _launches() -> Lines:
    with ExitStack() as stack:
        base = stack.enter_context(folders())
        tree = stack.enter_context(manager())
        ways: dict[str, Launch] = {_EACH: _one_by_one, _ALL: _at_once}
        missing = ""
        login = None
        try:
            login = stack.enter_context(server(base))
        except NoServer as error:
            missing = str(error)
        else:
            ways[_HAND] = lambda texts: login.type([" ".join(_quoted(t)) for t in texts])
            ways[_SCRIPT] = lambda texts: login.script(_script(texts))
        measured = _measure(tree, ways, login)
    for cell in _cells():
        if cell in measured:
            floor_is = _LOGIN_IS if cell[0] in _OVER_SSH else _QUERY_IS
            yield Row(_name(cell), "ms", *medians(measured[cell]), None, True, floor_is)
        else:
            yield Missing(_name(cell), missing)


def _measure(
    tree: Tree, ways: dict[str, Launch], login: Login | None
) -> dict[Cell, list[tuple[float, float]]]:
    """Let all ways take turns, each beside what it cannot be faster than."""
    bare = floor(tree)
    measured: dict[Cell, list[tuple[float, float]]] = {}
    for number in range(_ROUNDS + 1):
        query_ms = process(bare)
        login_ms = timed(lambda: login.script("")) if login is not None else 0.0
        for cell in _cells():
            method, place, count = cell
            if method not in ways:
                continue
            each_ms = _launch(tree, ways[method], place, count) / count
            commands = 1 if method == _ALL else count
            least_ms = commands * query_ms + (login_ms if method in _OVER_SSH else 0.0)
            if number:  # the first round is a warm-up
                measured.setdefault(cell, []).append((each_ms, least_ms / count))
    return measured


def _launch(tree: Tree, way: Launch, place: str, count: int) -> float:
    apart = place == _PLACES[1]
    suffixes = [f"&manager_name=n{index}" if apart else "" for index in range(count)]
    texts = [f"ConsoleIn?instance_name=N{index}{suffixes[index]}" for index in range(count)]
    elapsed_ms = timed(lambda: way(texts))
    until_listed(tree, count)
    remove(tree, count)
    return elapsed_ms


def _line(texts: list[str]) -> list[str]:
    line = [command("rtmgr"), "/localhost/manager.mgr"]
    for text in texts:
        line += ["-c", text]
    return line


def _one_by_one(texts: list[str]) -> None:
    for text in texts:
        process(_line([text]))


def _at_once(texts: list[str]) -> None:
    process(_line(texts))


def _quoted(text: str) -> list[str]:
    return [command("rtmgr"), "/localhost/manager.mgr", "-c", f"'{text}'"]


def _script(texts: list[str]) -> str:
    return "".join(f"{' '.join(_quoted(text))}\n" for text in texts)


PARTS = {"launches": _launches}


def pivot(rows: Sequence[Row | Missing]) -> str:
    """Return what was measured as one table, nothing if that is nothing."""
    metrics = {row.what: row.figure for row in rows if isinstance(row, Row)}
    if not any(_name(cell) in metrics for cell in _cells()):
        return ""
    heads = [f"{count}, {place}" for count in _COUNTS for place in _PLACES]
    cells = [("ms per component", *heads)]
    for method in _METHODS:
        names = [_name((method, place, count)) for count in _COUNTS for place in _PLACES]
        shown = [f"{metrics[n]:.0f}" if n in metrics else "not measured" for n in names]
        cells.append((method, *shown))
    return f"\nTable 3\n{columns(cells)}\n"
