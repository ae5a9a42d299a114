"""Changes in a source that 2to3 leaves out: divisions, texts that were decoded, gone functions."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import NamedTuple

from rtkit.openrtm.integers import divisions
from rtkit.openrtm.python2 import TOKEN

_OF_CONFIGPARSER = {"SafeConfigParser": "ConfigParser", "readfp": "read_file"}
"""Names that module configparser had until Python 3.12."""


class Edit(NamedTuple):
    """A text in place of another one, by offsets in the UTF-8 of the source [bytes]."""

    begin: int
    end: int
    text: str


class Remark(NamedTuple):
    """Place that a person should look at."""

    line: int
    text: str


def edited(text: str, tree: ast.Module, *, divides_whole: bool) -> tuple[str, list[Remark]]:
    """Return a source with these changes, and what is left to look at.

    Args:
        text: Of Python 3.
        tree: The same, parsed.
        divides_whole: In it ``/`` of two whole numbers has rounded down so far.
    """
    data = text.encode()
    places = _Places(data)
    edits, remarks = list(_renamed(tree, places)), list(_remarks(tree))
    edits += _decoded(tree, places)
    if divides_whole:
        for each in divisions(tree):
            if each.is_of_integers:
                edits.append(places.operator(each.node))
            elif each.is_open:
                why = "/ may have divided whole numbers, which Python 2 rounds down"
                remarks.append(Remark(each.node.lineno, why))
    for edit in sorted(edits, reverse=True):
        data = data[: edit.begin] + edit.text.encode() + data[edit.end :]
    return data.decode(), sorted(set(remarks))


class _Places:
    """Offsets of expressions in the UTF-8 of a source."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._lines = [0]
        for line in data.split(b"\n"):
            self._lines.append(self._lines[-1] + len(line) + 1)

    def begin(self, node: ast.expr) -> int:
        """Return where an expression begins."""
        return self._lines[node.lineno - 1] + node.col_offset

    def end(self, node: ast.expr) -> int:
        """Return where an expression ends."""
        return self._lines[(node.end_lineno or 1) - 1] + (node.end_col_offset or 0)

    def text(self, node: ast.expr) -> str:
        """Return an expression as it is written."""
        return self._data[self.begin(node) : self.end(node)].decode()

    def operator(self, node: ast.BinOp) -> Edit:
        """Return the change of a ``/`` into ``//``; there may be comments around it."""
        begin, end = self.end(node.left), self.begin(node.right)
        between = self._data[begin:end].decode("latin-1")
        bare = TOKEN.sub(lambda match: " " * len(match[0]), between)
        at = begin + bare.index("/")
        return Edit(at, at + 1, "//")


def _decoded(tree: ast.Module, places: _Places) -> Iterator[Edit]:
    """Yield changes of ``unicode(x, encoding)``: what it decoded may be text already.

    `str` took one argument in Python 2, so that one with two was `unicode`.
    """
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name(id="str"), args=[value, _, *_]) if _is_simple(value):
                begin, end = places.begin(node), places.end(node)
                name = places.text(value)
                text = f"({name} if isinstance({name}, str) else {places.text(node)})"
                yield Edit(begin, end, text)


def _is_simple(node: ast.expr) -> bool:
    """Return whether an expression may be evaluated twice."""
    match node:
        case ast.Name():
            return True
        case ast.Attribute(value=value):
            return _is_simple(value)
        case ast.Subscript(value=value, slice=ast.Constant() | ast.Name()):
            return _is_simple(value)
    return False


def _renamed(tree: ast.Module, places: _Places) -> Iterator[Edit]:
    """Yield changes of names that module configparser has no more."""
    if not any(_imports(node, "configparser") for node in ast.walk(tree)):
        return
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name) if name in _OF_CONFIGPARSER:
                end = places.end(node)
                yield Edit(end - len(name), end, _OF_CONFIGPARSER[name])
            case ast.Name(id="SafeConfigParser"):
                yield Edit(places.begin(node), places.end(node), "ConfigParser")
            case ast.ImportFrom(module="configparser", names=names):
                for each in names:
                    if each.name == "SafeConfigParser":
                        begin = places.begin(each)  # type: ignore[arg-type]  # has a place, too
                        yield Edit(begin, begin + len(each.name), "ConfigParser")


def _imports(node: ast.AST, module: str) -> bool:
    match node:
        case ast.Import(names=names):
            return any(each.name == module for each in names)
        case ast.ImportFrom(module=name):
            return name == module
    return False


def _remarks(tree: ast.Module) -> Iterator[Remark]:
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names) if any(each.name == "imp" for each in names):
                yield Remark(node.lineno, "Python 3.12 has no imp: importlib takes its place")
            case ast.Call(func=ast.Attribute(attr="encode" | "decode" as name)):
                why = f"{name}: texts and bytes are two kinds in Python 3"
                yield Remark(node.lineno, why)
