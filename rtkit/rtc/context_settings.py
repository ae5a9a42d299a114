"""Settings of the thread that drives an execution context, and of its process: keys and readers.

They are properties of a context: ``exec_cxt.KEY`` for all of a component or manager,
``ec.TYPE.KEY`` and ``ec.NAME.KEY`` for some. `rtkit.settings.values.processors` reads processors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import NamedTuple, TypeVar

from rtkit.errors import Malformed

EVERY = "exec_cxt."
SOME = "ec."
CPU_AFFINITY = "cpu_affinity"
"""The processors that the thread may use, ``0,2-3``."""

SCHED_POLICY = "sched_policy"
PRIORITY = "priority"
MEMORY_LOCK = "memory_lock"
GARBAGE_COLLECTOR = "garbage_collector"
_HIGHEST = 99
_TRUE = ("YES", "TRUE", "ON", "1")
_FALSE = ("NO", "FALSE", "OFF", "0")
_Word = TypeVar("_Word", bound=StrEnum)


class SchedulingPolicy(StrEnum):
    """Scheduling policy of a thread: that of all, or before all others in order of priority."""

    OTHER = "other"
    FIFO = "fifo"
    RR = "rr"


class CollectorMode(StrEnum):
    """Times at which the garbage collector of a process works; the later one counts more.

    Attributes:
        ON: As Python decides.
        FROZEN: Likewise, but what is there at the first cycle is not looked through again.
        BETWEEN: In the time that is left between two periods.
        OFF: Never.
    """

    ON = "on"
    FROZEN = "frozen"
    BETWEEN = "between"
    OFF = "off"


class ThreadSettings(NamedTuple):
    """Settings besides processors.

    Attributes:
        priority: 1 to 99; 0 for policy ``other``.
    """

    policy: SchedulingPolicy = SchedulingPolicy.OTHER
    priority: int = 0
    locks_memory: bool = False
    collector: CollectorMode = CollectorMode.ON


def policy(text: str) -> SchedulingPolicy:
    """Read a scheduling policy.

    Raises:
        Malformed: There is no such policy.
    """
    return _one_of(SchedulingPolicy, text, "scheduling policy")


def collector(text: str) -> CollectorMode:
    """Read when the garbage collector works.

    Raises:
        Malformed: There is no such word.
    """
    return _one_of(CollectorMode, text, "mode of the garbage collector")


def priority(text: str) -> int:
    """Read a priority of real-time scheduling.

    Raises:
        Malformed: It is none.
    """
    bare = text.strip()
    if not (bare.isascii() and bare.isdigit() and 1 <= int(bare) <= _HIGHEST):
        raise Malformed(f"not a priority from 1 to {_HIGHEST}: {text}")
    return int(bare)


def flag(text: str) -> bool:
    """Read YES or NO.

    Raises:
        Malformed: It is neither.
    """
    word = text.strip().upper()
    if word not in (*_TRUE, *_FALSE):
        raise Malformed(f"neither YES nor NO: {text}")
    return word in _TRUE


READERS: Mapping[str, Callable[[str], object]] = {
    SCHED_POLICY: policy,
    PRIORITY: priority,
    MEMORY_LOCK: flag,
    GARBAGE_COLLECTOR: collector,
}
SETTINGS = (CPU_AFFINITY, *READERS)


def is_setting(key: str) -> bool:
    """Return whether an option is a setting of contexts, ``exec_cxt.KEY`` or ``ec.NAME.KEY``."""
    setting = key.rpartition(".")[2]
    return setting in SETTINGS and (key == EVERY + setting or key.startswith(SOME))


def check_settings(options: Mapping[str, str]) -> None:
    """Refuse settings of contexts that cannot be read, but for processors.

    Raises:
        Malformed: Names one of them.
    """
    for key, text in options.items():
        read = READERS.get(key.rpartition(".")[2])
        if read is not None and is_setting(key) and text.strip():
            try:
                read(text)
            except Malformed as error:
                raise Malformed(f"{key}: {error}") from None


def read_thread_settings(properties: Mapping[str, str]) -> ThreadSettings:
    """Read the settings of a context; a priority alone means ``fifo``, a policy alone priority 1.

    Raises:
        Malformed: One makes no sense.
    """
    given = {key: properties[key] for key in READERS if properties.get(key, "").strip()}
    default = SchedulingPolicy.FIFO if PRIORITY in given else SchedulingPolicy.OTHER
    chosen = policy(given.get(SCHED_POLICY, default))
    return ThreadSettings(
        chosen,
        0 if chosen is SchedulingPolicy.OTHER else priority(given.get(PRIORITY, "1")),
        flag(given.get(MEMORY_LOCK, "NO")),
        collector(given.get(GARBAGE_COLLECTOR, CollectorMode.ON)),
    )


def _one_of(kind: type[_Word], text: str, what: str) -> _Word:
    try:
        return kind(text.strip().lower())
    except ValueError:
        raise Malformed(f"no {what}: {text} (one of {', '.join(kind)})") from None
