"""Tells which expressions are certainly whole numbers, and divides them as Python 2 did.

Python 2 rounds the quotient of two whole numbers down, Python 3 does not, and no error tells.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import NamedTuple

_RETURN_INTEGERS = frozenset({"int", "len", "ord"})
_KEEP_INTEGERS = (
    ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.LShift, ast.RShift, ast.BitAnd,
    ast.BitOr, ast.BitXor,
)  # fmt: skip
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_PARENT = "_rtkit_parent"


class Division(NamedTuple):
    """A division by ``/``.

    Attributes:
        node: The expression.
        is_of_integers: Both sides are certainly whole numbers.
        is_open: Neither that, nor is a side certainly none.
    """

    node: ast.BinOp
    is_of_integers: bool
    is_open: bool


def divisions(tree: ast.Module) -> Iterator[Division]:
    """Yield the divisions of a source."""
    for scope in (tree, *(node for node in ast.walk(tree) if isinstance(node, _FUNCTIONS))):
        names = _integer_names(scope) if isinstance(scope, _FUNCTIONS) else frozenset[str]()
        for node in _own_nodes(scope):
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
                sides = (node.left, node.right)
                are_integers = all(is_integer(each, names) for each in sides)
                is_open = not are_integers and not any(map(_is_no_integer, sides))
                yield Division(node, are_integers, is_open)


def is_integer(node: ast.expr, names: frozenset[str] = frozenset()) -> bool:
    """Return whether an expression is certainly a whole number; so are these names."""
    match node:
        case ast.Constant(value=value):
            return isinstance(value, int) and not isinstance(value, bool)
        case ast.Name(id=name):
            return name in names
        case ast.Call(func=ast.Name(id=name)):
            return name in _RETURN_INTEGERS
        case ast.UnaryOp(op=ast.UAdd() | ast.USub() | ast.Invert(), operand=operand):
            return is_integer(operand, names)
        case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _KEEP_INTEGERS):
            return is_integer(left, names) and is_integer(right, names)
    return False


def is_integer_needed(node: ast.BinOp) -> bool:
    """Return whether a division of whole numbers stands where Python 3 takes no other number.

    As the count of a list, an index, a bound of ``range``: that always fails in Python 3. Call
    `note_parents` first.
    """
    if not (is_integer(node.left) and is_integer(node.right)):
        return False
    match getattr(node, _PARENT, None):
        case ast.BinOp(op=ast.Mult(), left=left, right=right):
            return any(isinstance(each, ast.List | ast.Tuple) for each in (left, right))
        case ast.Subscript(slice=inner):
            return inner is node
        case ast.Slice():
            return True
        case ast.Call(func=ast.Name(id="range" | "xrange")):
            return True
    return False


def note_parents(tree: ast.AST) -> None:
    """Have each expression know what it stands in."""
    for node in ast.walk(tree):
        for child in ast.iter_child_nodes(node):
            setattr(child, _PARENT, node)


def _is_no_integer(node: ast.expr) -> bool:
    """Return whether an expression is certainly no whole number: its quotient is the same."""
    match node:
        case ast.Constant(value=value):
            return not isinstance(value, int)
        case ast.Call(func=ast.Name(id="float")):
            return True
        case ast.Call(func=ast.Attribute(value=ast.Name(id="math" | "numpy" | "np"))):
            return True
        case ast.Attribute(value=ast.Name(id="math"), attr="pi" | "e"):
            return True
        case ast.UnaryOp(operand=operand):
            return _is_no_integer(operand)
        case ast.BinOp(left=left, right=right):
            return _is_no_integer(left) or _is_no_integer(right)
    return False


def _own_nodes(scope: ast.AST) -> Iterator[ast.AST]:
    """Yield what is in a scope, without the functions in it."""
    for child in ast.iter_child_nodes(scope):
        if not isinstance(child, _FUNCTIONS):
            yield child
            yield from _own_nodes(child)


def _integer_names(function: ast.FunctionDef | ast.AsyncFunctionDef) -> frozenset[str]:
    """Return the local names of a function that are never anything but a whole number."""
    bindings: dict[str, list[ast.expr | None]] = {}
    for argument in ast.walk(function.args):
        if isinstance(argument, ast.arg):
            bindings[argument.arg] = [None]
    for node in ast.walk(function):
        for name, value in _bindings(node):
            bindings.setdefault(name, []).append(value)
    names = frozenset(bindings)
    while True:
        kept = frozenset(
            name
            for name in names
            if all(value is not None and is_integer(value, names) for value in bindings[name])
        )
        if kept == names:
            return names
        names = kept


def _bindings(node: ast.AST) -> Iterator[tuple[str, ast.expr | None]]:
    """Yield the names that a statement binds, each with its value; None for an unknown one."""
    match node:
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            yield name, value
        case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
            yield name, value if isinstance(op, _KEEP_INTEGERS) else None
        case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"))):
            yield name, ast.Constant(0)
        case ast.Assign() | ast.AnnAssign() | ast.For() | ast.With() | ast.NamedExpr():
            yield from ((name, None) for name in _stored(node))
        case ast.Global(names=names) | ast.Nonlocal(names=names):
            yield from ((name, None) for name in names)
        case ast.ExceptHandler(name=str(name)) | ast.FunctionDef(name=name):
            yield name, None
        case ast.ClassDef(name=name):
            yield name, None
        case ast.comprehension(target=target):
            yield from ((name, None) for name in _stored(target))
        case ast.alias(name=name, asname=other):
            yield other or name.partition(".")[0], None


def _stored(node: ast.AST) -> Iterator[str]:
    targets = getattr(node, "targets", None) or [getattr(node, "target", node)]
    items = [each.optional_vars for each in getattr(node, "items", ()) if each.optional_vars]
    for target in (*targets, *items):
        for each in ast.walk(target):
            if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store):
                yield each.id
