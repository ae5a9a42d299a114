"""Reads what components of an old module declare: specification, ports, parameters, data."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import TypeGuard

from rtkit.component.values.type_layout import Layout, StructLayout, layout_of
from rtkit.openrtm.convert.component_model import (
    BoundData,
    OldComponent,
    OldPort,
    PartUse,
    Path,
    is_self,
    text_of,
)
from rtkit.openrtm.convert.draft import API, ModuleDraft
from rtkit.openrtm.convert.edits import SourceEdits

ADDS = ("addInPort", "addOutPort", "registerInPort", "registerOutPort")
"""Methods that made a port one of the component."""
PREPARING = ("__init__", "onInitialize")
"""Methods whose statements declare the outside of a component."""


def read_components(draft: ModuleDraft) -> list[OldComponent]:
    """Return the components that a module registers, in the order of their classes."""
    specs = {
        node.targets[0].id: _spec(node.value)
        for node in draft.source.tree.body
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and isinstance(node.value, (ast.List, ast.Tuple))
    }
    registered = dict(_registrations(draft, specs))
    found = []
    for node in draft.source.tree.body:
        if isinstance(node, ast.ClassDef) and _is_component(draft, node):
            component = OldComponent(node, dict(registered.get(node.name, {})))
            _read_ports(draft, component)
            found.append(component)
    _mark_heirs(draft, {each.node.name for each in found})
    return found


def _mark_heirs(draft: ModuleDraft, names: set[str]) -> None:
    """Mark classes that derive from a component of the module: what they inherit is renamed."""
    for node in draft.source.tree.body:
        if not isinstance(node, ast.ClassDef):
            continue
        if any(isinstance(base, ast.Name) and base.id in names for base in node.bases):
            names.add(node.name)
            draft.mark(node, "it derives from a component of this file, which is another now")


def _is_component(draft: ModuleDraft, node: ast.ClassDef) -> bool:
    return any(draft.qualified(base) == f"{API}.DataFlowComponentBase" for base in node.bases)


def _spec(node: ast.List | ast.Tuple) -> dict[str, str]:
    texts = [text_of(each) or "" for each in node.elts]
    return dict(zip(texts[::2], texts[1::2], strict=False))


def _registrations(
    draft: ModuleDraft, specs: Mapping[str, dict[str, str]]
) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield each class that is registered with its specification."""
    for function in ast.walk(draft.source.tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        profiles = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                profiles[node.targets[0].id] = node.value
        for node in ast.walk(function):
            if is_call_of_method(node, "registerFactory") and len(node.args) > 1:
                given = node.args[0]
                if isinstance(given, ast.Name):
                    given = profiles.get(given.id, given)
                if isinstance(node.args[1], ast.Name):
                    yield node.args[1].id, _given_spec(draft, given, specs)


def is_call_of_method(node: ast.AST, *names: str) -> TypeGuard[ast.Call]:
    """Return whether a node calls a method of one of these names, of whatever object."""
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr in names
    )


def _given_spec(
    draft: ModuleDraft, node: ast.expr, specs: Mapping[str, dict[str, str]]
) -> dict[str, str]:
    if draft.call_of(node) != f"{API}.Properties" or not isinstance(node, ast.Call):
        return {}
    for given in [*node.args, *(each.value for each in node.keywords)]:
        if isinstance(given, ast.Name):
            return specs.get(given.id, {})
        if isinstance(given, (ast.List, ast.Tuple)):
            return _spec(given)
    return {}


def data_type_of(draft: ModuleDraft, node: ast.AST) -> type | None:
    """Return the data type of a value that an expression makes: by its constructor, or generic."""
    name = draft.call_of(node)
    if not name or not isinstance(node, ast.Call):
        return None
    if name == f"{API}.instantiateDataType" and node.args:
        return draft.data_class(draft.qualified(node.args[0]))
    return draft.data_class(name)


