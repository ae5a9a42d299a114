"""Writes data values: constructors, parts of bound data, and what ports read and write."""

from __future__ import annotations

import ast
from collections.abc import Mapping

from rtkit.component.types import Time
from rtkit.component.values.type_layout import BasicLayout, EnumLayout, Layout, StructLayout
from rtkit.openrtm.convert.component_model import OldPort, Path, is_self
from rtkit.openrtm.convert.data_plans import STAMP, DataPlan, part_of
from rtkit.openrtm.convert.draft import API, ModuleDraft

_CHARS, _OCTETS = "sequence<char>", "sequence<octet>"


def constructor(draft: ModuleDraft, call: ast.Call, *, keeps_lists: bool = True) -> str:
    """Return the native expression for a call that makes a value of a data type.

    Arguments that are defaults are left out; lists are kept where they may be filled later.
    """
    name = draft.call_of(call)
    if name == f"{API}.instantiateDataType":
        cls = draft.data_class(draft.qualified(call.args[0]))
        assert cls is not None
        return _built(draft, cls, [(f, "[]") for f in _lists(cls) if keeps_lists], cls)
    cls = draft.data_class(name)
    assert cls is not None
    from rtkit.component.values.type_layout import layout_of

    if call.keywords or any(isinstance(each, ast.Starred) for each in call.args):
        if len(call.args) == 1 and not call.keywords:  # *arg of an early RTC Builder: all None
            return f"{draft.data_name(cls)}()"
        return f"{draft.data_name(cls)}({', '.join(map(draft.source.render, [*call.args]))})"
    given = []
    for (field, layout), argument in zip(layout_of(cls).fields, call.args, strict=False):
        is_list = isinstance(argument, ast.List) and keeps_lists
        if is_list or not is_zero(draft, argument, layout):
            given.append((field, fitted(layout, draft.source.render(argument))))
    return _built(draft, cls, given, cls)


def _lists(cls: type) -> list[str]:
    from rtkit.component.values.type_layout import ItemsLayout, layout_of

    return [name for name, layout in layout_of(cls).fields if isinstance(layout, ItemsLayout)]


def _built(draft: ModuleDraft, cls: type, given: list[tuple[str, str]], _: type) -> str:
    """Return a call of a data type's class: by position as long as nothing is left out."""
    from rtkit.component.values.type_layout import layout_of

    fields = [name for name, _layout in layout_of(cls).fields]
    is_whole = [name for name, _text in given] == fields[: len(given)]
    texts = [text if is_whole else f"{name}={text}" for name, text in given]
    return f"{draft.data_name(cls)}({', '.join(texts)})"


def is_zero(draft: ModuleDraft, node: ast.expr, layout: Layout) -> bool:
    """Return whether an expression is the default of a field, or an empty one of another kind."""
    if isinstance(layout, StructLayout):
        name = draft.call_of(node)
        if not isinstance(node, ast.Call) or draft.data_class(name) is not layout.cls:
            return False
        pairs = zip(layout.fields, node.args, strict=False)
        return not node.keywords and all(is_zero(draft, each, field[1]) for field, each in pairs)
    if isinstance(layout, BasicLayout) and isinstance(node, ast.Constant):
        return not node.value or node.value == layout.zero
    if isinstance(layout, EnumLayout):
        return False
    return (isinstance(node, (ast.List, ast.Tuple)) and not node.elts) or (
        isinstance(node, ast.Constant) and not node.value
    )


def fitted(layout: Layout, text: str) -> str:
    """Return an expression for a field, that of a text for characters as a sequence."""
    if layout.name == _OCTETS and text.startswith("["):
        return f"bytes({text})"
    return f"tuple({text})" if layout.name == _CHARS else text


def zero_text(layout: Layout) -> str:
    """Return the expression for the default of a part that is no structure."""
    if layout.name == _OCTETS:
        return 'b""'
    return repr(layout.zero) if isinstance(layout, BasicLayout) else "[]"


def initial_of(
    draft: ModuleDraft, plan: DataPlan, path: Path, *, keeps_literals: bool = False
) -> str:
    """Return the native expression for the first value of a part of bound data.

    Literals that a field cannot hold are kept where the component may look at them.
    """
    layout: Layout = plan.data.layout
    node: ast.expr | None = plan.data.initial
    for each in path:
        assert isinstance(layout, StructLayout)
        place = [name for name, _ in layout.fields].index(each)
        is_plain = isinstance(node, ast.Call) and draft.data_class(draft.call_of(node))
        arguments = node.args if is_plain and isinstance(node, ast.Call) else []
        node = arguments[place] if place < len(arguments) else None
        if isinstance(node, ast.Starred) or any(isinstance(a, ast.Starred) for a in arguments):
            node = None
        layout = dict(layout.fields)[each]
    if isinstance(layout, StructLayout):
        if isinstance(node, ast.Call) and draft.data_class(draft.call_of(node)):
            return constructor(draft, node)
        return f"{draft.data_name(layout.cls)}()"
    if keeps_literals and isinstance(node, ast.Constant) and node.value is not None:
        return draft.source.render(node)
    if layout.name == _OCTETS and isinstance(node, ast.List) and not node.elts:
        return zero_text(layout)
    if node is None or (not isinstance(node, ast.List) and is_zero(draft, node, layout)):
        return zero_text(layout)
    return draft.source.render(node)


