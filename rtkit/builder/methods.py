"""Turns operations of interface definitions into Python methods.

``in`` parameters become parameters. A method returns the result, then each ``out`` parameter, in
order: none as None, one as itself, several as a tuple. An attribute becomes a method ``get_…``,
and a writable one also ``set_…``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from rtkit.builder.identifiers import Taken, in_words
from rtkit.builder.source_text import INDENT, WIDTH, docstring, sentence, width
from rtkit.builder.type_annotations import OWN, Annotations
from rtkit.idl.model import Attribute, Direction, InterfaceDeclaration, Operation, Path

_LONG_RESULT = 60


class GeneratedMethod(NamedTuple):
    """A method; annotations have ``§`` before names of the module with the types.

    Attributes:
        results: Names of the returned values where there is more than a result: that of each
            ``out`` parameter, an empty name for the result.
    """

    name: str
    parameters: tuple[tuple[str, str], ...]
    result: str
    doc: str
    results: tuple[str, ...] = ()
    raises: tuple[Path, ...] = ()


def methods_of(interface: InterfaceDeclaration, types: Annotations) -> list[GeneratedMethod]:
    """Return the methods of an interface, without those of its bases."""
    taken = Taken([*dir(object), "idl", "images", "rt"])
    found: list[GeneratedMethod] = []
    for operation in interface.operations:
        name = taken.add(operation.name)
        found.append(_operation(operation, name, types, f"{interface.path[-1]}{name}"))
    for attribute in interface.attributes:
        found += _attribute(attribute, taken, types)
    return found


def _operation(operation: Operation, name: str, types: Annotations, label: str) -> GeneratedMethod:
    taken = Taken()
    given = [each for each in operation.parameters if each.direction is not Direction.OUT]
    back = [each for each in operation.parameters if each.direction is not Direction.IN]
    results = [(each.name, types.of(each.type)) for each in back]
    if operation.result is not None:
        results.insert(0, ("", types.of(operation.result)))
    return GeneratedMethod(
        name,
        tuple((taken.add(each.name), types.of(each.type)) for each in given),
        _result([kind for _, kind in results], types, label),
        operation.doc,
        tuple(name for name, _ in results) if back else (),
        tuple(dict.fromkeys(operation.raises)),
    )


def _result(kinds: Sequence[str], types: Annotations, label: str) -> str:
    if len(kinds) < 2:
        return kinds[0] if kinds else "None"
    line = f"tuple[{', '.join(kinds)}]"
    if width(line) <= _LONG_RESULT:
        return line
    name = types.new_name(f"{label[:1].upper()}{label[1:]}Result")
    items = [f"{INDENT}{kind.replace(OWN, '')}," for kind in kinds]
    types.pending.append([f"{name} = tuple[", *items, "]"])
    return f"{OWN}{name}"


def _attribute(attribute: Attribute, taken: Taken, types: Annotations) -> Iterator[GeneratedMethod]:
    kind, words = types.of(attribute.type), in_words(attribute.name)
    doc = attribute.doc or f"Return the {words}"
    yield GeneratedMethod(taken.add(f"get_{attribute.name}"), (), kind, doc)
    if not attribute.is_readonly:
        name = taken.add(f"set_{attribute.name}")
        yield GeneratedMethod(name, (("value", kind),), "None", f"Change the {words}")


def signature(method: GeneratedMethod, prefix: str, indent: str) -> list[str]:
    """Return the lines of ``def …:``; `prefix` is how code gets at the types."""
    given = ["self", *(f"{name}: {kind}" for name, kind in method.parameters)]
    head = f"{indent}def {method.name}("
    tail = f") -> {method.result}:".replace(OWN, prefix)
    plain = [each.replace(OWN, prefix) for each in given]
    line = f"{head}{', '.join(plain)}{tail}"
    if width(line) <= WIDTH:
        return [line]
    return [head, *(f"{indent}{INDENT}{each}," for each in plain), f"{indent}{tail}"]


def documentation(method: GeneratedMethod, names: Callable[[Path], str], indent: str) -> list[str]:
    """Return the lines of the docstring; `names` gives those of exceptions."""
    sections: list[str] = []
    if method.results:
        listed = [f"``{name}``" if name else "the result" for name in method.results]
        sections += ["", "Returns:", f"{INDENT}{sentence(_listed(listed))}"]
    if method.raises:
        listed = [
            f"{INDENT}{names(path)}: As the interface definition says." for path in method.raises
        ]
        sections += ["", "Raises:", *listed]
    return docstring(sentence(in_words(method.name)), method.doc, indent=indent, sections=sections)


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
