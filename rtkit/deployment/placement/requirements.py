"""Requirements of components about their place, as properties of a profile and a create string.

``rtkit.place.hosts`` and ``.tags`` restrict the hosts, ``.memory`` is what has to be free there,
``.device`` names device files, ``.with`` components of the same process, ``.not_with`` components
of other hosts, ``.device_policy`` says what becomes of the component when a device goes.

See decision 81.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from enum import StrEnum
from functools import lru_cache
from typing import Any

from rtkit.deployment.extension import (
    PLACE,
    PLACE_APART,
    PLACE_DEVICE,
    PLACE_DEVICE_POLICY,
    PLACE_HOSTS,
    PLACE_MEMORY,
    PLACE_TAGS,
    PLACE_WITH,
)
from rtkit.deployment.limits import read_bytes
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.create import FRESH_SLAVE, listed_names
from rtkit.rtc.names import LOCAL, check_host_name
from rtkit.rtc.nearest import did_you_mean

FREE = "*"
"""The host in the path of a component whose host is to be chosen."""
_FOLDER = "/dev/"


class DevicePolicy(StrEnum):
    """Device policy: what becomes of a component when a device that it requires goes."""

    END = "end"
    KEEP = "keep"


@dataclass(frozen=True, slots=True)
class Requirements:
    """Requirements of one component.

    Attributes:
        hosts: Of which it is to be on one; empty for any.
        tags: Words that its host has.
        memory: Free memory there [bytes].
        devices: Paths that are there, perhaps with ``*`` and ``?``.
        with_: Components in whose process it is.
        apart: Components on whose hosts it is not.
    """

    hosts: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()
    memory: int = 0
    devices: tuple[str, ...] = ()
    with_: tuple[str, ...] = ()
    apart: tuple[str, ...] = ()
    device_policy: DevicePolicy = DevicePolicy.END


NOTHING_REQUIRED = Requirements()


def read_requirements(options: Mapping[str, str]) -> Requirements:
    """Return the requirements that the properties of a component state.

    Raises:
        Malformed: One makes no sense; names it.
    """
    stated = tuple(sorted((k, v) for k, v in options.items() if k.startswith(PLACE)))
    return _read(stated) if stated else NOTHING_REQUIRED


@lru_cache(maxsize=256)
def _read(stated: tuple[tuple[str, str], ...]) -> Requirements:
    values: dict[str, Any] = {}
    for key, text in stated:
        if key not in _READERS:
            hint = did_you_mean(key, _READERS, 1)
            raise Malformed(f"unknown requirement: {key}{hint or f' (one of {_KNOWN})'}")
        name, reader = _READERS[key]
        if text.strip():
            values[name] = reader(key, text.strip())
    both = sorted({*values.get("with_", ())} & {*values.get("apart", ())})
    if both:
        raise Malformed(f"{PLACE_WITH} and {PLACE_APART} both name {', '.join(both)}")
    return Requirements(**values)


def _names(key: str, text: str) -> tuple[str, ...]:
    names = listed_names(text)
    odd = [each for each in text.split(",") if not each.strip()]
    if odd or len(set(names)) < len(names):
        why = "an empty word" if odd else "a word twice"
        raise Malformed(f"{key}: {why} in the list: {text}")
    return names


def _hosts(key: str, text: str) -> tuple[str, ...]:
    names = _names(key, text)
    for each in names:
        try:
            if each != LOCAL:
                check_host_name(each)
        except Malformed as error:
            raise Malformed(f"{key}: {error}") from None
    return names


def _devices(key: str, text: str) -> tuple[str, ...]:
    return tuple(_device(key, each) for each in _names(key, text))


def _device(key: str, name: str) -> str:
    """Return the path of a device: a name without a slash before it is below /dev."""
    path = name if name.startswith("/") else _FOLDER + name
    steps = path.split("/")[1:]
    if any(each in ("", ".", "..") for each in steps) or not path.isprintable():
        raise Malformed(f"{key}: neither a name below /dev nor a path: {name}")
    if any("*" in each or "?" in each for each in steps[:-1]):
        raise Malformed(f"{key}: * and ? may stand behind the last slash only: {name}")
    return path


def _policy(key: str, text: str) -> DevicePolicy:
    try:
        return DevicePolicy(text.lower())
    except ValueError:
        raise Malformed(f"{key}: not one of {', '.join(DevicePolicy)}: {text}") from None


_READERS: Mapping[str, tuple[str, Any]] = {
    PLACE_HOSTS: ("hosts", _hosts),
    PLACE_TAGS: ("tags", _names),
    PLACE_MEMORY: ("memory", read_bytes),
    PLACE_DEVICE: ("devices", _devices),
    PLACE_WITH: ("with_", _names),
    PLACE_APART: ("apart", _names),
    PLACE_DEVICE_POLICY: ("device_policy", _policy),
}
_KNOWN = ", ".join(_READERS)


def check_named(name: str, required: Requirements, known: Collection[str]) -> None:
    """Refuse requirements that name components which the system does not have, or itself.

    Raises:
        Malformed: Names the requirement.
    """
    for key, names in ((PLACE_WITH, required.with_), (PLACE_APART, required.apart)):
        for each in names:
            if each == name:
                raise Malformed(f"{key}: names the component itself: {each}")
            if each not in known:
                raise Malformed(f"{key}: no such component: {each}{did_you_mean(each, known)}")


def process_groups(required: Mapping[str, Requirements]) -> list[list[str]]:
    """Return the components that share a process by requirement, those that are alone too."""
    group_of = {name: [name] for name in required}
    for name, each in required.items():
        for other in each.with_:
            ours, theirs = group_of[name], group_of.get(other, group_of[name])
            if ours is not theirs:
                ours.extend(theirs)
                group_of.update(dict.fromkeys(theirs, ours))
    return list({id(group): group for group in group_of.values()}.values())


def shared_slaves(
    required: Mapping[str, Requirements], stated: Mapping[str, str]
) -> Iterator[tuple[str, str]]:
    """Yield components that belong in the slave that another one of their process names.

    Args:
        required: Requirements by component.
        stated: The slaves that create strings name; nothing for components without one.

    Raises:
        Malformed: Two of one process name different slaves, or ask for one of their own.
    """
    for group in process_groups(required):
        named = {each: stated[each] for each in group if stated.get(each)}
        if len(group) < 2 or not named:
            continue
        alone = next((each for each, slave in named.items() if slave == FRESH_SLAVE), "")
        if alone:
            raise Malformed(
                f"{PLACE_WITH}: {alone} asks for a slave of its own ({FRESH_SLAVE}); its create"
                f" string has to name the slave that {_others(group, alone)} shares"
            )
        (first, slave), *others = named.items()
        other = next((each for each, its in others if its != slave), "")
        if other:
            raise Malformed(
                f"{PLACE_WITH}: {first} and {other} share a process, but their create strings name"
                f" the slaves {slave} and {named[other]}"
            )
        yield from ((each, slave) for each in group if each not in named)


def _others(group: Iterable[str], name: str) -> str:
    return ", ".join(each for each in group if each != name)
