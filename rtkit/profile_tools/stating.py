"""Edits extension properties of a system and its components: sets, adds, removes them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from rtkit.errors import Malformed, NotFound
from rtkit.fast_dataclass import replace
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import RtsProfile
from rtkit.rtc.nearest import did_you_mean


class Statement(NamedTuple):
    """One edit of an extension property.

    Attributes:
        instance: Name of the component; empty for the system itself.
        key: Name of the property.
        value: None has it removed.
    """

    instance: str
    key: str
    value: str | None


def statement(text: str, *, is_removal: bool = False) -> Statement:
    """Read ``[INSTANCE:]KEY=VALUE``, or ``[INSTANCE:]KEY`` of what is to be removed.

    Raises:
        Malformed: It is neither.
    """
    where, equals, value = text.partition("=")
    instance, _, key = where.rpartition(":")
    if not key.strip() or bool(equals) is is_removal:
        raise Malformed(f"not [INSTANCE:]KEY{'' if is_removal else '=VALUE'}: {text}")
    return Statement(instance.strip(), key.strip(), None if is_removal else value)


def stated(profile: RtsProfile, statements: Iterable[Statement]) -> RtsProfile:
    """Return a profile with these statements.

    Raises:
        NotFound: There is no such component, or no such property to be removed.
    """
    for each in statements:
        if not each.instance:
            profile = replace(profile, properties=_with(profile.properties, each, "the system"))
            continue
        if not any(c.instance_name == each.instance for c in profile.components):
            known = [c.instance_name for c in profile.components]
            hint = (
                did_you_mean(each.instance, known) or f" (components: {', '.join(known) or 'none'})"
            )
            raise NotFound(f"no component named {each.instance}{hint}")
        profile = replace(
            profile,
            components=tuple(
                replace(c, properties=_with(c.properties, each, c.instance_name))
                if c.instance_name == each.instance
                else c
                for c in profile.components
            ),
        )
    return profile


def _with(
    properties: tuple[ExtensionProperty, ...], statement: Statement, whose: str
) -> tuple[ExtensionProperty, ...]:
    """Return properties with one stated, in its place if it has one."""
    kept = [each for each in properties if each.name != statement.key]
    if statement.value is None:
        if len(kept) == len(properties):
            raise NotFound(f"{whose} has no property {statement.key}")
        return tuple(kept)
    place = next((n for n, each in enumerate(properties) if each.name == statement.key), len(kept))
    return (*kept[:place], ExtensionProperty(statement.key, statement.value), *kept[place:])
