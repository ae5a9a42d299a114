"""Converts a source from Python 2 to Python 3, by fissix and by changes of our own."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

from rtkit.errors import Malformed, Refused
from rtkit.openrtm.migrate.integers import note_parents
from rtkit.openrtm.migrate.keyword_names import FreedNames, with_free_names
from rtkit.openrtm.migrate.lost_names import losses
from rtkit.openrtm.migrate.meaning import as_python2_meant, without_losses
from rtkit.openrtm.migrate.package_imports import is_beside, sibling_imports
from rtkit.openrtm.migrate.python2 import SignOfPython2, sign_of_python2
from rtkit.openrtm.migrate.python2_names import PRINT_STATEMENT, IsBeside, signs_in
from rtkit.openrtm.migrate.source import encoded, read_source, with_spaces
from rtkit.openrtm.migrate.source_edits import Remark

_FIXES = "fissix.fixes"
_LEFT_OUT = frozenset({"buffer", "idioms", "import", "imports", "set_literal", "ws_comma"})
"""Fixers that are matters of taste; and those of imports, which know no siblings."""
_OWN = "rtkit.openrtm.migrate.fix_modules"


class ConvertedSource(NamedTuple):
    """A source of Python 2, or of an older version of 3.

    Attributes:
        before: The text before, with spaces for tabs of indentation where these had to go.
        after: The text as Python 3; the same where nothing can be mended for certain.
        data: The same as bytes.
        sign: What showed that it was old.
        is_python2: It was Python 2.
        remarks: What a person should look at.
        has_spaces: Tabs of indentation had to become spaces.
    """

    before: str
    after: str
    data: bytes
    sign: SignOfPython2
    is_python2: bool
    remarks: tuple[Remark, ...]
    has_spaces: bool

    @property
    def is_changed(self) -> bool:
        """Return whether there is anything to write."""
        return self.before != self.after


def converted(source: bytes, file: str, *, is_in_package: bool = False) -> ConvertedSource | None:
    """Return a source as Python 3; None where there is nothing to do, or to look at.

    Args:
        source: What the file holds.
        file: Its name, for errors; siblings are looked for beside it.
        is_in_package: It is imported as a part of a package.

    Raises:
        Malformed: It is Python of no version; or what becomes of it would not compile.
        Refused: What converts it is not installed; names the command that installs it.
    """
    read = read_source(source)
    before = read.text.replace("\r\n", "\n")
    beside = partial(is_beside, file)
    freed = with_free_names(before) if _is_broken(before, file) else FreedNames(before)
    tree = _parsed(with_spaces(freed.text), file)
    signs = _signs(tree, freed.text, file, beside)
    draft = _as_python3(freed.text, file, signs, is_broken=isinstance(tree, SyntaxError))
    result, data = _compiled(draft.after, file), draft.after.encode()
    found = list(losses(result, data, beside))
    found += sibling_imports(result, data, beside) if is_in_package else ()
    after, more = without_losses(draft.after, found)
    result = _compiled(after, file)
    more += _left(result, beside, more) if signs else ()
    if draft.has_spaces:
        before = with_spaces(before)
    if after == before and not more:
        return None
    lost = [SignOfPython2(each.line, each.what) for each in found]
    lost += [SignOfPython2(line, "async or await as a name") for line in freed.lines]
    whole = after.replace("\n", "\r\n") if "\r\n" in read.text else after
    remarks = tuple(sorted({*freed.remarks, *draft.remarks, *more}))
    return ConvertedSource(
        before,
        after,
        encoded(read, whole),
        min(signs or lost),
        bool(signs),
        remarks,
        draft.has_spaces,
    )


def _left(tree: ast.Module, is_beside: IsBeside, known: Sequence[Remark]) -> Iterator[Remark]:
    """Yield what of Python 2 nothing has converted, but for the lines that are known already."""
    note_parents(tree)
    lines = {each.line for each in known}
    for line, what in signs_in(tree, is_beside):
        if line not in lines:
            yield Remark(line, f"{what} is Python 2")


class _Draft(NamedTuple):
    """A source as Python 3, but for names that are lost."""

    after: str
    remarks: list[Remark]
    has_spaces: bool


def _as_python3(text: str, file: str, signs: Sequence[SignOfPython2], *, is_broken: bool) -> _Draft:
    if not signs:
        has_spaces = _is_broken(text, file)
        return _Draft(with_spaces(text) if has_spaces else text, [], has_spaces)
    has_statement = any(each.what == PRINT_STATEMENT for each in signs)
    prints = is_broken or (has_statement and "print_function" not in text)
    made = _refactored(text, file, has_print_statement=prints)
    has_spaces = _is_broken(made, file)
    if has_spaces:
        made = _refactored(with_spaces(text), file, has_print_statement=prints)
    divides_whole = "from __future__ import division" not in text
    result = _compiled(made, file)
    made, remarks = as_python2_meant(made, result, divides_whole=divides_whole)
    return _Draft(made, remarks, has_spaces)


def _signs(
    tree: ast.Module | SyntaxError, text: str, file: str, is_beside: IsBeside
) -> list[SignOfPython2]:
    """Return what shows that a source is Python 2.

    Raises:
        Malformed: It does not compile, and is no Python 2 either.
    """
    if isinstance(tree, ast.Module):
        note_parents(tree)
        return signs_in(tree, is_beside)
    sign = sign_of_python2(text, tree.lineno or 1)
    if sign is None:
        raise Malformed(f"SyntaxError: {tree.msg} ({file}:{tree.lineno or 1})")
    return [sign]


def _is_broken(text: str, file: str) -> bool:
    return isinstance(_parsed(text, file), SyntaxError)


def _compiled(text: str, file: str) -> ast.Module:
    """Return what was made of a source.

    Raises:
        Malformed: It does not compile.
    """
    tree = _parsed(text, file)
    if isinstance(tree, SyntaxError):
        why = f"{tree.msg} ({file}:{tree.lineno or 1})"
        raise Malformed(f"{file} cannot be converted; its Python 3 would not compile: {why}")
    return tree


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
    tool: Any = RefactoringTool([*fixers, _OWN], {"print_function": not has_print_statement})
    try:
        tree = tool.refactor_string(text if text.endswith("\n") else f"{text}\n", file)
    except (ParseError, IndentationError) as error:
        raise Malformed(f"{file} cannot be converted: {' '.join(str(error).split())}") from error
    made = str(tree)
    return made if text.endswith("\n") else made.removesuffix("\n")
