"""Finds names, modules and expressions of Python 2 in a source that Python 3 compiles."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from rtkit.openrtm.integers import is_integer_needed
from rtkit.openrtm.python2 import GONE, RENAMED, SignOfPython2

_METHODS = frozenset({"has_key", "iteritems", "iterkeys", "itervalues"})
_HANDLED = {"ImportError", "ModuleNotFoundError", "NameError", "AttributeError", "Exception"}


def signs_in(tree: ast.Module) -> list[SignOfPython2]:
    """Return what in a source is Python 2's and fails in Python 3, in the order of lines.

    What the source guards is none: by a handler of the error, or by the version of Python.
    """
    bound = set(_bound(tree))
    found = [sign for node in _unguarded(tree) for sign in _signs(node, bound)]
    return sorted(set(found))


def _signs(node: ast.AST, bound: set[str]) -> Iterator[SignOfPython2]:
    match node:
        case ast.Import(names=names):
            for each in names:
                if each.name.partition(".")[0] in RENAMED:
                    yield SignOfPython2(node.lineno, f"module {each.name}")
        case ast.ImportFrom(module=str(module), level=0) if module.partition(".")[0] in RENAMED:
            yield SignOfPython2(node.lineno, f"module {module}")
        case ast.Name(id=name, ctx=ast.Load()) if name in GONE and name not in bound:
            yield SignOfPython2(node.lineno, name)
        case ast.Call(func=ast.Attribute(attr=name)) if name in _METHODS and name not in bound:
            yield SignOfPython2(node.lineno, name)
        case ast.BinOp(left=ast.Name(id="print"), op=ast.RShift()):
            yield SignOfPython2(node.lineno, "print as a statement")
        case ast.BinOp(op=ast.Div()) if is_integer_needed(node):
            yield SignOfPython2(node.lineno, "/ between whole numbers")


def _unguarded(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes but those that run only where they work."""
    yield node
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Try) and any(_handles(each) for each in child.handlers):
            for each in (*child.orelse, *child.finalbody):
                yield from _unguarded(each)
        elif isinstance(child, ast.If | ast.IfExp) and "version" in ast.dump(child.test):
            continue
        else:
            yield from _unguarded(child)


def _handles(handler: ast.ExceptHandler) -> bool:
    if handler.type is None:
        return True
    return any(each.id in _HANDLED for each in ast.walk(handler.type) if isinstance(each, ast.Name))


def _bound(tree: ast.Module) -> Iterator[str]:
    """Yield the names that a source itself gives to something, anywhere."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Store() | ast.Del()):
                yield name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.alias(name=name, asname=other):
                yield other or name.partition(".")[0]
