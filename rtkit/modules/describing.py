"""Describes the component types of a module from its source, without running any of it.

Class attributes that are literals are understood, also of base classes and constants in the same
file. What a module decides only while it runs is reported as the reason for no description.
"""

from __future__ import annotations

import ast
import dataclasses
import os.path
import warnings
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rtkit.errors import Malformed
from rtkit.rtc.profiles import TypeProfile

_REGISTER = "register_factory"
_SERVED = "init_of"  # Init = init_of(Class): a class that is served as live properties
_OPENRTM, _REGISTER_THERE = b"OpenRTM_aist", b"registerFactory"
_LARGEST = 1 << 20


class OfferedType(NamedTuple):
    """A component type that a module would offer, and its parameters with their defaults."""

    type: TypeProfile
    parameters: Mapping[str, str]


def describe(
    source: bytes, file: str, init: str = "", package: str = ""
) -> list[OfferedType] | None:
    """Return what a file offers; None where it is plainly no module of components.

    Without `init` its init function is ``<name>Init``. The package, of an installed module, is
    the vendor of a served class.

    Raises:
        Malformed: It means to be one, but cannot be described; names the reason and the line.
    """
    init = init or f"{os.path.basename(file).partition('.')[0]}Init"
    if _OPENRTM in source and _REGISTER_THERE in source:
        return _openrtm_types(source, file)
    if init.encode() not in source and _REGISTER.encode() not in source:
        return None
    if len(source) > _LARGEST:
        raise Malformed(f"larger than {_LARGEST} bytes ({file}:1)")
    tree = _parse(source, file)
    classes = {each.name: each for each in tree.body if isinstance(each, ast.ClassDef)}
    names = _constants(tree.body, {})
    functions = (each for each in tree.body if isinstance(each, ast.FunctionDef))
    function = next((each for each in functions if each.name == init), None)
    if function is None:
        served = _served(tree, init)
        if served is None:
            raise Malformed(f"no init function {init} ({file}:1)")
        return [_offer_service(served, classes, names, package.partition(".")[0], file)]
    registered = list(_registered(function, file))
    missing = next((each for each in registered if each.id not in classes), None)
    if missing is not None:
        raise Malformed(f"{missing.id} is not defined in this file ({file}:{missing.lineno})")
    return [_offer(classes[each.id], classes, names) for each in registered]


def _openrtm_types(source: bytes, file: str) -> list[OfferedType]:
    from rtkit.openrtm.api.identity import type_of
    from rtkit.openrtm.loading.specification import specifications

    prefix = "conf.default."
    return [
        OfferedType(
            type_of(each),
            {k.removeprefix(prefix): text for k, text in each.items() if k.startswith(prefix)},
        )
        for each in specifications(source, file)
    ]


def _parse(source: bytes, file: str) -> ast.Module:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(source, file)
    except SyntaxError as error:
        raise Malformed(f"SyntaxError: {error.msg} ({file}:{error.lineno or 1})") from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise Malformed(f"{type(error).__name__}: {error} ({file}:1)") from None


def _registered(function: ast.FunctionDef, file: str) -> Iterator[ast.Name]:
    """Yield the names of the classes that an init function registers."""
    is_any = False
    for node in ast.walk(function):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        if node.func.attr != _REGISTER:
            continue
        is_any = True
        if not node.args or not isinstance(node.args[0], ast.Name):
            raise Malformed(f"registers what is known only when it runs ({file}:{node.lineno})")
        yield node.args[0]
    if not is_any:
        raise Malformed(f"{function.name} registers nothing ({file}:{function.lineno})")


def _served(tree: ast.Module, init: str) -> ast.Call | None:
    """Return the call of init_of that is the init function."""
    for node in tree.body:
        if not isinstance(node, ast.Assign) or not isinstance(node.value, ast.Call):
            continue
        called = node.value.func
        name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
        is_meant = any(isinstance(each, ast.Name) and each.id == init for each in node.targets)
        if is_meant and name == _SERVED:
            return node.value
    return None