def written_value(draft: ModuleDraft, plan: DataPlan, texts: Mapping[Path, str]) -> str:
    """Return the value that a write sends, made of the native expressions of its parts."""
    return _value(draft, plan, texts, ()) or f"{draft.data_name(plan.data.cls)}()"


def _value(draft: ModuleDraft, plan: DataPlan, texts: Mapping[Path, str], path: Path) -> str:
    """Return the expression of a part; "" where it has its default."""
    layout = part_of(plan.data.layout, path)
    if path in texts:
        return fitted(layout, texts[path])
    is_stamp = path == STAMP and isinstance(layout, StructLayout) and layout.cls is Time
    if is_stamp and not any(each[:1] == STAMP for each in texts):
        return f"{draft.native('Time')}.now()"
    if not isinstance(layout, StructLayout):
        first = initial_of(draft, plan, path)
        return "" if first == zero_text(layout) else fitted(layout, first)
    given = [(name, _value(draft, plan, texts, (*path, name))) for name, _ in layout.fields]
    kept = [(name, text) for name, text in given if text]
    if not kept and path:
        return ""
    return _built(draft, layout.cls, kept, layout.cls)


def changed(draft: ModuleDraft, root: str, path: Path, text: str) -> str:
    """Return the expression of a value in which one part is another."""
    if not path:
        return text
    inner = changed(draft, f"{root}.{path[0]}", path[1:], text)
    return draft.replaced(root, path[0], inner)


def default_value(draft: ModuleDraft, port: OldPort) -> str:
    """Return the value that a port reads before any came."""
    return f"{draft.data_name(port.cls)}()"


def is_guarded(draft: ModuleDraft, call: ast.Call) -> bool:
    """Return whether a value is known to wait where a port is read."""
    source = draft.source
    function = call.func
    assert isinstance(function, ast.Attribute)
    port = function.value
    assert isinstance(port, ast.Attribute)
    inner: ast.AST = call
    for outer in source.ancestors(call):
        if _is_branch(outer, inner, port.attr):
            return True
        if (
            isinstance(outer, ast.IfExp)
            and inner is outer.body
            and _asks_for_new(outer.test, port.attr)
        ):
            return True
        if isinstance(inner, ast.stmt) and not isinstance(inner, ast.FunctionDef):
            block = source.block(inner)
            if any(_leaves_unless_new(each, port.attr) for each in block[: block.index(inner)]):
                return True
        inner = outer
    return False


def _is_branch(outer: ast.AST, inner: ast.AST, port: str) -> bool:
    """Return whether a statement runs another only when a value waits."""
    if not isinstance(outer, (ast.If, ast.While)) or inner not in outer.body:
        return False
    return _asks_for_new(outer.test, port)


def _asks_for_new(test: ast.expr, port: str) -> bool:
    if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And):
        return any(_asks_for_new(each, port) for each in test.values)
    if isinstance(test, ast.Compare) and len(test.comparators) == 1:
        right = test.comparators[0]
        is_true = isinstance(right, ast.Constant) and right.value in (True, 1)
        return (
            is_true and isinstance(test.ops[0], (ast.Eq, ast.Is)) and _asks_for_new(test.left, port)
        )
    return (
        isinstance(test, ast.Call)
        and isinstance(test.func, ast.Attribute)
        and test.func.attr == "isNew"
        and is_self(test.func.value, port)
    )


def _leaves_unless_new(statement: ast.stmt, port: str) -> bool:
    """Return whether what follows a statement is reached only when a value waits."""
    if not isinstance(statement, (ast.If, ast.While)) or not isinstance(
        statement.test, ast.UnaryOp
    ):
        return False
    test = statement.test
    if not isinstance(test.op, ast.Not) or not _asks_for_new(test.operand, port):
        return False
    if isinstance(statement, ast.While):
        return not any(isinstance(each, ast.Break) for each in ast.walk(statement))
    return isinstance(statement.body[-1], (ast.Return, ast.Continue, ast.Raise, ast.Break))
