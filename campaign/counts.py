"""What cells count, in memory that they share with the campaign: also while nobody answers."""

from __future__ import annotations

import mmap
import struct
from typing import NamedTuple

CELLS = 20
_HEAD = ("lives", "executions", "longest_ns")
_PER_SENDER = ("received", "missing", "repeated")
_SIZE = struct.calcsize("q")
_CELL = len(_HEAD) + CELLS * len(_PER_SENDER)


class Stream(NamedTuple):
    """What came of one sender.

    Attributes:
        missing: Numbers that were left out.
        repeated: Numbers that came out of turn: again, or late.
    """

    received: int
    missing: int
    repeated: int


class Counts:
    """The counts of all cells; each is written by its own cell only."""

    def __init__(self, path: str, *, is_new: bool = False) -> None:
        mode = "w+b" if is_new else "r+b"
        with open(path, mode) as file:
            if is_new:
                file.truncate(CELLS * _CELL * _SIZE)
            self._memory = mmap.mmap(file.fileno(), 0)
        self._numbers = memoryview(self._memory).cast("q")

    def cell(self, index: int) -> Record:
        """Return the counts of one cell."""
        return Record(self._numbers[index * _CELL : (index + 1) * _CELL])

    def close(self) -> None:
        """Let go of the memory."""
        self._numbers.release()
        self._memory.close()


class Record:
    """The counts of one cell."""

    def __init__(self, numbers: memoryview[int]) -> None:
        self._numbers = numbers

    @property
    def lives(self) -> int:
        """How often it was made."""
        return self._numbers[0]

    @property
    def executions(self) -> int:
        """How many cycles it has done in all lives."""
        return self._numbers[1]

    @property
    def longest_s(self) -> float:
        """The longest time from one cycle to the next one, within a life, since `forget` [s]."""
        return self._numbers[2] / 1e9

    def forget(self) -> None:
        """Measure `longest_s` anew."""
        self._numbers[2] = 0

    def stream(self, sender: int) -> Stream:
        """Return what came of one sender, in all lives."""
        at = len(_HEAD) + sender * len(_PER_SENDER)
        return Stream(*self._numbers[at : at + len(_PER_SENDER)])

    def begin(self) -> None:
        """Count a life."""
        self._numbers[0] += 1

    def execute(self, since_ns: int) -> None:
        """Count a cycle that came so long after the one before [ns]."""
        self._numbers[1] += 1
        if since_ns > self._numbers[2]:
            self._numbers[2] = since_ns

    def receive(self, sender: int, missing: int) -> None:
        """Count a number that came, and how many were left out before; below 0: it came again."""
        at = len(_HEAD) + sender * len(_PER_SENDER)
        self._numbers[at] += 1
        if missing > 0:
            self._numbers[at + 1] += missing
        elif missing < 0:
            self._numbers[at + 2] += 1

    def close(self) -> None:
        """Let go of the memory."""
        self._numbers.release()
