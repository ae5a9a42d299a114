"""Known properties of system profiles, and warnings about properties that rtkit does not know."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from typing import NamedTuple

from rtkit.deployment import extension as ext
from rtkit.deployment.described import properties_of
from rtkit.errors import Malformed
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import RtsProfile
from rtkit.rtc.create import parse_create
from rtkit.rtc.nearest import CLOSE, did_you_mean

OWN = "rtkit."
OF_SYSTEMS = (
    ext.STATES, ext.TRANSITIONS, ext.STATE_CHART, ext.STATE, ext.EVENT, ext.FOLLOW,
    ext.SLAVE_RESTART,
)  # fmt: skip
OF_COMPONENTS = (
    ext.CREATE,
    ext.MODULE,
    ext.HOT,
    ext.COST,
    ext.STAND_IN,
    f"{ext.STAND_IN}.",
    ext.RESTART,
    ext.RESTART_DELAY,
    ext.RESTART_LIMIT,
    ext.CRITICAL,
    ext.HEALTH,
    ext.LIMIT,
    ext.LIMIT_MEMORY,
    ext.LIMIT_PROCESSES,
    ext.LIMIT_DESCRIPTORS,
    ext.LIMIT_PROCESSOR,
    ext.MOVABLE,
    ext.PLACE,
    ext.PLACE_HOSTS,
    ext.PLACE_TAGS,
    ext.PLACE_MEMORY,
    ext.PLACE_DEVICE,
    ext.PLACE_DEVICE_POLICY,
    ext.PLACE_WITH,
    ext.PLACE_APART,
)
OF_PORTS = (ext.INTERFACES, ext.STATED_TYPE)
"""Keys of properties; what ends in a dot begins many."""
_USUAL_OPTIONS = frozenset(("instance_name", "manager_name"))
_OWNERS = (("the system", OF_SYSTEMS), ("a component", OF_COMPONENTS), ("a port", OF_PORTS))


class Odd(NamedTuple):
    """A property that is not known.

    Attributes:
        steps: Where it stands: by the fields of the model from the root on, each with a number.
        key: Its name.
        text: The warning about it.
    """

    steps: tuple[tuple[str, int], ...]
    key: str
    text: str


def odd_properties(profile: RtsProfile) -> Iterator[Odd]:
    """Yield the properties that look like rtkit's and are not; those of others are theirs."""
    yield from _among(profile.properties, OF_SYSTEMS, (), "")
    for number, each in enumerate(profile.components):
        place, name = (("components", number),), f"{each.instance_name}: "
        yield from _among(each.properties, OF_COMPONENTS, place, name)
        for field in ("data_ports", "service_ports"):
            for count, port in enumerate(getattr(each, field)):
                below = (*place, (field, count))
                yield from _among(port.properties, OF_PORTS, below, f"{name}port {port.name}: ")


def odd_options(
    profile: RtsProfile, unknown: Callable[[Mapping[str, str]], Iterable[str]]
) -> Iterator[str]:
    """Yield what is `unknown` of the options of create strings, each with its component.

    Those that nearly every create string has are not checked, so that who has no others need not
    load what knows them all.
    """
    for each in profile.components:
        text = properties_of(each.properties).get(ext.CREATE, "")
        with suppress(Malformed):  # refused where it is read
            options = parse_create(text).options if text else {}
            if not options.keys() <= _USUAL_OPTIONS:
                yield from (f"{each.instance_name}: {note}" for note in unknown(options))


def _among(
    properties: Sequence[ExtensionProperty],
    known: tuple[str, ...],
    place: tuple[tuple[str, int], ...],
    name: str,
) -> Iterator[Odd]:
    for number, each in enumerate(properties):
        text = odd_key(each.name, known)
        if text:
            yield Odd((*place, ("properties", number)), each.name, f"{name}{text}")


@cache  # components of a system have the same few keys
def odd_key(key: str, known: tuple[str, ...]) -> str:
    """Return a warning about a key that looks like one of these and is not, empty for nothing."""
    if _is_among(key, known) or (ext.RESTART in known and ext.is_policy(key)):
        return ""  # policies are judged with their values
    owner = next((w for w, keys in _OWNERS if keys is not known and _is_among(key, keys)), "")
    hint = f" (it belongs to {owner})" if owner else did_you_mean(key, known, 1, least=CLOSE)
    return f"unknown property: {key}{hint}" if hint or key.startswith(OWN) else ""


def _is_among(key: str, known: Sequence[str]) -> bool:
    return any(key == each or (each.endswith(".") and key.startswith(each)) for each in known)
