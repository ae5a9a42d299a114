"""Rewrites expressions of a component: ports, parameters, data values, names of the API."""

from __future__ import annotations

import ast

from rtkit.component.values.type_layout import StructLayout, layout_of
from rtkit.openrtm.convert.component_model import OldComponent, is_self
from rtkit.openrtm.convert.data_plans import DataPlan
from rtkit.openrtm.convert.draft import API, ModuleDraft
from rtkit.openrtm.convert.foreign import LISTENER
from rtkit.openrtm.convert.naming import CALLBACKS, SIMPLE
from rtkit.openrtm.convert.reading import data_type_of, is_call_of_method
from rtkit.openrtm.convert.value_types import ValueTypes
from rtkit.openrtm.convert.values import changed, constructor, default_value, is_guarded

_CODES = {"RTC_OK": "OK", "RTC_ERROR": "ERROR"}
_RETURN_CODES = frozenset(
    {
        "RTC_OK", "RTC_ERROR", "BAD_PARAMETER", "UNSUPPORTED", "OUT_OF_RESOURCES",
        "PRECONDITION_NOT_MET",
    }
)  # fmt: skip
_LEVELS = {
    "RTC_FATAL": "critical", "RTC_ERROR": "error", "RTC_WARN": "warning", "RTC_INFO": "info",
    "RTC_DEBUG": "debug", "RTC_TRACE": "debug", "RTC_VERBOSE": "debug", "RTC_PARANOID": "debug",
}  # fmt: skip
_PORT_CALLS = {"isNew": "is_new"}
_SET_ONLY = "a parameter is changed in configuration sets only"


