"""Laws of interface definitions: what is declared is read, and becomes Python that is carried."""

from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from types import ModuleType
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from rtkit.builder.component_files import build_types
from rtkit.builder.packaging import TYPE_RULES, linter
from rtkit.builder.types_code import TypesCode
from rtkit.component.services.interface import Interface as Read
from rtkit.component.values.codec import codec_for
from rtkit.component.values.defined import class_of
from rtkit.component.values.definition import idl_of, name_of
from rtkit.idl.model import (
    ArrayOf,
    Basic,
    Definitions,
    EnumDeclaration,
    Field,
    InterfaceDeclaration,
    Named,
    Operation,
    OperationParameter,
    Path,
    SequenceOf,
    StructDeclaration,
    Type,
    Typedef,
)
from rtkit.idl.read import read_idl
from rtkit.idl.source import InvalidIdl

PROJECT = "\n".join(linter({"law_idl.py": TYPE_RULES}))
BASIC = ("short", "unsigned long", "long long", "float", "double", "char", "wchar", "boolean")
BASIC += ("octet", "string", "wstring", "uint8", "int8", "int64")
NAMES = ["a", "class", "from", "None", "self", "str", "tuple", "rt", "field", "Enum", "Point"]
NAMES += ["l", "mro", "value", "register", "import", "dataclass", "X1", "longName", "Final"]


def types(draw: Any, known: list[Path]) -> Type:
    """Draw a type of what is declared so far."""
    kind: Type = Basic(draw(st.sampled_from(BASIC)))
    if known and draw(st.booleans()):
        kind = Named(draw(st.sampled_from(known)))
    shape = draw(st.sampled_from(["plain", "plain", "sequence", "bounded", "nested"]))
    if shape == "sequence":
        return SequenceOf(kind)
    if shape == "bounded":
        return SequenceOf(kind, draw(st.integers(1, 9)))
    return SequenceOf(SequenceOf(kind)) if shape == "nested" else kind


def members(draw: Any, known: list[Path]) -> tuple[Field, ...]:
    names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=4, unique=True))
    found = []
    for name in names:
        kind = types(draw, known)
        sizes = draw(st.sampled_from([(), (), (2,), (3, 4), (12,)]))
        found.append(Field(name, ArrayOf(kind, sizes) if sizes else kind))
    return tuple(found)


@st.composite
def definitions(draw: Any) -> list[Any]:
    """Draw declarations, each of which may use those before it."""
    place: Any = None
    made: list[Any] = []
    values: list[Path] = []
    taken: set[Path] = set()
    for module in draw(st.lists(st.sampled_from([("M",), ("M", "N"), ("O",)]), max_size=6)):
        path = (*module, draw(st.sampled_from(NAMES)))
        if path in taken or path in (("M", "N"),):
            continue
        taken.add(path)
        kind = draw(st.sampled_from(["struct", "struct", "enum", "typedef", "interface"]))
        if kind == "struct":
            made.append(StructDeclaration(path, place, members(draw, values)))
        elif kind == "typedef":
            item = types(draw, values)
            sizes = draw(st.sampled_from([(), (2,), (3, 2)]))
            made.append(Typedef(path, place, ArrayOf(item, sizes) if sizes else item))
        elif kind == "enum":
            words = [f"{path[-1]}_{n}" for n in range(draw(st.integers(1, 3)))]
            made.append(EnumDeclaration(path, place, tuple(words)))
        else:
            names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True))
            made.append(
                InterfaceDeclaration(
                    path, place, operations=tuple(operation(draw, name, values) for name in names)
                )
            )
        if kind != "interface":
            values.append(path)
    return made


def operation(draw: Any, name: str, known: list[Path]) -> Operation:
    names = draw(st.lists(st.sampled_from(NAMES), max_size=3, unique=True))
    ways = st.sampled_from(["in", "out", "inout"])
    given_ = tuple(OperationParameter(draw(ways), each, types(draw, known)) for each in names)
    result = types(draw, known) if draw(st.booleans()) else None
    return Operation(name, result, given_)


