"""Compares two profiles of one kind by meaning: components, connectors, parameters.

Things are the same where their names are, or the ends of a connector; ids, dates, positions and
remarks make no difference unless all is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rtkit.errors import Refused
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile_tools.compared_things import ThingKey, Things

ADDED, REMOVED, CHANGED = "added", "removed", "changed"
_MARKS = {ADDED: "+", REMOVED: "-", CHANGED: "~"}


class Difference(NamedTuple):
    """One difference between two profiles.

    Attributes:
        change: ``added``, ``removed`` or ``changed``.
        kind: Kind of the thing: component, port, connector …
        name: Name of the thing.
        field: The field that changed; empty where all of the thing came or went.
        before: The value before, None where there was none.
        after: The value after, None where there is none.
    """

    change: str
    kind: str
    name: str
    field: str = ""
    before: str | None = None
    after: str | None = None

    @property
    def text(self) -> str:
        """The difference on one line."""
        thing = f"{_MARKS[self.change]} {self.kind} {self.name}".rstrip()
        if not self.field:
            return thing
        if self.before == self.after:
            return f"{thing}: {self.field}"
        return f"{thing}: {self.field} {_shown(self.before)} -> {_shown(self.after)}"


def differences(
    before: RtcProfile | RtsProfile, after: RtcProfile | RtsProfile, *, takes_all: bool = False
) -> list[Difference]:
    """Return the differences of `after` from `before`; with all, none only where they are equal.

    Raises:
        Refused: They are not of one kind.
    """
    if isinstance(before, RtsProfile) and isinstance(after, RtsProfile):
        from rtkit.profile_tools.system_things import shared_names, system_things

        shared = shared_names(before) | shared_names(after)
        ways = (system_things(before, takes_all, shared), system_things(after, takes_all, shared))
    elif isinstance(before, RtcProfile) and isinstance(after, RtcProfile):
        from rtkit.profile_tools.component_things import component_things

        ways = (component_things(before, takes_all), component_things(after, takes_all))
    else:
        raise Refused("a component profile and a system profile cannot be compared")
    found = list(_differences(*ways))
    if takes_all and not found and before != after:
        found.append(Difference(CHANGED, "profile", "", "order of its elements"))
    return found


def _differences(before: Things, after: Things) -> Iterator[Difference]:
    for key in sorted(before.keys() | after.keys()):
        if key not in after:
            if not _owner_is_gone(key, before, after):
                yield Difference(REMOVED, key.kind, key.name)
        elif key not in before:
            if not _owner_is_gone(key, after, before):
                yield Difference(ADDED, key.kind, key.name)
        else:
            yield from _changes(key, before[key].fields, after[key].fields)


def _owner_is_gone(key: ThingKey, here: Things, there: Things) -> bool:
    """Return whether the owner of a thing is gone, too, and is reported instead."""
    owner = here[key].owner
    return owner is not None and owner not in there


def _changes(key: ThingKey, before: dict[str, str], after: dict[str, str]) -> Iterator[Difference]:
    for field in dict.fromkeys((*before, *after)):
        was, now = before.get(field), after.get(field)
        if was != now:
            yield Difference(CHANGED, key.kind, key.name, field, was, now)


def _shown(value: str | None) -> str:
    return "(none)" if value is None else value if value and value == value.strip() else repr(value)