class ExpressionWriter:
    """Writes the native form of expressions in a component."""

    def __init__(
        self,
        draft: ModuleDraft,
        component: OldComponent,
        plans: dict[str, DataPlan],
        types: ValueTypes,
    ) -> None:
        self._draft = draft
        self._source = draft.source
        self._component = component
        self._plans = plans
        self._types = types

    def write(self) -> None:
        """Edit all expressions of the class, inner ones first."""
        nodes = [each for each in ast.walk(self._component.node) if isinstance(each, ast.expr)]
        for node in reversed(nodes):  # children come after their parents
            if not self._source.is_removed(node):
                self._edit(node)

    def _edit(self, node: ast.expr) -> None:
        if isinstance(node, ast.Call):
            self._edit_call(node)
        elif isinstance(node, ast.Attribute):
            self._edit_attribute(node)
        elif isinstance(node, ast.Subscript):
            self._edit_subscript(node)
        elif isinstance(node, ast.Name) and not write_name(self._draft, node):
            self._give_list(node)

    def _edit_call(self, node: ast.Call) -> None:
        function = node.func
        if data_type_of(self._draft, node) is not None:
            self._source.replace(node, constructor(self._draft, node))
        elif self._types.read_port(node) is not None:
            self._edit_read(node)
        elif is_call_of_method(node, *_LEVELS):
            self._edit_log(node)
        elif is_self(function) and function.attr in SIMPLE and not node.args:
            self._source.replace(node, f"self.{SIMPLE[function.attr]}")

    def _edit_read(self, node: ast.Call) -> None:
        port = self._types.read_port(node)
        if port is None or isinstance(self._source.parent(node), ast.Expr) or self._is_unused(node):
            return
        if not is_guarded(self._draft, node):
            text = f"{self._source.render(node)} or {default_value(self._draft, port)}"
            outer = self._source.parent(node)
            is_plain = isinstance(outer, (ast.Assign, ast.Return, ast.Call))
            self._source.replace(node, text if is_plain else f"({text})")

    def _is_unused(self, node: ast.Call) -> bool:
        """Return whether nobody looks at what a port is read into."""
        store = self._source.parent(node)
        return any(store in plan.unused_stores() for plan in self._plans.values())

    def _edit_log(self, node: ast.Call) -> None:
        """Write a message for a logger of the component."""
        function = node.func
        assert isinstance(function, ast.Attribute)
        if not is_self(function.value, "_rtcout"):
            return
        level = _LEVELS[function.attr]
        texts = [self._source.render(each) for each in node.args]
        if len(node.args) > 1 and isinstance(node.args[1], ast.Tuple):
            texts[1:] = [self._source.render(each) for each in node.args[1].elts]
        self._source.replace(node, f"self.logger.{level}({', '.join(texts)})")

    def _edit_attribute(self, node: ast.Attribute) -> None:
        if write_name(self._draft, node):
            return
        if is_self(node):
            self._edit_member(node)
        else:
            self._edit_part(node)

    def _edit_member(self, node: ast.Attribute) -> None:
        port = self._component.ports.get(node.attr)
        parameter = self._component.parameters.get(node.attr)
        if port is not None:
            self._edit_port(node, port.native)
        elif parameter is not None:
            parent = self._source.parent(node)
            is_first = isinstance(parent, ast.Subscript) and _is_zero(parent.slice)
            if not isinstance(node.ctx, ast.Load):
                self._draft.mark(node, _SET_ONLY)
            elif not is_first:
                self._source.replace(node, f"[{parameter.value}]")
        elif node.attr in self._plans:
            self._edit_data(node)
        elif node.attr in CALLBACKS:
            self._source.rename(node, CALLBACKS[node.attr])

    def _edit_port(self, node: ast.Attribute, native: str) -> None:
        self._source.rename(node, native)
        method = self._source.parent(node)
        if isinstance(method, ast.Attribute) and method.attr in _PORT_CALLS:
            self._source.rename(method, _PORT_CALLS[method.attr])
        elif not (isinstance(method, ast.Attribute) and method.attr in ("read", "write", "name")):
            self._draft.mark(node, _why_not(method))

    def _edit_data(self, node: ast.Attribute) -> None:
        """Put the native expression in the place of a part of bound data."""
        plan = self._plans[node.attr]
        access = next((a for a in plan.data.accesses if _reaches(a.node, node)), None)
        if access is None:
            return
        leaf = plan.leaf_of(access.path)
        part: ast.expr = access.node
        for _ in range(len(access.path) - len(leaf)):
            assert isinstance(part, ast.Attribute)
            part = part.value
        self._source.replace(part, plan.leaves[leaf])
        if part is access.node:
            self._give_list(part)

    def _edit_part(self, node: ast.Attribute) -> None:
        self._give_list(node)

    def _edit_subscript(self, node: ast.Subscript) -> None:
        if is_self(node.value):
            parameter = self._component.parameters.get(node.value.attr)
            if parameter is not None and _is_zero(node.slice):
                if not isinstance(node.ctx, ast.Load):
                    self._draft.mark(node, _SET_ONLY)
                    return
                text = parameter.value
                is_kept = not parameter.is_list or self._types.borrows(node)
                self._source.replace(node, text if is_kept else f"list({text})")
                return
        self._give_list(node)

    def _give_list(self, node: ast.expr) -> None:
        """Make a list of a received sequence where its tuple would not do."""
        if not isinstance(getattr(node, "ctx", None), ast.Load) or not self._types.is_tuple(node):
            return
        if self._types.changes_in_place(node):
            self._draft.mark(node, "a received value is changed in place: build a new one")
            return
        if self._types.borrows(node) or self._is_passed_on(node):
            return
        inner: ast.expr = node
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice):
            bounds = (node.slice.lower, node.slice.upper, node.slice.step)
            inner = node.value if bounds == (None, None, None) else node
        value = self._types.value_of(node)
        is_text = value is not None and value.layout.name == "sequence<char>"
        make = '"".join' if is_text else "list"
        self._source.replace(node, f"{make}({self._source.render(inner)})")

    def _is_passed_on(self, node: ast.expr) -> bool:
        """Return whether a sequence goes into a value, or into a variable that it stays in."""
        parent = self._source.parent(node)
        if isinstance(parent, ast.Call) and data_type_of(self._draft, parent) is not None:
            return True
        if not isinstance(parent, ast.Assign) or len(parent.targets) != 1:
            return False
        target = parent.targets[0]
        if isinstance(target, ast.Name):
            return self._types.is_tuple(target) and target.id not in self._types.lists
        return any(
            access.node is target
            and access.path
            and access.path in plan.leaves
            and plan.way == "inline"
            for plan in self._plans.values()
            for access in plan.data.accesses
        )

    def stamp(self, statement: ast.Expr) -> None:
        """Write the statement that sets the time of a value that no port is bound to."""
        call = statement.value
        if self._draft.call_of(call) != f"{API}.setTimestamp" or self._source.is_removed(statement):
            return
        assert isinstance(call, ast.Call)
        given = call.args[0] if call.args else call
        value = self._types.value_of(given)
        is_plain = isinstance(given, ast.Name) or (is_self(given) and not self._is_bound(given))
        if value is None or not is_plain or not isinstance(value.layout, StructLayout):
            return
        place, now = self._source.render(given), f"{self._draft.native('Time')}.now()"
        if "tm" in dict(value.layout.fields):
            text = self._draft.replaced(place, "tm", now)
            self._source.replace(statement, f"{place} = {text}")

    def _is_bound(self, node: ast.expr) -> bool:
        return getattr(node, "attr", "") in self._plans

    def store_part(self, statement: ast.stmt) -> None:
        """Write the statement that sets a field of a value: another value takes its place."""
        for node in ast.walk(statement):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                self._check_store(statement, node)
        if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
            target: ast.expr = statement.targets[0]
        elif isinstance(statement, ast.AugAssign):
            target = statement.target
        else:
            return
        found = self._root_of(target)
        if found is None:
            return
        root, path = found
        if isinstance(root, ast.Name) and self._types.is_alias(root):
            self._draft.mark(root, "a part of another value is changed by a second name")
        text = self._source.render(statement.value)
        if isinstance(statement, ast.AugAssign):
            operator = self._operator(statement)
            text = f"{self._source.render(target)} {operator} {_in_brackets(statement.value, text)}"
        place = self._source.render(root)
        self._source.replace(statement, f"{place} = {changed(self._draft, place, path, text)}")

    def _check_store(self, statement: ast.stmt, node: ast.Attribute) -> None:
        """Mark a field that is set in a way that no value can be put in its place."""
        targets = getattr(statement, "targets", [getattr(statement, "target", None)])
        is_only = len(targets) == 1 and targets[0] is node
        if not is_only and self._root_of(node) is not None:
            self._draft.mark(
                node, "a field of a value is set together with others: build a new one"
            )
        if not is_self(node) and self._types.may_be_item(node.value) and self._has_field(node.attr):
            self._draft.mark(node, "this may change a value of a data type, which is frozen")

    def _has_field(self, name: str) -> bool:
        """Return whether a data type that the component makes has a field of that name."""
        made = (data_type_of(self._draft, node) for node in ast.walk(self._component.node))
        layouts = (layout_of(cls) for cls in set(made) if cls is not None)
        return any(name in dict(layout.fields) for layout in layouts)

    def _operator(self, statement: ast.AugAssign) -> str:
        between = self._source.text(statement)[len(self._source.text(statement.target)) :]
        return between.partition("=")[0].strip()

    def _root_of(self, target: ast.expr) -> tuple[ast.expr, tuple[str, ...]] | None:
        """Return the value that a target is a field of, and the way down to that field."""
        path: tuple[str, ...] = ()
        node = target
        while isinstance(node, ast.Attribute) and not is_self(node):
            if self._is_leaf(node):
                break
            outer = self._types.value_of(node.value)
            if outer is None or not isinstance(outer.layout, StructLayout):
                break
            path, node = (node.attr, *path), node.value
        return (node, path) if path else None

    def _is_leaf(self, node: ast.expr) -> bool:
        """Return whether a part of bound data is kept by itself."""
        for plan in self._plans.values():
            for access in plan.data.accesses:
                part, path = access.node, access.path
                while path and path not in plan.leaves and isinstance(part, ast.Attribute):
                    part, path = part.value, path[:-1]
                if part is node and path in plan.leaves:
                    return True
        return False


