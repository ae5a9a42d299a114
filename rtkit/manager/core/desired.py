"""Desired state: everything that was acknowledged, as rows for the store.

Facts are reports of processes; desired state is what users asked for. A component that died is no
fact any more and is still desired; a component that a user ended is neither.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rtkit.deployment.facts import ComponentFacts, Followed, RestartStatus
from rtkit.deployment.supervision import Ledger
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.manager.core.events import Row
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode, encode

COMPONENT, WIRE, MODULE, SETTING, BEGUN, ZOMBIE, WATCHED, BOOT, ANSWERED, FOLLOWED, REACHED = (
    "component",
    "wire",
    "module",
    "setting",
    "begun",
    "zombie",
    "watched",
    "boot",
    "answered",
    "followed",
    "reached",
)
"""The kinds of rows."""
_TABLES: Mapping[str, str] = {
    COMPONENT: "components",
    WIRE: "wires",
    MODULE: "modules",
    SETTING: "settings",
    BEGUN: "begun",
    ZOMBIE: "zombies",
    WATCHED: "watched",
    BOOT: "boot",
    ANSWERED: "answered",
    FOLLOWED: "followed",
    REACHED: "reached",
}
"""The attributes that hold them."""
_URGENT = (ZOMBIE, WATCHED)
"""Those of ends, which are kept though something that answers them is under way."""


@dataclass(frozen=True, slots=True)
class DesiredComponent:
    """Component that shall exist.

    Attributes:
        create: Create string that makes it, with its instance name and its slave.
        pattern: Of a stand-in, as JSON.
        sets: What was set by users: set name to parameter name to text.
        active: Ids of the execution contexts in which it shall be active.
        rates: Rates that were set [Hz], by context.
        attached: Components that its contexts drive besides, by context.
        states: Table that its state machine was given, empty for its own.
        events: Events that its machine's port was given, empty for its own.
    """

    create: str
    names: tuple[str, ...] = ()
    pattern: str = ""
    sets: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    active_set: str = ""
    active: tuple[str, ...] = ()
    rates: Mapping[str, float] = field(default_factory=dict)
    attached: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    states: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    events: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RestartRecord:
    """Record of the restarts of a component, past and pending.

    Attributes:
        ledger: By what the law of restarts judges; its times are of this run of the machine.
        restarts: How often its policy made it again.
        why: For which end it was the last time.
        took_s: How long that took [s].
        pending: For which end it is to be restarted; empty when it is not.
        given_up: Why it is restarted no more.
        is_in_error: It is, and that was answered.
        rested: Which rule it broke for which it was deactivated.
        halted: For which loss everything was deactivated, since it is critical.
    """

    ledger: Ledger = field(default_factory=Ledger)
    restarts: int = 0
    why: str = ""
    took_s: float = 0.0
    pending: str = ""
    given_up: str = ""
    is_in_error: bool = False
    rested: str = ""
    halted: str = ""

    @property
    def record(self) -> RestartRecord:
        """Return what remains of the record once all failures are forgiven."""
        return RestartRecord(restarts=self.restarts, why=self.why, took_s=self.took_s)

    @property
    def is_in_hand(self) -> bool:
        """Return whether a restart is pending, or was given up."""
        return bool(self.pending or self.given_up)

    @property
    def due_s(self) -> float:
        """Return when the restart is due, monotonic [s]; 0 without one."""
        return self.ledger.times[-1] if self.pending and self.ledger.times else 0.0

    def told(self, degraded: str) -> RestartStatus:
        """Return the restart status, with the rule of health that it breaks."""
        return RestartStatus(
            self.restarts,
            self.why,
            self.took_s,
            self.pending,
            self.given_up,
            degraded,
            self.rested,
            self.halted,
            self.due_s,
        )


class DesiredState:
    """All desired rows, in their order of arrival, and which of them are not stored yet.

    Attributes:
        begun: What of the manager's own start was done, as ``KEY: ITEM``.
        zombies: Components whose end is for their user to see, as they were.
        watched: What has been done about the ends of components, by instance.
        revived: Components that are just being restarted: they are not newly desired.
        boot: Which run of the machine this is; kept along with the rest.
        answered: What batches came to that changed anything, the last ones, by id.
        followed: By what systems are followed whose events lead them, as text, by name.
        reached: What became of each of them.
    """

    def __init__(self) -> None:
        self.components: dict[str, DesiredComponent] = {}
        self.wires: dict[str, ConnectorProfile] = {}
        self.modules: dict[str, str] = {}
        self.settings: dict[str, str] = {}
        self.begun: dict[str, str] = {}
        self.zombies: dict[str, ComponentFacts] = {}
        self.watched: dict[str, RestartRecord] = {}
        self.revived: set[str] = set()
        self.boot: dict[str, str] = {}
        self.answered: dict[str, str] = {}
        self.followed: dict[str, str] = {}
        self.reached: dict[str, Followed] = {}
        self._changed: dict[tuple[str, str], None] = {}
        self._stored: set[tuple[str, str]] = set()

    @property
    def has_changed(self) -> bool:
        """Return whether there is something to store."""
        return bool(self._changed)

    def is_stored(self, kind: str, name: str) -> bool:
        """Return whether there is a row of that name on the disk, perhaps with another value."""
        return (kind, name) in self._stored

    @property
    def is_urgent(self) -> bool:
        """Return whether something is to be stored that cannot wait until nothing is under way."""
        return any(kind in _URGENT for kind, _ in self._changed)

    def changes(self, *, is_urgent: bool = False) -> tuple[Row, ...]:
        """Return the rows that have changed, or of them the urgent ones.

        They are taken for kept from now on.
        """
        changed = {key: None for key in self._changed if key[0] in _URGENT or not is_urgent}
        for key in changed:
            del self._changed[key]
        if self.boot and not self.is_stored(BOOT, "id"):
            changed[BOOT, "id"] = None
        return tuple((kind, name, self._text(kind, name)) for kind, name in changed)

    def is_kept(self, rows: Iterable[Row]) -> None:
        """Note that rows are on the disk."""
        for kind, name, text in rows:
            (self._stored.discard if text is None else self._stored.add)((kind, name))

    def not_kept(self, rows: Iterable[Row]) -> None:
        """Have rows kept with the next ones, since it failed this time."""
        self._changed = {**{(kind, name): None for kind, name, _ in rows}, **self._changed}

    def keep_all(self) -> None:
        """Have all rows kept again, since nothing is on the disk any more."""
        self._changed.update({(kind, name): None for kind in _TABLES for name in self._table(kind)})

    def read(self, rows: Iterable[Row]) -> list[str]:
        """Take in what was stored; return what cannot be read, one line each."""
        bad = []
        for kind, name, text in rows:
            self._stored.add((kind, name))
            try:
                self._table(kind)[name] = _READ[kind](json.loads(text or ""))
            except (ValueError, LookupError, TypeError) as error:
                bad.append(f"{kind} {name}: {error}")
        return bad

    def begin_life(self, boot: str) -> bool:
        """Note which run of the machine this is; return whether all was kept in the same one."""
        before = self.boot.get("id", boot)
        self.boot["id"] = boot
        if before != boot:
            self._changed[BOOT, "id"] = None
        return before == boot

    def clear(self) -> None:
        """Clear the desired state."""
        for kind in _TABLES:
            for name in list(self._table(kind)):
                self.drop(kind, name)

    def _table(self, kind: str) -> dict[str, Any]:
        table: dict[str, Any] = getattr(self, _TABLES[kind])
        return table

    def _text(self, kind: str, name: str) -> str | None:
        value = self._table(kind).get(name)
        if value is None:
            return None
        return json.dumps(value if isinstance(value, str) else encode(value), separators=(",", ":"))

    def put(self, kind: str, name: str, value: object) -> None:
        """Put a row under its name."""
        table = self._table(kind)
        if table.get(name) != value:
            table[name] = value
            self._changed[kind, name] = None

    def drop(self, kind: str, name: str) -> None:
        """Remove a row."""
        if self._table(kind).pop(name, None) is not None:
            self._changed[kind, name] = None

    # components

    def made(self, instance: str, create: str, names: tuple[str, ...], pattern: object) -> None:
        """Record a component that was made; a restarted one keeps its desired state."""
        self.drop(ZOMBIE, instance)
        if instance in self.revived and instance in self.components:
            return
        self.forget(instance)
        text = "" if pattern is None else json.dumps(encode(pattern), separators=(",", ":"))
        self.put(COMPONENT, instance, DesiredComponent(create, names, text))

    def adopt(self, facts: ComponentFacts, asked: DesiredComponent | None = None) -> None:
        """Record as desired what lives and is known from nothing else but user requests to it."""
        if asked is None:
            active = tuple(c.id for c in facts.contexts if c.state is LifeCycleState.ACTIVE)
            asked = DesiredComponent("", (), "", facts.sets, facts.active_set, active)
        self.put(COMPONENT, facts.instance, replace(asked, create=facts.create, names=facts.names))

    def forget(self, instance: str) -> None:
        """Remove a component from the desired state, and what depends on it."""
        self.drop(COMPONENT, instance)
        self.drop(ZOMBIE, instance)
        self.drop(WATCHED, instance)
        for connector_id, connector in list(self.wires.items()):
            if any(end.instance == instance for end in connector.ports):
                self.drop(WIRE, connector_id)
        # Few drive others: looking into each would make many components cost their square.
        drivers = [(owner, item) for owner, item in self.components.items() if item.attached]
        for owner, item in drivers:
            if any(instance in driven for driven in item.attached.values()):
                left = {c: tuple(p for p in ps if p != instance) for c, ps in item.attached.items()}
                self.change(owner, attached=left)

    def lost(self, facts: ComponentFacts) -> None:
        """Note that a component has died, and that its user is to see it."""
        if facts.instance in self.components:
            self.put(ZOMBIE, facts.instance, facts)

    def found(self, instance: str) -> None:
        """Note that a component lives that was taken for dead."""
        self.drop(ZOMBIE, instance)

    def watch(self, instance: str, **changes: Any) -> None:
        """Note what was done about the ends of a component."""
        self.put(WATCHED, instance, replace(self.watched.get(instance, RestartRecord()), **changes))

    def named(self, instance: str, names: tuple[str, ...]) -> None:
        """Note under which names a component is to be found."""
        self.change(instance, names=names)

    def wire(self, connector: ConnectorProfile) -> None:
        """Add a connector to the desired state."""
        self.put(WIRE, connector.connector_id, connector)

    def begin(self, what: str) -> None:
        """Note that something of the manager's own start was done."""
        self.put(BEGUN, what, "done")

    def set(self, key: str, value: str) -> None:
        """Note a property of the manager that was changed."""
        self.put(SETTING, key, value)

    def change(self, instance: str, **changes: Any) -> None:
        """Change a desired component; one that is not desired stays so."""
        item = self.components.get(instance)
        if item is not None:
            self.put(COMPONENT, instance, replace(item, **changes))


def _word(data: object) -> str:
    if not isinstance(data, str):
        raise Malformed(f"no text: {data!r}")
    return data


_READ: Mapping[str, Callable[[Any], object]] = {
    COMPONENT: lambda data: decode(DesiredComponent, data),
    WIRE: lambda data: decode(ConnectorProfile, data),
    ZOMBIE: lambda data: decode(ComponentFacts, data),
    WATCHED: lambda data: decode(RestartRecord, data),
    MODULE: _word,
    SETTING: _word,
    BEGUN: _word,
    BOOT: _word,
    ANSWERED: _word,
    FOLLOWED: _word,
    REACHED: lambda data: decode(Followed, data),
}


def module_row(path: str, init: str) -> str:
    """Return under which name it is kept that a module is to be loaded."""
    return f"{path}:{init}" if init else path


def module_path(row: str, init: str) -> str:
    """Return the path in such a name."""
    return row.removesuffix(f":{init}") if init else row
