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
from rtkit.fast_dataclass import dataclass
from rtkit.property.exchange import Reply

Row = tuple[str, str, str | None]
"""A row of desired state: kind, name and value; without a value it is to be removed."""

OWN_PROCESS = 0
"""Key of the manager's own process."""


@dataclass(frozen=True, slots=True)
class BatchRequested:
    """A client wants actions performed.

    Attributes:
        until: When the client gives up, monotonic [s]: what was not begun then is not done.
    """

    batch: Batch
    request: int
    until: float = math.inf


@dataclass(frozen=True, slots=True)
class SnapshotRequested:
    """A client that subscribes to deltas requests the snapshot they begin with."""

    request: int


@dataclass(frozen=True, slots=True)
class ListenersChanged:
    """A topic has its first subscriber now, or lost its last."""

    line: str
    is_heard: bool
    who: str = "clients"


@dataclass(frozen=True, slots=True)
class FollowAsked:
    """A client wants a system followed, with all that is needed for it; or, without, no more."""

    system: str
    text: str | None
    request: int


@dataclass(frozen=True, slots=True)
class FollowSaid:
    """A follower reports the outcome of its system, and waits until that is stored."""

    told: Followed
    request: int


@dataclass(frozen=True, slots=True)
class OperationRequested:
    """A client wants an operation done (see `rtkit.manager.core.operations`)."""

    name: str
    argument: str
    request: int


@dataclass(frozen=True, slots=True)
class StopRequested:
    """A client or a signal wants the manager to end; if it is urgent, without any grace.

    Desired state is kept only where it is not a user who wants that.
    """

    is_urgent: bool = False
    is_kept: bool = False


@dataclass(frozen=True, slots=True)
class StoreRead:
    """The store of an earlier manager was read, before any process has reported.

    Attributes:
        rows: Of the store.
        boot: Which run of the machine this is: in another one, nobody died by himself.
        remark: A finding about the store; mostly empty.
    """

    rows: Sequence[Row]
    boot: str = ""
    remark: str = ""


@dataclass(frozen=True, slots=True)
class RecoveryRequested:
    """All live processes have reported: what is desired and missing is to be created."""

    request: int


@dataclass(frozen=True, slots=True)
class StartStepDone:
    """A step of the manager's own start is done, and is not to be done again by the next one."""

    step: str


@dataclass(frozen=True, slots=True)
class RowsStored:
    """Rows are on the disk, or could not be written for a reason.

    Attributes:
        is_lost: Nor is anything that was kept before: the store is gone, and there can be another.
    """

    number: int
    why: str = ""
    is_lost: bool = False


@dataclass(frozen=True, slots=True)
class SlaveForked:
    """The zygote made the process of a slave."""

    key: int
    pid: int


@dataclass(frozen=True, slots=True)
class SlaveFailed:
    """The zygote could not make the process of a slave."""

    key: int
    reason: str


@dataclass(frozen=True, slots=True)
class SpawnDisabled:
    """No slave can be made at present, for this reason; or, with none, they can again."""

    why: str


@dataclass(frozen=True, slots=True)
class SlaveReady:
    """A slave has connected: it can hold components."""

    key: int


@dataclass(frozen=True, slots=True)
class SlaveFound:
    """A slave of an earlier manager, or an attached process, reported its components.

    With a `silence`, ``stopped`` or ``does not answer``, this is from its checkpoint.
    What was `asked` of components since they were made, it alone may know.
    """

    pid: int
    name: str
    components: object
    wires: object
    is_guest: bool = False
    silence: str = ""
    asked: object = None


@dataclass(frozen=True, slots=True)
class SlaveExitedUnseen:
    """A slave ended while no manager ran; its components are known from its checkpoint.

    If nobody has seen how, all that ran with it was ended at once.
    """

    pid: int
    name: str
    components: object
    reason: str
    is_seen: bool = True


@dataclass(frozen=True, slots=True)
class SlaveEnded:
    """The kernel reported the end of a slave; `last` is its exit diagnostics, in one line."""

    key: int
    reason: str
    last: str = ""


@dataclass(frozen=True, slots=True)
class SlaveStopped:
    """The kernel reported that a slave was stopped (``SIGSTOP``) or goes on."""

    key: int
    is_halted: bool


@dataclass(frozen=True, slots=True)
class SlaveOverLimit:
    """A slave has reached a limit that it was given by `LimitSlave`; `why` names the limit."""

    key: int
    why: str


@dataclass(frozen=True, slots=True)
class CallbackStuck:
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


@dataclass(frozen=True, slots=True)
class ProcessInspected:
    """`InspectProcess` is complete; its findings came by `CallbackStuck`."""

    key: int


@dataclass(frozen=True, slots=True)
class ContainerReported:
    """The container of a process answered, or reported a fact."""

    key: int
    message: Message


@dataclass(frozen=True, slots=True)
class TimerExpired:
    """The moment that `WakeAt` asked for has come."""


Event = (
    BatchRequested
    | SnapshotRequested
    | ListenersChanged
    | FollowAsked
    | FollowSaid
    | OperationRequested
    | StopRequested
    | StoreRead
    | RecoveryRequested
    | StartStepDone
    | RowsStored
    | SlaveForked
    | SlaveFailed
    | SpawnDisabled
    | SlaveReady
    | SlaveFound
    | SlaveExitedUnseen
    | SlaveEnded
    | SlaveStopped
    | SlaveOverLimit
    | CallbackStuck
    | ProcessInspected
    | ContainerReported
    | TimerExpired
)


@dataclass(frozen=True, slots=True)
class SpawnSlave:
    """Have the zygote fork a slave."""

    key: int
    name: str


@dataclass(frozen=True, slots=True)
class AdoptSlave:
    """Take a process that was found as one of ours, under this key."""

    key: int
    pid: int
    is_guest: bool = False


@dataclass(frozen=True, slots=True)
class SendToContainer:
    """Send a message to the container of a process."""

    key: int
    message: Message


@dataclass(frozen=True, slots=True)
class SignalSlave:
    """Send a signal to a slave."""

    key: int
    signal: int


@dataclass(frozen=True, slots=True)
class LimitSlave:
    """Have a slave and all below it use no more than that; without limits, as much as it likes."""

    key: int
    pid: int
    limits: SlaveLimits


@dataclass(frozen=True, slots=True)
class InspectProcess:
    """Report what has been under way in a process for longer than `age_s` [s].

    `ProcessInspected` ends the report.
    """

    key: int
    age_s: float


@dataclass(frozen=True, slots=True)
class StoreRows:
    """Write rows into the store, in one go; `RowsStored` reports when they are on the disk."""

    number: int
    rows: Sequence[Row]


@dataclass(frozen=True, slots=True)
class RemoveStore:
    """Remove the store at the end: nothing is desired any more."""


@dataclass(frozen=True, slots=True)
class AnswerClient:
    """Answer a request."""

    request: int
    reply: Reply


@dataclass(frozen=True, slots=True)
class Publish:
    """Publish a message on a topic; `message` lacks only the time."""

    line: str
    message: Message


@dataclass(frozen=True, slots=True)
class WakeAt:
    """Send a `TimerExpired` at this monotonic time [s]."""

    time_s: float


@dataclass(frozen=True, slots=True)
class ExitDaemon:
    """Nothing is left to be ended: close the endpoints and end the process."""


Instruction = (
    SpawnSlave
    | AdoptSlave
    | SendToContainer
    | SignalSlave
    | LimitSlave
    | InspectProcess
    | StoreRows
    | RemoveStore
    | AnswerClient
    | Publish
    | WakeAt
    | ExitDaemon
)
