"""Repairs that only RTC profiles need; the general ones are in `rtkit.profile.normalise`."""

from __future__ import annotations

from typing import Any

from rtkit.profile.findings import Findings
from rtkit.profile.rts_rules import add
from rtkit.profile.xmlnames import XSI, clark, short, split

ACTIVITY_TYPES = ("PERIODIC", "SPORADIC", "EVENTDRIVEN")
_LANGUAGES = {"cxx": "C++", "python": "Python", "java": "Java", "csharp": "C#", "ruby": "Ruby"}


def _loose(element: Any, local: str) -> str | None:
    """Return an attribute by its local name, whatever its namespace."""
    for name, value in element.items():
        namespace, own = split(name)
        if own == local and namespace != XSI:
            return str(value)
    return None


def composed_id(root: Any, _: Findings) -> str:
    """Compose an absent id from BasicInfo; a fragment has none."""
    info = next((item for item in root if split(item.tag)[1] == "BasicInfo"), None)
    if info is None:
        return ""
    parts = [_loose(info, name) or "" for name in ("vendor", "category", "name", "version")]
    return ":".join(["RTC", *parts])


def usual_position(port: Any, _: Findings) -> str:
    """Place a data port where its direction puts it: in ports left, out ports right."""
    return "RIGHT" if (_loose(port, "portType") or "").upper() in _OUT else "LEFT"


_OUT = ("DATAOUTPORT", "OUT")


def basic_info(info: Any, found: Findings) -> None:
    """Take a misspelt activity type for the nearest one."""
    name = clark("rtc:activityType")
    value = info.get(name)
    if value is None or value.upper() in ACTIVITY_TYPES:
        return
    from difflib import get_close_matches

    nearest = get_close_matches(value.upper().strip(), ACTIVITY_TYPES, 1, 0.7)
    if nearest:
        info.set(name, nearest[0])
        text = f"rtc:activityType {value!r} taken as {nearest[0]!r}"
        allowed = ", ".join(ACTIVITY_TYPES)
        found.repaired(info, "respelled-value", text, at=name, seen=value, allowed=allowed)


def fragment_configuration(configuration: Any, found: Findings) -> None:
    """Let a parameter be nameless in a fragment, which only shows a constraint."""
    if not _is_fragment(configuration, found):
        return
    for local in ("name", "type"):
        if _loose(configuration, local) is None:
            configuration.set(clark(f"rtc:{local}"), "")
            text = f"rtc:{local} is absent: taken as ''"
            found.repaired(configuration, "absent-attribute", text, allowed="any text")


def _is_fragment(configuration: Any, found: Findings) -> bool:
    if found.is_fragment is None:
        root = configuration.getroottree().getroot()
        found.is_fragment = all(split(item.tag)[1] != "BasicInfo" for item in root)
    return found.is_fragment


def only_one(negation: Any, found: Findings) -> None:
    """Refuse the negation of several constraints: nobody can tell what it means."""
    count = len(negation.findall(clark("rtc:Constraint")))
    if count > 1:
        text = "rtc:Not holds more than one rtc:Constraint"
        found.wrong(negation, "repeated-element", text, seen=str(count), allowed="one")


def nested_language(language: Any, found: Findings) -> None:
    """Bring the language element of version 0.1, one child per language, to the present form."""
    for item in list(language):
        kind = _LANGUAGES.get(split(item.tag)[1].lower())
        if kind is None:
            continue
        text = f"{short(item.tag)} taken as rtc:kind {kind!r}"
        found.repaired(item, "old-form", text, seen=short(item.tag), allowed="rtc:kind")
        language.remove(item)
        if _loose(language, "kind") is None:
            language.set(clark("rtc:kind"), kind)
        facts = [(split(name)[1], value) for name, value in item.items()]
        facts += [(split(below.tag)[1], _text_of(below)) for below in item]
        if facts:
            _target(language, facts, found)


def _text_of(element: Any) -> str:
    return (element.text or "").strip() or _loose(element, "name") or ""


def _target(language: Any, facts: list[tuple[str, str]], found: Findings) -> None:
    target = add(found, language, "rtcExt:targets", {})
    for local, value in facts:
        if local == "os":
            target.set(clark("rtcExt:os"), value)
        elif local == "arch":
            add(found, target, "rtcExt:cpus", {}).text = value
        elif local in ("library", "libraries"):
            add(found, target, "rtcExt:libraries", {"rtcExt:name": value})


def check_names(root: Any, found: Findings) -> None:
    """Tell of a fragment and of port names used twice."""
    missing = [name for name in ("rtc:BasicInfo", "rtc:Actions") if root.find(clark(name)) is None]
    if missing:
        text = f"a fragment: no {' and no '.join(missing)}"
        found.repaired(root, "fragment", text, allowed="one rtc:BasicInfo, one rtc:Actions")
    seen: dict[str, int] = {}
    for port in root.iterchildren(clark("rtc:DataPorts"), clark("rtc:ServicePorts")):
        name = port.get(clark("rtc:name"))
        if name in seen:
            text = f"port name {name} is also used on line {seen[name]}"
            found.remark(port, "shared-name", text, at=clark("rtc:name"), seen=name)
        elif name is not None:
            seen[name] = found.line(port)
