"""One fault: it happens, the system comes back, and what it cost is looked at."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

from bench.processes import living
from campaign.arena import Arena, end, kill
from campaign.counts import Stream
from campaign.law import Law
from campaign.layout import DEADLINE_S, NAMES, WIRES, wire_id
from campaign.pairs import PromiseBroken, fill_disk, kill_in_commit, kill_twice
from campaign.schedule import DECK, Fault

STEP_S = 10.0
"""How long a manager gives each step of a restart [s]."""
_HANG_S = DEADLINE_S + 1.0 + 1.0 + 2.0
"""Until what hangs is late, found out, asked to end, told to end, and ended [s]."""


class Outcome(NamedTuple):
    """What came of one fault.

    Attributes:
        recovery_s: From the fault, or from the end of one that lasts, until all is as desired [s].
        pause_s: The longest that a cell which it did not concern was without a cycle [s].
        failures: What should not have been; empty when all went as promised.
        is_back: Whether the system is as desired, by a plan.
    """

    fault: Fault
    recovery_s: float
    pause_s: float
    failures: tuple[str, ...]
    is_back: bool = True


class _Before(NamedTuple):
    lives: list[int]
    executions: list[int]
    streams: dict[tuple[int, int], Stream]
    processes: Mapping[str, int]


def allowed_s(fault: Fault, wait_s: float) -> float:
    """Return within what time a system is back after a fault, by its policy [s].

    Args:
        fault: What went wrong.
        wait_s: How long the law of restarts waits [s].
    """
    return STEP_S + wait_s + fault.length_s + _HANG_S * fault.kind.startswith("hang")


def tried(arena: Arena, law: Law, fault: Fault, patience: float = 1.0) -> Outcome:
    """Have a fault happen and return what came of it.

    Args:
        arena: Where.
        law: What the law of restarts knows so far.
        fault: What is to go wrong.
        patience: How many times as long as is promised it may take on a machine that is busy.
    """
    time.sleep(max(0.0, law.room_at_s(fault) - time.monotonic()))
    before = _before(arena)
    for cell in arena.cells:
        cell.forget()
    failures = _ghosts(arena)
    began = time.monotonic()
    bound_s = patience * allowed_s(fault, law.longest_wait_s(fault, began))
    try:
        try:
            began = _HAPPENS[fault.kind](arena, fault)
        except PromiseBroken as error:
            failures.append(str(error))
        ended = arena.until(lambda: not _awaited(arena, fault, before), bound_s)
    except TimeoutError:
        ended = time.monotonic()
        failures.append(f"not back within {bound_s:.1f} s: {_awaited(arena, fault, before)}")
    else:
        law.well(ended)
    pauses_s = [arena.cells[cell].longest_s for cell in _others(fault)]
    failures += _harm(arena, fault, before)
    left = arena.differs()
    if left:
        failures.append(left)
    return Outcome(
        fault, ended - began, max(pauses_s, default=0.0), tuple(failures), is_back=not left
    )


def _before(arena: Arena) -> _Before:
    return _Before(
        [cell.lives for cell in arena.cells],
        [cell.executions for cell in arena.cells],
        {(s, r): arena.cells[r].stream(s) for s, r in WIRES},
        arena.slaves(),
    )


def _ghosts(arena: Arena) -> list[str]:
    """Return what is told of and not there, though all is as desired."""
    known = {"the manager": arena.manager, "the zygote": arena.zygote(), **arena.slaves()}
    return [
        f"process {pid} of {name} is told of, and not there"
        for name, pid in known.items()
        if pid and not living([pid])
    ]


def _others(fault: Fault) -> list[int]:
    """Return the cells that a fault does not concern."""
    concerned = fault.renewed | fault.held_up
    return [cell for cell in range(len(NAMES)) if cell not in concerned]


def _untouched(fault: Fault) -> list[tuple[int, int]]:
    """Return the connections of which both ends live on: also who is held up loses nothing."""
    return [wire for wire in WIRES if fault.renewed.isdisjoint(wire)]


def _awaited(arena: Arena, fault: Fault, before: _Before) -> str:
    """Return the first thing that is not yet as it is to be; empty when the system is back."""
    for number, cell in enumerate(arena.cells):
        is_renewed = number in fault.renewed
        if is_renewed and cell.lives == before.lives[number]:
            return f"{NAMES[number]} is not made again"
    if fault.kind.startswith(("side", "service")) and arena.is_ordered(fault.cell):
        return f"{NAMES[fault.cell]} has not done as told"
    lack = arena.lacks()
    if lack:
        return lack
    if fault.kind.endswith("the zygote") and (arena.trouble() or not arena.zygote()):
        return arena.trouble() or "there is no zygote"
    for wire in WIRES:
        if arena.cells[wire[1]].stream(wire[0]).received == before.streams[wire].received:
            return f"nothing came over {wire_id(*wire)}"
    # A cell that sends counts its cycle after that: the last cycle may still be on its way.
    for number in _others(fault):
        if arena.cells[number].executions <= before.executions[number]:
            return f"{NAMES[number]} does not go on"
    return ""


def _harm(arena: Arena, fault: Fault, before: _Before) -> list[str]:
    """Return what happened and should not have."""
    found = []
    slaves = arena.slaves()
    for number, cell in enumerate(arena.cells):
        more = cell.lives - before.lives[number]
        wanted = int(number in fault.renewed)
        if not wanted <= more <= wanted + int(fault.is_pair) * wanted:
            found.append(f"{NAMES[number]} was made {more} times instead of {wanted}")
    ended = set(fault.slaves) if fault.renewed and not fault.kind.startswith("raise") else set()
    for name, pid in before.processes.items():
        if not fault.is_total and name not in ended and slaves.get(name) != pid:
            found.append(f"slave {name} was process {pid} and is {slaves.get(name)}")
    for wire in _untouched(fault):
        was, its = before.streams[wire], arena.cells[wire[1]].stream(wire[0])
        if its.missing != was.missing or its.repeated != was.repeated:
            lost, again = its.missing - was.missing, its.repeated - was.repeated
            found.append(f"{wire_id(*wire)}: {lost} lost, {again} repeated")
    return found


# what happens


def _kill_slaves(arena: Arena, fault: Fault) -> float:
    pids = [arena.slave(name) for name in fault.slaves]
    began = time.monotonic()
    kill(pids)
    return began


def _kill_zygote(arena: Arena, _fault: Fault) -> float:
    zygote = arena.zygote()
    began = time.monotonic()
    end([zygote])
    return began


def _kill_managing(arena: Arena, fault: Fault) -> float:
    pids = [arena.manager, *(arena.slave(name) for name in fault.slaves)]
    if fault.is_total:
        pids += [arena.zygote(), *arena.slaves().values()]
    began = time.monotonic()
    end(pids)
    arena.start_manager()
    return began


def _stop(arena: Arena, fault: Fault) -> float:
    if fault.slaves:
        pid = arena.slave(fault.slaves[0])
    else:
        pid = arena.manager if fault.kind == "stop the manager" else arena.zygote()
    kill([pid], signal.SIGSTOP)
    try:
        if fault.kind != "stop the manager":  # which cannot tell
            arena.until(lambda: bool(arena.lacks() or arena.trouble()), STEP_S)
        time.sleep(fault.length_s)
    finally:
        began = time.monotonic()
        kill([pid], signal.SIGCONT)
    return began


def _hang(arena: Arena, fault: Fault) -> float:
    how = fault.kind.partition(": ")[2]
    began = time.monotonic()
    arena.order(fault.cell, "work", f"{how} 1000" if how == "sleep" else how)
    return began


def _order(arena: Arena, fault: Fault) -> float:
    began = time.monotonic()
    arena.order(fault.cell, "work", fault.kind)
    return began


def _misuse(arena: Arena, fault: Fault) -> float:
    """Have the code of a served object go wrong in a getter, a setter and an action."""
    began = time.monotonic()
    complaint = arena.misuse(fault.kind.partition(": ")[2])
    if complaint:
        raise PromiseBroken(complaint)
    return began


def _slow(arena: Arena, fault: Fault) -> float:
    when = "birth" if fault.kind == "slow start" else "activation"
    arena.order(fault.cell, when, f"sleep {fault.length_s}")
    return _kill_slaves(arena, fault)


_HAPPENS: Mapping[str, Callable[[Arena, Fault], float]] = {
    "kill a slave": _kill_slaves,
    "kill two slaves": _kill_slaves,
    "kill the zygote": _kill_zygote,
    "kill the manager": _kill_managing,
    "kill manager and slave": _kill_managing,
    "kill everything": _kill_managing,
    "stop a slave": _stop,
    "stop the zygote": _stop,
    "stop the manager": _stop,
    "hang: sleep": _hang,
    "hang: loop": _hang,
    "hang: lock": _hang,
    "slow start": _slow,
    "slow activation": _slow,
    **{kind: _order for kind in DECK if kind.startswith(("raise", "exit", "side", "service"))},
    **{kind: _misuse for kind in DECK if kind.startswith("property")},
    "kill everything, then in the start": kill_twice,
    "kill manager and slave, then in the start": kill_twice,
    "kill in a commit, then everything": kill_in_commit,
    "disk full, kill the manager, then everything": fill_disk,
    "disk full and free again, kill everything": fill_disk,
}
