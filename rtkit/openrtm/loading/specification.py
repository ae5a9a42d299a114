"""Reads what a module for OpenRTM-aist says of its components, without running any of it.

It is a list of names and values in turn, which its init function makes `Properties` of.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator

from rtkit.errors import Malformed
from rtkit.openrtm.migrate.source import mended

_REGISTER = "registerFactory"
_SPECIFIED = "defaults_str"


def specifications(source: bytes, file: str) -> list[dict[str, str]]:
    """Return the properties of each component type that a module registers.

    Raises:
        Malformed: It cannot be read, or registers what is known only when it runs.
    """
    tree = _parse(source, file)
    lists = dict(_lists(tree.body))
    found: dict[str, dict[str, str]] = {}
    for function in (each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef)):
        calls = [each for each in ast.walk(function) if isinstance(each, ast.Call)]
        if any(_called(each) == _REGISTER for each in calls):
            for name in _specified(calls):
                if name in lists:
                    found[name] = lists[name]
    if not found:
        raise Malformed(f"registers what is known only when it runs ({file}:1)")
    return list(found.values())


def _parse(source: bytes, file: str) -> ast.Module:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(mended(source, file), file)
    except SyntaxError as error:
        raise Malformed(f"SyntaxError: {error.msg} ({file}:{error.lineno or 1})") from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise Malformed(f"{type(error).__name__}: {error} ({file}:1)") from None


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else ""


def _specified(calls: list[ast.Call]) -> Iterator[str]:
    """Yield the names of the lists that properties are made of."""
    for call in calls:
        for each in call.keywords:
            if each.arg == _SPECIFIED and isinstance(each.value, ast.Name):
                yield each.value.id


def _lists(body: list[ast.stmt]) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the lists of a module by name, as names and values up to an empty name."""
    for each in body:
        if isinstance(each, ast.Assign) and isinstance(each.value, ast.List | ast.Tuple):
            texts = [_text(item) for item in each.value.elts]
            pairs = zip(texts[::2], texts[1::2], strict=False)
            properties = {name.strip(): value.strip() for name, value in pairs if name.strip()}
            for target in each.targets:
                if isinstance(target, ast.Name):
                    yield target.id, properties


def _text(node: ast.expr) -> str:
    try:
        return str(ast.literal_eval(node))
    except ValueError:
        return ""
