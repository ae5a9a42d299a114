"""Types of expressions in a component, as far as data values of ports are concerned."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import NamedTuple

from rtkit.component.values.type_layout import (
    ArrayLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
)
from rtkit.openrtm.convert.component_model import OldComponent, OldPort, is_self
from rtkit.openrtm.convert.draft import ModuleDraft
from rtkit.openrtm.convert.reading import data_type_of

FUNCTION = (ast.FunctionDef, ast.Lambda)
BORROWERS = frozenset(
    {
        "all", "any", "enumerate", "filter", "iter", "len", "list", "map", "max", "min", "print",
        "reversed", "set", "sorted", "sum", "tuple", "zip",
    }
)  # fmt: skip
"""Functions that take a tuple for a list."""
CHANGES = ("append", "clear", "extend", "insert", "pop", "remove", "reverse", "sort")
_QUERIES = ("count", "index")


class Value(NamedTuple):
    """A value of a data type.

    Attributes:
        is_received: It came from a port, so that its sequences are tuples in the native component.
    """

    layout: Layout
    is_received: bool


_Given = list[tuple[ast.AST, Value | None]]
"""What a variable is given, with the statement or expression that does it."""


def _agreed(values: list[Value | None]) -> Value | None:
    """Return the type of all values; None where one differs or is not known."""
    first = values[0] if values else None
    if first is None or any(each is None or each.layout != first.layout for each in values):
        return None
    return Value(first.layout, any(each is not None and each.is_received for each in values))


def _has_any(block: list[ast.stmt], nodes: list[ast.AST]) -> bool:
    return any(each in nodes for each in block)


class ValueTypes:
    """Types of variables and expressions of one component."""

    def __init__(self, draft: ModuleDraft, component: OldComponent) -> None:
        self._draft = draft
        self._component = component
        self.lists: set[str] = set()
        self._locals: dict[tuple[int, str], _Given] = {}
        self._attributes: dict[str, Value] = {}
        for _ in range(2):  # what a variable was given from another one is known at the second
            self._read_assignments()

    def value_of(self, node: ast.AST) -> Value | None:
        """Return the type of an expression; None where it is no data value."""
        if isinstance(node, ast.Name):
            return self._local(node)
        if isinstance(node, ast.Attribute):
            return self._of_attribute(node)
        if isinstance(node, ast.Subscript):
            return self._of_item(node)
        if isinstance(node, ast.Call):
            return self._of_call(node)
        return None

    def is_tuple(self, node: ast.AST) -> bool:
        """Return whether a list of the old component is a tuple in the native one."""
        found = self.value_of(node)
        return found is not None and found.is_received and isinstance(found.layout, ItemsLayout)

    def note_use(self, node: ast.Name) -> None:
        """Note a use of a variable with a received sequence: some uses need a list."""
        if self.changes_in_place(node) or not self.borrows(node):
            self.lists.add(node.id)

    def borrows(self, node: ast.expr) -> bool:
        """Return whether a place takes a tuple for a list: it only looks at the items."""
        parent = self._draft.source.parent(node)
        if isinstance(parent, ast.Subscript):
            return parent.value is node and isinstance(parent.ctx, ast.Load)
        if isinstance(parent, (ast.For, ast.comprehension)):
            return parent.iter is node
        if isinstance(parent, ast.Call):
            return node in parent.args and self._is_borrower(parent)
        if isinstance(parent, (ast.If, ast.While, ast.IfExp)):
            return parent.test is node
        if isinstance(parent, ast.UnaryOp):
            return isinstance(parent.op, ast.Not)
        if isinstance(parent, ast.Compare):
            return node is not parent.left and isinstance(parent.ops[0], (ast.In, ast.NotIn))
        if isinstance(parent, ast.Attribute):
            return parent.attr in _QUERIES
        return isinstance(parent, (ast.Starred, ast.Expr))

    def changes_in_place(self, node: ast.expr) -> bool:
        """Return whether a place changes the sequence that it is given."""
        parent = self._draft.source.parent(node)
        if isinstance(parent, ast.Subscript) and parent.value is node:
            return not isinstance(parent.ctx, ast.Load)
        return isinstance(parent, ast.Attribute) and parent.attr in CHANGES

    def is_alias(self, node: ast.Name) -> bool:
        """Return whether a variable may be another name for a part of a value."""
        method = self._draft.source.method(node)
        given = self._locals.get((id(method), node.id), [])
        return any(
            isinstance(getattr(each, "value", None), (ast.Attribute, ast.Name, ast.Subscript))
            or isinstance(each, (ast.For, ast.comprehension))
            for each, _ in given
        )

    def may_be_item(self, node: ast.expr) -> bool:
        """Return whether an expression of unknown type may be a value in a list, or a parameter."""
        while isinstance(node, ast.Attribute) and not is_self(node):
            node = node.value
        if self.value_of(node) is not None:
            return False
        if isinstance(node, ast.Subscript):
            return True
        if not isinstance(node, ast.Name) or node.id == "self":
            return False
        method = self._draft.source.method(node)
        given = self._locals.get((id(method), node.id), [])
        return any(isinstance(each, (ast.For, ast.comprehension, ast.arg)) for each, _ in given)

    def _is_borrower(self, call: ast.Call) -> bool:
        name = self._draft.qualified(call.func)
        root = name.partition(".")[0]
        if isinstance(call.func, ast.Attribute) and call.func.attr in ("extend", "join"):
            return True
        return name in BORROWERS or root in ("np", "numpy", "random", "struct", "math")

    def _local(self, node: ast.Name) -> Value | None:
        method = self._draft.source.method(node)
        if method is None or node.id in self.lists:
            return None
        given = self._locals.get((id(method), node.id), [])
        reaching = self._reaching(node, given) if isinstance(node.ctx, ast.Load) else given
        return _agreed([value for _, value in reaching])

    def _reaching(self, node: ast.Name, given: _Given) -> _Given:
        """Return what may have been given to a variable last, where it is used."""
        source = self._draft.source
        around = [*source.ancestors(node)]
        here = source.span(node)[0]
        before = [each for each in given if source.place(each[0]) < here]
        sure = [
            each
            for each in before
            if isinstance(each[0], ast.stmt)
            and source.parent(each[0]) in around
            and any(
                each[0] in block and _has_any(block, around) for block in [source.block(each[0])]
            )
        ]
        if not sure:
            return given
        last = sure[-1]
        place = source.place(last[0])
        loops = [
            each
            for each in around
            if isinstance(each, (ast.For, ast.While)) and source.span(each)[0] > place
        ]
        later = [each for each in given if any(loop in source.ancestors(each[0]) for loop in loops)]
        between = [each for each in before if source.place(each[0]) > place]
        return [last, *between, *later]

    def _of_attribute(self, node: ast.Attribute) -> Value | None:
        if is_self(node):
            data = self._component.data.get(node.attr)
            if data is not None:
                is_received = any(self._is_read(each) for each in data.rebound)
                return Value(data.layout, is_received)
            return self._attributes.get(node.attr)
        outer = self.value_of(node.value)
        if outer is None or not isinstance(outer.layout, StructLayout):
            return None
        field = dict(outer.layout.fields).get(node.attr)
        return Value(field, outer.is_received) if field is not None else None

    def _is_read(self, statement: ast.stmt) -> bool:
        value = getattr(statement, "value", None)
        return value is not None and self._read_value(value) is not None

    def _of_item(self, node: ast.Subscript) -> Value | None:
        outer = self.value_of(node.value)
        if outer is None:
            return None
        if isinstance(node.slice, ast.Slice):
            return outer
        if isinstance(outer.layout, ItemsLayout):
            return Value(outer.layout.item, outer.is_received)
        if isinstance(outer.layout, ArrayLayout):
            return Value(outer.layout.items[0], outer.is_received)
        return None

    def _of_call(self, node: ast.Call) -> Value | None:
        cls = data_type_of(self._draft, node)
        if cls is not None:
            return Value(layout_of(cls), False)
        if self._draft.qualified(node.func) in ("copy.copy", "copy.deepcopy", "deepcopy"):
            return self.value_of(node.args[0]) if node.args else None
        return self._read_value(node)

    def _read_value(self, node: ast.AST) -> Value | None:
        port = self.read_port(node)
        return Value(layout_of(port.cls), True) if port is not None else None

    def read_port(self, node: ast.AST) -> OldPort | None:
        """Return the port that a call reads; None where it does not."""
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            return None
        receiver = node.func.value
        if node.func.attr != "read" or not is_self(receiver):
            return None
        return self._component.ports.get(receiver.attr)

    def _read_assignments(self) -> None:
        """Note the types of variables, of those that hold nothing else."""
        found: dict[tuple[int, str], _Given] = {}
        for node, target, value in self._assignments():
            if isinstance(target, ast.Name):
                method = self._draft.source.method(node)
                key = (id(method), target.id)
            elif is_self(target):
                key = (0, target.attr)
            else:
                continue
            if isinstance(value, ast.Constant) and value.value is None:
                continue
            value_type = self.value_of(value) if value is not None else None
            found.setdefault(key, []).append((node, value_type))
        self._locals, self._attributes = {}, {}
        for (place, name), given in found.items():
            if place:
                self._locals[(place, name)] = given
            elif name not in self._component.data:
                agreed = _agreed([value for _, value in given])
                if agreed is not None:
                    self._attributes[name] = agreed

    def _assignments(self) -> Iterator[tuple[ast.AST, ast.expr, ast.expr | None]]:
        """Yield what is given to each variable; None for what is not a value of its own."""
        for node in ast.walk(self._component.node):
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    if isinstance(target, (ast.Tuple, ast.List)):
                        for each in target.elts:
                            yield node, each, None
                    else:
                        yield node, target, node.value
            elif isinstance(node, (ast.For, ast.comprehension)):
                item = ast.Subscript(node.iter, ast.Constant(0), ast.Load())
                yield node, node.target, item if isinstance(node.target, ast.Name) else None
            elif isinstance(node, ast.AugAssign):
                yield node, node.target, None
            elif isinstance(node, ast.withitem) and node.optional_vars is not None:
                yield node.context_expr, node.optional_vars, None
            elif isinstance(node, ast.arg):
                yield node, ast.Name(node.arg, ast.Store()), None