def _offer_service(
    call: ast.Call,
    classes: Mapping[str, ast.ClassDef],
    names: Mapping[str, object],
    vendor: str,
    file: str,
) -> OfferedType:
    if not call.args or not isinstance(call.args[0], ast.Name):
        raise Malformed(f"serves what is known only when it runs ({file}:{call.lineno})")
    name = call.args[0].id
    given = {
        each.arg: each.value.value for each in call.keywords if isinstance(each.value, ast.Constant)
    }
    known = _offer(classes[name], classes, names).type if name in classes else TypeProfile(name)
    profile = dataclasses.replace(
        known,
        type_name=name,
        vendor=vendor,
        category=str(given.get("category", "service")),
        version=str(given.get("version") or known.version or "1.0"),
    )
    return OfferedType(profile, {})


def _offer(
    chosen: ast.ClassDef, classes: Mapping[str, ast.ClassDef], names: Mapping[str, object]
) -> OfferedType:
    attributes: dict[str, object] = {}
    parameters: dict[str, str] = {}
    for each in reversed(_ancestry(chosen, classes, [])):
        attributes.update(_constants(each.body, names))
        parameters.update(_parameters(each.body, names))

    def text(key: str) -> str:
        value = attributes.get(key)
        return value if isinstance(value, str) else ""

    described = (ast.get_docstring(chosen) or "").strip().partition("\n\n")[0]
    profile = TypeProfile(
        type_name=text("type_name") or chosen.name,
        vendor=text("vendor"),
        category=text("category"),
        version=text("version"),
        description=" ".join(described.split()),
    )
    return OfferedType(profile, parameters)


def _ancestry(
    chosen: ast.ClassDef, classes: Mapping[str, ast.ClassDef], seen: list[ast.ClassDef]
) -> list[ast.ClassDef]:
    """Return a class and its bases of the same file, the nearest first."""
    if chosen in seen:
        return seen
    seen.append(chosen)
    for base in chosen.bases:
        if isinstance(base, ast.Name) and base.id in classes:
            _ancestry(classes[base.id], classes, seen)
    return seen


def _assignments(body: list[ast.stmt]) -> Iterator[tuple[str, ast.expr]]:
    for each in body:
        if isinstance(each, ast.Assign) and len(each.targets) == 1:
            target, value = each.targets[0], each.value
        elif isinstance(each, ast.AnnAssign) and each.value is not None:
            target, value = each.target, each.value
        else:
            continue
        if isinstance(target, ast.Name):
            yield target.id, value
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for name, each_value in zip(target.elts, value.elts, strict=False):
                if isinstance(name, ast.Name):
                    yield name.id, each_value


def _constants(body: list[ast.stmt], names: Mapping[str, object]) -> dict[str, object]:
    found: dict[str, object] = {}
    for name, node in _assignments(body):
        if isinstance(node, ast.Constant):
            found[name] = node.value
        elif isinstance(node, ast.Name) and node.id in names:
            found[name] = names[node.id]
    return found


def _parameters(body: list[ast.stmt], names: Mapping[str, object]) -> dict[str, str]:
    found = {}
    for name, node in _assignments(body):
        if not isinstance(node, ast.Call):
            continue
        called = node.func.attr if isinstance(node.func, ast.Attribute) else node.func
        if called == "Parameter" or (isinstance(called, ast.Name) and called.id == "Parameter"):
            default = node.args[0] if node.args else None
            own = _name(node) or name.rstrip("_")
            if isinstance(default, ast.Name):
                found[own] = str(names.get(default.id, ""))
            elif default is not None:
                found[own] = _literal(default)
    return found


def _name(call: ast.Call) -> str:
    """Return the name that a declaration gives itself; empty when it is that of its attribute."""
    for each in call.keywords:
        if each.arg == "name" and isinstance(each.value, ast.Constant):
            return str(each.value.value)
    return ""


def _literal(node: ast.expr) -> str:
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return ""
    return ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
