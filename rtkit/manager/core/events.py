"""Events of a manager, and the instructions of its core to the shell.

Both are plain data: a process is named by a key and a request by a number, neither used twice.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rtkit.deployment.batch import Batch
from rtkit.deployment.facts import Followed
from rtkit.deployment.limits import SlaveLimits
from rtkit.deployment.message import Message
from rtkit.fast_dataclass import Record
from rtkit.property.exchange import Reply

Row = tuple[str, str, str | None]
"""A row of desired state: kind, name and value; without a value it is to be removed."""

OWN_PROCESS = 0
"""Key of the manager's own process."""


class Event(Record):
    """Something that has happened to a manager."""


class Instruction(Record):
    """Something that the loop is to do."""


class BatchRequested(Event):
    """A client wants actions performed.

    Attributes:
        until: When the client gives up, monotonic [s]: what was not begun then is not done.
    """

    batch: Batch
    request: int
    until: float = math.inf


class SnapshotRequested(Event):
    """A client that subscribes to deltas requests the snapshot they begin with."""

    request: int


class ListenersChanged(Event):
    """A topic has its first subscriber now, or lost its last."""

    line: str
    is_heard: bool
    who: str = "clients"


class FollowAsked(Event):
    """A client wants a system followed, with all that is needed for it; or, without, no more."""

    system: str
    text: str | None
    request: int


class FollowSaid(Event):
    """A follower reports the outcome of its system, and waits until that is stored."""

    told: Followed
    request: int


class OperationRequested(Event):
    """A client wants an operation done (see `rtkit.manager.core.operations`)."""

    name: str
    argument: str
    request: int


class PeerAsked(Event):
    """Another manager asks about halves of connectors (see `rtkit.manager.core.halves`).

    Attributes:
        peer: One of another host, by what its link lets pass; empty for this host's.
    """

    text: str
    request: int
    until: float = math.inf
    peer: str = ""


class PeerAnswered(Event):
    """Another manager has answered what `AskPeer` asked; or it could not, for a reason.

    Attributes:
        error: The kind of the error of which `text` tells; empty where it is an answer.
    """

    number: int
    text: str
    error: str = ""


class PeerFound(Event):
    """A manager that `WatchPeers` names has been found: it can be asked."""

    peer: str


class PeerLost(Event):
    """A manager that was found has ended."""

    peer: str
    why: str


class StopRequested(Event):
    """A client or a signal wants the manager to end; if it is urgent, without any grace.

    Desired state is kept only where it is not a user who wants that.
    """

    is_urgent: bool = False
    is_kept: bool = False


class StoreRead(Event):
    """The store of an earlier manager was read, before any process has reported.

    Attributes:
        rows: Of the store.
        boot: Identity of this run of the machine: in another one, no process died by itself.
        remark: A finding about the store; mostly empty.
        life: Names the store from now on, if it has no name yet.
    """

    rows: Sequence[Row]
    boot: str = ""
    remark: str = ""
    life: str = ""


class RecoveryRequested(Event):
    """All live processes have reported: what is desired and missing is to be created."""

    request: int


class StartStepDone(Event):
    """A step of the manager's own start is done, and is not to be done again by the next one."""

    step: str


class RowsStored(Event):
    """Rows are on the disk, or could not be written for a reason.

    Attributes:
        is_lost: Nor is anything that was kept before: the store is gone, and there can be another.
    """

    number: int
    why: str = ""
    is_lost: bool = False


class SlaveForked(Event):
    """The zygote made the process of a slave."""

    key: int
    pid: int


class SlaveFailed(Event):
    """The zygote could not make the process of a slave."""

    key: int
    reason: str


class SpawnDisabled(Event):
    """No slave can be made at present, for this reason; or, with none, they can again."""

    why: str


class SlaveReady(Event):
    """A slave has connected: it can hold components."""

    key: int


