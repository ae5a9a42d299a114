"""Catalogue of types: standard ones, and those of live ports, modules, IDL files and recordings."""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import is_dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.component.standard import SCOPES, find, names_of
from rtkit.component.values.codec import codec_for
from rtkit.component.values.defined import UNFIT, class_in
from rtkit.component.values.definition import docs_of, idl_of, word_of
from rtkit.component.values.type_layout import (
    ArrayLayout,
    BasicLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
    layout_of_hint,
    zero,
)
from rtkit.component.values.typenames import is_standard, type_by_name, type_name
from rtkit.component.values.value_text import plain
from rtkit.errors import Malformed, NotFound, RtkitError
from rtkit.idl.model import EnumDeclaration, InterfaceDeclaration, StructDeclaration
from rtkit.idl.read import read_idl
from rtkit.rtc.data_types import is_same_type, scoped_name
from rtkit.rtc.enums import PortType
from rtkit.rtc.nearest import did_you_mean

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.idl.model import Definitions
    from rtkit.recording.entries import RecordedStream

STANDARD = "standard"
_KINDS = {StructDeclaration: "struct", EnumDeclaration: "enum", InterfaceDeclaration: "interface"}
_MODULE = re.compile(r"\s*module \w+ \{$")


class CataloguedType(NamedTuple):
    """A type, as one source has it.

    Attributes:
        name: ``Robot::Wheel``.
        kind: ``struct``, ``enum`` or ``interface``.
        source: ``standard``, ``live``, ``module NAME``, or the path of a file.
        definition: IDL of it and all that it contains; empty where that is made of the class, or
            no port has it.
        cls: Its class, where that is known already.
    """

    name: str
    kind: str
    source: str
    definition: str = ""
    cls: type | None = None


class TypedPort(NamedTuple):
    """A live port and the type that it carries.

    Attributes:
        direction: ``in`` or ``out``; of an interface ``provided`` or ``required``.
    """

    path: str
    direction: str
    type_name: str
    definition: str


class TypePage(NamedTuple):
    """Page about a type.

    Attributes:
        definition: IDL of it and all that it contains; empty where nobody has it.
        fields: Name, type and description of each field; no number of a member.
        size_bytes: Size of the shortest value in CDR, with its header; None for other kinds.
        is_fixed: Whether all values have that size.
        example: A value, as data of JSON; None for other kinds.
    """

    type: CataloguedType
    definition: str
    fields: tuple[tuple[str, str, str], ...] = ()
    size_bytes: int | None = None
    is_fixed: bool = False
    example: Any = None


def ports_of_types(components: Iterable[tuple[str, ComponentFacts]]) -> Iterator[TypedPort]:
    """Yield the ports of components, each behind its path; service ports for each interface."""
    for path, facts in components:
        for port in facts.ports:
            place = f"{path}:{port.name}"
            for each in port.interfaces:
                direction = each.polarity.value.lower()
                yield TypedPort(place, direction, scoped_name(each.type_name), port.definition)
            if port.port_type is not PortType.SERVICE and scoped_name(port.data_type):
                direction = "out" if port.port_type is PortType.OUT else "in"
                yield TypedPort(place, direction, scoped_name(port.data_type), port.definition)