def written(declarations: list[Any]) -> str:
    """Write declarations as IDL; names that IDL keeps for itself are escaped."""
    return "\n".join(_inside(each.path[:-1], _text(each)) for each in declarations)


def _inside(module: Path, text: str) -> str:
    for name in reversed(module):
        text = f"module {name} {{ {text} }};"
    return text


def _text(each: Any) -> str:
    name = f"_{each.path[-1]}"
    if isinstance(each, StructDeclaration):
        return f"struct {name} {{ {' '.join(map(_member, each.fields))} }};"
    if isinstance(each, EnumDeclaration):
        return f"enum {name} {{ {', '.join(each.members)} }};"
    if isinstance(each, Typedef):
        return f"typedef {_member(Field(each.path[-1], each.type))}"
    return f"interface {name} {{ {' '.join(map(_operation, each.operations))} }};"


def _member(each: Field) -> str:
    if isinstance(each.type, ArrayOf):
        sizes = "".join(f"[{size}]" for size in each.type.sizes)
        return f"{_type(each.type.item)} _{each.name}{sizes};"
    return f"{_type(each.type)} _{each.name};"


def _operation(each: Operation) -> str:
    given_ = ", ".join(f"{p.direction} {_type(p.type)} _{p.name}" for p in each.parameters)
    return f"{_type(each.result) if each.result else 'void'} _{each.name}({given_});"


def _type(type: Type) -> str:
    if isinstance(type, Basic):
        return type.name
    if isinstance(type, Named):
        return "::" + "::".join(f"_{part}" for part in type.path)
    assert isinstance(type, SequenceOf)
    bound = f", {type.bound}" if type.bound else ""
    return f"sequence<{_type(type.item)}{bound} >"


def without_places(found: Definitions) -> list[Any]:
    return [
        type(each)(**{n: getattr(each, n) for n in each.__dataclass_fields__} | {"place": None})
        for each in found.by_path.values()
    ]


@settings(max_examples=150, deadline=None)
@given(definitions())
def test_what_is_written_is_read(declarations: list[Any]) -> None:
    assert without_places(read_idl(written(declarations))) == declarations


@settings(max_examples=100, deadline=None)
@given(definitions())
def test_what_is_read_becomes_python_that_is_carried(declarations: list[Any]) -> None:
    found = read_idl(written(declarations))
    code = TypesCode(found, list(found.by_path))
    text = code.text(["x.idl"])
    assert text == TypesCode(found, list(found.by_path)).text(["x.idl"])
    module = ModuleType("law_idl")
    sys.modules["law_idl"] = module
    try:
        exec(compile(text, "law_idl.py", "exec"), module.__dict__)
        for path, each in found.by_path.items():
            made = getattr(module, code.name(path))
            if isinstance(each, StructDeclaration):
                codec = codec_for(made)
                assert codec.decode(codec.encode(made())) == made()
                told = codec_for(class_of(name_of(made), idl_of(made)))
                assert told.encode(told.decode(codec.encode(made()))) == codec.encode(made())
            elif isinstance(each, InterfaceDeclaration):
                assert len(Read(made).methods) == len(each.operations)
    finally:
        del sys.modules["law_idl"]


# Not shrunk: what the linter says is small enough, and each step costs a process.
@settings(max_examples=30, deadline=None, phases=[Phase.generate])
@given(definitions())
def test_the_linter_finds_nothing(
    tmp_path_factory: pytest.TempPathFactory, declarations: list[Any]
) -> None:
    folder = tmp_path_factory.mktemp("idl")
    for name, file in build_types(read_idl(written(declarations)), "law.idl")[0].items():
        (folder / name).write_text(file.text, encoding="utf-8")
    (folder / "pyproject.toml").write_text(PROJECT, encoding="utf-8")
    for words in (("check", "--output-format", "concise"), ("format", "--diff")):
        command = [sys.executable, "-m", "ruff", words[0], "--no-cache", *words[1:], str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


@settings(max_examples=200, deadline=None)
@given(st.text(st.sampled_from("struct module{};<>,:()[]#\n\"'/*-+ aM1=_enum"), max_size=60))
def test_any_text_is_read_or_refused(text: str) -> None:
    with suppress(InvalidIdl):
        read_idl(text)
