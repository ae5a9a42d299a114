"""Limits of a slave's use of its host, as properties of the components in it.

``rtkit.limit.memory`` [bytes], ``rtkit.limit.processes``, ``rtkit.limit.descriptors`` (of each
process) and ``rtkit.limit.processor`` (1 is one processor). A limit applies to the slave and all
processes below it: the limits of its components add up, and so do those of a host. Pure code, no
measuring.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from math import inf
from typing import Any, NamedTuple

from rtkit.deployment.extension import LIMIT
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.system import WantedSystem
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.connector_properties import finite
from rtkit.rtc.create import readable_create
from rtkit.rtc.nearest import did_you_mean

WINDOW_S = 5.0
"""The share of a processor is the mean of so long [s]."""
_UNITS = "KMGT"
_LEAST_BYTES = 1 << 20
_MOST_COUNT = 1 << 20
_MOST_PROCESSORS = 4096.0


@dataclass(frozen=True, slots=True)
class SlaveLimits:
    """The most that a slave may use; 0 for as much as there is.

    Attributes:
        memory: Resident memory of all its processes [bytes].
        processes: Its own process and all below it.
        descriptors: Open files of any one of them.
        processor: Mean number of processors in use within `WINDOW_S`.
    """

    memory: int = 0
    processes: int = 0
    descriptors: int = 0
    processor: float = 0.0

    def __add__(self, other: SlaveLimits) -> SlaveLimits:
        return SlaveLimits(
            self.memory + other.memory,
            self.processes + other.processes,
            self.descriptors + other.descriptors,
            round(self.processor + other.processor, 9),
        )

    def __bool__(self) -> bool:
        return self != NO_LIMITS

    @property
    def text(self) -> str:
        """Return all limits that are set, in one line."""
        parts = [f"memory {bytes_text(self.memory)}"] if self.memory else []
        parts += [f"processes {self.processes}"] if self.processes else []
        parts += [f"descriptors {self.descriptors}"] if self.descriptors else []
        parts += [f"processor {self.processor:g}"] if self.processor else []
        return ", ".join(parts)


NO_LIMITS = SlaveLimits()


@dataclass(frozen=True, slots=True)
class TreeUsage:
    """Usage of a slave and the processes below it; `processor` is their recent share."""

    memory: int = 0
    processes: int = 0
    descriptors: int = 0
    processor: float = 0.0


class Capacity(NamedTuple):
    """Capacity of a host: memory [bytes] and processors, perhaps less than whole ones."""

    memory: float = inf
    processors: float = inf


def read_limits(options: Mapping[str, str]) -> SlaveLimits:
    """Return the limits that the properties of a component state.

    Raises:
        Malformed: One makes no sense; names it.
    """
    stated = tuple(sorted((k, v) for k, v in options.items() if k.startswith(LIMIT)))
    return _read(stated) if stated else NO_LIMITS


def limits_in(create: str) -> SlaveLimits:
    """Return the limits in a create string; none in one that cannot be read."""
    if LIMIT not in create:
        return NO_LIMITS
    try:
        return read_limits(readable_create(create).options)
    except Malformed:
        return NO_LIMITS


@lru_cache(maxsize=256)
def _read(stated: tuple[tuple[str, str], ...]) -> SlaveLimits:
    values: dict[str, Any] = {}
    for key, text in stated:
        kind = key.removeprefix(LIMIT)
        if kind not in _READERS:
            hint = did_you_mean(kind, _READERS, 1, lambda each: LIMIT + each)
            raise Malformed(f"unknown limit: {key}{hint or f' (one of {_KNOWN})'}")
        if text.strip():
            values[kind] = _READERS[kind](key, text.strip())
    return SlaveLimits(**values)


def read_bytes(key: str, text: str) -> int:
    """Read ``200M``, ``200MiB``, ``1.5G`` or a plain number of bytes; a K is 1024.

    Raises:
        Malformed: It is none, or below 1 MiB.
    """
    bare = text.upper().removesuffix("B").removesuffix("I")
    unit = _UNITS.find(bare[-1:]) + 1 if bare[-1:] else 0
    is_odd = text.upper().endswith("IB") and not unit
    value = _number(bare[:-1] if unit else bare) * 1024.0**unit
    if is_odd or not _LEAST_BYTES <= value <= 1024.0**5:
        raise Malformed(f"{key}: not an amount of memory from 1M on, such as 200M or 1.5G: {text}")
    return int(value)


def _count(key: str, text: str) -> int:
    value = _number(text)
    if not (1 <= value <= _MOST_COUNT and value == int(value)):
        raise Malformed(f"{key}: not a whole number from 1 to {_MOST_COUNT}: {text}")
    return int(value)


def _share(key: str, text: str) -> float:
    """Read ``0.5`` or ``50%`` of one processor."""
    value = _number(text[:-1]) / 100 if text.endswith("%") else _number(text)
    if not 0 < value <= _MOST_PROCESSORS:
        raise Malformed(f"{key}: not a share of a processor, such as 0.5, 50% or 2: {text}")
    return value


def _number(text: str) -> float:
    """Return a number; -1 for what is none, or is written in a way that nobody would mean."""
    if not text.strip().replace(".", "", 1).isdecimal() or not text.isascii():
        return -1.0
    value = finite(text)
    return -1.0 if value is None else value


_READERS: Mapping[str, Callable[[str, str], float]] = {
    "memory": read_bytes,
    "processes": _count,
    "descriptors": _count,
    "processor": _share,
}
_KNOWN = ", ".join(LIMIT + kind for kind in _READERS)


def bytes_text(amount: float) -> str:
    """Return an amount of memory with the largest unit that leaves a whole part."""
    for unit in reversed(_UNITS):
        size = 1024.0 ** (_UNITS.index(unit) + 1)
        if amount >= size:
            return f"{amount / size:.4g} {unit}iB"
    return f"{amount:.0f} B"


def reached(limits: SlaveLimits, used: TreeUsage) -> str:
    """Return which limit is reached, with what is used; empty for none."""
    if limits.memory and used.memory >= limits.memory:
        return memory_reached(limits, bytes_text(used.memory))
    if limits.processes and used.processes > limits.processes:
        return f"limit of {limits.processes} processes reached ({used.processes})"
    if limits.descriptors and used.descriptors >= limits.descriptors:
        return descriptors_reached(limits, str(used.descriptors))
    if limits.processor and used.processor > limits.processor:
        within = f"{used.processor:.2f} over {WINDOW_S:g} s"
        return f"processor limit of {limits.processor:g} reached ({within})"
    return ""


def memory_reached(limits: SlaveLimits, how: str) -> str:
    """Return the reason of an end for too much memory."""
    return f"memory limit of {bytes_text(limits.memory)} reached ({how})"


def descriptors_reached(limits: SlaveLimits, how: str) -> str:
    """Return the reason of an end for too many descriptors."""
    return f"limit of {limits.descriptors} descriptors reached ({how})"


def exhausted(limits: SlaveLimits, cause: str) -> str:
    """Return which limit made a callback fail for that cause; empty where none did."""
    if limits.memory and "MemoryError" in cause:
        return memory_reached(limits, cause)
    if limits.descriptors and "[Errno 24]" in cause:
        return descriptors_reached(limits, cause)
    return ""


def needs_slave(instance: str) -> str:
    """Return why a component with limits cannot be in the manager's own process."""
    return (
        f"{instance} has limits, and only a slave can be limited, not the manager itself:"
        " name one in its create string (manager_name=SLAVE)"
    )


