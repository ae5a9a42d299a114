"""Variants of a system: the desired differences from its profile in one of its states."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from rtkit.deployment.properties import parameter_path
from rtkit.deployment.system import WantedComponent, WantedSystem
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, replace
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.nearest import did_you_mean

ACTIVE_SET = "active_set"
ALL = "*"
_WORDS: Mapping[str, str] = {
    word.casefold(): word for word in ("Active", "Inactive", "Absent", "Any")
}


class StateDifference(NamedTuple):
    """A desired difference from the profile.

    Attributes:
        component: By name; ``*`` for all others.
        what: Empty for the life-cycle state, ``active_set``, or ``SET.PARAMETER``; with an empty
            SET for the set that is in use.
    """

    component: str
    what: str
    value: str


@dataclass(frozen=True, slots=True)
class Variant:
    """A system as desired in one of its states.

    Attributes:
        states: Life-cycle states of components; None for as it is. Of others: Active.
        absent: Components that are not to be there.
    """

    system: WantedSystem
    states: Mapping[str, LifeCycleState | None]
    absent: frozenset[str]


def differences_of(text: str, sets: Mapping[str, Sequence[str]]) -> tuple[StateDifference, ...]:
    """Parse differences: ``Motor0=Active; Nav0.variant=bug2; Nav0.active_set=fast; *=Inactive``.

    Args:
        text: Desired differences, separated by semicolons.
        sets: Names of the configuration sets of each component.

    Raises:
        Malformed: One cannot be read, or names no component; or two contradict each other.
    """
    found: dict[tuple[str, str], StateDifference] = {}
    for item in filter(None, map(str.strip, text.split(";"))):
        name, equals, value = (part.strip() for part in item.partition("="))
        if not (name and equals):
            raise Malformed(f"not NAME=VALUE: {item!r}")
        wish = _wish(name, value, sets)
        known = found.setdefault((wish.component, wish.what), wish)
        if known != wish:
            raise Malformed(f"{name} is wished {known.value} and {value}")
    return tuple(found.values())


def _wish(name: str, value: str, sets: Mapping[str, Sequence[str]]) -> StateDifference:
    component, what = component_of(name, (*sets, ALL))
    if not what:
        word = _WORDS.get(value.casefold())
        if word is None:
            raise Malformed(f"{name} cannot be {value!r}; there are {', '.join(_WORDS.values())}")
        return StateDifference(component, "", word)
    if component == ALL:
        raise Malformed(f"a parameter is of one component: {name}")
    if what == ACTIVE_SET:
        return StateDifference(component, what, value)
    set_id, _, parameter = what.partition(".")
    is_named = bool(parameter) and set_id in sets[component]
    return StateDifference(component, what if is_named else f".{what}", value)


def component_of(name: str, known: Iterable[str]) -> tuple[str, str]:
    """Return a component, and what is named of it: ``Motor0.gain``.

    Raises:
        Malformed: There is no such component.
    """
    known = list(known)
    fits = [each for each in known if name == each or name.startswith(f"{each}.")]
    if not fits:
        first = name.partition(".")[0]
        raise Malformed(f"no such component: {first}{did_you_mean(first, known)}")
    component = max(fits, key=len)
    return component, name[len(component) + 1 :]


def variant(
    system: WantedSystem,
    wished: Iterable[StateDifference],
    watched: Collection[tuple[str, str]] = (),
) -> Variant:
    """Return a system as it is to be with these differences.

    Args:
        system: As its profile states it.
        wished: Desired differences from it.
        watched: Component and property of each value that leads from state to state. A
            living component keeps it: it was changed so that something happens, not to be set back.
    """
    of: dict[str, dict[str, str]] = {}
    for wish in wished:
        of.setdefault(wish.component, {})[wish.what] = wish.value
    usual = of.get(ALL, {}).get("", "Active")
    words = {c.instance: of.get(c.instance, {}).get("", usual) for c in system.components}
    states: dict[str, LifeCycleState | None] = {
        name: None if word in ("Any", "Absent") else LifeCycleState(word)
        for name, word in words.items()
    }
    components = tuple(
        _changed(c, of.get(c.instance, {}), {name for each, name in watched if each == c.instance})
        for c in system.components
    )
    absent = frozenset(name for name, word in words.items() if word == "Absent")
    return Variant(replace(system, components=components), states, absent)


def _changed(
    component: WantedComponent, wished: Mapping[str, str], watched: Collection[str]
) -> WantedComponent:
    active = wished.get(ACTIVE_SET, component.active_set)
    sets = {name: dict(values) for name, values in component.sets.items()}
    stated = set()
    for what, value in wished.items():
        set_id, dot, parameter = what.partition(".")
        if dot:
            set_id = set_id or active or "default"
            sets.setdefault(set_id, {})[parameter] = value
            stated.add((set_id, parameter))
    led_by = frozenset(
        (set_id, name)
        for set_id, values in sets.items()
        for name in values
        if parameter_path(set_id, name) in watched and (set_id, name) not in stated
    )
    return replace(component, sets=sets, active_set=active, kept=led_by)
