"""Names of OpenRTM-aist that a source uses and rtkit does not have, found without running it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.openrtm.absent import is_absent
from rtkit.openrtm.api.rtobject import ABSENT_METHODS
from rtkit.openrtm.loading.names import shared_module
from rtkit.openrtm.migrate.source import mended

_METHODS = frozenset(ABSENT_METHODS.split())


class AbsentUse(NamedTuple):
    """A place that names what is absent.

    Attributes:
        line: Of the source, from 1.
        name: As the documentation of OpenRTM has it.
    """

    line: int
    name: str


def absences_in(source: bytes, file: str) -> list[AbsentUse]:
    """Return each name once, at its first place, in the order of lines.

    Raises:
        Refused: The source is Python 2; names the line, and the command that converts it.
        Malformed: It is Python of no version; names the line.
    """
    try:
        tree = ast.parse(mended(source, file), file)
    except SyntaxError as error:
        raise Malformed(f"{file}:{error.lineno or 1}: {error.msg}") from error
    modules = dict(_imported(tree))
    own = {each.name for each in ast.walk(tree) if isinstance(each, ast.FunctionDef)}
    first: dict[str, int] = {}
    for line, name in _used(tree, modules, own):
        first[name] = min(line, first.get(name, line))
    return sorted(AbsentUse(line, name) for name, line in first.items())


def _imported(tree: ast.Module) -> Iterator[tuple[str, Any]]:
    """Yield what is imported of OpenRTM and CORBA, by the name that the source gives it."""
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                for each in names:
                    top = each.name if each.asname else each.name.partition(".")[0]
                    yield each.asname or top, shared_module(top)
            case ast.ImportFrom(module=str(module), level=0, names=names):
                home = shared_module(module)
                for each in names:
                    yield each.asname or each.name, getattr(home, each.name, None)


def _used(tree: ast.Module, modules: dict[str, Any], own: set[str]) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) if is_absent(modules.get(name)):
                yield node.lineno, str(modules[name].__doc__)
            case ast.Attribute(value=ast.Name(id="self"), attr=name):
                if name in _METHODS and name not in own:
                    yield node.lineno, f"RTObject.{name}"
            case ast.Attribute(value=value, attr=name):
                found = _value(node, modules)
                if is_absent(found) and not is_absent(_value(value, modules)):
                    yield node.lineno, str(found.__doc__)


def _value(node: ast.expr, modules: dict[str, Any]) -> Any:
    """Return what a dotted name of an imported module stands for; None for all else."""
    match node:
        case ast.Name(id=name):
            return modules.get(name)
        case ast.Attribute(value=value, attr=name):
            return getattr(_value(value, modules), name, None)
    return None
