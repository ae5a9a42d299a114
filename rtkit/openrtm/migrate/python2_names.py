"""Finds names, modules and expressions of Python 2 in a source that Python 3 compiles."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping

from rtkit.openrtm.migrate.integers import is_integer_needed
from rtkit.openrtm.migrate.python2 import GONE, RENAMED, SignOfPython2

_METHODS = frozenset({"has_key", "iteritems", "iterkeys", "itervalues"})
_HANDLED = {"ImportError", "ModuleNotFoundError", "NameError", "AttributeError", "Exception"}


_ATTRIBUTES = {
    "itertools": {"ifilter", "ifilterfalse", "imap", "izip", "izip_longest"},
    "os": {"getcwdu"},
    "string": {
        "atof", "atoi", "join", "letters", "lower", "lowercase", "maketrans", "replace", "split",
        "strip", "upper", "uppercase",
    },
    "sys": {"exc_clear", "maxint", "setdefaultencoding"},
    "types": {
        "BooleanType", "DictType", "FloatType", "IntType", "ListType", "LongType", "StringType",
        "StringTypes", "TupleType", "UnicodeType",
    },
}  # fmt: skip
"""What modules had in Python 2 alone."""
PRINT_STATEMENT = "print as a statement"
IsBeside = Callable[[str], bool]
"""Tells whether a source has a sibling of that name, which it imports in place of others."""


def signs_in(tree: ast.Module, is_beside: IsBeside) -> list[SignOfPython2]:
    """Return what in a source is Python 2's and fails in Python 3, in the order of lines.

    What the source guards is none: by a handler of the error, or by the version of Python.
    """
    bound = {*_given_names(tree), *_imported_names(tree)}
    modules = imported_modules(tree)
    found = [
        SignOfPython2(getattr(node, "lineno", 1), what)
        for node in unguarded(tree)
        for what in (*_of_modules(node, modules, is_beside), *_signs(node, bound))
    ]
    return sorted(set(found))


def _of_modules(node: ast.AST, modules: Mapping[str, str], is_beside: IsBeside) -> Iterator[str]:
    """Yield modules that have another name now, and what modules have no more."""
    match node:
        case ast.Import(names=names):
            for each in names:
                if _is_renamed(each.name, is_beside):
                    yield f"module {each.name}"
        case ast.ImportFrom(module=str(module), level=0, names=names):
            if _is_renamed(module, is_beside):
                yield f"module {module}"
            lost = _ATTRIBUTES.get(module, set())
            yield from (f"{module}.{each.name}" for each in names if each.name in lost)
        case ast.Attribute(value=ast.Name(id=local), attr=name):
            module = modules.get(local, "")
            if name in _ATTRIBUTES.get(module, ()):
                yield f"{module}.{name}"


def _is_renamed(module: str, is_beside: IsBeside) -> bool:
    top = module.partition(".")[0]
    return top in RENAMED and not is_beside(top)


def _signs(node: ast.AST, bound: set[str]) -> Iterator[str]:
    match node:
        case ast.Name(id=name, ctx=ast.Load()) if name in GONE and name not in bound:
            yield name
        case ast.Call(func=ast.Attribute(attr=name)) if name in _METHODS and name not in bound:
            yield name
        case ast.BinOp(left=ast.Name(id="print"), op=ast.RShift()):
            yield PRINT_STATEMENT
        case ast.BinOp(op=ast.Div()) if is_integer_needed(node):
            yield "/ between whole numbers"


def unguarded(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes but those that run only where they work."""
    yield node
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Try) and any(_handles(each) for each in child.handlers):
            for each in (*child.orelse, *child.finalbody):
                yield from unguarded(each)
        elif isinstance(child, ast.If | ast.IfExp) and "version" in ast.dump(child.test):
            continue
        else:
            yield from unguarded(child)


def _handles(handler: ast.ExceptHandler) -> bool:
    if handler.type is None:
        return True
    return any(each.id in _HANDLED for each in ast.walk(handler.type) if isinstance(each, ast.Name))


def imported_modules(tree: ast.Module) -> dict[str, str]:
    """Return which modules the names of a source stand for, where they stand for nothing else."""
    others = set(_given_names(tree))
    return {
        each.asname or each.name: each.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for each in node.names
        if (each.asname or each.name) not in others
    }


def _given_names(tree: ast.Module) -> Iterator[str]:
    """Yield the names that a source itself gives to something, anywhere."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Store() | ast.Del()):
                yield name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name


def _imported_names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.alias):
            yield node.asname or node.name.partition(".")[0]
