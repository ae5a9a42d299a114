"""Makes records of what managers tell: components, connectors, processes, managers, by their ids.

The id of a component, a process or a manager is its path in the tree. Records are plain data that
go to the page as they are; ``web/src/model/types.ts`` has their types.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.api.observers import place_of
from rtkit.component.configuration.constraint_check import CONSTRAINT_SET, WIDGET_SET
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.deployment.listing import ListingRow, listing_of
from rtkit.profile_tools.system_summary import short_type
from rtkit.rtc.enums import PortType
from rtkit.rtc.far_ends import on_host, split_far
from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX
from rtkit.tree.view import NodeKind, TreeNode

if TYPE_CHECKING:
    from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef

Record = dict[str, Any]
Records = dict[str, Record]

_DIRECTIONS = {PortType.IN: "in", PortType.OUT: "out"}
_GONE = "gone"


class KnownRights(NamedTuple):
    """Rights of the user at a manager that lets users in by their certificates.

    Attributes:
        name: Of the user, there.
        role: See `rtkit.keys.roles`.
    """

    name: str
    role: str


class KnownManager(NamedTuple):
    """A manager as the page is to show it.

    Attributes:
        name: As `Observers.names` has it; with its host where that is another one.
        place: Name of its host in paths.
        is_usual: Paths of its components on this host do not name it.
        facts: As it told them last.
        why: Why it does not answer any more; empty while it does.
        rights: Those of the user there; None at one of the user's own, where all may be done.
    """

    name: str
    place: str
    is_usual: bool
    facts: Snapshot
    why: str = ""
    rights: KnownRights | None = None

    @property
    def id(self) -> str:
        """Return the path of the manager."""
        return f"/{self.place}/{self.facts.manager}{MANAGER_SUFFIX}"

    def path(self, facts: ComponentFacts, hostname: str) -> str:
        """Return the path of a component of it; paths of this host begin with ``/localhost``."""
        return place_of(self.name, facts, hostname, is_usual=self.is_usual, local=self.place)


class SystemRecords(NamedTuple):
    """All that is known at one moment, by ids."""

    managers: Records
    processes: Records
    components: Records
    connectors: Records

    @classmethod
    def nothing(cls) -> SystemRecords:
        """Return what is known before anything is."""
        return cls({}, {}, {}, {})


def records_of(managers: list[KnownManager], hostname: str) -> SystemRecords:
    """Return the records of what some managers hold."""
    found = SystemRecords.nothing()
    paths = {
        (on_host(each.facts.manager, each.facts.host), facts.instance): each.path(facts, hostname)
        for each in managers
        for facts in each.facts.components
    }
    for each in managers:
        _add_manager(found, each, hostname)
        for connector in each.facts.connectors:
            _add_connector(found.connectors, each.facts, connector, paths)
    return found


def _add_manager(found: SystemRecords, manager: KnownManager, hostname: str) -> None:
    facts = manager.facts
    found.managers[manager.id] = {
        "id": manager.id,
        "name": facts.manager,
        "host": facts.host,
        "pid": facts.pid,
        "version": facts.version,
        "state": _GONE if manager.why else "up",
        "why": manager.why,
        "rights": manager.rights and manager.rights._asdict(),
    }
    processes: dict[str, str] = {}
    for process in (*facts.processes, *_ended(facts)):
        is_own = process.pid == facts.pid
        id = manager.id if is_own else f"{manager.id}/{process.name}{MANAGER_SUFFIX}"
        processes[process.name] = id
        found.processes[id] = _process(process, id, manager)
    rows = {row.instance: row for row in listing_of(facts).rows}
    ids = {each.instance: manager.path(each, hostname) for each in facts.components}
    for each in facts.components:
        record = _component(each, rows[each.instance], is_reached=not manager.why)
        record |= {
            "id": ids[each.instance],
            "manager": manager.id,
            "process": processes.get(each.process, manager.id),
            "composite": ids.get(each.composite, ""),
            "members": [ids[name] for name in each.members if name in ids],
            "is_composite": bool(each.composite_type),
        }
        for context in record["contexts"]:
            context["owner"] = ids.get(context["owner"], context["owner"])
            context["participants"] = [ids.get(name, name) for name in context["participants"]]
        found.components[ids[each.instance]] = record


def _ended(facts: Snapshot) -> Iterable[ProcessFacts]:
    """Return the processes of zombies that ended before this manager began: they have no pid."""
    known = {each.name for each in facts.processes}
    ended = {each.process: each.zombie for each in facts.components if each.process not in known}
    return (ProcessFacts(name, True, 0, "lost", why) for name, why in ended.items() if why)


def _process(process: ProcessFacts, id: str, manager: KnownManager) -> Record:
    return {
        "id": id,
        "name": process.name,
        "manager": manager.id,
        "pid": process.pid,
        "state": "lost" if manager.why else process.state,
        "why": manager.why or process.reason,
        "is_slave": process.is_slave,
    }


def _component(facts: ComponentFacts, row: ListingRow, *, is_reached: bool) -> Record:
    kind = NodeKind.ZOMBIE if facts.zombie else NodeKind.COMPONENT
    remark = TreeNode(facts.instance, kind, row).remark
    look = _look(facts, row) if is_reached else "unreachable"
    hidden = {name: facts.sets.get(name, {}) for name in (WIDGET_SET, CONSTRAINT_SET)}
    return {
        "name": facts.instance,
        "type": facts.type.type_name,
        "type_id": facts.type.id,
        "description": facts.type.description,
        "state": facts.state,
        "look": look,
        "word": look if look in ("zombie", "unreachable", "restarting") else facts.state,
        "remark": remark if is_reached else "the manager does not answer",
        "since": facts.since,
        "contexts": [
            {
                "id": each.id,
                "kind": str(each.kind),
                "rate_hz": each.rate,
                "is_running": each.is_running,
                "state": str(each.state),
                "owner": each.owner,
                "participants": list(each.participants),
                "missed": each.missed,
                "trouble": each.trouble,
            }
            for each in facts.contexts
        ],
        "ports": [port_record(each) for each in facts.ports],
        "active_set": facts.active_set,
        "sets": {name: dict(values) for name, values in facts.sets.items()},
        "widgets": dict(hidden[WIDGET_SET]),
        "constraints": dict(hidden[CONSTRAINT_SET]),
        "properties": dict(facts.properties),
    }


def _look(facts: ComponentFacts, row: ListingRow) -> str:
    """Return which of the looks of `docs/design.md` a component has."""
    if facts.zombie:
        return "restarting" if row.coming(monotonic()) else "zombie"
    return "stuck" if facts.trouble else facts.state.lower()


def port_record(port: PortProfile) -> Record:
    """Return the record of a port."""
    return {
        "name": port.name,
        "direction": _DIRECTIONS.get(port.port_type, "service"),
        "type": short_type(port.data_type),
        "interfaces": [
            {
                "instance": each.instance_name,
                "type": each.type_name,
                "polarity": str(each.polarity),
            }
            for each in port.interfaces
        ],
    }


def _add_connector(
    connectors: Records,
    facts: Snapshot,
    connector: ConnectorProfile,
    paths: Mapping[tuple[str, str], str],
) -> None:
    """Add a connector; of one between managers both tell, and each may know only of a half."""
    if len(connector.ports) < 2:
        return
    known = connectors.get(connector.connector_id)
    trouble = connector.trouble or (known["trouble"] if known else "")
    source, target = (_end(facts, end, paths) for end in connector.ports[:2])
    connectors[connector.connector_id] = {
        "id": connector.connector_id,
        "name": connector.name,
        "source": source,
        "target": target,
        "properties": dict(connector.properties),
        "trouble": trouble,
    }


def _end(facts: Snapshot, end: PortRef, paths: Mapping[tuple[str, str], str]) -> Record:
    far, instance = split_far(end.instance)
    manager = far if "/" in far else on_host(far or facts.manager, facts.host)
    host, _, name = manager.partition("/")
    unseen = f"/{host}/{name}{MANAGER_SUFFIX}/{instance}{COMPONENT_SUFFIX}"
    return {"component": paths.get((manager, instance), unseen), "port": end.port}


class Change(NamedTuple):
    """Difference of two moments: whole records that are new or changed, and the ids that went."""

    fresh: SystemRecords
    gone: dict[str, list[str]]

    def __bool__(self) -> bool:
        return any(self.fresh) or any(self.gone.values())


def change_between(before: SystemRecords, after: SystemRecords) -> Change:
    """Return what changed from one moment to another."""
    fresh = SystemRecords.nothing()
    gone = {}
    for name, old, new, kept in zip(before._fields, before, after, fresh, strict=True):
        kept.update({id: each for id, each in new.items() if old.get(id) != each})
        gone[name] = [id for id in old if id not in new]
    return Change(fresh, gone)