def _read_ports(draft: ModuleDraft, component: OldComponent) -> None:
    """Read the data ports of a class and the data that they are bound to."""
    made = dict(_assigned(component))
    added = {
        node.args[1].attr
        for node in ast.walk(component.node)
        if is_call_of_method(node, *ADDS) and len(node.args) > 1 and is_self(node.args[1])
    }
    for attribute, (statement, value) in made.items():
        kind = draft.call_of(value).removeprefix(f"{API}.")
        if kind not in ("InPort", "OutPort") or attribute not in added:
            continue
        port = _port(draft, component, attribute, statement, made)
        if port is not None:
            component.ports[attribute] = port
    for node in ast.walk(component.node):
        if isinstance(node, ast.Attribute) and is_self(node):
            data = component.data.get(node.attr)
            if data is not None:
                _note_access(draft, component, data, node)
        if isinstance(node, ast.Call) and not node.args and not node.keywords:
            written = written_port(component, node)
            if written is not None and written.bound:
                component.data[written.bound].writes.append((node, written))


def _assigned(component: OldComponent) -> Iterator[tuple[str, tuple[ast.Assign, ast.expr]]]:
    """Yield the attributes that get a value where nothing is conditional, with the statement."""
    for method in component.methods:
        if method.name in PREPARING:
            for statement in method.body:
                if isinstance(statement, ast.Assign) and is_self(statement.targets[0]):
                    yield statement.targets[0].attr, (statement, statement.value)


def _port(
    draft: ModuleDraft,
    component: OldComponent,
    attribute: str,
    statement: ast.Assign,
    made: Mapping[str, tuple[ast.Assign, ast.expr]],
) -> OldPort | None:
    call = statement.value
    assert isinstance(call, ast.Call)
    name = text_of(call.args[0]) if call.args else None
    if name is None or len(call.args) < 2:
        return None
    kind = draft.call_of(call).removeprefix(f"{API}.")
    given = call.args[1]
    if not is_self(given):
        cls = data_type_of(draft, given)
        return OldPort(attribute, name, kind, cls, "") if cls else None
    bound = given.attr
    initial = made[bound][1] if bound in made else None
    cls = data_type_of(draft, initial) if initial is not None else None
    if cls is None:
        return None
    if bound not in component.data:
        assert isinstance(initial, ast.Call)
        component.data[bound] = BoundData(
            bound, cls, layout_of(cls), initial, [made[bound][0]], port_name=name
        )
    return OldPort(attribute, name, kind, cls, bound)


def _note_access(
    draft: ModuleDraft, component: OldComponent, data: BoundData, node: ast.Attribute
) -> None:
    source = draft.source
    parent, statement = source.parent(node), source.statement(node)
    if statement in data.made_at:
        return
    is_stamp = draft.call_of(parent) == f"{API}.setTimestamp"
    if is_stamp and isinstance(statement, ast.Expr) and statement.value is parent:
        data.stamps.append(statement)
        return
    if isinstance(parent, ast.Call) and node in parent.args:
        if draft.call_of(parent) in (f"{API}.InPort", f"{API}.OutPort"):
            return
        port = written_port(component, parent)
        if port is not None and port.bound == data.attribute:
            data.writes.append((parent, port))
            return
    top, path, _ = descend(source, node, data.layout)
    data.accesses.append(PartUse(top, path, usage(source, top)))
    if not path and isinstance(getattr(top, "ctx", None), ast.Store):
        data.rebound.append(statement)


def written_port(component: OldComponent, call: ast.Call) -> OldPort | None:
    """Return the port that a call writes to; None where it does not."""
    function = call.func
    if isinstance(function, ast.Attribute) and function.attr == "write" and is_self(function.value):
        return component.ports.get(function.value.attr)
    return None


def descend(source: SourceEdits, node: ast.expr, layout: Layout) -> tuple[ast.expr, Path, Layout]:
    """Return the largest expression that begins with a value and goes down its fields only."""
    path: Path = ()
    while isinstance(layout, StructLayout):
        parent = source.parent(node)
        fields = dict(layout.fields)
        if not (isinstance(parent, ast.Attribute) and parent.value is node):
            break
        if parent.attr not in fields:
            break
        path, layout, node = (*path, parent.attr), fields[parent.attr], parent
    return node, path, layout


def usage(source: SourceEdits, node: ast.expr) -> str:
    """Return how an expression is used: ``load``, ``store``, ``change`` or ``delete``."""
    context = getattr(node, "ctx", None)
    if isinstance(context, ast.Del):
        return "delete"
    if not isinstance(context, ast.Store):
        return "load"
    parent = source.parent(node)
    return "change" if isinstance(parent, ast.AugAssign) and parent.target is node else "store"
