"""One module that is converted: its source, its names, and what needs a hand."""

from __future__ import annotations

import ast
import builtins
import keyword
import os
import re
from collections.abc import Iterable, Iterator
from glob import escape, glob
from typing import NamedTuple

from rtkit.component.standard import SCOPES, find, home_of
from rtkit.openrtm.convert.edits import SourceEdits

API = "OpenRTM_aist"
MARK = "# rtkit convert: "
"""Begins the comment at each place that needs a hand."""
FOREIGN = frozenset(
    {API, "OpenRTM", "RTC", "RTC__POA", "Img", "omniORB", "CORBA", "SDOPackage", "RTM"}
)
"""Modules that native components do not import."""


class HandWork(NamedTuple):
    """A place that needs a hand.

    Attributes:
        line: Of the source that was converted.
        reason: In one line.
    """

    line: int
    reason: str


class ModuleDraft:
    """The source of a module, what its names mean, and what the native module will import.

    Attributes:
        source: The source and its edits.
        marks: What needs a hand, so far.
        imported: Names from `rtkit.component`, each with its name in the module.
        names: All names that the module uses.
        stubs: Modules it imports that a compiler of IDL made.
    """

    def __init__(self, text: str, folder: str = "") -> None:
        self.source = SourceEdits(text)
        self.marks: list[HandWork] = []
        self.imported: dict[str, str] = {}
        self.names = {
            name
            for node in ast.walk(self.source.tree)
            for name in (
                getattr(node, "id", None) if isinstance(node, ast.Name) else None,
                getattr(node, "name", None),
                getattr(node, "arg", None),
            )
            if isinstance(name, str)
        }
        self._aliases: dict[str, str] = {}
        self._has_star: set[str] = set()
        for node in ast.walk(self.source.tree):
            if isinstance(node, ast.Import):
                self._aliases |= {a.asname: a.name for a in node.names if a.asname}
            elif isinstance(node, ast.ImportFrom) and node.module in FOREIGN:
                for each in node.names:
                    if each.name == "*":
                        self._has_star.add(node.module)
                    else:
                        self._aliases[each.asname or each.name] = f"{node.module}.{each.name}"
        self.stubs = frozenset(_stubs(self.source.tree, folder))
        self.uses_replace = False
        self._replaces = "dataclasses.replace" if "replace" in self.names else "replace"

    def mark(self, node: ast.AST, reason: str) -> None:
        """Note that a place needs a hand, at the line of its statement."""
        statement = self.source.statement(node)
        mark = HandWork(getattr(node, "lineno", statement.lineno), reason)
        if any(each.reason == reason and each.line == mark.line for each in self.marks):
            return
        self.marks.append(mark)
        self.source.insert_before(statement, [MARK + reason])

    def qualified(self, node: ast.AST) -> str:
        """Return the dotted name of an expression, as its modules call it; "" for another one."""
        if isinstance(node, ast.Attribute):
            before = self.qualified(node.value)
            full = f"{before}.{node.attr}" if before else ""
            return full.removeprefix(f"{API}.") if full.startswith(f"{API}.RTC.") else full
        if not isinstance(node, ast.Name):
            return ""
        if node.id in self._aliases:
            return self._aliases[node.id]
        if "RTC" in self._has_star and (find("RTC", node.id) or node.id.startswith("RTC_")):
            return f"RTC.{node.id}"
        if API in self._has_star and node.id in _API_NAMES:
            return f"{API}.{node.id}"
        return node.id

    def call_of(self, node: ast.AST) -> str:
        """Return the dotted name of what a call calls; "" for what is no call."""
        return self.qualified(node.func) if isinstance(node, ast.Call) else ""

    def data_class(self, name: str) -> type | None:
        """Return the standard data type of a dotted name, ``RTC.TimedLong``."""
        scope, _, last = name.rpartition(".")
        if scope not in SCOPES:
            return None
        home = home_of(scope, last)
        if not home:
            return None
        from importlib import import_module

        found: type = getattr(import_module(f"rtkit.component.{home}"), last)
        return found

    def native(self, name: str) -> str:
        """Return how the module calls something that it imports from `rtkit.component`."""
        known = self.imported.get(name)
        if known is None:
            own = self._own_names()
            known = self.imported[name] = f"Rt{name}" if name in own else name
        return known

    def data_name(self, cls: type) -> str:
        """Return how the module calls a data type."""
        if cls.__module__.endswith(".images"):
            return f"{self.native('images')}.{cls.__name__}"
        return self.native(cls.__name__)

    def replaced(self, value: str, field: str, text: str) -> str:
        """Return the expression of a value with another field."""
        self.uses_replace = True
        return f"{self._replaces}({value}, {field}={text})"

    def free(self, wanted: str, taken: Iterable[str]) -> str:
        """Return a name like the wanted one that nothing else has."""
        blocked = {*taken, *keyword.kwlist}
        name, number = wanted, 1
        if keyword.iskeyword(name):
            name = wanted = f"{wanted}_"
        while name in blocked:
            number += 1
            name = f"{wanted}{number}"
        return name

    def free_local(self, wanted: str) -> str:
        """Return a name for a variable that the module uses for nothing else."""
        name = self.free(wanted, {*self.names, *dir(builtins), *self.imported.values()})
        self.names.add(name)
        return name

    def _own_names(self) -> set[str]:
        """Return the names that the module itself binds at its top."""
        found: set[str] = set()
        for node in self.source.tree.body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                found.add(node.name)
            elif isinstance(node, ast.Assign):
                found |= {each.id for each in node.targets if isinstance(each, ast.Name)}
            elif isinstance(node, (ast.Import, ast.ImportFrom)):
                module = getattr(node, "module", None)
                if module not in FOREIGN:
                    found |= {each.asname or each.name for each in node.names}
        return found


def _stubs(tree: ast.Module, folder: str) -> Iterator[str]:
    """Yield the modules of an import that were generated of IDL."""
    modules = [
        each.name for node in ast.walk(tree) if isinstance(node, ast.Import) for each in node.names
    ]
    declared = _declared_modules(folder)
    for module in modules:
        base = module.removesuffix("__POA")
        if base != module:
            yield from (module, base)
        elif module in declared or module.endswith("_idl") or _is_generated(folder, module):
            yield module


def _declared_modules(folder: str) -> set[str]:
    """Return the modules that IDL files beside a component declare."""
    found: set[str] = set()
    for file in (
        *glob(f"{escape(folder or '.')}/*.idl"),
        *glob(f"{escape(folder or '.')}/idl/*.idl"),
    ):
        with open(file, encoding="utf-8", errors="replace") as stream:
            found.update(re.findall(r"^\s*module\s+(\w+)", stream.read(), re.MULTILINE))
    return (found | {"_GlobalIDL"}) - FOREIGN


def _is_generated(folder: str, module: str) -> bool:
    for name in (f"{module}/__init__.py", f"{module}.py"):
        try:
            with open(os.path.join(folder, name), "rb") as file:
                return b"omniORB" in file.read(_HEAD)
        except OSError:
            continue
    return False


_HEAD = 400
"""Bytes of a generated module in which its first imports stand."""
_API_NAMES = frozenset(
    {
        "CorbaConsumer", "CorbaPort", "DataFlowComponentBase", "Delete", "InPort", "Manager",
        "OutPort", "Properties", "instantiateDataType", "setTimestamp",
    }
)  # fmt: skip
"""Names that a star import of the API brings, those that are looked for."""
