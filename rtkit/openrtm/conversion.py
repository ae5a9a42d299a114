"""Converts a source from Python 2 to Python 3, by fissix and by changes of our own."""

from __future__ import annotations

import ast
import warnings
from typing import Any, NamedTuple

from rtkit.errors import Malformed, Refused
from rtkit.openrtm.edits import Remark, edited
from rtkit.openrtm.integers import note_parents
from rtkit.openrtm.python2 import SignOfPython2, sign_of_python2
from rtkit.openrtm.python2_names import signs_in
from rtkit.openrtm.source import encoded, read_source, with_spaces

_FIXES = "fissix.fixes"
_LEFT_OUT = frozenset({"buffer", "idioms", "import", "set_literal", "ws_comma"})
"""Fixers that are matters of taste; and that of imports: siblings of a component are no package."""


class ConvertedSource(NamedTuple):
    """A source that was Python 2.

    Attributes:
        before: The text before, with spaces for tabs of indentation where these had to go.
        after: The text as Python 3.
        data: The same as bytes.
        sign: What showed that it was Python 2.
        remarks: What a person should look at.
        has_spaces: Tabs of indentation had to become spaces.
    """

    before: str
    after: str
    data: bytes
    sign: SignOfPython2
    remarks: tuple[Remark, ...]
    has_spaces: bool


def converted(source: bytes, file: str) -> ConvertedSource | None:
    """Return a source as Python 3; None where it is no Python 2, or not known to be.

    Raises:
        Malformed: It is Python of no version; or what becomes of it would not compile.
        Refused: What converts it is not installed; names the command that installs it.
    """
    read = read_source(source)
    text = read.text.replace("\r\n", "\n")
    tree = _parsed(with_spaces(text), file)
    sign = _sign(tree, text, file)
    if sign is None:
        return None
    is_statement = isinstance(tree, SyntaxError)
    made = _refactored(text, file, has_print_statement=is_statement)
    has_spaces = isinstance(_parsed(made, file), SyntaxError)
    if has_spaces:
        text = with_spaces(text)
        made = _refactored(text, file, has_print_statement=is_statement)
    result = _parsed(made, file)
    if isinstance(result, SyntaxError):
        why = f"{result.msg} ({file}:{result.lineno})"
        raise Malformed(f"{file} cannot be converted; its Python 3 would not compile: {why}")
    divides_whole = "from __future__ import division" not in text
    made, remarks = edited(made, result, divides_whole=divides_whole)
    whole = made.replace("\n", "\r\n") if "\r\n" in read.text else made
    return ConvertedSource(text, made, encoded(read, whole), sign, tuple(remarks), has_spaces)


def _sign(tree: ast.Module | SyntaxError, text: str, file: str) -> SignOfPython2 | None:
    """Return what shows that a source is Python 2; None for nothing.

    Raises:
        Malformed: It does not compile, and is no Python 2 either.
    """
    if isinstance(tree, ast.Module):
        note_parents(tree)
        return next(iter(signs_in(tree)), None)
    sign = sign_of_python2(text, tree.lineno or 1)
    if sign is None:
        raise Malformed(f"SyntaxError: {tree.msg} ({file}:{tree.lineno or 1})")
    return sign


def _parsed(text: str, file: str) -> ast.Module | SyntaxError:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(text, file, "exec", dont_inherit=True)
            return ast.parse(text, file)
    except SyntaxError as error:
        return error
    except ValueError as error:  # a null byte
        return SyntaxError(str(error), (file, 1, 0, ""))


def _refactored(text: str, file: str, *, has_print_statement: bool) -> str:
    """Return a source as fissix converts it.

    Raises:
        Malformed: It cannot read it.
        Refused: It is not installed.
    """
    try:
        from fissix.pgen2.parse import ParseError
        from fissix.refactor import RefactoringTool, get_fixers_from_package
    except ImportError:
        from rtkit.extras import how_to_get

        way = how_to_get("openrtm")
        raise Refused(f"fissix, which converts Python 2, is not installed: {way}") from None
    left_out = _LEFT_OUT if has_print_statement else _LEFT_OUT | {"print"}
    fixers = [
        each
        for each in get_fixers_from_package(_FIXES)
        if each.rpartition(".fix_")[2] not in left_out
    ]
    tool: Any = RefactoringTool(fixers, {"print_function": not has_print_statement})
    try:
        tree = tool.refactor_string(text if text.endswith("\n") else f"{text}\n", file)
    except (ParseError, IndentationError) as error:
        raise Malformed(f"{file} cannot be converted: {' '.join(str(error).split())}") from error
    made = str(tree)
    return made if text.endswith("\n") else made.removesuffix("\n")
