"""Moves a component to another slave or manager: what is wanted then, and what it was before.

See decision 73.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.deployment import actions as act
from rtkit.deployment import extension
from rtkit.deployment.actions import Action
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.multi_manager import JointSnapshot, inward, outward
from rtkit.deployment.system import WantedSystem
from rtkit.deployment.wanted import wanted
from rtkit.errors import Refused
from rtkit.fast_dataclass import dataclass, field, fields, replace
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.connector_properties import DATAFLOW_TYPE
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, PortType, Transition
from rtkit.rtc.far_ends import split_far
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX, split_manager
from rtkit.rtc.profiles import ConnectorProfile

_DRAIN_S = 2.0
"""How long a component may take to read what has arrived before it ends [s]."""
_HEADING = SystemHeading("1970-01-01T00:00:00", "move")


@dataclass(frozen=True, slots=True)
class MoveRecord:
    """A move that has begun: where a component goes, and all that it is to have there.

    Attributes:
        source: Facts of the manager that it leaves, about this component only.
        connectors: Its connections, with the plain names of both ends.
        manager: Manager that it goes to.
        slave: Slave there; empty for the manager's own process.
        managers: All that have to do with it; the first one's names are shown without its own.
        homes: Managers of the components at the other ends, by instance name.
        host: The host on which the move is planned.
    """

    source: Snapshot
    connectors: tuple[ConnectorProfile, ...]
    manager: str
    slave: str = ""
    managers: tuple[str, ...] = ()
    homes: Mapping[str, str] = field(default_factory=dict)
    host: str = ""

    @property
    def facts(self) -> ComponentFacts:
        """Return the component as it was, in the words of its manager."""
        return self.source.components[0]

    @property
    def place(self) -> str:
        """Return where it goes, as users know it."""
        slave = f"/{self.slave}{MANAGER_SUFFIX}" if self.slave else ""
        return place_text(self.manager) + slave

    def shown_at(self, manager: str) -> tuple[str, ...]:
        """Return the names of the component at one of its managers, as all of them see it."""
        facts = self.facts
        names = facts.names or (f"localhost/{facts.instance}.rtc",)
        if manager == self.managers[0]:
            return tuple(names)
        return tuple(outward(name, manager) for name in names)


def place_text(manager: str) -> str:
    """Return the path of a manager that is called as in plans."""
    name, host = split_manager(manager)
    return f"/{host or LOCAL}/{name}{MANAGER_SUFFIX}"


def record_of(
    whole: Snapshot, instance: str, source: str, target: tuple[str, str], homes: Mapping[str, str]
) -> MoveRecord:
    """Return the record of a move that begins now.

    Args:
        whole: Facts of all managers that have to do with it.
        instance: The component.
        source: Manager that it lives in.
        target: Manager and slave that it is to go to.
        homes: Managers of the components that it is connected with.

    Raises:
        Refused: It cannot be moved; says why.
    """
    known = {each.manager: each for each in (whole, *whole.others)}
    facts = whole.component(instance)
    why = "it is not there any more"
    if facts is not None:
        why = next(obstacles(facts, known[source]), "")
    if why or facts is None:
        raise Refused(f"{instance} cannot be moved: {why}")
    own = {each.name: getattr(known[source], each.name) for each in fields(Snapshot)}
    names = tuple(inward(name, source) for name in facts.names)
    own.update(components=(replace(facts, names=names),), connectors=(), systems=())
    connectors = tuple(
        each for each in whole.connectors if any(end.instance == instance for end in each.ports)
    )
    return MoveRecord(Snapshot(**own), connectors, *target, tuple(known), homes, whole.host)


def obstacles(facts: ComponentFacts, manager: Snapshot) -> Iterator[str]:
    """Yield why a component cannot be moved."""
    if facts.zombie:
        yield f"it is dead ({facts.zombie})"
    if facts.trouble:
        yield f"it does not answer ({facts.trouble})"
    if not facts.create:
        yield "nothing tells how it was made"
    if any(each.is_guest and each.name == facts.process for each in manager.processes):
        yield f"its user has started it in {facts.process}"
    if facts.composite_type or facts.composite:
        yield f"it is {'composed of others' if facts.composite_type else 'part of a composite'}"
    states = {context.state for context in facts.contexts if context.owner == facts.instance}
    if any(context.owner not in ("", facts.instance) for context in facts.contexts):
        yield "an execution context of another component drives it"
    if any({*context.participants} - {facts.instance} for context in facts.contexts):
        yield "its execution contexts drive other components"
    if LifeCycleState.ERROR in states:
        yield "it is in Error (rtreset comes first)"
    elif len(states) > 1:
        yield "it is Active in some of its execution contexts only"


def ends_elsewhere(facts: Snapshot, instance: str) -> dict[str, str]:
    """Return the components that one is connected with in other managers, and these.

    Raises:
        Refused: Two of them bear one name, or a connection is only half there.
    """
    homes: dict[str, str] = {}
    for connector in facts.connectors:
        if all(end.instance != instance for end in connector.ports):
            continue
        if connector.trouble:
            raise Refused(
                f"{instance} cannot be moved: only half of connection {connector.connector_id} is"
                f" there: {connector.trouble} (rtdis removes it)"
            )
        for end in connector.ports:
            manager, name = split_far(end.instance)
            if homes.setdefault(name, manager or facts.manager) != (manager or facts.manager):
                raise Refused(
                    f"{instance} cannot be moved: it is connected with a {name} in"
                    f" {homes[name]} and one in {manager or facts.manager}"
                )
    homes.pop(instance, None)
    return homes


def wanted_move(record: MoveRecord) -> WantedSystem:
    """Return the system of one component that a move leads to."""
    facts = record.facts
    (captured,) = capture(record.source, _HEADING, takes_all=True).components
    path, *more = record.shown_at(record.manager)
    stated = {each.name: each.value or "" for each in captured.properties}
    create = parse_create(stated[extension.CREATE]).with_options(manager_name=record.slave)
    stated[extension.CREATE] = str(create)
    properties = tuple(ExtensionProperty(name, value) for name, value in stated.items())
    profile = replace(
        capture(replace(record.source, components=()), _HEADING),
        components=(replace(captured, path_uri=path, properties=properties),),
    )
    stand_ins = (facts.instance,) if facts.is_stand_in else ()
    host = record.host or record.source.host
    system = wanted(profile, host, stand_ins=stand_ins, managers=record.managers[1:])
    moving = replace(system.components[0], may_move=True, more_names=tuple(more))
    return replace(system, components=(moving,))


def holding_steps(record: MoveRecord) -> tuple[tuple[Action, ...], ...]:
    """Return what comes before the plan of a move, so that no value on the way is lost.

    The ports of others keep values for the component, it reads all that have arrived, then the
    values arrive that it wrote itself.
    """
    facts = record.facts
    name = facts.instance
    pushed = [
        each
        for each in record.connectors
        if each.properties.get("port.port_type") != PortType.SERVICE.value
        and each.properties.get(DATAFLOW_TYPE, "push") != "pull"
    ]
    rest = tuple(
        act.ChangeState(name, context.id, Transition.DEACTIVATE, drains_s=_DRAIN_S)
        for context in facts.contexts
        if context.owner == name and context.state == LifeCycleState.ACTIVE
    )
    into, out = (
        tuple(
            act.Disconnect(each.connector_id, holds=True)
            for each in pushed
            if each.ports[end].instance == name and each.ports[1 - end].instance != name
        )
        for end in (1, 0)
    )
    return into, rest, out


def move_goal(record: MoveRecord) -> DeploymentGoal:
    """Return the goal that the component is where it goes, and otherwise as it was."""
    is_up = record.facts.state == LifeCycleState.ACTIVE
    state = LifeCycleState.ACTIVE if is_up else LifeCycleState.INACTIVE
    return DeploymentGoal(wanted_move(record), state)


def before(now: Snapshot, record: MoveRecord) -> Snapshot:
    """Return what lived before a move: what lives now, and the component where it was."""
    name, source = record.facts.instance, record.source.manager
    facts = replace(record.facts, names=record.shown_at(source))
    ids = {each.connector_id for each in record.connectors}

    def without(components: tuple[ComponentFacts, ...]) -> tuple[ComponentFacts, ...]:
        return tuple(each for each in components if each.instance != name)

    others = tuple(
        replace(
            each,
            components=(*without(each.components), *((facts,) if each.manager == source else ())),
        )
        for each in now.others
    )
    values = {each.name: getattr(now, each.name) for each in fields(Snapshot)}
    values["components"] = (*without(now.components), facts)
    left = (each for each in now.connectors if each.connector_id not in ids)
    values["connectors"] = (*left, *record.connectors)
    return JointSnapshot(**values, others=others) if others else Snapshot(**values)
