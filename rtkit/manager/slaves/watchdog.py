"""Watches the heartbeats of slaves: names callbacks that are stuck, and their line of code.

The line comes from the slave's own stacks (see `rtkit.container.stacks`).

See decision 18.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from functools import lru_cache
from math import inf

from rtkit.container.heartbeats import Activity, HeartbeatReader, guest_pattern, heartbeats_path
from rtkit.container.stacks import forget_stacks, is_in_debugger, place_of, read_stacks
from rtkit.deployment.health import IN_DEBUGGER, STUCK, read_rules
from rtkit.fast_dataclass import dataclass
from rtkit.manager.core.events import CallbackStuck, ProcessInspected
from rtkit.rtc.create import parse_create

POLL_S = 0.025
"""How often heartbeats are read where something is stuck or asked about, and at most [s]."""

_POLL_NS = int(POLL_S * 1e9)

_STACK_POLLS = 20
"""How many polls a process has to write its stacks."""

_ASKED_POLLS = 4
"""How many of them it has to answer who asks; then it is sent a signal."""

WatchdogEvent = CallbackStuck | ProcessInspected


DEADLINE_KEY = "exec_cxt.callback_deadline"
DEADLINE_S = 1.0
"""How long a callback may take before it is called stuck, unless the create string says [s]."""


def callback_deadline_s(create: str) -> float:
    """Return the deadline of callbacks that a create string sets [s].

    ``rtkit.health.stuck`` takes precedence over ``exec_cxt.callback_deadline``.
    """
    return _deadline_s(create) if DEADLINE_KEY in create or STUCK in create else DEADLINE_S


@lru_cache(maxsize=256)
def _deadline_s(create: str) -> float:
    options = parse_create(create).options
    try:
        rules = read_rules(options)
        deadline = next((rule.most for rule in rules if rule.kind == "stuck"), inf)
        if deadline == inf:
            deadline = float(options.get(DEADLINE_KEY, ""))
    except ValueError:
        return DEADLINE_S
    return deadline if 0 < deadline < inf else DEADLINE_S


def remove_traces(pattern: str, pid: int) -> None:
    """Remove what a process wrote to be watched by."""
    for each in (pattern, guest_pattern(pattern)):
        with contextlib.suppress(FileNotFoundError):
            os.unlink(heartbeats_path(each, pid))


@dataclass(slots=True)
class _Watched:
    """A process and what is known to be stuck in it, by instance.

    Attributes:
        pattern: Of the data sockets of its kind.
        stack_polls: How many polls it still has to write the stacks that it was asked for.
        age_s: Age from which a call is reported before its deadline, as somebody asks [s].
        due_ns: Before then nothing in it can be late [ns].
        is_halted: It is stopped: nothing in it can be late.
        went_on_ns: When it last went on; time that it was stopped counts for no callback [ns].
    """

    pid: int
    pattern: str
    reader: HeartbeatReader
    stuck: dict[str, Activity]
    is_guest: bool = False
    stack_polls: int = 0
    age_s: float | None = None
    due_ns: int = 0
    is_halted: bool = False
    went_on_ns: int = 0

    def begin_ns(self, beat: Activity) -> int:
        """Return from when on a callback counts [ns]."""
        return max(beat.since_ns, self.went_on_ns)


class Watchdog:
    """Reads heartbeats of processes and reports what is stuck, and what no longer is.

    It looks at a process when something in it could be late: a callback that it has seen, or one
    that has been entered since. So idle processes cost a look a second, not forty.

    Args:
        pattern: Of the processes' data sockets; heartbeats lie beside them.
        deadline_s: Returns how long a callback of an instance may take [s].
        shortest_s: Returns the least of all those [s].
        ask_for_stack: Asks a process to write its stacks; then, if it does not, with `is_urgent`,
            makes it.
    """

    def __init__(
        self,
        pattern: str,
        deadline_s: Callable[[str], float],
        shortest_s: Callable[[], float],
        ask_for_stack: Callable[[int, bool], object],
    ) -> None:
        self._pattern = pattern
        self._deadline_s = deadline_s
        self._shortest_s = shortest_s
        self._ask_for_stack = ask_for_stack
        self._watched: dict[int, _Watched] = {}
        self._look_at_ns = 0

    def watch(self, key: int, pid: int, *, is_guest: bool = False) -> None:
        """Begin to watch a process; one without heartbeats is let be, as tools have none."""
        pattern = guest_pattern(self._pattern) if is_guest else self._pattern
        with contextlib.suppress(OSError):
            reader = HeartbeatReader(heartbeats_path(pattern, pid))
            self._watched[key] = _Watched(pid, pattern, reader, {}, is_guest)
            self._look_at_ns = 0

    def forget(self, key: int) -> None:
        """Watch a process that ended no longer."""
        watched = self._watched.pop(key, None)
        if watched is not None:
            watched.reader.close()

    def instance_on(self, key: int, thread: int) -> str:
        """Return whose code ran last on a thread of a process; empty when that is not known."""
        watched = self._watched.get(key)
        inside = watched.reader.inside() if watched is not None else ()
        return next((beat.instance for beat in inside if beat.thread == thread), "")

    def halted(self, key: int, *, is_halted: bool) -> None:
        """Note that a process was stopped, or goes on."""
        watched = self._watched.get(key)
        if watched is not None:
            watched.is_halted = is_halted
            watched.went_on_ns = time.monotonic_ns()

    @property
    def look_at(self) -> float:
        """Return when the next `poll` has something to do, or would have if nothing ended [s]."""
        return self._look_at_ns / 1e9

    def hasten(self, key: int) -> None:
        """Look at a process soon, because its components change."""
        watched = self._watched.get(key)
        if watched is not None:
            watched.due_ns = min(watched.due_ns, time.monotonic_ns() + _POLL_NS)
            self._look_at_ns = min(self._look_at_ns, watched.due_ns)

    def inspect(self, key: int, age_s: float) -> Iterator[WatchdogEvent]:
        """Yield what has been under way in a process for longer than that [s].

        `ProcessInspected` comes when all is reported, perhaps only with the next `poll`.
        """
        watched = self._watched.get(key)
        if watched is None:
            yield ProcessInspected(key)
            return
        watched.age_s = age_s if watched.age_s is None else min(age_s, watched.age_s)
        yield from self._poll(key, watched, time.monotonic_ns(), self._shortest_s())
        self._look_at_ns = self._earliest_ns()

    def poll(self) -> Iterator[WatchdogEvent]:
        """Yield what got stuck since the last poll, then its line, and what goes on again."""
        now_ns, shortest_s = time.monotonic_ns(), self._shortest_s()
        soon_ns = now_ns + int(shortest_s * 0.5e9)  # one look at all costs less than many
        for key, watched in self._watched.items():
            if watched.due_ns <= soon_ns:
                yield from self._poll(key, watched, now_ns, shortest_s)
        self._look_at_ns = self._earliest_ns()

    def _earliest_ns(self) -> int:
        return min((each.due_ns for each in self._watched.values()), default=0)

    def _poll(
        self, key: int, watched: _Watched, now_ns: int, shortest_s: float
    ) -> Iterator[WatchdogEvent]:
        if watched.stack_polls:
            yield from self._lines(key, watched, now_ns)
        inside = watched.reader.inside()
        late = {
            beat.instance: beat
            for beat in inside
            if self._is_late(beat, watched, now_ns - watched.begin_ns(beat))
        }
        for instance in [each for each in watched.stuck if each not in late]:
            del watched.stuck[instance]
            yield CallbackStuck(key, instance, "")
        fresh = [beat for name, beat in late.items() if watched.stuck.get(name) != beat]
        for beat in fresh:
            watched.stuck[beat.instance] = beat
            if not watched.is_guest:  # of these a debugger may be why: the stack tells first
                yield CallbackStuck(key, beat.instance, _text(beat, now_ns, ""))
        if fresh:
            with contextlib.suppress(OSError):
                forget_stacks(watched.pattern, watched.pid)
                self._ask_for_stack(key, False)
                watched.stack_polls = _STACK_POLLS
        if watched.age_s is not None and not watched.stack_polls:
            watched.age_s = None
            yield ProcessInspected(key)
        watched.due_ns = self._due_ns(watched, inside, now_ns, shortest_s)

    def _due_ns(
        self, watched: _Watched, inside: list[Activity], now_ns: int, shortest_s: float
    ) -> int:
        """Return when something may be late that is not now, but not before the next poll."""
        if watched.stuck or watched.stack_polls or watched.age_s is not None:
            return now_ns + _POLL_NS
        moments = [
            watched.begin_ns(beat) + int(self._deadline_s(beat.instance) * 1e9) for beat in inside
        ]
        due_ns = min([*moments, now_ns + int(shortest_s * 1e9)])
        return max(due_ns + 1, now_ns + _POLL_NS)

    def _is_late(self, beat: Activity, watched: _Watched, age_ns: int) -> bool:
        """Return whether to report it: what was reported is late until it is over."""
        if watched.stuck.get(beat.instance) == beat:
            return True
        if watched.is_halted:
            return False
        bound_s = self._deadline_s(beat.instance)
        if watched.age_s is not None:
            bound_s = min(bound_s, watched.age_s)
        return age_ns > bound_s * 1e9

    def _lines(self, key: int, watched: _Watched, now_ns: int) -> Iterator[WatchdogEvent]:
        """Yield the lines of what is stuck, when the stack is written that names them."""
        stacks = read_stacks(watched.pattern, watched.pid)
        places = {each: place_of(stacks, beat.thread) for each, beat in watched.stuck.items()}
        watched.stack_polls = 0 if all(places.values()) else watched.stack_polls - 1
        if watched.stack_polls == _STACK_POLLS - _ASKED_POLLS and not stacks:
            self._ask_for_stack(key, True)
        if not watched.stack_polls:
            for instance, beat in watched.stuck.items():
                is_debugged = is_in_debugger(stacks, beat.thread)
                text = _text(beat, now_ns, places[instance], is_debugged=is_debugged)
                yield CallbackStuck(key, instance, text, True)


def _text(beat: Activity, now_ns: int, place: str, *, is_debugged: bool = False) -> str:
    began = time.localtime(time.time() - (now_ns - beat.since_ns) / 1e9)
    since = time.strftime("%H:%M:%S", began)
    what = IN_DEBUGGER if is_debugged else f"stuck in {beat.callback}"
    return f"{what} since {since}" + (f" ({place})" if place else "")
