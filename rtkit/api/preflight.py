"""Checks a system before it is created: what its components are like, what the host reserves."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from rtkit.api.looking import on_this_host, present_code
from rtkit.deployment.extension import LIMIT
from rtkit.errors import Impossible, NotFound, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.rtc.create import parse_create
from rtkit.rtc.names import split_manager

NOTHING: Mapping[str, str] = {}

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.planning.feasibility import Feasibility, Making
    from rtkit.deployment.system import WantedComponent, WantedSystem
    from rtkit.rtc.profiles import PortProfile
    from rtkit.static_check.blueprint import Blueprint


def look_ahead(
    session: Session,
    system: WantedSystem,
    snapshot: Snapshot,
    *,
    installs: Collection[str] = (),
    lacks: Mapping[str, str] = NOTHING,
) -> Feasibility:
    """Return the known facts of components that do not live as wanted; no code is run.

    Args:
        session: Whose manager is asked.
        system: The wanted system.
        snapshot: What lives.
        installs: Components whose packages are installed first.
        lacks: Why others cannot be made, where that is known already.

    Raises:
        Unreachable: The manager does not answer.
    """
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.planning.feasibility import Feasibility, makings

    live = LiveIndex(snapshot, system)
    asked = makings(system, live)
    here = {name: making for name, making in asked.items() if name not in installs}
    lacks = _lacking(session, here, live) | {n: why for n, why in lacks.items() if n in asked}
    pending = [system.component(name) for name in asked if name not in lacks]
    types = _described(session, {each.instance: each.id for each in pending if _is_compared(each)})
    parameters = {
        name: {key: each.declared for key, each in known.parameters.items()}
        for name, known in types.items()
    }
    ports = _ports(system, live, pending, types)
    code = present_code(on_this_host(snapshot))
    return Feasibility(lacks, ports, parameters, frozenset(types), code)


def _is_compared(component: WantedComponent) -> bool:
    """Return whether sets or ports are to be compared; those of a composite show once it lives."""
    is_composite = (
        "members" in parse_create(component.create).options if component.create else False
    )
    return bool(component.sets or component.ports) and not is_composite


def missing(session: Session, system: WantedSystem, snapshot: Snapshot) -> dict[str, str]:
    """Return the reasons why missing components cannot be created, by component name.

    Raises:
        Unreachable: The manager does not answer.
    """
    from rtkit.deployment.live_index import LiveIndex

    live = LiveIndex(snapshot, system)
    absent = {each.instance for each in system.components if live.at(each.instance) is None}
    if not absent:
        return {}
    from rtkit.deployment.planning.feasibility import makings

    asked = makings(system, live)
    return _lacking(session, {name: asked[name] for name in asked if name in absent}, live)


def _lacking(session: Session, asked: Mapping[str, Making], live: LiveIndex) -> dict[str, str]:
    found: dict[str, str] = {}
    for manager, known in live.managers.items():
        mine = {name: making for name, making in asked.items() if live.destination(name) == manager}
        if mine and known.pid:
            found.update(_lacking_at(session, manager, mine))
    return found


def _lacking_at(session: Session, manager: str, asked: Mapping[str, Making]) -> dict[str, str]:
    distinct = sorted(set(asked.values()))
    try:
        found = dict(zip(distinct, session.tree.at(manager).lacking(distinct), strict=True))
    except NotFound as error:
        session.verbose(f"which modules are found is not known: {error}")
        return {}
    return {name: found[making] for name, making in asked.items() if found[making]}


def _ports(
    system: WantedSystem,
    live: LiveIndex,
    pending: Collection[WantedComponent],
    types: Mapping[str, Blueprint],
) -> dict[str, tuple[PortProfile, ...]]:
    """Return the ports that components will have, of those that are to be connected.

    A living component of the same type shows them, else an RTC profile of the type says them.
    """
    ends = {end.instance for connector in system.connectors for end in connector.profile.ports}
    alive = {c.type.id: c.ports for c in live.snapshot.components if not c.zombie}
    found = {}
    for component in pending:
        name = component.instance
        if name in ends and component.id in alive:
            found[name] = alive[component.id]
        elif name in ends and name in types:
            found[name] = _ports_of(types[name])
    return found


def _described(session: Session, wanted: Mapping[str, str]) -> dict[str, Blueprint]:
    """Return the RTC profiles of the types of components, where a profile is of just that type."""
    if not wanted:
        return {}
    from rtkit.api.component_profiles import profiles
    from rtkit.deployment.described import type_of
    from rtkit.static_check.stock import CandidateDocument, stocked

    names = {type_of(id).type_name for id in wanted.values()}
    catalogue, _ = stocked(
        (CandidateDocument(*each) for each in profiles((), session.verbose)), names
    )
    found = {}
    for name, id in wanted.items():
        match = catalogue.find(id)
        if match is not None and not match.is_other_version and not match.others:
            found[name] = match.blueprint
    return found


def _ports_of(blueprint: Blueprint) -> tuple[PortProfile, ...]:
    """Return ports by type alone: their other properties show when they live."""
    from rtkit.rtc.enums import PortType
    from rtkit.rtc.profiles import PortProfile

    data = [
        PortProfile(name, each.kind, {"dataport.data_type": each.data_type})
        for name, ports in blueprint.data_ports.items()
        for each in ports[:1]
        if len(ports) == 1
    ]
    service = [
        PortProfile(name, PortType.SERVICE, interfaces=interfaces)
        for name, interfaces in blueprint.service_ports.items()
    ]
    return (*data, *service)


def check_reserved(session: Session, system: WantedSystem, snapshot: Snapshot) -> None:
    """Check that this host has what components may use together, those of other managers too.

    Raises:
        Impossible: It has not; tells the numbers.
    """
    # What another host has is known there.
    here = tuple(c for c in system.components if not split_manager(c.manager)[1])
    system = replace(system, components=here)
    policies = (component.policy or {} for component in here)
    if not any(key.startswith(LIMIT) for policy in policies for key in policy):
        return
    from rtkit.deployment.limits import overbooked, reserved
    from rtkit.manager.limits.control_groups import capacity

    managers = {each.manager for each in (snapshot, *snapshot.others)}
    elsewhere = _elsewhere(session, managers) if session.finds_managers else {}
    why = overbooked(reserved(system, snapshot.components, elsewhere), capacity())
    if why:
        raise Impossible(why)


def _elsewhere(
    session: Session, managers: Collection[str]
) -> dict[str, tuple[ComponentFacts, ...]]:
    """Return the components of the other managers of this host, by manager."""
    from rtkit.api.gathering import snapshots

    found = {}
    for name, snapshot in snapshots(session, managers):
        if isinstance(snapshot, RtkitError):
            session.verbose(f"what manager {name} has reserved is not known: {snapshot}")
        else:
            found[name] = snapshot.components
    return found
