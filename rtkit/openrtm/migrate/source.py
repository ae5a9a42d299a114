"""Mends sources of old components, so that Python compiles them: encodings, tabs mixed with spaces.

Nothing is written: the mended bytes are what is compiled. A source that is Python 2 is refused by
name; `rtkit openrtm migrate` converts it once (see `rtkit.openrtm.migrate.files`).
"""

from __future__ import annotations

import codecs
import re
import warnings
from bisect import bisect_right
from collections.abc import Callable
from types import CodeType
from typing import NamedTuple

from rtkit.errors import Refused

MARK = b"OpenRTM_aist"
"""Found in the source of every module that was written for OpenRTM-aist-Python."""
Compile = Callable[[str, bytes], CodeType]
"""Compiles the source of a file; raises what `compile` raises."""
# Python compiles most sources as they are: patterns are compiled when one of them is needed.
_COOKIE = rb"^[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)"
_BLANK = rb"^[ \t\f]*(?:#.*)?\r?\n?$"
_FALLBACKS = ("utf-8", "euc_jp", "cp932", "latin-1")
"""Encodings of sources that declare none that fits: EUC-JP is tried before Shift JIS, whose bytes
it refuses nearly always, and the last one accepts any bytes."""
_HALVED = rb"(\(len\(\w+\._d_\w+\) *- *4\)) */ *2"
"""How RTC Builder 1.1 counts the fields of a structure: in Python 3 that is no whole number."""
_INDENT = r"[ \t]*"
_LINE = r"[^\n]*\n|[^\n]+"
_TAB = 8
"""Columns of a tab, as Python 2 counted them."""


class SourceText(NamedTuple):
    """A source as text.

    Attributes:
        text: With the line ends of the file.
        encoding: In which it was read.
        is_declared: The source itself declares that encoding, or needs no declaration.
    """

    text: str
    encoding: str
    is_declared: bool


def compiled(file: str, source: bytes, compile_source: Compile) -> CodeType:
    """Return the code of a module, mended where it does not compile as it is.

    Raises:
        Refused: It is Python 2; names the line, and the command that converts it.
        SyntaxError: It is Python of no version.
    """
    if b"._d_" in source:
        source = re.sub(_HALVED, rb"\1 // 2", source)
    try:
        return compile_source(file, source)
    except (SyntaxError, ValueError):
        return compile_source(file, mended(source, file))


def mended(source: bytes, file: str) -> bytes:
    """Return a source as Python compiles it: itself where nothing is to be mended.

    Args:
        source: What the file holds.
        file: Its name, for errors.

    Raises:
        Refused: It is Python 2; names the line, and the command that converts it.
        SyntaxError: It is Python of no version.
    """
    if _compiles(source, file) is None:
        return source
    read = read_source(source)
    text = with_spaces(read.text)
    data = encoded(read, text)
    error = _compiles(data, file)
    if error is None:
        return data
    from rtkit.openrtm.migrate.python2 import sign_of_python2  # most files are compiled as they are

    sign = sign_of_python2(text, error.lineno or 1)
    if sign is not None:
        raise Refused(python2_refusal(file, sign.line, sign.what)) from error
    raise error


def python2_refusal(file: str, line: int, what: str) -> str:
    """Return the error about a file that is Python 2, with the command that converts it."""
    return f"{file}:{line} is Python 2 ({what}): rtkit openrtm migrate {file} converts it"


def read_source(source: bytes) -> SourceText:
    """Return a source as text, in the encoding that it declares or else in one that fits."""
    declared = declared_encoding(source)
    has_mark = source.startswith(codecs.BOM_UTF8)
    tried = ("utf-8-sig",) if has_mark else (declared or "utf-8", *_FALLBACKS)
    for encoding in tried:
        try:
            text = source.decode(encoding)
        except (UnicodeDecodeError, LookupError):
            continue
        return SourceText(text, encoding, encoding == tried[0])
    return SourceText(source.decode("latin-1"), "latin-1", False)


def declared_encoding(source: bytes) -> str:
    """Return the encoding that one of the first two lines declares (PEP 263); empty for none."""
    for line in source.splitlines(keepends=True)[:2]:
        found = re.match(_COOKIE, line)
        if found is not None:
            return found[1].decode("ascii")
        if not re.match(_BLANK, line):
            break
    return ""


def encoded(read: SourceText, text: str) -> bytes:
    """Return a text as bytes: in the encoding that the source declares, if that was right.

    Else it is UTF-8, and a wrong declaration is replaced, which keeps the numbers of lines.
    """
    if read.is_declared:
        return text.encode(read.encoding)
    lines = text.encode().splitlines(keepends=True)
    for place, line in enumerate(lines[:2]):
        found = re.match(_COOKIE, line)
        if found is not None:
            lines[place] = line[: found.start(1)] + b"utf-8" + line[found.end(1) :]
    return b"".join(lines)


def with_spaces(text: str) -> str:
    """Return a source with tabs of indentation as spaces, to columns of 8; texts stay as they are.

    A source that has none is returned as it is.
    """
    if "\t" not in text:
        return text
    from rtkit.openrtm.migrate.python2 import TOKEN

    spans = [each.span() for each in TOKEN.finditer(text)]
    starts = [begin for begin, _ in spans]

    def with_indent(line: re.Match[str]) -> str:
        place = bisect_right(starts, line.start() - 1) - 1
        if place >= 0 and spans[place][1] > line.start():  # it begins inside a text
            return line[0]
        indent = re.match(_INDENT, line[0])
        width = indent.end() if indent is not None else 0
        return line[0][:width].expandtabs(_TAB) + line[0][width:]

    return re.sub(_LINE, with_indent, text)


def _compiles(source: bytes, file: str) -> SyntaxError | None:
    """Return why a source does not compile, None where it does."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its own import tells of them
            compile(source, file, "exec", dont_inherit=True)
    except SyntaxError as error:
        return error
    except ValueError as error:  # a null byte
        return SyntaxError(str(error), (file, 1, 0, ""))
    return None
