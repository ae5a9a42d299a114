"""Measures ways to launch components, here and on another host: Table 3 of the deployment paper.

By command, each component by one of its own or all by one; over ssh by hand, which is a login on a
terminal and a command typed for each; over ssh by script, all in one login or, as scripts that
launch robots do it, by a login for each. The operator types without thinking.
Milliseconds per component, until its command is back, which is when it is Inactive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from typing import NamedTuple

from bench import far
from bench.harness import (
    Lines,
    Missing,
    Row,
    columns,
    command,
    folders,
    manager,
    process,
    remove,
    timed,
    until_listed,
)
from bench.pairs import medians
from bench.query import floor
from bench.sshd import Login, NoServer, server
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect, connect_far

_ROUNDS = 5
_COUNTS = (1, 10)
_EACH, _ALL, _HAND, _SCRIPT, _LOGINS = (
    "rtmgr, one command each",
    "rtmgr, one command",
    "ssh, by hand",
    "ssh, by script",
    "ssh, by script, a login each",
)
_OVER_SSH = (_HAND, _SCRIPT, _LOGINS)
_METHODS = (_EACH, _ALL, *_OVER_SSH)
_HERE, _THERE = "Table 3", "Table 3, another host"
_PLACES = ("same process", "own processes")
_LOCAL = "/localhost/manager.mgr"
_QUERY_IS = "as many bare Python processes that import click and socket and ask one thing"
_LOGIN_IS = "as many ssh logins that do nothing, and those"
Cell = tuple[str, str, int]
Launch = Callable[[list[str]], object]


class _Site(NamedTuple):
    """Where components are launched: the manager, by its path here, and how to log in there."""

    table: str
    tree: Tree
    path: str
    program: str
    login: Login | None


def _cells() -> Iterable[Cell]:
    return ((m, place, count) for m in _METHODS for place in _PLACES for count in _COUNTS)


def _name(table: str, cell: Cell) -> str:
    method, place, count = cell
    return f"{table}: {method}, {place}, {count} component{'s' if count > 1 else ''}, each"


def _launches() -> Lines:
    with ExitStack() as stack:
        base = stack.enter_context(folders())
        tree = stack.enter_context(manager())
        login, missing = None, ""
        try:
            login = stack.enter_context(server(base))
        except NoServer as error:
            missing = str(error)
        site = _Site(_HERE, tree, _LOCAL, command("rtmgr"), login)
        yield from _rows(site, floor(tree), missing)


def _remote() -> Lines:
    if why := far.missing():
        yield from (Missing(_name(_THERE, cell), why) for cell in _cells())
        return
    with far.hosts(1) as hosts, far.linked(hosts), connect() as near, connect_far("b0", "") as tree:
        site = _Site(_THERE, tree, "/b0/manager.mgr", far.PROGRAM, far.login(hosts[0]))
        yield from _rows(site, floor(near), "")


def _rows(site: _Site, bare: list[str], missing: str) -> Lines:
    measured = _measure(site, bare)
    for cell in _cells():
        name = _name(site.table, cell)
        if cell in measured:
            floor_is = _LOGIN_IS if cell[0] in _OVER_SSH else _QUERY_IS
            yield Row(name, "ms", medians(measured[cell]), None, True, floor_is)
        else:
            yield Missing(name, missing)


def _ways(site: _Site) -> dict[str, Launch]:
    def one_by_one(texts: list[str]) -> None:
        for text in texts:
            process(_line(site.path, [text]))

    def quoted(text: str) -> str:
        return f"{site.program} {_LOCAL} -c '{text}'\n"

    ways: dict[str, Launch] = {
        _EACH: one_by_one,
        _ALL: lambda texts: process(_line(site.path, texts)),
    }
    if (login := site.login) is not None:
        ways[_HAND] = lambda texts: login.type([quoted(text).strip() for text in texts])
        ways[_SCRIPT] = lambda texts: login.script("".join(map(quoted, texts)))
        ways[_LOGINS] = lambda texts: [*map(login.script, map(quoted, texts))]
    return ways


def _measure(site: _Site, bare: list[str]) -> dict[Cell, list[tuple[float, float]]]:
    """Let all ways take turns, each beside what it cannot be faster than."""
    ways, login = _ways(site), site.login
    measured: dict[Cell, list[tuple[float, float]]] = {}
    for number in range(_ROUNDS + 1):
        query_ms = process(bare)
        login_ms = timed(lambda: login.script("")) if login is not None else 0.0
        for cell in _cells():
            method, place, count = cell
            if method not in ways:
                continue
            each_ms = _launch(site.tree, ways[method], place, count) / count
            commands = 1 if method == _ALL else count
            logins = (count if method == _LOGINS else 1) * (method in _OVER_SSH)
            least_ms = commands * query_ms + logins * login_ms
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


def _line(path: str, texts: list[str]) -> list[str]:
    line = [command("rtmgr"), path]
    for text in texts:
        line += ["-c", text]
    return line


PARTS = {"launches": _launches, "remote": _remote}


def pivots(rows: Sequence[Row | Missing]) -> str:
    """Return what was measured, here and on another host, as a table each; nothing of nothing."""
    return pivot(rows, _HERE) + pivot(rows, _THERE)


def pivot(rows: Sequence[Row | Missing], table: str = _HERE) -> str:
    """Return what was measured as one table, nothing if that is nothing."""
    metrics = {row.what: row.measured.figure for row in rows if isinstance(row, Row)}
    if not any(_name(table, cell) in metrics for cell in _cells()):
        return ""
    heads = [f"{count}, {place}" for count in _COUNTS for place in _PLACES]
    cells = [("ms per component", *heads)]
    for method in _METHODS:
        names = [_name(table, (method, place, count)) for count in _COUNTS for place in _PLACES]
        shown = [f"{metrics[n]:.0f}" if n in metrics else "not measured" for n in names]
        cells.append((method, *shown))
    return f"\n{table}\n{columns(cells)}\n"