def overbooked(reserved: Mapping[str, SlaveLimits], capacity: Capacity) -> str:
    """Return of what components may use more together than there is; empty for nothing."""
    for kind, have, text in (
        ("memory", capacity.memory, bytes_text),
        ("processor", capacity.processors, "{:g}".format),
    ):
        amounts = {name: float(getattr(each, kind)) for name, each in reserved.items()}
        total = round(sum(amounts.values()), 6)
        if total > have:
            who = _largest(amounts, text)
            return f"{LIMIT}{kind}: {text(total)} in all ({who}), but this host has {text(have)}"
    return ""


def _largest(amounts: Mapping[str, float], text: Callable[[float], str], most: int = 4) -> str:
    """Return who may use most, the others by their number."""
    ranked = sorted(filter(amounts.get, amounts), key=lambda name: -amounts[name])
    parts = [f"{name} {text(amounts[name])}" for name in ranked]
    return ", ".join([*parts[:most], *([f"{len(parts) - most} more"] if len(parts) > most else [])])


def wanted_limits(system: WantedSystem) -> dict[str, SlaveLimits]:
    """Return the limits that a system states for its components, by instance; empty ones too."""
    policies = {c.instance: c.policy for c in system.components if c.policy is not None}
    return {instance: read_limits(policy) for instance, policy in policies.items()}


def reserved(
    system: WantedSystem,
    living: Iterable[ComponentFacts],
    elsewhere: Mapping[str, Iterable[ComponentFacts]],
) -> dict[str, SlaveLimits]:
    """Return what each component of a host may use when the system is up, by its name.

    Args:
        system: The wanted system.
        living: Facts of the managers of the system.
        elsewhere: Facts of other managers of the host, by their names.
    """
    found = {each.instance: limits_in(each.create) for each in living if not each.zombie}
    found.update(wanted_limits(system))
    for manager, components in elsewhere.items():
        more = {each.instance: limits_in(each.create) for each in components if not each.zombie}
        found.update({f"{instance} in {manager}": had for instance, had in more.items()})
    return found