class SlaveFound(Event):
    """A slave of an earlier manager, or an attached process, reported its components.

    With a `silence`, ``stopped`` or ``does not answer``, this is from its checkpoint. It alone may
    know the requests since components were made (`asked`), and how it is `configured`.
    """

    pid: int
    name: str
    components: object
    wires: object
    is_guest: bool = False
    silence: str = ""
    asked: object = None
    configured: object = None


class SlaveExitedUnseen(Event):
    """A slave ended while no manager ran; its components are known from its checkpoint.

    If nobody has seen how, all that ran with it was ended at once. `time` is when it wrote last
    [s since 1970], 0 where that is not known.
    """

    pid: int
    name: str
    components: object
    reason: str
    is_seen: bool = True
    time: float = 0.0


class SlaveEnded(Event):
    """The kernel reported the end of a slave; `last` is its exit diagnostics, in one line.

    `time` is when that was [s since 1970], 0 where it is not known.
    """

    key: int
    reason: str
    last: str = ""
    time: float = 0.0


class SlaveStopped(Event):
    """The kernel reported that a slave was stopped (``SIGSTOP``) or goes on."""

    key: int
    is_halted: bool


class SlaveOverLimit(Event):
    """A slave has reached a limit that it was given by `LimitSlave`; `why` names the limit."""

    key: int
    why: str


class DevicesSeen(Event):
    """The devices were looked at that components require; these are absent."""

    absent: tuple[str, ...]


class CallbackStuck(Event):
    """A callback of a component exceeds its deadline; or, with no text, it goes on again.

    `instance` may also be one that is being made, or a module that is being imported. Each is
    reported twice: at once, as users are to see it however long its process takes to tell more, and
    again with the line where it stands, so that the reason of a restart names it.

    Attributes:
        is_all: No more is to come: its line is known, or cannot be had. Health is judged then, as
            to end the process is to lose the line; after the first report it waits, not for long.
    """

    key: int
    instance: str
    text: str
    is_all: bool = False


class ProcessInspected(Event):
    """`InspectProcess` is complete; its findings came by `CallbackStuck`."""

    key: int


class ContainerReported(Event):
    """The container of a process answered, or reported a fact."""

    key: int
    message: Message


class TimerExpired(Event):
    """The moment that `WakeAt` asked for has come."""


class SpawnSlave(Instruction):
    """Have the zygote fork a slave, once it has imported some modules."""

    key: int
    name: str
    ahead: tuple[str, ...] = ()


class AdoptSlave(Instruction):
    """Take a process that was found as one of ours, under this key."""

    key: int
    pid: int
    is_guest: bool = False


class SendToContainer(Instruction):
    """Send a message to the container of a process."""

    key: int
    message: Message


class SignalSlave(Instruction):
    """Send a signal to a slave."""

    key: int
    signal: int


class LimitSlave(Instruction):
    """Have a slave and all below it use no more than that; without limits, as much as it likes."""

    key: int
    pid: int
    limits: SlaveLimits


class InspectProcess(Instruction):
    """Report what has been under way in a process for longer than `age_s` [s].

    `ProcessInspected` ends the report.
    """

    key: int
    age_s: float


class StoreRows(Instruction):
    """Write rows into the store, in one go; `RowsStored` reports when they are on the disk."""

    number: int
    rows: Sequence[Row]


class RemoveStore(Instruction):
    """Remove the store at the end: nothing is desired any more."""


class AskPeer(Instruction):
    """Ask another manager; `PeerAnswered` brings the answer, within `timeout_s` [s]."""

    number: int
    peer: str
    text: str
    timeout_s: float


class WatchPeers(Instruction):
    """Report whenever one of these managers is found or lost; others no more."""

    peers: tuple[str, ...]


class AnswerClient(Instruction):
    """Answer a request."""

    request: int
    reply: Reply


class Publish(Instruction):
    """Publish a message on a topic; `message` lacks only the time."""

    line: str
    message: Message


class WakeAt(Instruction):
    """Send a `TimerExpired` at this monotonic time [s]."""

    time_s: float


class ExitDaemon(Instruction):
    """Nothing is left to be ended: close the endpoints and end the process."""
