"""Finds bytes that go where a port carries text: Python 2 made no difference, a port does.

The old API drops such a value without an error; a native port raises one.
"""

from __future__ import annotations

import ast

from rtkit.component.values.type_layout import BasicLayout, ItemsLayout, Layout, layout_of
from rtkit.openrtm.convert.component_model import OldComponent
from rtkit.openrtm.convert.data_plans import DataPlan, part_of
from rtkit.openrtm.convert.draft import ModuleDraft
from rtkit.openrtm.convert.reading import data_type_of, is_call_of_method

_REASON = "encode() makes bytes, but this is a text: leave it out"


def mark_bytes(draft: ModuleDraft, component: OldComponent, plans: dict[str, DataPlan]) -> None:
    """Mark where what `encode` returned becomes a text of a value."""
    for plan in plans.values():
        for access in plan.data.accesses:
            store = plan.stores.get(id(access.node))
            if store is not None and _is_text(part_of(plan.data.layout, access.path)):
                _check(draft, store.value)
    for node in ast.walk(component.node):
        cls = data_type_of(draft, node)
        if cls is not None and isinstance(node, ast.Call):
            for (_, layout), given in zip(layout_of(cls).fields, node.args, strict=False):
                if _is_text(layout):
                    _check(draft, given)


def _is_text(layout: Layout) -> bool:
    if isinstance(layout, ItemsLayout):
        return _is_text(layout.item)
    return isinstance(layout, BasicLayout) and layout.cls is str


def _check(draft: ModuleDraft, node: ast.expr) -> None:
    method = draft.source.method(node)
    if _is_encoded(node) or (
        isinstance(node, ast.Name) and method is not None and _holds_bytes(method, node.id)
    ):
        draft.mark(node, _REASON)


def _is_encoded(node: ast.AST) -> bool:
    return is_call_of_method(node, "encode")


def _holds_bytes(method: ast.FunctionDef, name: str) -> bool:
    """Return whether a variable is given bytes, or a list is given some, anywhere in a method."""
    for node in ast.walk(method):
        if isinstance(node, ast.Assign) and _is_encoded(node.value):
            if any(isinstance(each, ast.Name) and each.id == name for each in node.targets):
                return True
        elif is_call_of_method(node, "append") and node.args and _is_encoded(node.args[0]):
            function = node.func
            assert isinstance(function, ast.Attribute)
            if isinstance(function.value, ast.Name) and function.value.id == name:
                return True
    return False
