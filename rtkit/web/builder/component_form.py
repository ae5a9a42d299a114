"""Turns RTC profiles into the forms that the page edits, and back, with findings by field.

A form is the JSON form of an RTC profile without its root. Constraints are texts in it, as people
write them: ``0<=x<=100``. A place is the path of a field in the form, ``dataPorts.1.name``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.profile.common import Note
from rtkit.profile.constraint_text import format_constraint, parse_constraint
from rtkit.profile.examine import examine
from rtkit.profile.forms import JSON
from rtkit.profile.rtc_model import DeclaredParameters, RtcProfile
from rtkit.profile.tree_form import ROOTS, key_of
from rtkit.profile.write import plain_profile
from rtkit.profile.xmlnames import NAMESPACES, clark

Form = dict[str, Any]
ERROR, WARNING = "error", "warning"
_STEP = re.compile(r"@?(\w+):([\w.-]+)(?:\[(\d+)\])?")
_ROOT = ROOTS["rtc"]


class FieldFinding(NamedTuple):
    """A finding about one field of a form.

    Attributes:
        place: The field; empty for the whole.
        level: `ERROR` where nothing can be generated, else `WARNING`.
        text: A sentence.
    """

    place: str
    level: str
    text: str


class CheckedForm(NamedTuple):
    """A form that was read: its profile, None where there are errors, and findings."""

    profile: RtcProfile | None
    findings: Sequence[FieldFinding]


def form_of(profile: RtcProfile) -> Form:
    """Return the form of a profile.

    Raises:
        Malformed: It holds what XML could not.
    """
    form: Form = plain_profile(profile)[_ROOT]
    declared = profile.configuration_set or DeclaredParameters()
    constraints = [each.constraint for each in declared.configurations]
    constraints += [each.constraint for each in profile.data_ports]
    for (_, part), constraint in zip(_constrained(form), constraints, strict=True):
        if constraint is not None:
            part["constraint"] = format_constraint(constraint)
    return form


def read_form(form: Form) -> CheckedForm:
    """Read a form as an RTC profile, whose id is composed of its names.

    Raises:
        Malformed: It is no form.
    """
    if not isinstance(form.get("basicInfo"), dict):
        raise Malformed("basicInfo: an object is wanted")
    form = json.loads(json.dumps(form))
    names = (str(form["basicInfo"].get(key, "")) for key in _ID)
    form["id"] = ":".join(("RTC", *names))
    findings = list(_with_constraints(form))
    found = examine(json.dumps({_ROOT: form}), "form", form=JSON, kind="rtc")
    findings += [_finding(note, form, ERROR) for note in found.errors]
    findings += [_finding(note, form, WARNING) for note in found.repairs]
    profile = found.profile
    has_errors = any(each.level == ERROR for each in findings)
    return CheckedForm(profile if isinstance(profile, RtcProfile) and not has_errors else None,
                       findings)  # fmt: skip


_ID = ("vendor", "category", "name", "version")


def rows_of(form: Form, *keys: str) -> list[tuple[str, Form]]:
    """Return the parts of a list in a form, each with its place.

    Raises:
        Malformed: There is something else.
    """
    at: Any = form
    for key in keys:
        at = at.get(key, {}) if isinstance(at, dict) else None
    rows = at or []
    if not isinstance(rows, list) or not all(isinstance(each, dict) for each in rows):
        raise Malformed(f"{'.'.join(keys)}: a list of objects is wanted")
    return [(".".join((*keys, str(number))), each) for number, each in enumerate(rows)]


def _constrained(form: Form) -> list[tuple[str, Form]]:
    """Return the parts that may have a constraint: parameters, then data ports."""
    return rows_of(form, "configurationSet", "configuration") + rows_of(form, "dataPorts")


def _with_constraints(form: Form) -> Iterator[FieldFinding]:
    """Put constraints in place of their texts; yield what is wrong with some."""
    for place, part in _constrained(form):
        text = part.pop("constraint", None)
        if not isinstance(text, str):
            part |= {} if text is None else {"constraint": text}
            continue
        try:
            found = parse_constraint(text)
        except Malformed as error:
            yield FieldFinding(f"{place}.constraint", ERROR, str(error))
            continue
        if found is not None:
            part["constraint"] = _plain_constraint(found)


def _plain_constraint(constraint: Any) -> Any:
    """Return a constraint as the JSON form of profiles has it."""
    from rtkit.profile.rtc_spec import RTC_PROFILE
    from rtkit.profile.write import plain

    (ports,) = (each for each in RTC_PROFILE.children if each.name == clark("rtc:DataPorts"))
    assert ports.spec is not None
    (one,) = (each for each in ports.spec.children if each.field == "constraint")
    assert one.spec is not None
    return plain(constraint, one.spec, one.name)


def _finding(note: Note, form: Form, level: str) -> FieldFinding:
    return FieldFinding(place_of(note.path, form), level, note.text)


def place_of(path: str, form: Form) -> str:
    """Return the place of an XPath in a form; of a part that it does not have, what is around it.

    >>> place_of("/rtc:RtcProfile/rtc:DataPorts[2]/@rtc:name", {"dataPorts": [{}, {"name": ""}]})
    'dataPorts.1.name'
    """
    parent, at, steps = clark("rtc:RtcProfile"), form, []
    for step in path.split("/")[2:]:
        found = _STEP.fullmatch(step)
        if found is None or found[1] not in NAMESPACES or not isinstance(at, dict):
            break
        name = clark(f"{found[1]}:{found[2]}")
        key = key_of(name, parent)
        steps.append(key)
        at, parent = at.get(key, {}), name
        if isinstance(at, list):
            number = int(found[3] or 1) - 1
            steps.append(str(number))
            at = at[number] if number < len(at) else {}
    return ".".join(steps)
