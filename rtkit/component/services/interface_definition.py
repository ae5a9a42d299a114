"""Writes service interfaces as IDL text, by which service ports describe their operations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.component.services.interface import Interface, InterfaceMethod
from rtkit.component.values.definition import _definitions, _field, _word, word_of
from rtkit.component.values.type_layout import ArrayLayout, Layout
from rtkit.errors import Malformed


def definition_of(interfaces: Iterable[Interface]) -> str:
    """Return the IDL definitions of interfaces, behind those of all that they need.

    Operations that IDL has no words for are left out.
    """
    writer = _Writer()
    return "\n".join([line for each in interfaces for line in writer.interface(each)])


class _Writer:
    """Writes each type that several interfaces need once."""

    def __init__(self) -> None:
        self._known: dict[str, object] = {}
        self._exceptions: dict[str, str] = {}

    def interface(self, interface: Interface) -> Iterator[str]:
        """Yield the definitions that are new, that of the interface last."""
        *modules, name = (_word(each) for each in interface.name.split("::"))
        needed: list[str] = []
        operations: list[str] = []
        for method in interface.methods.values():
            try:
                before, operation = self._operation(method)
            except Malformed:
                continue
            needed += before
            operations.append(f"    {operation};\n")
        yield from needed
        inner = f"  interface {name} {{\n{''.join(operations)}  }};\n"
        yield "".join(f"module {each} {{\n" for each in modules) + inner + "};\n" * len(modules)

    def _operation(self, method: InterfaceMethod) -> tuple[list[str], str]:
        """Return what an operation needs, and its declaration.

        Raises:
            Malformed: IDL has no words for it.
        """
        needed: list[str] = []
        prefix = method.label.replace("::", "_").replace(".", "_")
        given = [
            f"in {self._type(item, f'{prefix}_{name}', needed)} {_word(name)}"
            for name, item in method.layouts.items()
        ]
        names, results = method.results
        kinds = [
            self._type(each, f"{prefix}_{number}", needed) for number, each in enumerate(results)
        ]
        result = kinds[0] if names[:1] == ("",) else "void"
        back = [
            f"out {kind} {_word(name)}" for kind, name in zip(kinds, names, strict=True) if name
        ]
        raised = [self._exception(name, each, needed) for name, each in method.exceptions.items()]
        tail = f" raises ({', '.join(raised)})" if raised else ""
        return needed, f"{result} {_word(method.name)}({', '.join(given + back)}){tail}"

    def _type(self, layout: Layout, name: str, needed: list[str]) -> str:
        """Return the word for a type; an array gets the name, as IDL wants one here.

        Raises:
            Malformed: IDL has no words for it, or they would be read as another type.
        """
        if "sequence<uint8>" in layout.name:
            raise Malformed("a list of numbers that would be read as bytes")
        needed += _definitions(layout, self._known)
        if not isinstance(layout, ArrayLayout):
            return word_of(layout)
        needed.append(f"typedef {_field(layout, name)};")
        return name

    def _exception(self, name: str, members: dict[str, Layout], needed: list[str]) -> str:
        for item in members.values():
            needed += _definitions(item, self._known)
        fields = "".join(f" {_field(item, each)};" for each, item in members.items())
        text = f"exception {_word(name)} {{{fields} }};"
        if self._exceptions.setdefault(name, text) != text:
            raise Malformed(f"two exceptions are called {name}")
        if text not in needed and self._exceptions[name] is text:
            needed.append(text)
        return _word(name)