def write_name(draft: ModuleDraft, node: ast.AST) -> bool:
    """Write a name of the API, or a call that makes a value; return whether it is one."""
    if isinstance(node, ast.Call) and data_type_of(draft, node) is not None:
        draft.source.replace(node, constructor(draft, node))
        return True
    if not isinstance(node, (ast.Attribute, ast.Name)):
        return False
    name = draft.qualified(node)
    scope, _, last = name.rpartition(".")
    cls = draft.data_class(name)
    if scope == "RTC" and last in _RETURN_CODES:
        code = draft.native("ReturnCode")
        draft.source.replace(node, f"{code}.{_CODES.get(last, last)}")
        return True
    if cls is not None:
        draft.source.replace(node, draft.data_name(cls))
    return cls is not None


def _why_not(method: ast.AST) -> str:
    """Return why a use of a port needs a hand."""
    if not isinstance(method, ast.Attribute):
        return "a port is used as a value"
    if "Listener" in method.attr:
        return LISTENER
    return f"a native port has no {method.attr}"


def _reaches(top: ast.expr, node: ast.expr) -> bool:
    while top is not node:
        if not isinstance(top, ast.Attribute):
            return False
        top = top.value
    return True


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == 0


def _in_brackets(node: ast.expr, text: str) -> str:
    is_simple = isinstance(node, (ast.Name, ast.Attribute, ast.Constant, ast.Call, ast.Subscript))
    return text if is_simple else f"({text})"
