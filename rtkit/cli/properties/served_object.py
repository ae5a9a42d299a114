"""Resolves ``MODULE:CLASS``: imports the module and calls the class."""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any

from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.rtc.nearest import did_you_mean

_KEY = re.compile(r"[A-Za-z_]\w*")


def made(thing: str, arguments: Sequence[str]) -> object:
    """Import a module and return the named object in it, called if it is callable.

    Raises:
        NotFound: There is no such module, or nothing of that name in it.
        Refused: It does not import, or raises when it is called.
        Malformed: An argument cannot be read.
    """
    module_name, mark, path = thing.rpartition(":")
    if not mark or not module_name or not path:
        raise Malformed(f"not MODULE:CLASS: {thing}")
    found: Any = _module(module_name)
    for step in path.split("."):
        try:
            found = getattr(found, step)
        except AttributeError:
            hint = did_you_mean(step, [each for each in dir(found) if not each.startswith("_")])
            raise NotFound(f"nothing of that name in {module_name}: {path}{hint}") from None
    if not callable(found) or (not isinstance(found, type) and not _is_function(found)):
        return found
    given, named = _given(thing, found, arguments)
    _check_call(thing, found, given, named)
    try:
        return found(*given, **named)
    except RtkitError:
        raise
    except Exception as error:
        raise Refused(f"{thing}: {type(error).__name__}: {error}") from error


def _check_call(thing: str, called: Any, given: list[object], named: dict[str, object]) -> None:
    """Refuse arguments that are too many, missing or given twice, before they are taken.

    Raises:
        Refused: Names the parameters; Python's own error would count ``self``, too.
    """
    import inspect

    try:
        signature = inspect.signature(called)
    except (ValueError, TypeError):
        return  # not written in Python
    try:
        signature.bind(*given, **named)
    except TypeError as error:
        takes = " ".join(str(each.replace(annotation=each.empty)).replace(" ", "")
                         for each in signature.parameters.values())  # fmt: skip
        raise Refused(f"{thing}: {error} (it takes {takes or 'none'})") from None


def _is_function(found: object) -> bool:
    import inspect

    return inspect.isroutine(found)


def _module(name: str) -> ModuleType:
    try:
        if name.endswith(".py"):
            return _from_file(name)
        if os.getcwd() not in sys.path:
            sys.path.insert(0, os.getcwd())
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and name.startswith(error.name):
            raise NotFound(f"no such module: {name}") from None
        from rtkit.extras import hint

        raise Refused(f"{name} does not import: {error}{hint(error)}") from error
    except RtkitError:
        raise
    except Exception as error:
        raise Refused(f"{name} does not import: {type(error).__name__}: {error}") from error


def _from_file(path: str) -> ModuleType:
    if not os.path.isfile(path):
        raise NotFound(f"no such file: {path}")
    name = os.path.basename(path).removesuffix(".py")
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise Refused(f"cannot be imported: {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _given(
    thing: str, called: Any, arguments: Sequence[str]
) -> tuple[list[object], dict[str, object]]:
    """Return arguments by place and by name, as objects of Python that fit their annotations."""
    names, hints, is_open = _declared(called)
    given: list[object] = []
    named: dict[str, object] = {}
    for each in arguments:
        key, mark, text = each.partition("=")
        if not mark or _KEY.fullmatch(key) is None:
            name = names[len(given)] if len(given) < len(names) else ""
            given.append(_fitted(each, each, hints.get(name), f"{name or 'argument'} of {thing}"))
        elif key in names or is_open:
            named[key] = _fitted(each, text, hints.get(key), f"{key} of {thing}")
        else:
            raise Malformed(f"{thing} takes no argument {key}{did_you_mean(key, names)}")
    return given, named


def _declared(called: Any) -> tuple[list[str], dict[str, Any], bool]:
    """Return names and annotations of arguments, and whether there may be others."""
    import inspect

    from rtkit.property.annotations import hints_of_function

    try:
        parameters = inspect.signature(called).parameters.values()
    except (ValueError, TypeError):
        return [], {}, True
    several = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    names = [each.name for each in parameters if each.kind not in several]
    function = getattr(called, "__init__", None) if isinstance(called, type) else called
    hints = hints_of_function(function)
    return names, hints, any(each.kind is each.VAR_KEYWORD for each in parameters)


def _fitted(typed: str, text: str, hint: Any, parameter: str) -> object:
    """Return the argument that a text stands for; where a text is wanted, what was typed is one."""
    from rtkit.property.annotations import Range, bare, extra_of, spec_of
    from rtkit.property.codes import PropertyError
    from rtkit.property.fitting import from_value
    from rtkit.property.reading import read

    plain = bare(hint)
    try:
        value = read(text)
        fitting = from_value(value, hint, None)
        if extra_of(hint, Range) is not None:
            spec_of(hint, None, "rw", "").within(value)
        return fitting
    except PropertyError as error:
        if plain is str or str in getattr(plain, "__args__", ()):
            return text
        raise Malformed(f"cannot be read: {typed}: {error} ({parameter})") from None
