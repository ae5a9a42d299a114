"""Text of a dump: a header, the checkpoint, one line for each event or fault, the state at the end.

Each line is a JSON table; values are written as `rtkit.manager.core.tagged` does. What is read is
data of a stranger: it is checked before anything is done with it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.manager.core.event_ring import Recording
from rtkit.manager.core.state import ManagerState
from rtkit.manager.core.tagged import from_plain, to_plain

FORM = 1
"""Of the file; another one cannot be read."""
_FORM_KEY = "rtkit-dump"


class Dump(NamedTuple):
    """A recording, with what its file says about it.

    Attributes:
        header: Texts: ``manager``, ``host``, ``pid``, ``rtkit`` (its version), ``time``, ``why``.
    """

    header: Mapping[str, str]
    recording: Recording


def to_lines(dump: Dump) -> Iterator[str]:
    """Yield the lines of a dump, without their ends."""
    header, recording = dump
    yield _line({_FORM_KEY: FORM, **header, "lost": recording.lost})
    yield _line({"start": to_plain(recording.start)})
    for at, item in recording.items:
        yield _line({"at": at, "item": to_plain(item)})
    yield _line({"end": to_plain(recording.end)})


def from_lines(lines: Iterable[str]) -> Dump:
    """Read a dump.

    Raises:
        Malformed: It is none, or of another form, or cut off; names the line.
    """
    header: dict[str, Any] = {}
    found: dict[str, Any] = {}
    items: list[tuple[float, Any]] = []
    number = 0
    for number, line in enumerate(lines, 1):
        try:
            table = _table(line)
            if number == 1:
                header = _header(table)
            elif "end" in found:
                raise Malformed("something follows the end")
            elif "item" in table and "start" in found:
                items.append((_moment(table.get("at")), from_plain(table["item"])))
            else:
                name = "end" if "start" in found else "start"
                if table.keys() != {name}:
                    raise Malformed("no such line is expected here")
                found[name] = from_plain(table[name])
        except Malformed as error:
            raise Malformed(f"not a dump of a manager, line {number}: {error}") from error
    if "end" not in found:
        raise Malformed(f"not a whole dump of a manager: it ends after line {number}")
    return _checked(header, found, items)


def _checked(
    header: dict[str, Any], found: Mapping[str, Any], items: list[tuple[float, Any]]
) -> Dump:
    start, end, lost = found["start"], found["end"], header.pop("lost")
    if not isinstance(end, ManagerState) or not isinstance(start, dict | None):
        raise Malformed("not a dump of a manager: it has no state")
    return Dump(header, Recording(start, items, end, lost))


def _line(table: Mapping[str, Any]) -> str:
    return json.dumps(table, separators=(",", ":"))


def _table(line: str) -> dict[str, Any]:
    try:
        table = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"not JSON: {error}") from error
    if not isinstance(table, dict):
        raise Malformed("not a JSON table")
    return table


def _header(table: dict[str, Any]) -> dict[str, Any]:
    form = table.pop(_FORM_KEY, None)
    if form is None:
        raise Malformed("no header")
    if form != FORM:
        by = f", of rtkit {table['rtkit']}" if isinstance(table.get("rtkit"), str) else ""
        raise Malformed(f"form {form!r}{by}; this rtkit reads form {FORM}")
    lost = table.pop("lost", None)
    if type(lost) is not int or not all(type(text) is str for text in table.values()):
        raise Malformed("a header of another kind")
    return {**table, "lost": lost}


def _moment(at: object) -> float:
    if type(at) not in (int, float) or not math.isfinite(at):  # type: ignore[arg-type]
        raise Malformed(f"no time: {at!r}")
    return float(at)  # type: ignore[arg-type]
