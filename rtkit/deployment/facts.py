"""Facts about a live system: components, their restarts, processes, connectors, followed systems.

The manager keeps these facts and sends them to clients as one snapshot.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.enums import merged_state
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    ModuleProfile,
    PortProfile,
    TypeProfile,
)

TOOL = ("rtkit", "tool")
"""Vendor and category of the components of data tools."""
AT_FIRST, IS_SO, BY_OTHERS = "at first", "is so", "by others"
"""Words for the ways in which a system came to a state without an event."""


@dataclass(frozen=True, slots=True)
class Followed:
    """Status of a system whose events its manager follows.

    Attributes:
        system: Identity of its profile.
        state: The last one that it was seen in, or the one that it is led to.
        before: The state before that; empty for the first one.
        event: Event that led from there.
        count: How many transitions there were.
        time: When the last one was, or began [s since 1970].
        is_led: It is being led to `state` just now.
        waits: For whom it waits before it is led on; mostly empty.
        why: Why the last transition that failed did; empty where the last one did not.
        kind: Of that error.
        is_over: It is followed no more, for that reason.
    """

    system: str
    state: str = ""
    before: str = ""
    event: str = ""
    count: int = 0
    time: float = 0.0
    is_led: bool = False
    waits: str = ""
    why: str = ""
    kind: str = ""
    is_over: bool = False

    def __str__(self) -> str:
        if not self.state:
            return "not looked at yet"
        way = f"{self.before} -{self.event}-> {self.state}"
        return way if self.before else f"{self.state} ({self.event})"


@dataclass(frozen=True, slots=True)
class RestartStatus:
    """Results of a policy and of health rules; each text is empty where nothing happened.

    Attributes:
        restarts: How often its policy made it again.
        why: For which end its policy made it again the last time.
        took_s: How long that took, from its end until it was as it had been [s].
        returning: For which end it is to be restarted, as long as it is not.
        given_up: Why it is restarted no more.
        degraded: Rule of health that it breaks and that says so.
        rested: Rule for whose breach it was deactivated.
        halted: For which loss everything was deactivated, since it is critical.
        due_s: When it is to be restarted, on the monotonic clock of its host [s]; 0 for never.
    """

    restarts: int = 0
    why: str = ""
    took_s: float = 0.0
    returning: str = ""
    given_up: str = ""
    degraded: str = ""
    rested: str = ""
    halted: str = ""
    due_s: float = 0.0

    @property
    def trouble(self) -> str:
        """Return the trouble of a component that answers; empty for none."""
        return f"degraded: {self.degraded}" if self.degraded else self.given_up

    @property
    def again(self) -> str:
        """Return how often its policy restarted it, and for what the last time; empty for never."""
        times = "once" if self.restarts == 1 else f"{self.restarts} times"
        return f"made again {times}, for {self.why}" if self.why else ""

    @property
    def stops(self) -> str:
        """Return why it, or for its sake everything, was deactivated; empty for nothing."""
        reasons = [f"deactivated: {self.rested}"] if self.rested else []
        reasons += [f"all was deactivated: {self.halted}"] if self.halted else []
        return "; ".join(reasons)

    @property
    def history(self) -> str:
        """Return the actions of its policy and rules so far; empty for none."""
        return "; ".join(filter(None, (self.again, self.stops)))


@dataclass(frozen=True, slots=True)
class ComponentFacts:
    """One component as its process last reported it.

    Attributes:
        process: Name of the manager or slave process that holds it.
        sets: Configuration sets: set name to parameter name to text.
        names: Paths under which it is registered, ``localhost/dir.host_cxt/Motor0.rtc``.
        contexts: Execution contexts, own ones first: an index is a place in here.
        create: Create string that makes it again; a stand-in, together with its pattern.
        module: ``PATH:INIT`` of its module when one was loaded for it.
        is_stand_in: Generated from data, no code of its own.
        cause: The exception that put it into Error, one line with file:line.
        zombie: Why nobody is behind the entry any more (``signal 9``); empty while it lives.
        composite_type: ``PeriodicECShared``, ``PeriodicStateShared`` or ``Grouping``; empty for a
            component that is no composite.
        members: Instance names of a composite's members, in order of execution.
        composite: The composite that it is a member of; empty for most.
        fsm_state: Present state of its state machine; empty without one, and before it began.
        fsm_states: The machine's table: state to event to next state, the initial one first.
        fsm_events: Data type of each event that its event port takes.
        trouble: Why it does not answer though it lives (``stopped``); empty when it answers.
        restart_status: Record of the reactions to its ends and its health.
        since: When its state last changed, or it died [s since 1970]; 0 where that is not known.
        code: CRC-32 of the file of its module when that was loaded, eight hexadecimal digits, and
            where that file is; a line for each file beside it that it imports, too. Empty for one
            that comes from no module.
    """

    instance: str
    type: TypeProfile
    process: str
    ports: tuple[PortProfile, ...] = ()
    sets: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    active_set: str = ""
    contexts: tuple[ExecutionContextProfile, ...] = ()
    names: tuple[str, ...] = ()
    create: str = ""
    module: str = ""
    is_stand_in: bool = False
    cause: str = ""
    zombie: str = ""
    trouble: str = ""
    properties: Mapping[str, str] = field(default_factory=dict)
    composite_type: str = ""
    members: tuple[str, ...] = ()
    composite: str = ""
    fsm_state: str = ""
    fsm_states: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    fsm_events: Mapping[str, str] = field(default_factory=dict)
    restart_status: RestartStatus = field(default_factory=RestartStatus)
    code: str = ""
    since: float = 0.0
    waits: str = ""

    def changed_code(self, present: Mapping[str, str]) -> str:
        """Return a file that it comes from, if that has changed since it was loaded.

        `present` has the CRC-32 of files as they are now.
        """
        parts = (line.partition(" ") for line in self.code.splitlines())
        changed = (file for loaded, _, file in parts if present.get(file, loaded) != loaded)
        return next(changed, "")

    @property
    def is_tool(self) -> bool:
        """Return whether it is that of a data tool, there for as long as the tool runs."""
        return (self.type.vendor, self.type.category) == TOOL

    @property
    def state(self) -> str:
        """Merged life-cycle state over all contexts, ``Unknown`` without any."""
        return merged_state([context.state for context in self.contexts])

    def port(self, name: str) -> PortProfile | None:
        """Return the port of that name, or None."""
        return next((port for port in self.ports if port.name == name), None)


@dataclass(frozen=True, slots=True)
class ProcessFacts:
    """The manager, a slave or an attached process.

    Attributes:
        state: ``starting``, ``up``, ``stopped``, ``silent`` (left by an earlier manager, and not
            come back to this one) or ``lost``.
        reason: Why it is lost or stopped; of one that is up, what is stuck in it and is no
            component: one that is being made, or a module.
        is_guest: It came by itself, as a data tool does, with components of its own.
    """

    name: str
    is_slave: bool
    pid: int
    state: str
    reason: str = ""
    is_guest: bool = False


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything one manager knows at one moment.

    Attributes:
        names: Paths under which the manager itself is registered, ``localhost/manager.mgr``.
        systems: Those whose events it follows, or followed until a transition failed.
    """

    host: str
    manager: str
    pid: int
    version: str
    processes: tuple[ProcessFacts, ...] = ()
    components: tuple[ComponentFacts, ...] = ()
    connectors: tuple[ConnectorProfile, ...] = ()
    modules: tuple[ModuleProfile, ...] = ()
    properties: Mapping[str, str] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    systems: tuple[Followed, ...] = ()

    @property
    def others(self) -> tuple[Snapshot, ...]:
        """Return the facts of the other managers of a `JointSnapshot`; empty for one manager."""
        return ()

    @property
    def unreachable(self) -> Mapping[str, str]:
        """Return why managers of a `JointSnapshot` cannot be asked, by their names."""
        return {}

    def component(self, instance: str) -> ComponentFacts | None:
        """Return the component of that instance name, or None."""
        return next((c for c in self.components if c.instance == instance), None)
