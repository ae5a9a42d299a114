"""Chooses hosts for the components of a system profile by what they require."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api.system_profiles import BUNDLE
from rtkit.closing import Closing
from rtkit.deployment.described import properties_of, type_of
from rtkit.deployment.extension import CREATE, MODULE, PLACE_HOSTS, STAND_IN
from rtkit.errors import Impossible, Refused, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.rtc.create import readable_create
from rtkit.rtc.names import LOCAL

if TYPE_CHECKING:
    from rtkit.api.candidates import LookedAt
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.deployment.placement.choice import PlaceCandidate, PlacedComponent, PlacementProblem
    from rtkit.deployment.placement.requirements import Requirements
    from rtkit.profile.rts_model import ComponentInstance, DataPortConnector, ServicePortConnector

    Wire = DataPortConnector | ServicePortConnector


class PlacedProfile(NamedTuple):
    """A profile whose components have places.

    Attributes:
        lacks: By component that is not required, why there is no place for it.
        moving: The places that components are to leave, by component.
    """

    document: SystemProfile
    lacks: Mapping[str, str] = {}
    moving: Mapping[str, str] = {}


def placed(session: Session, document: SystemProfile, *, stand_in: bool = False) -> PlacedProfile:
    """Return a profile with the cheapest places that meet the requirements of its components.

    A `stand_in` needs no code, so it may be anywhere.

    Raises:
        InvalidDocument: Requirements make no sense.
        Impossible: Required components have no place; names a minimal set of reasons.
        Unreachable: A component may live on a host that cannot be reached.
        Refused: One is a zombie elsewhere, which might come back there.
    """
    from rtkit.deployment.placement.profiles import has_requirements, with_places

    if not has_requirements(document.profile):
        return PlacedProfile(document)
    from rtkit.deployment.placement.conflict import placed as chosen

    with _placer(session, document, stand_in=stand_in) as placer:
        session.warn(placer.unknown_hosts())
        problem = placer.problem()
        try:
            choice, lacks = chosen(problem)
        except Impossible as error:
            dead = (f"{n.instance} is a zombie on {p} ({n.zombie})" for n, p in placer.zombies())
            raise Impossible("; ".join([str(error), *dead])) from None
        placer.check_zombies(choice.places)
    if choice.gap:
        session.report(f"the places may cost {choice.gap:g} more than the cheapest ones")
    homes = {each.name: each.home for each in problem.components if each.home}
    moving = {n: homes[n] for n, place in choice.places.items() if homes.get(n, place) != place}
    places = {**dict.fromkeys(lacks, LOCAL), **choice.places}
    for name in placer.free:
        session.verbose(f"{name} is placed on {places[name]}")
    profile = with_places(document.profile, places)
    return PlacedProfile(replace(document, profile=profile), lacks, moving)


def unmet(session: Session, document: SystemProfile) -> dict[str, str]:
    """Return what components require that is not so where they live, by component."""
    from rtkit.deployment.placement.profiles import has_requirements

    if not has_requirements(document.profile):
        return {}
    from rtkit.deployment.placement import conflict

    with _placer(session, document, stand_in=True) as placer:
        session.warn(placer.unknown_hosts())
        return conflict.unmet(placer.problem_as_is())


def other_places(
    session: Session, document: SystemProfile, named: Mapping[str, Sequence[str]]
) -> tuple[Mapping[str, str], Mapping[str, str]]:
    """Return places for components whose host is open, and why there is none for some.

    Each has the first of the hosts named for it that meets the requirements; all others stay.
    """
    from rtkit.deployment.placement.elsewhere import elsewhere

    with _placer(session, document, stand_in=False) as placer:
        return elsewhere(placer.problem_among(named), named)


def settled(session: Session, document: SystemProfile) -> SystemProfile:
    """Return a profile whose components are where they live, or may live unseen, else here.

    One that is a zombie, such as one that waits for its device, is where it is to come back.
    """
    from rtkit.deployment.placement.profiles import is_free, with_places

    if not any(map(is_free, document.profile.components)):
        return document
    with _placer(session, document, stand_in=True) as placer:
        homes = placer.homes()
        lost = {name: next(placer.lost_for(name), LOCAL) for name in placer.free}
        dead = {facts.instance: place for facts, place in placer.zombies()}
    places = {**lost, **dead, **homes}
    return replace(document, profile=with_places(document.profile, places))


def _placer(session: Session, document: SystemProfile, *, stand_in: bool) -> _Placer:
    """Return what finds out where components of a profile live and may be; it is to be closed.

    Raises:
        InvalidDocument: Requirements make no sense.
    """
    from rtkit.deployment.placement.profiles import requirements_of

    with document.naming():
        required = requirements_of(document.profile)
    return _Placer(session, document, required, stand_in=stand_in)


class _Placer(Closing):
    """Poses the problem of places for the components of one profile.

    Attributes:
        free: The components whose host is open.
    """

    def __init__(
        self,
        session: Session,
        document: SystemProfile,
        required: Mapping[str, Requirements],
        *,
        stand_in: bool,
    ) -> None:
        from rtkit.api.candidates import Places, stated_place
        from rtkit.deployment.placement.profiles import is_free
        from rtkit.deployment.placement.requirements import NOTHING_REQUIRED

        self._session, self._profile, self._required = session, document.profile, required
        self._is_bundle = document.source.endswith(BUNDLE)
        self._needs_code = not stand_in
        components = document.profile.components
        self.free = [each.instance_name for each in components if is_free(each)]
        devices = sorted({device for each in required.values() for device in each.devices})
        self._places = Places(session, devices, document.mapped)
        hosts = self._places.hosts
        stated = {c.instance_name: stated_place(c, hosts) for c in components}
        self._stated = {**stated, **dict.fromkeys(self.free, "")}
        picky = (name for name, each in required.items() if each != NOTHING_REQUIRED)
        self._demanding = {*picky, *self.free}

    def close(self) -> None:
        """End all connections."""
        self._places.close()

    def unknown_hosts(self) -> Iterator[str]:
        """Yield a remark for each host that a requirement names and that is not known."""
        from rtkit.rtc.nearest import did_you_mean

        known = [LOCAL, *self._places.hosts]
        for name, each in self._required.items() if self._session.finds_managers else ():
            for host in (host for host in each.hosts if host not in known):
                hint = did_you_mean(host, known) or f" (rthost add {host} USER@ADDRESS)"
                yield f"{name}: {PLACE_HOSTS}: host {host} is not known, and is left out{hint}"

    def homes(self) -> dict[str, str]:
        """Return where components live that may be there, as far as managers can be asked."""
        self._places.look(self._open_places(), is_remote=False)
        return self._seen_homes()

    def _seen_homes(self) -> dict[str, str]:
        found: dict[str, str] = {}
        for each in self._places.seen.values():
            for facts in each.snapshot.components if each.snapshot is not None else ():
                name = facts.instance
                if not facts.zombie and self._stated.get(name, "?") in ("", each.candidate.place):
                    found.setdefault(name, each.candidate.place)
        return found

    def check_zombies(self, places: Mapping[str, str]) -> None:
        """Have nothing made beside a zombie of its name that is elsewhere.

        Raises:
            Refused: Names it, and the command that ends it.
        """
        for facts, place in self.zombies():
            if places.get(facts.instance, place) != place:
                path = f"/{facts.names[0].replace(LOCAL, place, 1)}" if facts.names else ""
                hint = f"; rtexit {path} or rtdel {path} ends it first" if path else ""
                raise Refused(f"{facts.instance} is a zombie on {place} ({facts.zombie}){hint}")

    def zombies(self) -> Iterator[tuple[ComponentFacts, str]]:
        """Yield the free components that are zombies, with their places."""
        for each in self._places.seen.values():
            for facts in each.snapshot.components if each.snapshot is not None else ():
                if facts.zombie and facts.instance in self.free:
                    yield facts, each.candidate.place

    def _open_places(self) -> list[str]:
        """Return the places where a free component may be, this host first."""
        asked = [self._required[name].hosts for name in self.free]
        known = [LOCAL, *self._places.hosts]
        return [each for each in known if any(not some or each in some for some in asked)]

    def problem(self) -> PlacementProblem:
        """Return the problem; a host without a link is asked only if that may be worth it.

        Raises:
            Unreachable: A free component may live on a host that cannot be reached.
        """
        from rtkit.deployment.placement.choice import choose
        from rtkit.deployment.planning.default_costs import DEFAULT_COSTS

        self._look_at_stated(is_remote=True)
        homes = self.homes()
        self._check_reached(homes)
        problem = self._posed(homes)
        choice, start = choose(problem), DEFAULT_COSTS["start_manager"]
        made = sum(each.making for each in problem.components if not each.home)
        if choice is None or choice.cost - made > start:
            self._places.look(self._open_places(), is_remote=True)
            problem = self._posed(homes)
        return problem

    def _look_at_stated(self, *, is_remote: bool) -> None:
        stated = {self._stated[name] for name in self._demanding} - {""}
        self._places.look(sorted(stated), is_remote=is_remote)

    def problem_as_is(self) -> PlacementProblem:
        """Return the problem with what lives where it is, as far as managers can be asked."""
        self._look_at_stated(is_remote=False)
        return self._posed(self._seen_homes())

    def problem_among(self, named: Mapping[str, Sequence[str]]) -> PlacementProblem:
        """Return the problem with the hosts that are named for components as candidates."""
        self._look_at_stated(is_remote=True)
        self._places.look({host for hosts in named.values() for host in hosts}, is_remote=False)
        return self._posed(self._seen_homes())

    def _check_reached(self, homes: Mapping[str, str]) -> None:
        """Have nothing made a second time: where it may live unseen, it is not placed.

        Raises:
            Unreachable: Names component, host and reason.
        """
        for name in self.free:
            for host in self.lost_for(name) if name not in homes else ():
                why = self._places.seen[host].candidate.why_not
                hint = f"rtmgr stop --host {host} gives it up"
                raise Unreachable(f"{name} may live on {host}: {why} ({hint})")

    def lost_for(self, name: str) -> Iterator[str]:
        """Yield the hosts that cannot be reached on which a component may live."""
        hosts = self._required[name].hosts
        for place, each in self._places.seen.items():
            if each.is_lost and (not hosts or place in hosts):
                yield place

    def _posed(self, homes: Mapping[str, str]) -> PlacementProblem:
        from rtkit.deployment.placement.choice import PlaceCandidate, PlacementProblem

        seen = self._places.seen
        order = [LOCAL, *self._places.hosts, *sorted({*self._stated.values()} - {""})]
        candidates = [
            self._candidate(seen[place]) if place in seen else PlaceCandidate(place)
            for place in dict.fromkeys(order)
            if place in seen or place in self._stated.values()
        ]
        wires: list[Wire] = [*self._profile.data_port_connectors]
        wires += self._profile.service_port_connectors
        return PlacementProblem(
            tuple(self._component(each, homes, wires) for each in self._profile.components),
            tuple(candidates),
            tuple((each.source.instance_name, each.target.instance_name) for each in wires),
        )

    def _component(
        self, component: ComponentInstance, homes: Mapping[str, str], wires: Sequence[Wire]
    ) -> PlacedComponent:
        """Return a component; one that requires nothing, or is out of sight, counts as there."""
        from rtkit.deployment.placement.choice import PlacedComponent
        from rtkit.deployment.placement.requirements import NOTHING_REQUIRED
        from rtkit.deployment.planning.default_costs import DEFAULT_COSTS

        name = component.instance_name
        own = properties_of(component.properties)
        is_inproc = not readable_create(own.get(CREATE, "")).place
        steps = ["delete", "deactivate", "activate"]
        for each in wires:
            is_end = name in (each.source.instance_name, each.target.instance_name)
            steps += ["disconnect", "connect"] if is_end else []
        stated, required = self._stated[name], self._required[name]
        is_lost = stated in self._places.seen and self._places.seen[stated].is_lost
        is_demanding = name in self._demanding and not is_lost
        return PlacedComponent(
            name,
            required if is_demanding else NOTHING_REQUIRED,
            stated,
            homes.get(name, "") if is_demanding else stated,
            DEFAULT_COSTS["create" if is_inproc else "create_slave"],
            sum(DEFAULT_COSTS[step] for step in steps),
            component.is_required,
        )

    def _candidate(self, found: LookedAt) -> PlaceCandidate:
        from rtkit.api.candidates import lacking
        from rtkit.deployment.planning.default_costs import DEFAULT_COSTS

        candidate, lacks = found.candidate, lacking(self._session, found, self._makings)
        start = {}
        if found.tree is None:
            start = {f"mgr:{candidate.place}": DEFAULT_COSTS["start_manager"]}
            if candidate.host != LOCAL:
                lacks = dict.fromkeys(self._packaged, "")
        extras = {name: {**start} for name in self._demanding}
        for name in lacks.keys() & self._packaged.keys():
            extras[name][f"pkg:{candidate.host}/{self._packaged[name]}"] = DEFAULT_COSTS["install"]
            del lacks[name]
        return replace(candidate, lacks=lacks, extras=extras)

    @cached_property
    def _makings(self) -> dict[str, tuple[str, str]]:
        """Module and create string of the components to be placed that need code."""
        found = {}
        for each in self._profile.components if self._needs_code else ():
            own = properties_of(each.properties)
            if each.instance_name in self._demanding and STAND_IN not in own:
                create = own.get(CREATE, "").partition("?")[0]
                module = own.get(MODULE, "") if create else ""
                found[each.instance_name] = (module, create or type_of(each.id).full_id)
        return found

    @cached_property
    def _packaged(self) -> dict[str, str]:
        """The types of components that a package offers, or may offer, by component."""
        from rtkit.packages.precheck import is_built_in, known_repositories

        named = {each.instance_name: each for each in self._profile.components}
        coded = [named[name] for name in self._makings if not is_built_in(named[name])]
        types = {each.instance_name: type_of(each.id).id for each in coded}
        may_be_any = self._is_bundle or bool(known_repositories())
        if not types or may_be_any:
            return types
        from rtkit.packages.offering import offerings

        here = offerings({*types.values()})
        return {name: id for name, id in types.items() if id in here}
