"""Checks forms of components while they are typed: names, doubles, numbers, files."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence

from rtkit.builder.settings import default_value
from rtkit.component.configuration.constraint_check import Declared, misfit_of, read_constraint
from rtkit.component.configuration.kinds import kind_of
from rtkit.errors import Malformed, RtkitError
from rtkit.rtc.names import near_port_name
from rtkit.web.builder.component_form import ERROR, WARNING, FieldFinding, Form, rows_of
from rtkit.web.folders import granted

_NAME = re.compile(r"[A-Za-z0-9_-]+")
_PORTS = ("dataPorts", "servicePorts")
_PARTS_OF_ID = ("vendor", "category", "version")


def check_form(form: Form, folder: str, folders: Sequence[str]) -> list[FieldFinding]:
    """Return what is to be said about fields, beside what makes a profile invalid.

    Args:
        form: As the page edits it.
        folder: Where its files are to be; IDL files are looked for from there.
        folders: Those that were granted.

    Raises:
        Malformed: It is no form.
    """
    return [
        *_names(form), *_doubles(form), *_numbers(form), *_idl_files(form, folder, folders),
    ]  # fmt: skip


def _text(part: Form, key: str) -> str:
    value = part.get(key, "")
    return value if isinstance(value, str) else ""


def _names(form: Form) -> Iterator[FieldFinding]:
    info = form["basicInfo"]
    name = _text(info, "name")
    if not name.strip():
        yield FieldFinding("basicInfo.name", ERROR, "A component needs a name.")
    elif not _NAME.fullmatch(name):
        text = f"{name!r}: other tools take letters, digits, - and _ only."
        yield FieldFinding("basicInfo.name", WARNING, text)
    for key in _PARTS_OF_ID:
        if ":" in _text(info, key):
            yield FieldFinding(f"basicInfo.{key}", ERROR, "A colon would break the id.")
    for kind in _PORTS:
        for place, port in rows_of(form, kind):
            yield from _name_of(place, _text(port, "name"), "A port")
        if kind == "dataPorts":
            for place, port in rows_of(form, kind):
                if not _text(port, "type").strip() and port.get("portType") != "EventPort":
                    yield FieldFinding(f"{place}.type", ERROR, "A data port needs a type.")
    for place, parameter in rows_of(form, "configurationSet", "configuration"):
        yield from _name_of(place, _text(parameter, "name"), "A parameter")
        if not _text(parameter, "type").strip():
            yield FieldFinding(f"{place}.type", ERROR, "A parameter needs a type.")


def _name_of(place: str, name: str, what: str) -> Iterator[FieldFinding]:
    if not name.strip():
        yield FieldFinding(f"{place}.name", ERROR, f"{what} needs a name.")
    elif near_port_name(name) != name:
        yield FieldFinding(f"{place}.name", ERROR, f"{what} cannot be called {name!r}.")
    elif not _NAME.fullmatch(name):
        text = f"{name!r}: other tools take letters, digits, - and _ only."
        yield FieldFinding(f"{place}.name", WARNING, text)


def _doubles(form: Form) -> Iterator[FieldFinding]:
    """Find names that are used twice: across all kinds of ports, and within the other lists."""
    ports = [row for kind in _PORTS for row in rows_of(form, kind)]
    yield from _twice(ports, "a port")
    yield from _twice(rows_of(form, "configurationSet", "configuration"), "a parameter")
    for place, port in rows_of(form, "servicePorts"):
        interfaces = rows_of(port, "serviceInterface")
        yield from _twice([(f"{place}.{own}", each) for own, each in interfaces], "an interface")


def _twice(rows: Sequence[tuple[str, Form]], what: str) -> Iterator[FieldFinding]:
    seen: set[str] = set()
    for place, part in rows:
        name = _text(part, "name")
        if name and name in seen:
            yield FieldFinding(f"{place}.name", ERROR, f"There is {what} {name} already.")
        seen.add(name)


def _numbers(form: Form) -> Iterator[FieldFinding]:
    info = form["basicInfo"]
    for key in ("executionRate", "maxInstances"):
        value = info.get(key)
        if isinstance(value, int | float) and value < 0:
            yield FieldFinding(f"basicInfo.{key}", ERROR, f"{value:g} is less than 0.")
    for place, part in rows_of(form, "configurationSet", "configuration"):
        at, text = f"{place}.defaultValue", part.get("defaultValue", "")
        notes: list[str] = []
        value = default_value(_text(part, "type"), str(text), "default", notes.append)
        if notes:
            yield from (FieldFinding(at, WARNING, each.removeprefix("default: ")) for each in notes)
            continue
        constraint = _text(part, "constraint")
        try:
            kind = kind_of(value)
            rule = Declared(kind.name, constraint, read_constraint(constraint))
            why = misfit_of(rule, str(text))
        except Malformed:
            continue  # the constraint itself has a finding
        if why:
            yield FieldFinding(at, ERROR, f"The default breaks the constraint: {why}")


def _idl_files(form: Form, folder: str, folders: Sequence[str]) -> Iterator[FieldFinding]:
    """Find IDL files that are there, outside of what was granted: they would be copied."""
    interfaces = [
        (f"{place}.{own}", each)
        for place, port in rows_of(form, "servicePorts")
        for own, each in rows_of(port, "serviceInterface")
    ]
    for place, part in (*rows_of(form, "dataPorts"), *interfaces):
        name = _text(part, "idlFile").replace("\\", "/")
        is_far = name.startswith("/") or ".." in name.split("/")
        path = os.path.normpath(os.path.join(folder, name))
        if is_far and os.path.lexists(path):
            try:
                granted(path, folders, endings=(".idl",))
            except RtkitError as error:
                yield FieldFinding(f"{place}.idlFile", ERROR, str(error))
