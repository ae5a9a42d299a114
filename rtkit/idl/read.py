"""Reads IDL files into declarations."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from rtkit.idl.comments import Comment, Comments
from rtkit.idl.constants import BadConstant, evaluate
from rtkit.idl.model import (
    ArrayOf,
    Attribute,
    Basic,
    BasicKind,
    Constant,
    Declaration,
    Definitions,
    Direction,
    EnumDeclaration,
    EnumValue,
    Field,
    InterfaceDeclaration,
    Named,
    Opaque,
    Operation,
    OperationParameter,
    Path,
    SequenceOf,
    SourceLine,
    StructDeclaration,
    Type,
    Typedef,
    Value,
)
from rtkit.idl.scopes import ResolvedName, Scopes, is_forward
from rtkit.idl.source import Find, IdlSource, InvalidIdl

if TYPE_CHECKING:
    from lark import Token, Tree
    from lark.exceptions import UnexpectedInput

_LONGEST_EXPECTATION = 4
_BROKER = "CORBA"
"""The module whose names every file may use, and which no file defines."""

_INTEGERS = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
"""Types that IDL 4 added; in older files these may be names of something else."""
_OPAQUE = {
    "union": BasicKind.UNION,
    "valuetype": BasicKind.VALUETYPE,
    "native": BasicKind.NATIVE,
    "forward_interface": BasicKind.FORWARD,
    "forward_structure": BasicKind.FORWARD,
    "forward_union": BasicKind.FORWARD,
    "forward_value": BasicKind.FORWARD,
}
"""Rules of the grammar for declarations that are known by name only."""

_UNIT = re.compile(r'@unit\s*\(\s*(?:value\s*=\s*)?"([^"]+)"\s*\)')
_ABOUT_VALUES = ("[", "@range", "@min", "@max")
"""How annotations begin that are kept: those that people read, not generators."""

_WORDS = {
    "CHARACTER": "a character",
    "DIRECTION": "in, out or inout",
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a text",
    "TEXT": "a type",
    "TRUTH": "TRUE or FALSE",
    "WORD": "a type",
}
"""Names in messages of the grammar's terminals that are no fixed words."""


def nothing(_name: str, _file: str) -> None:
    """Find no included file."""


def read_idl(
    text: str, file: str = "<stdin>", find: Find = nothing, known: Container[Path] = ()
) -> Definitions:
    """Read an IDL file and all that it includes.

    Args:
        text: Its content.
        file: Its name, for messages and for `find`.
        find: Gives the text of included files.
        known: Types that need no definition, by path.

    Raises:
        InvalidIdl: It is no IDL, or a name means nothing; tells file and line.
    """
    source = IdlSource(file, text, find)
    tree, comments = _parse(source)
    reader = _Reader(source, comments, known)
    reader.definitions(tree.children, ())
    return Definitions(reader.scopes.declarations, tuple(dict.fromkeys(source.missing)))


@cache
def _parser() -> Any:
    from lark import Lark

    from rtkit.idl.grammar import GRAMMAR

    # The lexer hands comments to the present reader, because the parser itself is made once.
    tokens: list[Token] = []
    parser = Lark(
        GRAMMAR,
        parser="lalr",
        propagate_positions=True,
        maybe_placeholders=True,
        lexer_callbacks={"COMMENT": _keep(tokens)},
    )
    return parser, tokens


def _keep(tokens: list[Token]) -> Callable[[Token], Token]:
    def keep(token: Token) -> Token:
        tokens.append(token)
        return token

    return keep


def _parse(source: IdlSource) -> tuple[Tree[Token], Comments]:
    from lark.exceptions import UnexpectedInput

    parser, tokens = _parser()
    tokens.clear()
    try:
        tree: Tree[Token] = parser.parse(source.text)
    except UnexpectedInput as error:
        raise InvalidIdl(_explain(error, source)) from None
    comments = [Comment(str(token), token.line or 1, token.end_line or 1) for token in tokens]
    return tree, Comments([line.text for line in source.lines], comments)


