"""Edits a source by places of its syntax tree: what no edit touches keeps layout and comments."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator
from typing import Any

_PASS = "pass"


def parsed(text: str) -> ast.Module:
    """Return the syntax tree of a source, without warnings about its style."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ast.parse(text)


class SourceEdits:
    """A source, its syntax tree, and replacements for parts of it.

    An edit around others replaces them too; its text is made by `render`, which has them applied.

    Attributes:
        tree: The syntax tree.
        removed: Statements that are left out.
    """

    def __init__(self, text: str) -> None:
        self.tree = parsed(text)
        self._data = text.encode()
        self._starts = [0]
        for line in self._data.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))
        self._edits: dict[tuple[int, int], str] = {}
        self._parents: dict[int, ast.AST] = {}
        self.removed: set[int] = set()
        self._settled: set[int] = set()
        for node in ast.walk(self.tree):
            for child in ast.iter_child_nodes(node):
                self._parents[id(child)] = node

    def parent(self, node: ast.AST) -> ast.AST:
        """Return the node around another; the tree itself around the outermost."""
        return self._parents.get(id(node), self.tree)

    def ancestors(self, node: ast.AST) -> Iterator[ast.AST]:
        """Yield the nodes around another, the nearest first."""
        while node is not self.tree:
            node = self.parent(node)
            yield node

    def statement(self, node: ast.AST) -> ast.stmt:
        """Return the statement that a node is in, or is."""
        for each in (node, *self.ancestors(node)):
            if isinstance(each, ast.stmt):
                return each
        raise ValueError(f"{node} is in no statement")

    def method(self, node: ast.AST) -> ast.FunctionDef | None:
        """Return the outermost function around a node, which for code of a class is its method."""
        found = [each for each in self.ancestors(node) if isinstance(each, ast.FunctionDef)]
        return found[-1] if found else None

    def block(self, statement: ast.stmt) -> list[ast.stmt]:
        """Return the statements among which one stands."""
        return next(each for each in _blocks(self.parent(statement)) if statement in each)

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Return begin and end of a node, decorators included."""
        decorators = getattr(node, "decorator_list", None)
        head: Any = decorators[0] if decorators else node
        begin = self._starts[head.lineno - 1] + head.col_offset - bool(decorators)  # the @
        last: Any = node
        return begin, self._starts[last.end_lineno - 1] + last.end_col_offset

    def place(self, node: ast.AST) -> int:
        """Return where a node begins; a loop of a comprehension begins at its variable."""
        return self.span(node.target if isinstance(node, ast.comprehension) else node)[0]

    def text(self, node: ast.AST) -> str:
        """Return the source of a node as it was."""
        begin, end = self.span(node)
        return self._data[begin:end].decode()

    def render(self, node: ast.AST) -> str:
        """Return the source of a node with all edits inside of it."""
        return self._rendered(*self.span(node), is_part=True)

    def replace(self, node: ast.AST, text: str) -> None:
        """Put a text where a node stands."""
        self._edits[self.span(node)] = text

    def replace_span(self, begin: int, end: int, text: str) -> None:
        """Put a text where a part of the source stands."""
        self._edits[(begin, end)] = text

    def rename(self, node: ast.Attribute, name: str) -> None:
        """Give an attribute another name."""
        end = self.span(node)[1]
        self._edits[(end - len(node.attr.encode()), end)] = name

    def rename_function(self, node: ast.FunctionDef, name: str) -> None:
        """Give a function another name where it is defined."""
        begin = self._starts[node.lineno - 1] + node.col_offset
        found = self._data.index(node.name.encode(), begin + len("def"))
        self._edits[(found, found + len(node.name.encode()))] = name

    def insert_after(self, begin: int, sign: bytes, text: str) -> None:
        """Put a text behind the next sign of the source."""
        place = self._data.index(sign, begin) + len(sign)
        self._edits[(place, place)] = self._edits.get((place, place), "") + text

    def insert_below(self, node: ast.AST, text: str) -> None:
        """Put lines below the line at which a node ends."""
        newline = self._data.find(b"\n", self.span(node)[1])
        place = newline + 1 if newline >= 0 else len(self._data)
        self._edits[(place, place)] = self._edits.get((place, place), "") + text

    def body_text(self, function: ast.FunctionDef) -> str:
        """Return the lines of a function's body with all edits, without its docstring."""
        first = function.body[0]
        begin = self._line_begin(self.span(first)[0])
        if ast.get_docstring(function, clean=False) is not None:
            begin = self._data.find(b"\n", self.span(first)[1]) + 1
        end = self._data.find(b"\n", self.span(function)[1]) + 1 or len(self._data)
        return self._rendered(begin, end)

    def is_renamed(self, node: ast.Attribute) -> bool:
        """Return whether an attribute was given another name."""
        end = self.span(node)[1]
        return (end - len(node.attr.encode()), end) in self._edits

    def is_edited(self, node: ast.AST) -> bool:
        """Return whether a node itself is replaced, or stands in one that is."""
        begin, end = self.span(node)
        return any(first <= begin and end <= last for first, last in self._edits)

    def indent(self, statement: ast.stmt) -> str:
        """Return the blanks before a statement."""
        return " " * statement.col_offset

    def remove(self, statement: ast.stmt) -> None:
        """Leave a statement out; its line too, if nothing else stands there."""
        self.removed.add(id(statement))

    def is_removed(self, node: ast.AST) -> bool:
        """Return whether a node is left out, by itself or with what it is in."""
        return any(id(each) in self.removed for each in (node, *self.ancestors(node)))

    def insert_before(self, statement: ast.stmt, lines: list[str]) -> None:
        """Put lines before a statement, indented as that is."""
        begin = self._line_begin(self.span(statement)[0])
        new = "".join(f"{self.indent(statement)}{line}\n" for line in lines)
        self._edits[(begin, begin)] = self._edits.get((begin, begin), "") + new

    def insert_text(self, statement: ast.stmt, text: str) -> None:
        """Put whole lines before a statement, and before what was put there."""
        begin = self._line_begin(self.span(statement)[0])
        self._edits[(begin, begin)] = text + self._edits.get((begin, begin), "")

    def result(self) -> str:
        """Return the source with all edits."""
        self.settle()
        return self._rendered(0, len(self._data))

    def settle(self) -> None:
        """Make edits of what is left out so far; a block that would be empty passes.

        That of a class, or of the module, is left to those that write something else there.
        """
        for node in ast.walk(self.tree):
            if isinstance(node, (ast.Module, ast.ClassDef)):
                for each in node.body:
                    self._remove_once(each)
                continue
            for block in _blocks(node):
                gone = [each for each in block if id(each) in self.removed - self._settled]
                if gone and all(id(each) in self.removed for each in block):
                    last = gone.pop()
                    self._settled.add(id(last))
                    self.replace(last, _PASS)
                for each in gone:
                    self._remove_once(each)

    def _remove_once(self, statement: ast.stmt) -> None:
        if id(statement) in self.removed - self._settled:
            self._settled.add(id(statement))
            self._remove(statement)

    def _remove(self, statement: ast.stmt) -> None:
        begin, end = self.span(statement)
        first = self._line_begin(begin)
        newline = self._data.find(b"\n", end)
        last = newline + 1 if newline >= 0 else len(self._data)
        rest = self._data[end:last].strip()
        if self._data[first:begin].strip() or (rest and not rest.startswith(b"#")):
            self._edits[(begin, end)] = _PASS
        else:
            self._edits[(first, last)] = self._edits.pop((first, first), "")

    def _line_begin(self, place: int) -> int:
        return self._data.rfind(b"\n", 0, place) + 1

    def _rendered(self, begin: int, end: int, *, is_part: bool = False) -> str:
        parts, place = [], begin
        for (first, last), text in sorted(
            self._edits.items(),
            key=lambda edit: (edit[0][0], edit[0][0] != edit[0][1], -edit[0][1]),
        ):
            if first < place or last > end:
                continue
            if is_part and first == last == begin:
                continue  # lines before the whole
            parts += [self._data[place:first].decode(), text]
            place = last
        return "".join([*parts, self._data[place:end].decode()])


def _blocks(node: ast.AST) -> Iterator[list[ast.stmt]]:
    for name in ("body", "orelse", "finalbody"):
        block = getattr(node, name, None)
        if isinstance(block, list) and block:
            yield block
    for each in (*getattr(node, "handlers", ()), *getattr(node, "cases", ())):
        if isinstance(each, (ast.ExceptHandler, ast.match_case)):
            yield each.body
