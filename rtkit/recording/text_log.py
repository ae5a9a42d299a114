"""Reads and writes recordings as text: ``SECONDS.NANOSECONDS TAB (stream, value)`` a line.

Values are written as JSON. The reader also accepts the constructor calls of other tools,
``RTC.TimedLong(tm=RTC.Time(sec=1, nsec=2), data=3)``: it parses and never executes them.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.recording.entries import NANOSECONDS

_LINE = re.compile(r"(\d{1,12})\.(\d{9})\t\((?:'([^']*)'|\"([^\"]*)\"), (.*)\)")


_MCAP = b"\x89MCAP"
"""First bytes of an MCAP file."""


class TextEntry(NamedTuple):
    """One line; `value` is data of JSON."""

    stream: str
    time_ns: int
    value: Any


def line_of(stream: str, time_ns: int, value: Any) -> str:
    """Return the line of a value that is data of JSON."""
    seconds, nanoseconds = divmod(time_ns, NANOSECONDS)
    return f"{seconds}.{nanoseconds:09}\t({stream!r}, {json.dumps(value, ensure_ascii=False)})"


def read_file(name: str) -> Iterator[TextEntry]:
    """Yield the values of a text log.

    Raises:
        Malformed: The file is no text, or a line is none of a log; names it.
        OSError: The file cannot be read.
    """
    with open(name, "rb") as file:
        data = file.read()
    if data.startswith(_MCAP):
        raise Malformed(f"{name}: this is an MCAP file, no text log: -l mcap")
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise Malformed(f"{name}:{line}: no line of a text log: it is not UTF-8") from None
    return read_lines(text.split("\n"), name)


def read_lines(lines: Iterable[str], source: str) -> Iterator[TextEntry]:
    """Yield the values of a text log.

    Raises:
        Malformed: A line is none; names it.
    """
    for number, line in enumerate(lines, start=1):
        text = line.rstrip("\r\n")
        if not text:
            continue
        match = _LINE.fullmatch(text)
        if match is None:
            raise Malformed(f"{source}:{number}: no line of a text log: {text[:60]}")
        seconds, nanoseconds, single, double, value = match.groups()
        try:
            data = _value(value)
        except (ValueError, SyntaxError, RecursionError, MemoryError) as error:
            raise Malformed(f"{source}:{number}: value not understood: {error}") from None
        time_ns = int(seconds) * NANOSECONDS + int(nanoseconds)
        yield TextEntry(single if single is not None else double, time_ns, data)


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return _built(ast.parse(text, mode="eval").body)


def _built(node: ast.expr) -> Any:
    """Return the data of a constant, a list or a constructor call, without calling anything."""
    if isinstance(node, ast.Constant):
        return list(node.value) if isinstance(node.value, bytes) else node.value
    if isinstance(node, (ast.List, ast.Tuple)):
        return [_built(item) for item in node.elts]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        number = _built(node.operand)
        if isinstance(number, (int, float)):
            return -number
    if isinstance(node, ast.Call) and not node.args and all(k.arg for k in node.keywords):
        return {str(keyword.arg): _built(keyword.value) for keyword in node.keywords}
    raise ValueError(f"{ast.unparse(node)[:60]} is no value")
