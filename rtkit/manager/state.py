"""The facts that a manager keeps: processes, components, connectors, modules."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.manager.events import OWN_PROCESS
from rtkit.rtc.profiles import ConnectorProfile, ModuleProfile


@dataclass(slots=True)
class Process:
    """The manager's own process, or a slave.

    Attributes:
        state: ``starting``, ``up``, ``stopped`` or ``lost``.
        reason: Why it is lost.
        is_wanted: False once it was told to end.
    """

    key: int
    name: str
    pid: int = 0
    state: str = "starting"
    reason: str = ""
    is_wanted: bool = True

    @property
    def is_slave(self) -> bool:
        """Whether it is not the manager itself."""
        return self.key != OWN_PROCESS

    @property
    def is_alive(self) -> bool:
        """Whether the kernel still runs it."""
        return self.state != "lost"


@dataclass(slots=True)
class State:
    """Everything one manager knows; only its core changes it.

    Attributes:
        holders: Key of the process that holds, or held, each component.
        reserved: Instance names of components that are being made.
    """

    host: str
    name: str
    pid: int
    version: str
    processes: dict[int, Process] = field(default_factory=dict)
    components: dict[str, ComponentFacts] = field(default_factory=dict)
    holders: dict[str, int] = field(default_factory=dict)
    connectors: dict[str, ConnectorProfile] = field(default_factory=dict)
    modules: dict[str, ModuleProfile] = field(default_factory=dict)
    properties: dict[str, str] = field(default_factory=dict)
    reserved: set[str] = field(default_factory=set)

    def living_process(self, name: str) -> Process | None:
        """Return the living process of that name, or None."""
        return next(
            (
                process
                for process in self.processes.values()
                if process.name == name and process.is_alive and process.is_wanted
            ),
            None,
        )

    def process_of(self, instance: str) -> Process | None:
        """Return the process that holds (or held) a component."""
        return self.processes.get(self.holders.get(instance, -1))

    def held_by(self, key: int) -> list[str]:
        """Return the instances in a process, in the order of their creation."""
        return [instance for instance, holder in self.holders.items() if holder == key]

    def connectors_of(self, instance: str) -> list[ConnectorProfile]:
        """Return the connectors that have an end at a component."""
        return [
            wire
            for wire in self.connectors.values()
            if any(end.instance == instance for end in wire.ports)
        ]

    def name_owner(self, name: str) -> str:
        """Return the instance registered under a full name, or nothing."""
        for instance, facts in self.components.items():
            if name in facts.names:
                return instance
        return ""

    def forget(self, instance: str) -> None:
        """Drop a component; a lost process goes with its last one."""
        self.components.pop(instance, None)
        key = self.holders.pop(instance, None)
        if key is not None:
            self.drop_if_empty(key)

    def drop_if_empty(self, key: int) -> None:
        """Drop a lost process of which no component is shown any more."""
        process = self.processes.get(key)
        if process is not None and not process.is_alive and not self.held_by(key):
            del self.processes[key]

    def update(self, instance: str, **changes: object) -> None:
        """Replace fields of a component's facts."""
        self.components[instance] = replace(self.components[instance], **changes)  # type: ignore[arg-type]

    def snapshot(self) -> Snapshot:
        """Return all facts, for clients."""
        return Snapshot(
            host=self.host,
            manager=self.name,
            pid=self.pid,
            version=self.version,
            processes=tuple(
                ProcessFacts(p.name, p.is_slave, p.pid, p.state, p.reason)
                for p in self.processes.values()
            ),
            components=tuple(self.components.values()),
            connectors=tuple(self.connectors.values()),
            modules=tuple(self.modules.values()),
            properties=dict(self.properties),
        )
