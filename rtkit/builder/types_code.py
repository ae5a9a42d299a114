"""Generates Python of IDL: protocols, data classes, enumerations, constants."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from hashlib import sha256

from rtkit.builder import standard_types
from rtkit.builder.closure import closure
from rtkit.builder.identifiers import Taken
from rtkit.builder.methods import GeneratedMethod, documentation, methods_of, signature
from rtkit.builder.source_layout import assigned, constant
from rtkit.builder.source_text import INDENT, WIDTH, docstring, one_line, wrapped
from rtkit.builder.type_annotations import OWN, Annotations, member_names
from rtkit.idl.model import (
    ArrayOf,
    Basic,
    Constant,
    Declaration,
    Definitions,
    EnumDeclaration,
    EnumValue,
    Field,
    InterfaceDeclaration,
    Named,
    Path,
    SequenceOf,
    StructDeclaration,
    Type,
    Typedef,
)

_IMPORTS = {
    "dataclass": ("dataclasses", "dataclass"),
    "field": ("dataclasses", "field"),
    "Enum": ("enum", "Enum"),
    "TYPE_CHECKING": ("typing", "TYPE_CHECKING"),
    "Annotated": ("typing", "Annotated"),
    "Final": ("typing", "Final"),
    "Protocol": ("typing", "Protocol"),
}


_FORM = "1"
"""Counts up when classes of the same content are generated in another form."""
_LENGTH = 12


class TypesCode:
    """The module made of some declarations and all that they need.

    `rtkit.builder.obstacles` must have found nothing against any of them.
    """

    def __init__(self, definitions: Definitions, wanted: Iterable[Path]) -> None:
        self._definitions = definitions
        # Exceptions of a method have to stand before it, and are often declared inside.
        needed = closure(definitions, wanted)
        self._order = sorted(
            needed, key=lambda p: isinstance(definitions.by_path[p], InterfaceDeclaration)
        )
        self._types = Annotations(definitions, self._order)
        self._methods: dict[Path, list[GeneratedMethod]] = {}
        self._blocks = [block for path in self._order for block in self._emit(path)]

    def __bool__(self) -> bool:
        return bool(self._order)

    def name(self, path: Path) -> str:
        """Return the name of a declaration in the module."""
        return self._types.names[path]

    def methods(self, path: Path) -> list[GeneratedMethod]:
        """Return the methods of an interface, those of its bases first."""
        declared = self._definitions.by_path[path]
        found: dict[str, GeneratedMethod] = {}
        for base in declared.bases if isinstance(declared, InterfaceDeclaration) else ():
            found.update({each.name: each for each in self.methods(base)})
        found.update({each.name: each for each in self._methods.get(path, ())})
        return list(found.values())

    def text(self, made_of: Sequence[str], mark: Sequence[str] = ()) -> str:
        """Return the source; `mark` are lines that stand before the imports."""
        doc = docstring("What interface definitions say.", "", [f"Made of {', '.join(made_of)}."])
        lines = [*doc, "", *mark, "from __future__ import annotations"]
        lines += self._imports()
        return "\n".join([*lines, *_laid_out(self._blocks), ""])

    def _imports(self) -> list[str]:
        uses = self._types.uses
        modules: dict[str, list[str]] = {}
        for use in _IMPORTS:
            if use in uses:
                modules.setdefault(_IMPORTS[use][0], []).append(use)
        standard = [f"from {m} import {', '.join(names)}" for m, names in modules.items()]
        ours = ["from rtkit import component as rt"] if "rt" in uses else []
        ours += [standard_types.IMAGES] if "images" in uses else []
        ours += ["from rtkit.component.values.typenames import shared"] if "shared" in uses else []
        return [line for block in (standard, ours) if block for line in ["", *block]]

    def _emit(self, path: Path) -> Iterator[list[str]]:
        """Yield the code of a declaration, behind what it turns out to need."""
        code = self._code(self._definitions.by_path[path], self.name(path))
        yield from self._types.pending
        self._types.pending.clear()
        if code:
            yield code

    def _code(self, declared: Declaration, name: str) -> list[str]:
        if isinstance(declared, StructDeclaration):
            return (
                self._exception(declared, name)
                if declared.is_exception
                else self._struct(declared, name)
            )
        if isinstance(declared, EnumDeclaration):
            return self._enumeration(declared, name)
        if isinstance(declared, InterfaceDeclaration):
            return self._interface(declared, name)
        if isinstance(declared, Typedef):
            return [f"{name} = {self._plain(declared.type)}"]
        return self._constant(declared, name) if isinstance(declared, Constant) else []

    def _plain(self, type: Type) -> str:
        return self._types.of(type).replace(OWN, "")

    def _struct(self, declared: StructDeclaration, name: str) -> list[str]:
        self._types.uses.add("dataclass")
        fields = self._fields(declared)
        doc = docstring(
            f"Structure {name}.", declared.doc, indent=INDENT, sections=_attributes(fields)
        )
        lines = []
        for own, each in fields:
            default = self._types.zero(each.type).default
            if default.startswith("field("):
                self._types.uses.add("field")
            lines.append(f"{INDENT}{own}: {self._plain(each.type)} = {default}")
        head = ["@dataclass(frozen=True, slots=True)", f"class {name}:"]
        return [self._shared(declared), *head, *doc, "", *lines]

    def _shared(self, declared: Declaration) -> str:
        """Return the line that makes it one class for all that know the type."""
        self._types.uses.add("shared")
        return f'@shared("{declared.name}", "{version_of(self._definitions, declared.path)}")'

    def _fields(self, declared: StructDeclaration) -> list[tuple[str, Field]]:
        taken = Taken(self._types.all)
        return [(taken.add(each.name), each) for each in declared.fields]

    def _exception(self, declared: StructDeclaration, name: str) -> list[str]:
        fields = self._fields(declared)
        doc = docstring(
            f"Exception {name}.", declared.doc, indent=INDENT, sections=_attributes(fields)
        )
        lines = [self._shared(declared), f"class {name}(Exception):", *doc]
        if not fields:
            return lines
        given = [f"{own}: {self._types.of_any(each.type).replace(OWN, '')}" for own, each in fields]
        names = ", ".join(own for own, _ in fields)
        head = f"{INDENT}def __init__(self, {', '.join(given)}) -> None:"
        if len(head) <= WIDTH:
            lines += ["", head]
        else:
            split = [f"{INDENT * 2}{each}," for each in ["self", *given]]
            lines += ["", f"{INDENT}def __init__(", *split, f"{INDENT}) -> None:"]
        lines.append(f"{INDENT * 2}super().__init__({names})")
        return lines + [f"{INDENT * 2}self.{own} = {own}" for own, _ in fields]

    def _enumeration(self, declared: EnumDeclaration, name: str) -> list[str]:
        self._types.uses.add("Enum")
        members = [
            f"{INDENT}{member} = {number}"
            for member, number in zip(
                member_names(declared), declared.numbers.values(), strict=True
            )
        ]
        doc = docstring(f"Enumeration {name}.", declared.doc, indent=INDENT)
        return [self._shared(declared), f"class {name}(Enum):", *doc, "", *members]

    def _constant(self, declared: Constant, name: str) -> list[str]:
        if isinstance(declared.value, EnumValue):
            owner = self._definitions.by_path[declared.value.path]
            assert isinstance(owner, EnumDeclaration)
            member = member_names(owner)[owner.members.index(declared.value.name)]
            return [f"{name} = {self.name(owner.path)}.{member}"]
        self._types.uses.add("Final")
        return assigned(f"{name}: Final", constant(declared.value), "")

    def _interface(self, declared: InterfaceDeclaration, name: str) -> list[str]:
        self._types.uses.add("Protocol")
        methods = self._methods[declared.path] = methods_of(declared, self._types)
        bases = [self.name(path) for path in declared.bases]
        lines = [f"class {name}({', '.join([*bases, 'Protocol'])}):"]
        lines += docstring(f"Interface {name}.", declared.doc, indent=INDENT)
        for method in methods:
            lines += ["", *self._raises(method), *self._returns(method)]
            lines += signature(method, "", INDENT)
            lines += documentation(method, self.name, INDENT * 2)
            # Type checkers miss a value where a body is nothing but a docstring.
            lines += [f"{INDENT * 2}..."] if method.result != "None" else []
        return lines

    def _raises(self, method: GeneratedMethod) -> list[str]:
        """Return the line that declares what a method raises, if it does."""
        if not method.raises:
            return []
        self._types.uses.add("rt")
        names = [self.name(path) for path in method.raises]
        line = f"{INDENT}@rt.raises({', '.join(names)})"
        if len(line) <= WIDTH:
            return [line]
        return [f"{INDENT}@rt.raises(", *(f"{INDENT * 2}{name}," for name in names), f"{INDENT})"]

    def _returns(self, method: GeneratedMethod) -> list[str]:
        """Return the line that names what a method returns, if it has ``out`` parameters."""
        if not method.results:
            return []
        self._types.uses.add("rt")
        names = [f'"{name}"' for name in method.results]
        line = f"{INDENT}@rt.returns({', '.join(names)})"
        if len(line) <= WIDTH:
            return [line]
        return [f"{INDENT}@rt.returns(", *(f"{INDENT * 2}{name}," for name in names), f"{INDENT})"]


def _attributes(fields: Iterable[tuple[str, Field]]) -> list[str]:
    """Return the section of a docstring about the fields that have one."""
    lines: list[str] = []
    for name, each in fields:
        if each.doc:
            first, *rest = wrapped(f"{name}: {one_line(each.doc)}", WIDTH - 4 * len(INDENT))
            lines += [f"{INDENT}{first}", *(f"{INDENT * 2}{line}" for line in rest)]
    return ["", "Attributes:", *lines] if lines else []


def _laid_out(blocks: Sequence[list[str]]) -> list[str]:
    """Return blocks below each other: single lines close together, others two blank lines apart."""
    lines: list[str] = []
    was_single = False
    for block in blocks:
        is_single = not block[0].startswith(("class ", "@"))
        if not lines:
            lines += [""] if is_single else ["", ""]
        elif not (is_single and was_single):
            lines += ["", ""]
        lines += block
        was_single = is_single
    return lines


def version_of(definitions: Definitions, path: Path) -> str:
    """Return the version of a structure, an enumeration or an exception.

    It changes with names and types of members, also of structures inside, not with comments, places
    or the names of type definitions.
    """
    text = f"{_FORM} {_content(definitions, path, ())}"
    return sha256(text.encode()).hexdigest()[:_LENGTH]


def _content(definitions: Definitions, path: Path, outer: tuple[Path, ...]) -> str:
    declared = definitions.by_path.get(path)
    name, within = "::".join(path), (*outer, path)
    if isinstance(declared, StructDeclaration) and path not in outer:
        inner = (f"{each.name}:{_type(definitions, each.type, within)}" for each in declared.fields)
        return f"{name}{{{';'.join(inner)}}}"
    if isinstance(declared, EnumDeclaration):
        return f"{name}{{{','.join(declared.members)}}}"
    if isinstance(declared, Typedef):
        return _type(definitions, declared.type, within)
    return name  # a type of the standard


def _type(definitions: Definitions, type: Type, outer: tuple[Path, ...]) -> str:
    if isinstance(type, Named):
        return _content(definitions, type.path, outer)
    if isinstance(type, ArrayOf):
        return f"{_type(definitions, type.item, outer)}{list(type.sizes)}"
    if isinstance(type, SequenceOf):
        return f"sequence<{_type(definitions, type.item, outer)},{type.bound}>"
    assert isinstance(type, Basic)
    return type.name
