"""Effects: the requests that a procedure yields to act or to wait.

A procedure is a generator that does one action. `rtkit.manager.core.tasks` resumes it with what it
waited for, or raises inside it the error that ended the wait.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

from rtkit.deployment.actions import Result
from rtkit.deployment.message import Message
from rtkit.fast_dataclass import Record
from rtkit.manager.core.state import Process


class Effect(Record):
    """Request of a procedure."""


class Wait(Effect):
    """Request after which the procedure waits."""


class AcquireSlave(Wait):
    """Wait for the slave of that name, started if it does not live; receives a `Process`.

    One for the trial of a module is always started, and has no name that anybody could ask for.
    """

    name: str
    trial_of: str = ""


class Call(Wait):
    """Send a message to a container and wait for the value that it answers.

    Attributes:
        timeout_s: Bound on the wait; 0 means that of the batch [s].
        is_lasting: The container does it whenever it can, also when nobody waits for it any more:
            what is to go has to go. Anything else that was not begun in time is not done.
    """

    process: Process
    message: Message
    timeout_s: float = 0.0
    is_lasting: bool = False


class CallPeer(Wait):
    """Ask another manager and wait for its answer; receives that, as plain data.

    A time-out of 0 means that of the batch [s].
    """

    peer: str
    message: Message
    timeout_s: float = 0.0


class WaitForEnds(Wait):
    """Wait until each of these slaves has ended, at most `timeout_s` [s]."""

    slaves: tuple[Process, ...]
    timeout_s: float


class Sleep(Wait):
    """Wait for `time_s` [s]."""

    time_s: float


class WaitUntil(Wait):
    """Wait for a condition that other procedures bring about; `why` describes what is missing."""

    is_so: Callable[[], bool]
    why: str


class Send(Effect):
    """Send a message to a container that needs no answer; goes on at once."""

    process: Process
    message: Message


class SendSignal(Effect):
    """Send a signal to a slave; goes on at once."""

    process: Process
    number: int


class Spawn(Effect):
    """Begin a procedure whose outcome nobody waits for: cleaning up must not delay an answer."""

    procedure: Procedure


class ReadClock(Effect):
    """Ask for the time; receives monotonic seconds."""


class Gather(Wait):
    """Do these procedures side by side and wait until each has ended; receives their results."""

    procedures: tuple[Procedure, ...]


Procedure = Generator[Effect, Any, Result]
