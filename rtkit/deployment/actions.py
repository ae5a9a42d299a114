"""Actions of a manager as data: the one vocabulary of plans, batches and dry runs."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rtkit import errors
from rtkit.deployment.message import MISSING as MISSING
from rtkit.deployment.message import NEW as NEW
from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.rtc.enums import ReturnCode, Transition

if TYPE_CHECKING:
    from rtkit.rtc.pattern import ComponentPattern
    from rtkit.rtc.profiles import ConnectorProfile

_ON_DEMAND = {"ComponentPattern": "rtkit.rtc.pattern", "ConnectorProfile": "rtkit.rtc.profiles"}


@dataclass(frozen=True, slots=True)
class Load:
    """Load a module and call its init function.

    Attributes:
        manager: Manager that is to do it, among several; never sent.
        is_strict: Refuse where there would be a note, and leave nothing.
    """

    path: str
    init: str = ""
    manager: str = ""
    is_strict: bool = False


@dataclass(frozen=True, slots=True)
class Unload:
    """Forget a module; components already made stay.

    Attributes:
        manager: Manager that is to do it, among several; never sent.
    """

    path: str
    manager: str = ""


@dataclass(frozen=True, slots=True)
class Create:
    """Make a component from a create string (commands §20), or from a pattern.

    With a pattern the create string only states the instance name, the place and the properties.

    Attributes:
        is_strict: Refuse where there would be a note, and leave nothing.
        manager: Manager that is to do it, among several; never sent.
    """

    create: str
    names: tuple[str, ...] = ()
    pattern: ComponentPattern | None = None
    is_strict: bool = False
    manager: str = ""


@dataclass(frozen=True, slots=True)
class Delete:
    """Finalise a component and forget it, with its connections and names.

    Attributes:
        is_forced: End the slave that holds it if it does not end by itself; what else was in it
            is the value of the result, and shown as zombies.
        slave: Refuse unless that slave holds it; empty for any process.
    """

    instance: str
    is_forced: bool = False
    slave: str = ""


@dataclass(frozen=True, slots=True)
class EndSlave:
    """End a slave with all components in it.

    Attributes:
        is_forced: At once, however its components are, instead of each in order.
    """

    name: str
    is_forced: bool = False


@dataclass(frozen=True, slots=True)
class Unregister:
    """Remove a name from the tree; what bears it lives on, a zombie goes with its last name.

    Attributes:
        name: In full, as facts state it: ``localhost/dir.host_cxt/Motor0.rtc``.
        is_zombie: Refuse unless a zombie bears it.
    """

    name: str
    is_zombie: bool = False


@dataclass(frozen=True, slots=True)
class Register:
    """Give a component that lives a further name in the tree.

    Attributes:
        name: In full, as facts state it: ``localhost/dir.host_cxt/Motor0.rtc``.
    """

    instance: str
    name: str


@dataclass(frozen=True, slots=True)
class Connect:
    """Make a connection."""

    connector: ConnectorProfile


@dataclass(frozen=True, slots=True)
class Disconnect:
    """Remove the connection of that id.

    Attributes:
        holds: Its out port keeps what is written for the next connection of that id.
    """

    connector_id: str
    holds: bool = False


@dataclass(frozen=True, slots=True)
class SetParameters:
    """Change parameters of one configuration set, all or none.

    Attributes:
        adds: Where there is no such set this is refused if it is empty; `MISSING` adds it, `NEW`
            does and refuses one that is there.
    """

    instance: str
    set_id: str
    values: Mapping[str, str] = field(default_factory=dict)
    adds: str = ""


@dataclass(frozen=True, slots=True)
class RemoveSet:
    """Remove a configuration set that was added at run time, and is not the active one."""

    instance: str
    set_id: str


@dataclass(frozen=True, slots=True)
class ActivateSet:
    """Make a configuration set the active one."""

    instance: str
    set_id: str


@dataclass(frozen=True, slots=True)
class ChangeState:
    """Activate, deactivate or reset a component in one of its execution contexts.

    The answer comes when the transition is done, refused or failed; with `wait` false at once.

    Attributes:
        drains_s: How long it may take first until the component has read all that arrived [s].
    """

    instance: str
    context: str
    transition: Transition
    wait: bool = True
    drains_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SetRate:
    """Change the rate [Hz] of a periodic execution context that a component takes part in."""

    instance: str
    context: str
    rate: float


@dataclass(frozen=True, slots=True)
class SetContext:
    """Change settings of the thread that drives an execution context.

    Attributes:
        instance: The component that owns the context.
        settings: By the keys of `rtkit.rtc.context_settings`; an empty one is taken away.
    """

    instance: str
    context: str
    settings: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class SetPolicy:
    """Change what is done about the end and the health of a component, which lives on.

    Attributes:
        policy: All of its properties ``rtkit.restart…``, ``rtkit.critical``, ``rtkit.health.…``;
            those that are not named are taken away.
    """

    instance: str
    policy: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Tick:
    """Give a context that is not periodic one cycle; the answer comes when it is over."""

    instance: str
    context: str


@dataclass(frozen=True, slots=True)
class Attach:
    """Have an execution context of `owner` drive a component of the same process too.

    The participant is Inactive there and knows the context as ``OWNER/CONTEXT``.
    """

    owner: str
    context: str
    participant: str


@dataclass(frozen=True, slots=True)
class Detach:
    """Take a component out of an execution context of another, deactivating it there first."""

    owner: str
    context: str
    participant: str


@dataclass(frozen=True, slots=True)
class SetStructure:
    """Give the state machine of a component another table: state to event to next state."""

    instance: str
    states: Mapping[str, Mapping[str, str]]


@dataclass(frozen=True, slots=True)
class SetEventProfiles:
    """Give the event port of a state machine other events, each with its data type."""

    instance: str
    events: Mapping[str, str]


Action = (
    Load
    | Unload
    | Create
    | Delete
    | EndSlave
    | Unregister
    | Register
    | Connect
    | Disconnect
    | SetParameters
    | RemoveSet
    | ActivateSet
    | ChangeState
    | SetRate
    | SetContext
    | SetPolicy
    | Tick
    | Attach
    | Detach
    | SetStructure
    | SetEventProfiles
)


def strict(action: Action) -> Action:
    """Return an action that is refused where it would be done, with a note on the request."""
    return replace(action, is_strict=True) if isinstance(action, Load | Create) else action


@dataclass(frozen=True, slots=True)
class Result:
    """Outcome of one action.

    Attributes:
        kind: Kind of the error (see `rtkit.errors`); empty on success.
        why: One line for the user; empty on success.
        value: Result: the instance name of a created component.
        note: Remark on a result that the user may not expect; mostly empty.
        left_out: Parts of a component that died which the one in its place lacks; a plan of its
            system creates them again, so only commands without a plan state them.
        took_s: How long it took [s]; 0 where nobody measured it.
    """

    code: ReturnCode = ReturnCode.OK
    kind: str = ""
    why: str = ""
    value: str = ""
    note: str = ""
    left_out: str = ""
    took_s: float = field(default=0.0, compare=False)

    @property
    def ok(self) -> bool:
        """Return whether the action was done."""
        return self.code is ReturnCode.OK

    def raise_for_error(self) -> None:
        """Raise the error that this result stands for, if any."""
        if not self.ok:
            raise errors.from_kind(self.kind, self.why)


def __getattr__(name: str) -> Any:
    # Most commands send neither, so only who reads the annotations (`rtkit.rtc.serde`) loads them.
    if name not in _ON_DEMAND:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found = getattr(import_module(_ON_DEMAND[name]), name)
    return found