def _explain(error: UnexpectedInput, source: IdlSource) -> str:
    token = getattr(error, "token", None)
    place = source.place(error.line)
    if token is None:
        return f"{place}: unexpected character {getattr(error, 'char', '')!r}"
    if token.type == "$END":
        return f"{source.place(len(source.lines))}: the file ends too early"
    texts = {each.name: each.pattern.value for each in _parser()[0].terminals}
    expected: list[str] = sorted(getattr(error, "accepts", None) or getattr(error, "expected", []))
    words = [_WORDS.get(name) or repr(texts.get(name, name)) for name in expected if name != "AT"]
    wanted = f"; expected {' or '.join(words)}" if len(words) <= _LONGEST_EXPECTATION else ""
    return f"{place}: unexpected {str(token)!r}{wanted}"


class _Reader:
    """Walks the tree of one text; knows what was declared so far."""

    def __init__(self, source: IdlSource, comments: Comments, known: Container[Path]) -> None:
        self._source = source
        self._comments = comments
        self.scopes = Scopes(known)

    def definitions(self, nodes: list[Any], scope: Path) -> None:
        for node in nodes:
            if node.data in _OPAQUE:
                path, place = (*scope, _name(node.children[0])), self._place(node)
                kind = _OPAQUE[node.data]
                self.scopes.declare(Opaque(path, place, kind, doc=self._doc(node)))
            elif node.data != "annotation":
                getattr(self, f"_{node.data}")(node, scope)

    def _module(self, node: Any, scope: Path) -> None:
        name, *inner = node.children
        path = (*scope, _name(name))
        self.scopes.open_module(path, self._place(node))
        self.definitions(inner, path)

    def _interface(self, node: Any, scope: Path) -> None:
        path, place = self._begin(node, scope)
        bases = tuple(
            self._base(each, scope)
            for part in _parts(node, "inheritance")
            for each in part.children
        )
        self.scopes.inherit(path, bases)
        operations: list[Operation] = []
        attributes: list[Attribute] = []
        for part in node.children[1:]:
            if part.data == "operation":
                operations.append(self._operation(part, path))
            elif part.data == "attribute":
                attributes += self._attribute(part, path)
            elif part.data not in ("inheritance", "annotation"):
                self.definitions([part], path)
        self.scopes.declare(
            InterfaceDeclaration(
                path, place, bases, tuple(operations), tuple(attributes), doc=self._doc(node)
            )
        )

    def _base(self, node: Any, scope: Path) -> Path:
        path = self._look_up(node, scope).path
        known = self.scopes.declarations.get(path)
        if not isinstance(known, InterfaceDeclaration) and not _is_missing(known):
            raise InvalidIdl(f"{self._place(node)}: {'::'.join(path)} is no complete interface")
        return path

    def _operation(self, node: Any, scope: Path) -> Operation:
        result, name, *rest = [part for part in node.children if part is not None]
        parameters = tuple(
            self._parameter(part, scope) for part in rest if part.data == "parameter"
        )
        raises = tuple(
            self._look_up(each, scope).path
            for part in rest
            if part.data == "raises"
            for each in part.children
        )
        kind = None if result.data == "void" else self._type(result, scope)
        return Operation(_name(name), kind, parameters, raises, self._doc(node))

    def _parameter(self, node: Any, scope: Path) -> OperationParameter:
        direction, kind, name = _bare(node)
        return OperationParameter(Direction(str(direction)), _name(name), self._type(kind, scope))

    def _attribute(self, node: Any, scope: Path) -> Iterator[Attribute]:
        readonly, kind, *names = [part for part in node.children if not _is(part, "names")]
        type, doc = self._type(kind, scope), self._doc(node)
        for name in names:
            if not _is(name, "raises"):
                yield Attribute(_name(name), type, readonly is not None, doc)

    def _structure(self, node: Any, scope: Path) -> None:
        path, place = self._begin(node, scope)
        fields: list[Field] = []
        for part in _parts(node, "inheritance"):
            base = self.scopes.declarations.get(self._look_up(part.children[0], scope).path)
            fields += base.fields if isinstance(base, StructDeclaration) else ()
        for part in _parts(node, "member"):
            fields += self._member(part, path)
        names = [each.name for each in fields]
        for name in names:
            if names.count(name) > 1:
                raise InvalidIdl(f"{place}: {'::'.join(path)} has two members {name}")
        is_exception = node.data == "exception"
        self.scopes.declare(
            StructDeclaration(path, place, tuple(fields), is_exception, doc=self._doc(node))
        )

    _exception = _structure

    def _member(self, node: Any, scope: Path) -> Iterator[Field]:
        kind, *declarators = _bare(node)
        type, doc = self._type(kind, scope), self._doc(node)
        marks = (
            self._source.text[m.meta.start_pos : m.meta.end_pos] for m in _parts(node, "annotation")
        )
        full_doc = " ".join(filter(None, (doc, *(_mark(each, doc) for each in marks))))
        for each in declarators:
            name, full = self._declarator(each, type, scope)
            yield Field(name, full, full_doc)

    def _declarator(self, node: Any, type: Type, scope: Path) -> tuple[str, Type]:
        name, *sizes = node.children
        found = tuple(self._size(each.children[0], scope) for each in sizes)
        return _name(name), ArrayOf(type, found) if found else type

    def _enumeration(self, node: Any, scope: Path) -> None:
        name, *rest = node.children
        path, place = (*scope, _name(name)), self._place(node)
        members = tuple(_name(each.children[-1]) for each in rest)
        values = self._numbers(rest, scope)
        given = values if values != tuple(range(len(values))) else ()
        self.scopes.declare(EnumDeclaration(path, place, members, given, doc=self._doc(node)))
        for member in members:
            self.scopes.define((*scope, member), EnumValue(path, member), place)

    def _numbers(self, enumerators: list[Any], scope: Path) -> tuple[int, ...]:
        """Return the numbers of enumerators: as ``@value`` says, else one more than before."""
        numbers: list[int] = []
        for each in enumerators:
            number = numbers[-1] + 1 if numbers else 0
            for mark in _parts(each, "annotation"):
                if [str(word) for word in mark.children[0].children if word] == ["value"]:
                    number = self._number(mark, scope)
            numbers.append(number)
        if len(set(numbers)) < len(numbers):
            raise InvalidIdl(f"{self._place(enumerators[0])}: two members have one number")
        return tuple(numbers)

    def _number(self, mark: Any, scope: Path) -> int:
        value = self._value(mark.children[-1], scope) if len(mark.children) > 1 else None
        if type(value) is not int:
            raise InvalidIdl(f"{self._place(mark)}: {value} is no number of a member")
        return value

    def _typedef(self, node: Any, scope: Path) -> None:
        kind, *declarators = node.children
        type, place, doc = self._type(kind, scope), self._place(node), self._doc(node)
        for each in declarators:
            name, full = self._declarator(each, type, scope)
            self.scopes.declare(Typedef((*scope, name), place, full, doc=doc))

    def _constant(self, node: Any, scope: Path) -> None:
        kind, name, expression = node.children
        path, place = (*scope, _name(name)), self._place(node)
        type, value = self._type(kind, scope), self._value(expression, scope)
        self.scopes.declare(Constant(path, place, type, value, doc=self._doc(node)))
        self.scopes.define(path, value, place)

    def _begin(self, node: Any, scope: Path) -> tuple[Path, SourceLine]:
        """Announce a declaration whose body may name it."""
        path, place = (*scope, _name(node.children[0])), self._place(node)
        known = self.scopes.declarations.get(path)
        if known is None or is_forward(known):
            self.scopes.declare(Opaque(path, place, BasicKind.FORWARD))
        return path, place

    def _type(self, node: Any, scope: Path) -> Type:
        if node.data == "scoped":
            return self._named(node, scope)
        if node.data == "map" and str(node.children[0]) != "map":
            raise InvalidIdl(f"{self._place(node)}: unexpected '<' after {node.children[0]}")
        if node.data == "sequence":
            item, *bound = node.children
            return SequenceOf(
                self._type(item, scope), self._size(bound[0], scope) if bound else None
            )
        if node.data == "text":
            return Basic(str(node.children[0]))
        words = [str(word) for word in node.children if word is not None]
        return Basic(" ".join(words) if node.data == "basic" else str(node.data))

    def _named(self, node: Any, scope: Path) -> Type:
        root, *names = node.children
        is_later = root is None and len(names) == 1 and names[0] in _INTEGERS
        if is_later and not self.scopes.find((str(names[0]),), scope, is_absolute=False):
            return Basic(str(names[0]))
        found = self._look_up(node, scope)
        if found.value is not None:
            raise InvalidIdl(f"{self._place(node)}: {'::'.join(found.path)} is no type")
        return Named(found.path)

    def _size(self, node: Any, scope: Path) -> int:
        value = self._value(node, scope)
        if type(value) is not int or value <= 0:
            raise InvalidIdl(f"{self._place(node)}: {value} is no size")
        return value

    def _value(self, node: Any, scope: Path) -> Value:
        try:
            return evaluate(node, lambda name: self._constant_named(name, scope))
        except (BadConstant, OverflowError) as error:
            raise InvalidIdl(f"{self._place(node)}: {error}") from None

    def _constant_named(self, node: Any, scope: Path) -> Value:
        found = self._look_up(node, scope)
        if found.value is None:
            raise InvalidIdl(f"{self._place(node)}: {'::'.join(found.path)} is no constant")
        return found.value

    def _look_up(self, node: Any, scope: Path) -> ResolvedName:
        root, *names = node.children
        name = tuple(_name(each) for each in names)
        found = self.scopes.find(name, scope, is_absolute=root is not None)
        if found is not None:
            return found
        place, missing = self._place(node), self._source.missing
        is_brokers = name[0] == _BROKER and len(name) > 1
        if not missing and not is_brokers:
            raise InvalidIdl(f"{place}: {'::'.join(name)} is not defined")
        self.scopes.declare(
            Opaque(name, place, BasicKind.BROKER if is_brokers else BasicKind.MISSING)
        )
        return ResolvedName(name)

    def _place(self, node: Any) -> SourceLine:
        return self._source.place(node.meta.line)

    def _doc(self, node: Any) -> str:
        return self._comments.of(node.meta.line, node.meta.end_line)


def _mark(text: str, doc: str) -> str:
    """Return what an annotation tells of values, a unit in brackets; empty where `doc` tells it."""
    unit = _UNIT.fullmatch(text)
    shown = f"[{unit[1]}]" if unit else " ".join(text.split())
    return "" if shown in doc or not shown.startswith(_ABOUT_VALUES) else shown


def _is_missing(declared: Declaration | None) -> bool:
    return declared is None or (
        isinstance(declared, Opaque) and declared.kind in (BasicKind.MISSING, BasicKind.BROKER)
    )


def _name(token: Any) -> str:
    """Return an identifier without the underscore that lets it look like a keyword."""
    return str(token).removeprefix("_")


def _is(part: Any, data: str) -> bool:
    return getattr(part, "data", "") == data


def _parts(node: Any, data: str) -> list[Any]:
    return [part for part in node.children if _is(part, data)]


def _bare(node: Any) -> list[Any]:
    """Return the children without annotations."""
    return [part for part in node.children if not _is(part, "annotation")]
