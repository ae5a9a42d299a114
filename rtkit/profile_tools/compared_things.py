"""Things with fields, the parts by which two profiles are compared by name."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

from rtkit.profile.common import NO_FOREIGN, ExtensionProperty, Foreign


class ThingKey(NamedTuple):
    """Identity of a thing: its kind and name, in the order of reports."""

    rank: int
    kind: str
    name: str


class Thing(NamedTuple):
    """A component, port, connector or the like.

    Attributes:
        fields: Its values as text, by what they are called.
        owner: The thing that it belongs to.
    """

    fields: dict[str, str]
    owner: ThingKey | None = None


Things = dict[ThingKey, Thing]


def put(things: Things, key: ThingKey, thing: Thing) -> ThingKey:
    """Add a thing; a second one of its name gets a number.

    Returns:
        The key under which it was added.
    """
    number = 1
    new = key
    while new in things:
        number += 1
        new = key._replace(name=f"{key.name} ({number})")
    things[new] = thing
    return new


class Collector:
    """Collects the things of a profile: with all their fields, or with what these mean."""

    def __init__(self, takes_all: bool) -> None:
        self.takes_all = takes_all
        self.things: Things = {}

    def add(
        self,
        key: tuple[int, str, str],
        model: Any,
        meaning: dict[str, str],
        without: Container[str] = (),
        owner: ThingKey | None = None,
    ) -> ThingKey:
        """Add a thing, of which a model tells all but the fields `without`; return its key."""
        fields = fields_of(model, without) if self.takes_all else meaning
        return put(self.things, ThingKey(*key), Thing(fields, owner))


def fields_of(model: Any, without: Container[str] = (), prefix: str = "") -> dict[str, str]:
    """Return all values of a model as text, by name; absent ones are left out.

    Properties are fields of their own, nested models have theirs behind a dot.
    """
    found: dict[str, str] = {}
    for each in fields(model):
        if each.name not in without:
            _put_value(found, prefix + each.name, getattr(model, each.name))
    return found


def _put_value(found: dict[str, str], name: str, value: Any) -> None:
    if value is None or (isinstance(value, Foreign) and value == NO_FOREIGN):
        return
    if isinstance(value, tuple):
        for number, item in enumerate(value, 1):
            if isinstance(item, ExtensionProperty):
                called = f"property {item.name}"
                _append(found, called, "(no value)" if item.value is None else item.value)
                _put_value(found, f"{called}.foreign", item.foreign)
            else:
                _put_value(found, f"{name} {number}", item)
    elif isinstance(value, Foreign) or not is_dataclass(value):
        found[name] = _text(value)
    else:
        found.update(fields_of(value, prefix=f"{name}."))


def _append(found: dict[str, str], name: str, value: str) -> None:
    found[name] = f"{found[name]}\n{value}" if name in found else value


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    is_whole = isinstance(value, float) and value.is_integer()
    return str(int(value)) if is_whole else str(value)


def as_fields(**values: object) -> dict[str, str]:
    """Return values as fields; absent and empty ones are the same."""
    return {name: _text(value) for name, value in values.items() if value not in (None, "")}


def picked(model: Any, *names: str) -> dict[str, str]:
    """Return some values of a model as fields, under their names in the model."""
    return as_fields(**{name: getattr(model, name) for name in names})
