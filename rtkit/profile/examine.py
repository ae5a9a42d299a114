"""Examines a document: its kind of profile, every finding on the way, and where each part stands.

For programs that report on profiles. Programs that use one call `rtkit.profile.read`.

The parser only reports the line on which a start tag ends. For tags over several lines the text is
searched, where its encoding has ASCII in it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.profile.common import Note
from rtkit.profile.findings import Findings, InvalidProfile
from rtkit.profile.forms import XML, form_of
from rtkit.profile.read import STDIN, as_it_stands, outcome
from rtkit.profile.spec import Child, ElementSpec

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile


_MOST_LINES = 200
_LONGEST_LINE = 5_000
"""A tag over more lines is not looked for, nor one among longer lines: there may be many notes."""
_LAST_NAME = re.compile(r"(?:[^/\[\]:'@]*:)?([^/\[\]:'@]+)(?:\[\d+\])?$")
_LOCAL_NAME = re.compile(
    r"local-name\(\)='([^']*)'(?: and namespace-uri\(\)='[^']*')?\](?:\[\d+\])?$"
)


class Position(NamedTuple):
    """A line of a document, and the XPath of an element or attribute."""

    line: int
    path: str


class Positions:
    """Positions of the parts of one model, in the tree that the model was built from."""

    def __init__(self, root: Any, spec: ElementSpec, found: Findings) -> None:
        self._root = root
        self._spec = spec
        self._found = found
        self._children: dict[Any, dict[str, list[tuple[Any, ElementSpec | None]]]] = {}

    def position(self, steps: Sequence[tuple[str, int]], field: str = "") -> Position:
        """Return where the part is to which fields of the model lead, each with its number.

        `field` is an attribute of that part. What the document does not hold is where it would
        be: at the nearest part around it.
        """
        element, spec = self._root, self._spec
        for name, number in steps:
            below = self._below(element, spec).get(name, [])
            if number >= len(below) or below[number][1] is None:
                break
            element, inner = below[number]
            spec = inner if inner is not None else spec
        names = (each.name for each in spec.attributes if each.field == field)
        attribute = next((each for each in names if element.get(each) is not None), None)
        return Position(self._found.line(element), self._found.path(element, attribute))

    def _below(
        self, element: Any, spec: ElementSpec
    ) -> dict[str, list[tuple[Any, ElementSpec | None]]]:
        known = self._children.get(element)
        if known is None:
            known = {}
            for item in element:
                slot: tuple[int, Child] | None = spec.index.get(item.tag)
                if slot is not None:
                    known.setdefault(slot[1].field, []).append((item, slot[1].spec))
            self._children[element] = known
        return known


@dataclass(frozen=True, slots=True)
class Examination:
    """Findings on one document.

    Attributes:
        kind: ``rts`` or ``rtc``; empty where the document is neither.
        profile: None where there are errors.
        errors: Faults that no mode forgives.
        repairs: Repaired deviations; errors where the strict form is asked for.
        remarks: Allowed content that is worth knowing of.
        positions: Where the parts of `profile` stand; None where it is None.
    """

    kind: str
    profile: RtcProfile | RtsProfile | None
    errors: tuple[Note, ...] = ()
    repairs: tuple[Note, ...] = ()
    remarks: tuple[Note, ...] = ()
    positions: Positions | None = field(default=None, compare=False, repr=False)


def examine(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, kind: str | None = None
) -> Examination:
    """Examine a profile of either kind in any form; takes the arguments of `read_profile`.

    Raises:
        Malformed: There is no such form.
    """
    try:
        seen = outcome(data, source, form, kind)
    except InvalidProfile as error:
        return Examination("", None, error.problems)
    return Examination(
        seen.kind,
        seen.profile,
        _sorted(seen.errors, data, source, form),
        _sorted(seen.repairs, data, source, form),
        _sorted(seen.remarks, data, source, form),
        None if seen.profile is None else Positions(seen.root, seen.spec, seen.found),
    )


def objections(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, kind: str | None = None
) -> tuple[Note, ...]:
    """Return the schema's violations of a document as it stands, before any repair; slow.

    Raises:
        Malformed: There is no such form.
    """
    from rtkit.profile.validate import explained_violations

    try:
        root, _, grammar = as_it_stands(data, source, form, kind)
    except InvalidProfile:
        # `examine` has reported a document that cannot be opened.
        return ()
    return _sorted(explained_violations(root, grammar.schema), data, source, form)


def _sorted(
    notes: Sequence[Note], data: bytes | str, source: str, form: str | None
) -> tuple[Note, ...]:
    """Return notes by line; those on XML by the lines at which people look."""
    raw = data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data
    if not notes or (form or form_of(raw, source)) != XML:
        return tuple(sorted(notes))
    return tuple(sorted(at_their_lines(notes, raw)))


def at_their_lines(notes: Iterable[Note], data: bytes) -> list[Note]:
    """Return the notes of an XML document with the lines at which a reader would look."""
    if b"\0" in data[:4]:
        return list(notes)
    # Any encoding that has ASCII in it will do: names of profiles are nothing else.
    lines = data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return [replace(note, line=_line(note, lines)) for note in notes]


def _line(note: Note, lines: list[str]) -> int:
    element, _, attribute = note.path.partition("/@")
    name = _name(element)
    if not name or not 0 < note.line <= len(lines):
        return note.line
    start = re.compile(rf"<(?:[\w.-]+:)?{re.escape(name)}(?![\w.-])")
    nearest = range(note.line, max(0, note.line - _MOST_LINES), -1)
    if any(len(lines[n - 1]) > _LONGEST_LINE for n in nearest):
        return note.line
    begin = next((n for n in nearest if start.search(lines[n - 1])), None)
    if begin is None:
        return note.line
    named = _name(attribute)
    if begin == note.line or not named:
        return begin
    inside = re.compile(rf"(?<![\w.-]){re.escape(named)}\s*(?:=|$)")
    return next((n for n in range(begin, note.line + 1) if inside.search(lines[n - 1])), begin)


def _name(path: str) -> str:
    """Return the local name that the last step of a path tells."""
    found = _LOCAL_NAME.search(path) or _LAST_NAME.search(path)
    return found[1] if found else ""
