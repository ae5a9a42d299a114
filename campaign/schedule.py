"""Which faults happen, in which order, to whom: all drawn from one seed, before anything runs.

Kinds are dealt like cards, so that few faults show many kinds. Nobody is hit so often in a row that
the law of restarts would give it up: that law is tried by tests of its own.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from campaign.layout import MANAGER, NAMES, SLAVES, members

WAYS_TO_RAISE = ("SystemExit", "KeyboardInterrupt", "no text", "recursion", "memory", "coroutine")
"""Besides the plain one."""

DECK: Mapping[str, int] = {
    "kill a slave": 3,
    "kill two slaves": 1,
    "kill the zygote": 1,
    "kill the manager": 2,
    "kill manager and slave": 1,
    "kill everything": 1,
    "stop a slave": 2,
    "stop the zygote": 1,
    "stop the manager": 1,
    "hang: sleep": 1,
    "hang: loop": 1,
    "hang: lock": 1,
    "slow start": 1,
    "slow activation": 1,
    "raise": 1,
    **{f"raise: {how}": 1 for how in WAYS_TO_RAISE},
    "exit": 1,
    "exit: abort": 1,
    "exit: segfault": 1,
    "exit: in a thread": 1,
    "side: prints": 1,
    "side: threads": 1,
    "side: process": 1,
    **{f"service: {how}": 1 for how in (*WAYS_TO_RAISE, "raise", "slow")},
    **{f"property: {how}": 1 for how in (*WAYS_TO_RAISE, "raise", "hang", "prints", "threads")},
    "kill everything, then in the start": 1,
    "kill manager and slave, then in the start": 1,
    "kill in a commit, then everything": 2,
    "disk full, kill the manager, then everything": 1,
    "disk full and free again, kill everything": 1,
}
"""How many cards of each kind; each kind's first card is dealt before any second one."""

HARMLESS = ("stop", "side", "service", "property")
"""How kinds begin that end no component."""

SPACING = 20
"""How many of the last faults are looked at."""
CHOICE = 4
"""Among how many of those that were hit least it is chosen by chance."""
_STOP_S = (0.2, 1.5)
_START_S = (0.5, 2.0)
_ACTIVATION_S = (0.3, 0.7)
"""Longer ones count as stuck, and rightly so [s]."""
_IN_START_S = (0.0, 0.8)
_IN_COMMIT_S = (0.0, 0.006)
_FULL_S = (0.01, 1.5)


class Fault(NamedTuple):
    """One thing that goes wrong.

    Attributes:
        slaves: Which slaves are meant.
        cell: Which cell is, -1 for none.
        length_s: For how long it lasts [s].
    """

    kind: str
    slaves: tuple[str, ...] = ()
    cell: int = -1
    length_s: float = 0.0

    def __str__(self) -> str:
        whom = [*self.slaves, *([NAMES[self.cell]] if self.cell >= 0 else [])]
        length = [f"for {self.length_s:.2f} s"] if self.length_s else []
        return " ".join(filter(None, [self.kind, ", ".join(whom), *length]))

    @property
    def is_total(self) -> bool:
        """Whether it ends everything."""
        return "everything" in self.kind

    @property
    def is_pair(self) -> bool:
        """Whether it is two faults on top of each other: some cells may be made twice."""
        return ", " in self.kind

    @property
    def renewed(self) -> frozenset[int]:
        """The cells that are made anew afterwards."""
        if self.is_total:
            return frozenset(range(len(NAMES)))
        if self.kind.startswith(HARMLESS) or self.kind == "kill the zygote":
            return frozenset()
        if self.kind.startswith("raise"):
            return frozenset({self.cell})
        cells = {cell for slave in self.slaves for cell in members(slave)}
        if self.kind.startswith(("kill the manager", "kill manager and slave")):
            cells |= set(members(MANAGER))
        return frozenset(cells)

    @property
    def held_up(self) -> frozenset[int]:
        """The cells that it holds up without an end of them."""
        if self.kind == "stop a slave":
            return frozenset(members(self.slaves[0]))
        return frozenset(members(MANAGER)) if self.kind == "stop the manager" else frozenset()


def schedule(seed: int, count: int) -> list[Fault]:
    """Return so many faults."""
    chance = random.Random(seed)
    kinds = _kinds(chance)
    faults: list[Fault] = []
    for _ in range(count):
        recent = faults[-SPACING:]
        faults.append(_drawn(chance, next(kinds), recent))
    return faults


def _kinds(chance: random.Random) -> Iterator[str]:
    while True:
        first = list(DECK)
        second = [kind for kind, cards in DECK.items() for _ in range(cards - 1)]
        for cards in (first, second):
            chance.shuffle(cards)
            yield from cards


def _drawn(chance: random.Random, kind: str, recent: list[Fault]) -> Fault:
    """Return a fault of that kind; its victims are some of those that were hit least of late."""
    hits = Counter(cell for fault in recent for cell in fault.renewed)

    def spared(cells: tuple[int, ...]) -> tuple[int, float]:
        return max(hits[cell] for cell in cells), chance.random()

    slaves = sorted(SLAVES, key=lambda slave: spared(members(slave)))[:CHOICE]
    slave, other = chance.sample(slaves, 2)
    cell = chance.choice(members(slave))
    match kind.partition(":")[0]:
        case "kill two slaves":
            return Fault(kind, (slave, other))
        case "kill a slave" | "kill manager and slave":
            return Fault(kind, (slave,))
        case "kill manager and slave, then in the start":
            return Fault(kind, (slave,), length_s=chance.uniform(*_IN_START_S))
        case "kill everything, then in the start":
            return Fault(kind, length_s=chance.uniform(*_IN_START_S))
        case "kill in a commit, then everything":
            return Fault(
                kind, cell=chance.randrange(len(NAMES)), length_s=chance.uniform(*_IN_COMMIT_S)
            )
        case "disk full, kill the manager, then everything":
            return Fault(kind, cell=cell, length_s=chance.uniform(*_FULL_S))
        case "disk full and free again, kill everything":
            return Fault(kind, cell=chance.randrange(len(NAMES)))
        case "stop a slave":
            return Fault(kind, (chance.choice(SLAVES),), length_s=chance.uniform(*_STOP_S))
        case "stop the zygote" | "stop the manager":
            return Fault(kind, length_s=chance.uniform(*_STOP_S))
        case "slow start":
            return Fault(kind, (slave,), cell, chance.uniform(*_START_S))
        case "slow activation":
            return Fault(kind, (slave,), cell, chance.uniform(*_ACTIVATION_S))
        case "hang" | "exit" | "side" | "service":
            return Fault(kind, (slave,), cell)
        case "raise":
            cells = sorted(range(len(NAMES)), key=lambda each: spared((each,)))[:CHOICE]
            return Fault(kind, cell=chance.choice(cells))
    return Fault(kind)
