"""Checks identities and names: unknown types, other versions, names that two components share."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.report.finding import ERROR, NOTE, WARNING
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX
from rtkit.static_check.finding import StaticFinding
from rtkit.static_check.view import CheckedComponent, View

_LOOPBACK = ("127.0.0.1", "::1", "[::1]", "")


def name_findings(view: View) -> Iterator[StaticFinding]:
    """Yield components without profile or of another version, and names that clash."""
    for part in view.parts:
        yield from _type(view, part)
    yield from _clashes(view)


def _type(view: View, part: CheckedComponent) -> Iterator[StaticFinding]:
    id, where = part.component.id, part.place.at("id")
    if part.match is None:
        if part.component.participants:
            return  # its members decide what a composite is like
        text = f"no RTC profile is known for {part.name} ({id})"
        others = view.catalogue.namesakes(id)
        text += f"; of that name there is {', '.join(others)}" if others else ""
        yield StaticFinding(WARNING, "no-profile", text, where, id)
        return
    found = part.match.blueprint
    if part.match.is_other_version:
        text = f"{part.name} is checked against version {found.type.version} ({found.source})"
        yield StaticFinding(NOTE, "version", text, where, id, found.type.id)
    if part.match.others:
        text = (
            f"{part.name} is checked against {found.source};"
            f" its type is described otherwise in {', '.join(part.match.others)}"
        )
        yield StaticFinding(WARNING, "several-profiles", text, where, id)


def _clashes(view: View) -> Iterator[StaticFinding]:
    names: dict[tuple[str, str], CheckedComponent] = {}
    paths: dict[str, CheckedComponent] = {}
    for part in view.parts:
        manager, path = _place(part)
        first = names.setdefault((manager, part.name), part)
        if first is not part:
            text = f"two components are named {part.name} on {manager}"
            where = part.place.at("instance_name")
            yield StaticFinding(ERROR, "name-clash", text, where, part.name, "a name of its own")
            continue
        first = paths.setdefault(path, part) if path else part
        if first is not part:
            uri = part.component.path_uri
            text = f"{part.name} is registered as {uri}, and so is {first.name}"
            where = part.place.at("path_uri")
            yield StaticFinding(ERROR, "path-clash", text, where, uri, "a path of its own")


def _place(part: CheckedComponent) -> tuple[str, str]:
    """Return the manager that a component's path leads to, and the path if it is one."""
    elements = (part.component.path_uri or "").strip().lstrip("/").split("/")
    is_path = len(elements) > 1 and elements[-1].endswith(COMPONENT_SUFFIX)
    if not is_path or elements[0].endswith(":"):
        return LOCAL, ""
    host, *rest = elements
    name, colon, port = host.rpartition(":")
    host = name if colon and port.isdecimal() else host
    host = LOCAL if host in _LOOPBACK else host
    manager = next((each for each in rest if each.endswith(MANAGER_SUFFIX)), "")
    return f"{host}/{manager}".rstrip("/"), "/".join((host, *rest))
