"""Reads files that omniidl generated, where the interface definition itself is not there.

They are not run. What they declare is told by type descriptors: tuples of kinds, names and further
descriptors. The names of parameters are not among them.
"""

from __future__ import annotations

import ast
import re

from rtkit.idl.model import (
    ArrayOf,
    Basic,
    Constant,
    Declaration,
    Definitions,
    Direction,
    EnumDeclaration,
    Field,
    InterfaceDeclaration,
    Named,
    Operation,
    OperationParameter,
    Path,
    SequenceOf,
    SourceLine,
    StructDeclaration,
    Type,
    Typedef,
)

_BASIC = {
    "ushort": "unsigned short",
    "ulong": "unsigned long",
    "longlong": "long long",
    "ulonglong": "unsigned long long",
}
_SCOPE = "_0_"
_CONSTANTS = {bool: "boolean", int: "long", float: "double", str: "string"}


def read_stub(text: str, file: str) -> Definitions:
    """Return the declarations of a generated file.

    Raises:
        SyntaxError: It is no Python.
    """
    reader = _Reader(file)
    for statement in ast.parse(text, file).body:
        reader.take(statement)
    return Definitions(reader.declarations())


class _Reader:
    """Collects declarations in the order of the file."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._ids: dict[str, str] = {}
        self._declared: dict[Path, Declaration] = {}
        self._operations: dict[str, list[Operation]] = {}
        self._bases: dict[str, tuple[Path, ...]] = {}
        self._interfaces: dict[str, tuple[Path, SourceLine]] = {}

    def declarations(self) -> dict[Path, Declaration]:
        """Return what was collected, interfaces with their operations."""
        for name, (path, place) in self._interfaces.items():
            operations = tuple(self._operations.get(name, ()))
            bases = self._bases.get(name, ())
            self._declared[path] = InterfaceDeclaration(path, place, bases, operations)
        return self._declared

    def take(self, statement: ast.stmt) -> None:
        """Take a statement at the top of the file."""
        if isinstance(statement, ast.ClassDef):
            self._take_class(statement)
        elif isinstance(statement, ast.Assign):
            for target in statement.targets:
                if isinstance(target, ast.Attribute):
                    self._take_value(target, statement.value)

    def _take_class(self, statement: ast.ClassDef) -> None:
        name = statement.name.removeprefix("_objref_")
        if name != statement.name:
            bases = (ast.unparse(base) for base in statement.bases)
            self._bases[name] = tuple(
                _path_of(each.replace("_objref_", "")) for each in bases if each[:3] == _SCOPE
            )
        for each in statement.body:
            if isinstance(each, ast.Assign) and ast.unparse(each).startswith(
                "_NP_RepositoryId = '"
            ):
                self._ids[name] = str(ast.literal_eval(each.value))

    def _take_value(self, target: ast.Attribute, value: ast.expr) -> None:
        owner, name = ast.unparse(target.value), target.attr
        place = SourceLine(self._file, target.lineno)
        if isinstance(value, ast.Constant) and owner.startswith(_SCOPE) and name[0] != "_":
            path = (*_path_of(owner), name)
            kind = Basic(_CONSTANTS.get(type(value.value), "string"))
            self._declared[path] = Constant(path, place, kind, value.value)  # type: ignore[arg-type]
        elif isinstance(value, ast.Call) and ast.unparse(value.func) == "omniORB.Enum":
            path = _path(str(ast.literal_eval(value.args[0])))
            items = getattr(value.args[1], "elts", [])
            members = tuple(ast.unparse(each).rpartition(".")[2] for each in items)
            self._declared[path] = EnumDeclaration(path, place, members)
        elif isinstance(value, ast.Tuple) and name.startswith(("_d_", "_ad_")):
            self._take_descriptor(owner, name.partition("d_")[2], value.elts, place)

    def _take_descriptor(
        self, owner: str, name: str, parts: list[ast.expr], place: SourceLine
    ) -> None:
        kind = _kind(parts[0]) if parts else ""
        if kind in ("struct", "except"):
            path = _path(self._ids.get(name, name))
            pairs = zip(parts[4::2], parts[5::2], strict=False)
            fields = tuple(Field(str(ast.literal_eval(n)), self._type(t)) for n, t in pairs)
            self._declared[path] = StructDeclaration(path, place, fields, kind == "except")
        elif kind == "alias":
            path = _path(self._ids.get(name, name))
            self._declared[path] = Typedef(path, place, self._type(parts[3]))
        elif kind == "objref":
            self._interfaces[name] = (_path(str(ast.literal_eval(parts[1]))), place)
        elif owner in self._interfaces and len(parts) >= 2:
            self._operations.setdefault(owner, []).append(self._operation(name, parts))

    def _operation(self, name: str, parts: list[ast.expr]) -> Operation:
        given = [self._type(each) for each in getattr(parts[0], "elts", [])]
        back = [self._type(each) for each in getattr(parts[1], "elts", [])]
        raised = getattr(parts[2], "keys", []) if len(parts) > 2 else []
        parameters = (
            *(OperationParameter(Direction.IN, f"in{at}", each) for at, each in enumerate(given)),
            *(OperationParameter(Direction.OUT, f"out{at}", t) for at, t in enumerate(back[1:], 1)),
        )
        errors = tuple(_path_of(ast.unparse(each).rpartition(".")[0]) for each in raised)
        return Operation(name, back[0] if back else None, parameters, errors)

    def _type(self, node: ast.expr) -> Type:
        """Return the type that a descriptor stands for."""
        if isinstance(node, ast.Subscript):  # omniORB.typeMapping["IDL:…"]
            return Named(_path(str(ast.literal_eval(node.slice))))
        if isinstance(node, ast.Tuple):
            kind, *rest = node.elts
            word = _kind(kind)
            if word == "sequence":
                bound = ast.literal_eval(rest[1])
                return SequenceOf(self._type(rest[0]), bound or None)
            if word == "array":
                return ArrayOf(self._type(rest[0]), (int(ast.literal_eval(rest[1])),))
            return Basic(word)
        word = _kind(node)
        return Basic(_BASIC.get(word, word))


def _kind(node: ast.expr) -> str:
    """Return ``long`` of ``omniORB.tcInternal.tv_long``."""
    return node.attr.removeprefix("tv_") if isinstance(node, ast.Attribute) else ""


def _path(id: str) -> Path:
    """Return the path of ``IDL:omg.org/RTC/Time:1.0``, without the prefix of its owner."""
    parts = id.removeprefix("IDL:").partition(":")[0].split("/")
    return tuple(each for each in parts if "." not in each)


def _path_of(expression: str) -> Path:
    """Return the path of ``_0_Robot.Arm``."""
    parts = re.split(r"\.", expression.removeprefix(_SCOPE))
    return tuple(each for each in parts if each != "_GlobalIDL")
