"""Desired state: everything that was acknowledged, as rows for the store.

Facts are reports of processes; desired state is what users asked for. A component that died is no
fact any more and is still desired; a component that a user ended is neither. The last request to a
process is desired, recorded or not; a desire without a request since a component was made is still
to be fulfilled.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from rtkit.deployment.facts import ComponentFacts, Followed, RestartStatus
from rtkit.deployment.supervision import Ledger
from rtkit.fast_dataclass import Record, field, replace
from rtkit.manager.core.events import Row
from rtkit.manager.core.indexed_table import IndexedTable
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.far_ends import host_of, peer_of
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode, encode

_URGENT = ("zombie", "watched")
"""Kinds of rows on ends, which are kept though something that answers them is under way."""


class DesiredComponent(Record):
    """Component that shall exist.

    Attributes:
        create: Create string that makes it, with its instance name and its slave.
        pattern: Of a stand-in, as JSON.
        sets: Values set by users: set name to parameter name to text.
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


class RestartRecord(Record):
    """Record of the restarts of a component, past and pending.

    Attributes:
        ledger: By what the law of restarts judges; its times are of this run of the machine.
        restarts: How often its policy made it again.
        why: For which end it was the last time.
        took_s: How long that took [s].
        pending: For which end it is to be restarted; empty when it is not.
        given_up: Why it is restarted no more.
        is_in_error: It is, and that was answered.
        rested: Rule for whose breach it was deactivated.
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

    def restart_status(self, degraded: str) -> RestartStatus:
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


class _Kind(NamedTuple):
    """A kind of rows: the attribute that holds them, and what each is."""

    table: str
    row: type


_KINDS: Mapping[str, _Kind] = {
    "component": _Kind("components", DesiredComponent),
    "wire": _Kind("wires", ConnectorProfile),
    "module": _Kind("modules", str),
    "setting": _Kind("settings", str),
    "begun": _Kind("begun", str),
    "zombie": _Kind("zombies", ComponentFacts),
    "watched": _Kind("watched", RestartRecord),
    "boot": _Kind("boot", str),
    "life": _Kind("life", str),
    "half": _Kind("halves", tuple[str, str]),
    "answered": _Kind("answered", str),
    "followed": _Kind("followed", str),
    "reached": _Kind("reached", Followed),
    "host": _Kind("hosts", str),
    "gone": _Kind("gone", tuple[str, str, str]),
    "fence": _Kind("fences", tuple[str, str, str]),
}


def _driven(component: DesiredComponent) -> Iterator[str]:
    return (each for driven in component.attached.values() for each in driven)


def _ends(connector: ConnectorProfile) -> Iterator[str]:
    return (end.instance for end in connector.ports)


class DesiredState:
    """All desired rows, in their order of arrival, and which of them are not stored yet.

    Attributes:
        begun: Steps of the manager's own start that were done, as ``KEY: ITEM``.
        zombies: Components whose end is for their user to see, as they were.
        watched: Record of the reactions to ends of components, by instance.
        revived: Components that are just being restarted: they are not newly desired.
        boot, life: Identity of this run of the machine, and the unique name of this store.
        halves: Of connectors to other managers, by id: which making each comes from, and with which
            store of its peer it was made.
        far: Ids of those connectors, by peer.
        untold: Of which ones a peer is to hear, by peer: they have changed, or are no more; with
            the making that the last one of that id came from.
        answered: Results of the last batches that changed anything, by id.
        followed: By what systems are followed whose events lead them, as text, by name.
        reached, hosts: The state of each of them; other hosts to be linked, by name, as JSON.
        gone: Removed connectors of which a manager of another host has not heard yet, as (peer,
            connector, making), also over restarts.
        fences: Components that may be moved: since which epoch they are where, and their owner.
    """

    def __init__(self) -> None:
        self.components: IndexedTable[str, DesiredComponent] = IndexedTable(_driven, {})
        self.wires: IndexedTable[str, ConnectorProfile] = IndexedTable(_ends, {})
        self.modules: dict[str, str] = {}
        self.settings: dict[str, str] = {}
        self.begun: dict[str, str] = {}
        self.zombies: dict[str, ComponentFacts] = {}
        self.watched: dict[str, RestartRecord] = {}
        self.revived: set[str] = set()
        self.boot: dict[str, str] = {}
        self.life: dict[str, str] = {}
        self.halves: dict[str, tuple[str, str]] = {}
        self.far: dict[str, dict[str, None]] = {}
        self.untold: dict[str, dict[str, str]] = {}
        self.answered: dict[str, str] = {}
        self.followed: dict[str, str] = {}
        self.reached: dict[str, Followed] = {}
        self.hosts: dict[str, str] = {}
        self.gone: dict[str, tuple[str, str, str]] = {}
        self.fences: dict[str, tuple[str, str, str]] = {}
        self._changed: dict[tuple[str, str], None] = {}
        self._urgent: dict[tuple[str, str], None] = {}
        self._stored: set[tuple[str, str]] = set()

    @property
    def has_changed(self) -> bool:
        """Return whether there is something to store."""
        return bool(self._changed or self._urgent)

    def is_stored(self, kind: str, name: str) -> bool:
        """Return whether there is a row of that name on the disk, perhaps with another value."""
        return (kind, name) in self._stored

    @property
    def is_urgent(self) -> bool:
        """Return whether something is to be stored that cannot wait until nothing is under way."""
        return bool(self._urgent)

    def changes(self, *, is_urgent: bool = False) -> tuple[Row, ...]:
        """Return the rows that have changed, or of them the urgent ones.

        They are taken for kept from now on.
        """
        changed = {**({} if is_urgent else self._changed), **self._urgent}
        self._urgent.clear()
        if not is_urgent:
            self._changed.clear()
        for kind, table in (("boot", self.boot), ("life", self.life)):
            if table and not self.is_stored(kind, "id"):
                changed[kind, "id"] = None
        return tuple((kind, name, self._text(kind, name)) for kind, name in changed)

    def is_kept(self, rows: Iterable[Row]) -> None:
        """Note that rows are on the disk."""
        for kind, name, text in rows:
            (self._stored.discard if text is None else self._stored.add)((kind, name))

    def not_kept(self, rows: Iterable[Row]) -> None:
        """Have rows kept with the next ones, since it failed this time."""
        later, self._changed = self._changed, {}
        for kind, name, _ in rows:
            self._note_change(kind, name)
        self._changed.update(later)

    def keep_all(self) -> None:
        """Have all rows kept again, since nothing is on the disk any more."""
        for kind in _KINDS:
            for name in self._table(kind):
                self._note_change(kind, name)

    def read(self, rows: Iterable[Row]) -> list[str]:
        """Take in what was stored; return what cannot be read, one line each."""
        bad = []
        for kind, name, text in rows:
            self._stored.add((kind, name))
            try:
                value: Any = decode(_KINDS[kind].row, json.loads(text or ""))
                self._table(kind)[name] = value
                if kind == "wire":
                    self._note_far(value)
                elif kind == "gone":
                    self.untell(*value)
            except (ValueError, LookupError, TypeError) as error:
                bad.append(f"{kind} {name}: {error}")
        return bad

    def begin_life(self, boot: str) -> bool:
        """Note which run of the machine this is; return whether all was kept in the same one."""
        before = self.boot.get("id", boot)
        self.boot["id"] = boot
        if before != boot:
            self._note_change("boot", "id")
        return before == boot

    def name_store(self, life: str) -> None:
        """Name a store that has no name yet."""
        if life:
            self.life.setdefault("id", life)

    @property
    def store_name(self) -> str:
        """Return the name of this store."""
        return self.life.get("id", "")

    def making_of(self, connector_id: str) -> str:
        """Return which making a half comes from; empty where that is not known."""
        return self.halves.get(connector_id, ("", ""))[0]

    def untell(self, peer: str, connector_id: str, making: str = "") -> None:
        """Have a peer hear of a connector, whichever making it comes from or came from."""
        self.untold.setdefault(peer, {})[connector_id] = making or self.making_of(connector_id)

    def notified(self, peer: str, connector_id: str) -> None:
        """Note that a peer has heard of a connector."""
        untold = self.untold.get(peer, {})
        untold.pop(connector_id, None)
        if not untold:
            self.untold.pop(peer, None)

    def note_gone_there(self, peer: str, connector_id: str, making: str) -> None:
        """Note that a manager of another host knows that a connector of that id is gone."""
        name = f"{peer} {connector_id}"
        if name in self.gone and making in ("*", self.gone[name][2]):
            self.drop("gone", name)

    def _note_far(self, connector: ConnectorProfile) -> str:
        peer = peer_of(connector)
        if peer:
            self.far.setdefault(peer, {})[connector.connector_id] = None
        return peer

    def _cut_far(self, connector: ConnectorProfile) -> None:
        peer = peer_of(connector)
        connector_id = connector.connector_id
        if peer:
            self.far[peer].pop(connector_id, None)
            if not self.far[peer]:
                del self.far[peer]
            self.untell(peer, connector_id)
            if host_of(peer):
                row = (peer, connector_id, self.making_of(connector_id))
                self.put("gone", f"{peer} {connector_id}", row)
            self.drop("half", connector_id)

    def clear(self) -> None:
        """Clear the desired state."""
        for kind in _KINDS:
            for name in list(self._table(kind)):
                self.drop(kind, name)

    def _table(self, kind: str) -> dict[str, Any]:
        table: dict[str, Any] = getattr(self, _KINDS[kind].table)
        return table

    def _text(self, kind: str, name: str) -> str | None:
        value = self._table(kind).get(name)
        return None if value is None else json.dumps(encode(value), separators=(",", ":"))

    def put(self, kind: str, name: str, value: object) -> None:
        """Put a row under its name."""
        table = self._table(kind)
        if table.get(name) != value:
            table[name] = value
            self._note_change(kind, name)
            if kind == "wire":
                self._note_far(self.wires[name])

    def drop(self, kind: str, name: str) -> None:
        """Remove a row."""
        dropped = self._table(kind).pop(name, None)
        if dropped is not None:
            self._note_change(kind, name)
            if kind == "wire":
                self._cut_far(dropped)

    def _note_change(self, kind: str, name: str) -> None:
        (self._urgent if kind in _URGENT else self._changed)[kind, name] = None

    # components

    def made(self, instance: str, create: str, names: tuple[str, ...], pattern: object) -> None:
        """Record a component that was made; a restarted one keeps its desired state."""
        self.drop("zombie", instance)
        if instance in self.revived and instance in self.components:
            return
        self.forget(instance)
        text = "" if pattern is None else json.dumps(encode(pattern), separators=(",", ":"))
        self.put("component", instance, DesiredComponent(create, names, text))

    def adopt(self, facts: ComponentFacts, asked: DesiredComponent | None = None) -> None:
        """Record as desired what lives and is known from nothing else but user requests to it."""
        if asked is None:
            active = tuple(c.id for c in facts.contexts if c.state is LifeCycleState.ACTIVE)
            asked = DesiredComponent("", (), "", facts.sets, facts.active_set, active)
        asked = replace(asked, create=facts.create, names=facts.names)
        self.put("component", facts.instance, asked)

    def forget(self, instance: str) -> None:
        """Remove a component from the desired state, and what depends on it."""
        self.drop("component", instance)
        self.drop("zombie", instance)
        self.drop("watched", instance)
        for connector_id in list(self.wires.keys_with(instance)):
            self.drop("wire", connector_id)
        for owner in list(self.components.keys_with(instance)):
            attached = self.components[owner].attached
            left = {c: tuple(p for p in ps if p != instance) for c, ps in attached.items()}
            self.change(owner, attached=left)

    def lost(self, facts: ComponentFacts) -> None:
        """Note that a component has died, and that its user is to see it."""
        if facts.instance in self.components:
            self.put("zombie", facts.instance, facts)

    def watch(self, instance: str, **changes: Any) -> None:
        """Note what was done about the ends of a component."""
        before = self.watched.get(instance, RestartRecord())
        self.put("watched", instance, replace(before, **changes))

    def change(self, instance: str, **changes: Any) -> None:
        """Change a desired component; one that is not desired stays so."""
        item = self.components.get(instance)
        if item is not None:
            self.put("component", instance, replace(item, **changes))


def module_row(path: str, init: str) -> str:
    """Return under which name it is kept that a module is to be loaded."""
    return f"{path}:{init}" if init else path


def module_path(row: str, init: str) -> str:
    """Return the path in such a name."""
    return row.removesuffix(f":{init}") if init else row