class TypeCatalogue:
    """Types of all sources, those first that take precedence.

    Attributes:
        types: In that order; one name may be there several times.
        ports: Live ports with their types.
    """

    def __init__(self) -> None:
        self.types: list[CataloguedType] = []
        self.ports: list[TypedPort] = []

    def add_modules(self, names: Sequence[str]) -> None:
        """Add the data types of modules that are imported."""
        for name in names:
            for cls in vars(sys.modules[name]).values():
                is_type = isinstance(cls, type) and (is_dataclass(cls) or issubclass(cls, Enum))
                if is_type and cls.__module__ == name and cls is not Enum and _is_carried(cls):
                    kind = "enum" if issubclass(cls, Enum) else "struct"
                    full = scoped_name(type_name(cls))
                    self.types.append(CataloguedType(full, kind, f"module {name}", cls=cls))

    def add_recording(self, path: str, streams: Iterable[RecordedStream]) -> None:
        """Add the types of a recording."""
        for each in streams:
            self._add(CataloguedType(each.data_type, "struct", path, each.definition))

    def add_idl(self, path: str, definitions: Definitions) -> None:
        """Add what a file of interface definitions declares."""
        for each in definitions.by_path.values():
            is_exception = isinstance(each, StructDeclaration) and each.is_exception
            if type(each) in _KINDS and each.place.file == path and not is_exception:
                try:
                    cls = class_in(definitions, each.name) if type(each) in _DATA else None
                except (RtkitError, *UNFIT):
                    cls = None  # it is known by name, and cannot be carried
                self._add(CataloguedType(each.name, _KINDS[type(each)], path, cls=cls))

    def add_live(self, components: Iterable[tuple[str, ComponentFacts]]) -> None:
        """Add the types of live ports; one that has no definition where no port of it has one."""
        new = list(ports_of_types(components))
        self.ports += new
        for each in sorted(new, key=lambda port: not port.definition):
            kind = "struct" if each.direction in ("in", "out") else "interface"
            known = any(it.name == each.type_name and it.source == "live" for it in self.types)
            if each.definition or not known:
                self._add(CataloguedType(each.type_name, kind, "live", each.definition))

    def add_standard(self) -> None:
        """Add the data types of the standard."""
        for scope in SCOPES:
            for name in names_of(scope):
                declared = find(scope, name)
                assert declared is not None
                self.types.append(CataloguedType(f"{scope}::{name}", declared.kind, STANDARD))

    def _add(self, new: CataloguedType) -> None:
        if new.name and not is_standard(new.name) and new not in self.types:
            self.types.append(new)

    def counts(self) -> Counter[str]:
        """Return how many live ports carry each type."""
        return Counter(port.type_name for port in self.ports)

    def find(self, typed: str) -> list[CataloguedType]:
        """Return a type as all sources have it; also one that is only part of others.

        Raises:
            NotFound: There is none; names those that may have been meant.
            Malformed: Several are meant.
        """
        if not scoped_name(typed):
            raise NotFound(f"Type not found: {typed} (ports of any type carry bytes)")
        found = [each for each in self.types if is_same_type(each.name, typed)]
        found = found or [each for each in self._parts() if is_same_type(each.name, typed)]
        names = sorted({each.name for each in found})
        if len(names) > 1:
            raise Malformed(f"{typed} may be {' or '.join(names)}")
        if not found:
            known = dict.fromkeys(each.name for each in self.types)
            word = scoped_name(typed)
            if "::" not in word:
                known = {name.rpartition("::")[2]: None for name in known}
            raise NotFound(f"Type not found: {typed}{did_you_mean(word, known)}")
        return found

    def _parts(self) -> Iterator[CataloguedType]:
        """Yield the types inside of those that have a definition."""
        for each in [*self.types]:
            try:
                inner = read_idl(each.definition, each.name).by_path if each.definition else {}
            except RtkitError:
                continue
            for part in inner.values():
                if type(part) in _DATA and not is_standard(part.name):
                    yield each._replace(name=part.name, kind=_KINDS[type(part)])


_DATA = (StructDeclaration, EnumDeclaration)


def page_of(known: CataloguedType) -> TypePage:
    """Return what is known of a type."""
    try:
        cls = _class_of(known)
        definition = idl_of(cls) if cls is not None else known.definition
    except (RtkitError, *UNFIT):
        return TypePage(known, known.definition)  # no values of it can be made
    if cls is None:
        return TypePage(known, definition)
    if issubclass(cls, Enum):
        members = layout_of_hint(cls, known.name)
        assert isinstance(members, EnumLayout)
        rows = tuple((each.name, str(number), "") for each, number in members.numbers.items())
        return TypePage(known, definition, rows)
    layout, docs = layout_of(cls), docs_of(cls)
    fields = tuple((name, word_of(each), docs.get(name, "")) for name, each in layout.fields)
    size = len(codec_for(cls).encode(zero(layout)))
    return TypePage(known, definition, fields, size, _is_fixed(layout), plain(_example(layout)))


def _class_of(known: CataloguedType) -> type | None:
    if known.cls is not None or known.kind == "interface":
        return known.cls
    if known.definition:
        made: type = class_in(read_idl(known.definition, known.name), known.name)
        return made
    return type_by_name(known.name)


def _is_carried(cls: type) -> bool:
    try:
        return bool(layout_of_hint(cls, cls.__name__))
    except Malformed:
        return False


def _is_fixed(layout: Layout) -> bool:
    if isinstance(layout, StructLayout):
        return all(_is_fixed(item) for _, item in layout.fields)
    if isinstance(layout, ArrayLayout):
        return all(map(_is_fixed, layout.items))
    return isinstance(layout, EnumLayout) or (isinstance(layout, BasicLayout) and bool(layout.code))


def _example(layout: Layout) -> Any:
    """Return a value with one item in each sequence, everything else zero."""
    if isinstance(layout, StructLayout):
        return layout.cls(**{name: _example(item) for name, item in layout.fields})
    if isinstance(layout, ArrayLayout):
        return tuple(map(_example, layout.items))
    return (
        layout.make((_example(layout.item),)) if isinstance(layout, ItemsLayout) else zero(layout)
    )


def lines_of(page: TypePage, source: str) -> Iterator[str]:
    """Yield a page as IDL; further facts are in comments."""
    yield f"// {page.type.name}, {source}"
    yield from page.definition.splitlines() or ["// nothing here has its IDL"]
    if page.size_bytes is not None:
        yield f"// size: {page.size_bytes} B{'' if page.is_fixed else ' or more'}"
        yield f"// example: {json.dumps(page.example, ensure_ascii=False)}"
