"""State of a manager: its processes, components, connectors and modules."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from string import digits

from rtkit.deployment.facts import ComponentFacts, ProcessFacts, RestartStatus, Snapshot
from rtkit.deployment.limits import Capacity, SlaveLimits
from rtkit.errors import NotFound, RtkitError
from rtkit.fast_dataclass import Record, dataclass, field, replace
from rtkit.manager.core.desired import DesiredComponent, DesiredState, RestartRecord
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.indexed_table import IndexedTable
from rtkit.rtc.far_ends import host_of, on_host, peer_of
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, is_local_host
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.profiles import ConnectorProfile, ModuleProfile, PortRef
from rtkit.settings.properties import Settings

NOWHERE = -1
"""Key of no process."""
_UNWATCHED = RestartRecord()
_MOST_DIGITS = 9
"""Longer numbers are given by users only."""


@dataclass(slots=True)
class Process:
    """The manager's own process, a slave, or an attached process that nobody here started.

    Attributes:
        state: ``starting``, ``up``, ``stopped``, ``silent`` or ``lost``; a silent one was left by
            an earlier manager and has not come back to this one.
        reason: Why it is lost.
        silence: Of a silent one: ``stopped`` or ``does not answer``.
        last: Its exit diagnostics.
        verdict: Why it is ended though what it holds is wanted; that takes precedence over how.
        is_wanted: False once its end was requested.
        is_overdue: It was killed, and has not ended.
        is_guest: It came by itself with components of its own and ends by itself.
        trial_of: The module of which it only tries whether it can be imported; it is not shown.
        failure: Why that module cannot be imported.
        stuck: Calls that exceed their deadline in it, with their place: by component, also one
            that is being made, or by module.
        found: Keys of the modules that it has loaded by itself for a component being made.
    """

    key: int
    name: str
    pid: int = 0
    state: str = "starting"
    reason: str = ""
    silence: str = ""
    last: str = ""
    verdict: str = ""
    is_wanted: bool = True
    is_overdue: bool = False
    is_guest: bool = False
    trial_of: str = ""
    failure: RtkitError | None = None
    stuck: dict[str, str] = field(default_factory=dict)
    found: list[str] = field(default_factory=list)

    @property
    def is_trial(self) -> bool:
        """Return whether the process exists for nothing but the import check of a module."""
        return bool(self.trial_of)

    @property
    def is_slave(self) -> bool:
        """Return whether the manager started the process, and is to end it."""
        return self.key != OWN_PROCESS and not self.is_guest

    @property
    def is_alive(self) -> bool:
        """Return whether the kernel still runs it."""
        return self.state != "lost"

    @property
    def is_ready(self) -> bool:
        """Return whether it takes messages, though it may be stopped and take them later."""
        return self.state in ("up", "stopped")

    @property
    def end(self) -> str:
        """Return how the process was lost, with its exit diagnostics."""
        if not self.pid:
            return f"slave {self.name} could not be started: {self.reason}"
        words = f"; its last words: {self.last}" if self.last else ""
        return f"slave {self.name} ended: {self.reason}{words}"

    @property
    def unfit(self) -> str:
        """Return why it answers nothing at present; empty when it does."""
        if not self.is_alive:
            return self.end
        if self.is_stopped:
            return f"slave {self.name} does not answer: it is stopped"
        return f"slave {self.name} does not answer" * bool(self.silence)

    @property
    def is_stopped(self) -> bool:
        """Return whether it was stopped and has not continued yet."""
        return "stopped" in (self.state, self.silence)


@dataclass(slots=True)
class NameReservation:
    """Reservation for a component that is being made: its names, and its process once chosen.

    Attributes:
        is_by_template: Nobody asked for these names; once it is made there may be more.
        is_in_new_slave: Its process is a slave that was started for it.
    """

    names: tuple[str, ...]
    key: int = NOWHERE
    is_by_template: bool = False
    is_in_new_slave: bool = False


@dataclass(slots=True)
class Opening:
    """A connector that is being made; `is_broken` when an end has gone meanwhile."""

    wire: ConnectorProfile
    is_broken: bool = False


class Expected(Record):
    """A connector that a manager of another host may make until then, monotonic time [s]."""

    peer: str
    ports: tuple[PortRef, ...]
    until: float


def _names_and_folders(names: Iterable[str]) -> Iterator[str]:
    """Yield full names, and the directories in which they are, each with a slash at its end."""
    for name in names:
        yield name
        end = name.find("/")
        while end >= 0:
            yield name[: end + 1]
            end = name.find("/", end + 1)


def _instances(connector: ConnectorProfile) -> Iterator[str]:
    return (end.instance for end in connector.ports)


def _components() -> IndexedTable[str, ComponentFacts]:
    return IndexedTable(lambda facts: _names_and_folders(facts.names), {})


def _containers() -> IndexedTable[str, int]:
    return IndexedTable(lambda key: (key,), {})


def _connectors() -> IndexedTable[str, ConnectorProfile]:
    return IndexedTable(_instances, {})


def _claims() -> IndexedTable[str, NameReservation]:
    return IndexedTable(lambda claim: _names_and_folders(claim.names), {})


@dataclass(slots=True)
class ManagerState:
    """State of one manager; only its core changes it.

    Attributes:
        holders: Key of the process that holds, or held, each component.
        claims: Instance names of components that are being made.
        ending: Instance names of components that are being deleted.
        openings: Connectors that are being made, by id.
        tried: Modules that another process has imported before, with the fingerprint of each.
        ahead: Modules that slaves are to have imported before they are forked.
        names: Paths under which the manager itself is registered.
        settings: The properties that the manager was given.
        folder: Where relative paths of properties begin.
        base_paths: Folders of modules that are always there.
        port: TCP port of the TCP endpoint, 0 without one.
        masters: Managers that this one is registered with.
        slaves: Managers with processes of their own that are registered with this one.
        is_in_haste: It is to end without any grace.
        barred: Why no slave can be made at present; empty when they can.
        kept: Desired state, as it is stored for the next manager.
        unkept: Why desired state cannot be stored at present; empty when it can.
        remark: A finding about the store of an earlier manager; mostly empty.
        returning: Instances that are to be restarted.
        unwell: Those of them that live, and are to be ended first.
        ruled: Instances with rules of health.
        bound: Devices whose end ends components, by instance; replaced when that changes.
        absent: Those of them that were not there at the last look.
        unjudged: Components that were made after it, by such a device: the next look tells.
        degraded: Those rules that they break, by instance.
        limits: Limits of components that have any, by instance.
        capacity: Returns what this host has.
        since_made: Requests of users to found components since they were made, by instance; no
            more once all else that is desired of them is done.
        loose: Ends of connectors that slaves hold which were found, by connector and slave, until
            the other end is known too.
        peers: Other managers that can be asked about halves of connectors.
        failing: Why own ends of halves cannot be opened or joined, by connector; tried again.
        expected: Connectors that managers of other hosts may make, by id.
        makings: How many connectors to other managers it has made.
        free_numbers: By the beginning of instance names that are chosen here: all with a lower
            number exist or are reserved. It follows from those, and saves a look at each.
    """

    UNRECORDED = ("capacity", "free_numbers")

    host: str
    name: str
    pid: int
    version: str
    processes: dict[int, Process] = field(default_factory=dict)
    components: IndexedTable[str, ComponentFacts] = field(default_factory=_components)
    containers: IndexedTable[str, int] = field(default_factory=_containers)
    connectors: IndexedTable[str, ConnectorProfile] = field(default_factory=_connectors)
    modules: dict[str, ModuleProfile] = field(default_factory=dict)
    properties: dict[str, str] = field(default_factory=dict)
    claims: IndexedTable[str, NameReservation] = field(default_factory=_claims)
    ending: set[str] = field(default_factory=set)
    openings: dict[str, Opening] = field(default_factory=dict)
    tried: dict[str, int] = field(default_factory=dict)
    ahead: set[str] = field(default_factory=set)
    names: tuple[str, ...] = ()
    loose: dict[tuple[str, int], ConnectorProfile] = field(default_factory=dict)
    settings: Settings = field(default_factory=Settings)
    folder: str = "/"
    base_paths: tuple[str, ...] = ()
    port: int = 0
    masters: list[str] = field(default_factory=list)
    slaves: list[str] = field(default_factory=list)
    is_in_haste: bool = False
    barred: str = ""
    kept: DesiredState = field(default_factory=DesiredState)
    unkept: str = ""
    remark: str = ""
    returning: set[str] = field(default_factory=set)
    unwell: set[str] = field(default_factory=set)
    ruled: set[str] = field(default_factory=set)
    bound: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    absent: frozenset[str] = frozenset()
    unjudged: set[str] = field(default_factory=set)
    degraded: dict[str, str] = field(default_factory=dict)
    limits: dict[str, SlaveLimits] = field(default_factory=dict)
    capacity: Callable[[], Capacity] = Capacity
    since_made: dict[str, DesiredComponent] = field(default_factory=dict)
    peers: set[str] = field(default_factory=set)
    failing: dict[str, str] = field(default_factory=dict)
    expected: dict[str, Expected] = field(default_factory=dict)
    makings: int = 0
    free_numbers: dict[str, int] = field(default_factory=dict)

    def cut(self, connector_id: str) -> None:
        """Drop a connector; the other manager, if it leads to one, is to hear of it."""
        connector = self.connectors.pop(connector_id, None)
        peer = peer_of(connector) if connector is not None else ""
        if peer:
            self.kept.untell(peer, connector_id)

    def name_for(self, peer: str) -> str:
        """Return the name of this manager between it and a peer."""
        return on_host(self.name, self.host) if host_of(peer) else self.name

    def new_making(self) -> str:
        """Return the name of another making of a connector, which no other has."""
        self.makings += 1
        return f"{self.kept.store_name} {self.pid} {self.makings}"

    def trouble_of(self, instance: str, process: Process) -> str:
        """Return why a component that lives does not answer; empty when it does."""
        if process.is_stopped:
            return "stopped"
        return process.stuck.get(instance, "") or process.silence

    def waits_in(self, key: int) -> dict[str, str]:
        """Return which components of a process wait for input, and how that is given."""
        held = (self.components[each] for each in self.held_by(key))
        way = "rtattach gives it some"
        return {facts.instance: f"{facts.waits} ({way})" for facts in held if facts.waits}

    def watched(self, instance: str) -> RestartRecord:
        """Return what has been done about the ends of a component."""
        return self.kept.watched.get(instance, _UNWATCHED)

    def watch(self, instance: str, **changes: object) -> None:
        """Record what was done about the ends of a component, and report it."""
        self.kept.watch(instance, **changes)
        self.report_restart_status(instance)

    def restart_status_of(self, instance: str) -> RestartStatus:
        """Return the restart status and the health of a component."""
        return self.watched(instance).restart_status(self.degraded.get(instance, ""))

    def is_in_hand(self, instance: str) -> bool:
        """Return whether a component is dead, and its policy restarts it or gave up."""
        facts, watched = self.components.get(instance), self.watched(instance)
        is_dead = facts is not None and bool(facts.zombie)
        return is_dead and instance in self.kept.components and watched.is_in_hand

    def report_restart_status(self, instance: str) -> None:
        """Add the restart status to the facts of a component."""
        facts = self.components.get(instance)
        if facts is not None and facts.restart_status != (
            restart_status := self.restart_status_of(instance)
        ):
            self.update(instance, restart_status=restart_status)

    def trouble_in(self, process: Process) -> str:
        """Return what is wrong with a process and is shown at none of its components."""
        parts = [process.silence] if process.silence else []
        parts += [
            f"{name} is {text}"
            for name, text in process.stuck.items()
            if self.containers.get(name) != process.key
        ]
        if process.key == OWN_PROCESS:
            parts += [self.remark] if self.remark else []
            parts += [f"the desired state cannot be recorded: {self.unkept}"] if self.unkept else []
            parts[:0] = [f"no slave can be started: {self.barred}"] if self.barred else []
        return "; ".join(parts)

    def living_process(self, name: str) -> Process | None:
        """Return the living process of that name, or None."""
        return next(
            (
                process
                for process in self.processes.values()
                if process.name == name
                and process.is_alive
                and process.is_wanted
                and not process.is_guest
            ),
            None,
        )

    def process_of(self, instance: str) -> Process | None:
        """Return the process that holds (or held) a component."""
        return self.processes.get(self.containers.get(instance, NOWHERE))

    def held_by(self, key: int) -> list[str]:
        """Return the instances in a process, in the order of their creation."""
        return list(self.containers.keys_with(key))

    def is_needed(self, key: int) -> bool:
        """Return whether a process holds a component, or one is being made in it."""
        is_held = bool(self.containers.keys_with(key))
        return is_held or any(claim.key == key for claim in self.claims.values())

    def connectors_of(self, instance: str) -> list[ConnectorProfile]:
        """Return the connectors that have an end at a component."""
        return [self.connectors[each] for each in self.connectors.keys_with(instance)]

    def name_owner(self, name: str) -> str:
        """Return who is, or is to be, registered under a full name; empty for nobody."""
        for instance in self.components.keys_with(name):
            return instance
        if name in self.names:
            return f"manager {self.name}"
        return next(iter(self.claims.keys_with(name)), "")

    def at_path(self, path: str) -> list[str]:
        """Return the components that may be at a path: by a name, or below their manager."""
        host, _, rest = path.partition("/")
        instance = rest.rpartition("/")[2].removesuffix(COMPONENT_SUFFIX)
        found = {instance: None} if instance in self.components else {}
        hosts = (host, LOCAL, self.host) if is_local_host(host, self.host) else (host,)
        for each in hosts:
            found |= dict.fromkeys(self.components.keys_with(f"{each}/{rest}"))
        return list(found)

    def name_below(self, name: str) -> str:
        """Return a full name in a directory, taken or reserved; empty when there is none."""
        folder = f"{name}/"
        named = [self.components[each].names for each in self.components.keys_with(folder)]
        named += [self.claims[each].names for each in self.claims.keys_with(folder)]
        names = (each for names in (self.names, *named) for each in names)
        return next((each for each in names if each.startswith(folder)), "")

    def first_free(self, base: str) -> int:
        """Return the lowest number that makes an instance name of `base` that nobody has."""
        number = self.free_numbers.get(base, 0)
        while (name := f"{base}{number}") in self.components or name in self.claims:
            number += 1
        self.free_numbers[base] = number
        return number

    def _note_free(self, instance: str) -> None:
        """Note that an instance name is free now, whatever it may begin with."""
        if instance in self.components or instance in self.claims:
            return
        for end in range(len(instance.rstrip(digits)), len(instance)):
            base, number = instance[:end], instance[end:]
            if base in self.free_numbers and len(number) <= _MOST_DIGITS:
                self.free_numbers[base] = min(self.free_numbers[base], int(number))

    def release(self, instance: str) -> None:
        """End the reservation of a component that was made, or could not be."""
        self.claims.pop(instance, None)
        self._note_free(instance)

    def forget(self, instance: str) -> None:
        """Drop a component with its connectors; a lost process goes with its last one."""
        self.drop_connectors(instance)
        self.components.pop(instance, None)
        self._note_free(instance)
        key = self.containers.pop(instance, None)
        if key is not None:
            self.drop_if_empty(key)

    def drop_connectors(self, instance: str) -> None:
        """Drop the connectors of a component; those that are being made will not be kept."""
        for connector in self.connectors_of(instance):
            self.cut(connector.connector_id)
        for opening in self.openings.values():
            opening.is_broken |= instance in _instances(opening.wire)

    def drop_loose(self, key: int) -> None:
        """Drop the connector ends of a found slave whose other ends are not known."""
        self.loose = {end: connector for end, connector in self.loose.items() if end[1] != key}

    def drop_if_empty(self, key: int) -> None:
        """Drop a lost process of which no component is shown any more."""
        process = self.processes.get(key)
        if process is not None and not process.is_alive and not self.held_by(key):
            del self.processes[key]

    def update(self, instance: str, **changes: object) -> None:
        """Replace fields of a component's facts."""
        self.components[instance] = replace(self.components[instance], **changes)  # type: ignore[arg-type]

    def is_leaving(self, process: Process) -> bool:
        """Return whether a process ends as it was told to, so that nobody need look at it."""
        ends = process.is_slave and process.is_alive and not process.is_wanted
        is_odd = process.is_overdue or self.trouble_in(process)
        return ends and not is_odd and not self.held_by(process.key)

    def process_facts(self) -> Iterator[ProcessFacts]:
        """Yield facts about processes, but for those that nobody need look at."""
        for p in self.processes.values():
            if not (p.is_trial or self.is_leaving(p)):
                why = p.reason or self.trouble_in(p)
                yield ProcessFacts(p.name, p.is_slave, p.pid, p.state, why, p.is_guest)

    def snapshot(self) -> Snapshot:
        """Return all facts, for clients."""
        return Snapshot(
            host=self.host,
            manager=self.name,
            pid=self.pid,
            version=self.version,
            processes=tuple(self.process_facts()),
            components=tuple(self.components.values()),
            connectors=tuple(self.connectors.values()),
            systems=tuple(self.kept.reached.values()),
            modules=tuple(self.modules.values()),
            properties=dict(self.properties),
            names=self.names,
        )


def no_component(state: ManagerState, instance: str) -> NotFound:
    """Return the error that there is no such component, with those that may have been meant."""
    return NotFound(f"no component named {instance}{did_you_mean(instance, state.components)}")
