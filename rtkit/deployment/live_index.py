"""Looks up in a snapshot what a wanted system names: components by path, contexts, connections."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.deployment.described import is_same_id
from rtkit.deployment.extension import stated_id
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.system import WantedComponent, WantedSystem
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX
from rtkit.rtc.profiles import ConnectorProfile, ExecutionContextProfile, PortRef


class LiveIndex:
    """One snapshot, indexed for questions about one wanted system."""

    def __init__(
        self, snapshot: Snapshot, system: WantedSystem, *, takes_namesakes: bool = False
    ) -> None:
        """Index a snapshot.

        Args:
            snapshot: Facts of the live system.
            system: The wanted system.
            takes_namesakes: A component of the wanted instance name is the wanted one also where
                it is not registered under the wanted name.
        """
        self._takes_namesakes = takes_namesakes
        self.snapshot = snapshot
        self._instances = {c.instance: c for c in snapshot.components}
        self._connectors = {connector.connector_id: connector for connector in snapshot.connectors}
        self._managers = {each.manager: each for each in (snapshot, *snapshot.others)}
        self._lives: dict[str, str] = {}
        self._belongs: dict[str, str] = {}
        self._moving = {c.instance for c in system.components if c.may_move}
        if snapshot.others:
            from rtkit.deployment.multi_manager import homes_in

            self._lives = homes_in(snapshot)
            self._belongs = {c.instance: c.manager or snapshot.manager for c in system.components}
        self._names = {
            (self._lives.get(c.instance, ""), name): c
            for c in snapshot.components
            for name in c.names
        }
        self._found = {c.instance: self._locate(c) for c in system.components}

    def at(self, instance: str) -> ComponentFacts | None:
        """Return what lives where the wanted component of that name belongs, or None."""
        facts = self._found[instance]
        return facts if facts is not None and not facts.zombie else None

    def entry(self, instance: str) -> ComponentFacts | None:
        """Return the same, or the zombie that is there."""
        return self._found[instance]

    def namesake(self, instance: str) -> ComponentFacts | None:
        """Return the component of that instance name wherever it is registered, or None."""
        return self._instances.get(instance)

    def create_of(self, wanted: WantedComponent) -> str:
        """Return the create string of a component: what is wanted, else what made what is there."""
        entry = self.entry(wanted.instance)
        if wanted.create or entry is None or entry.is_stand_in:
            return wanted.create
        return entry.create

    def home(self, instance: str) -> str:
        """Return the manager that a component lives in, or belongs to."""
        belongs = self._belongs.get(instance, self.snapshot.manager)
        return self._lives.get(instance, belongs)

    def destination(self, instance: str) -> str:
        """Return the manager that a component is to be in: its home, unless it is to move."""
        if instance in self._moving:
            return self._belongs.get(instance, self.snapshot.manager)
        return self.home(instance)

    def why_unreachable(self, instance: str) -> str:
        """Return why the manager that a component belongs to cannot be asked; mostly empty."""
        return self.snapshot.unreachable.get(self.home(instance), "")

    def is_guest(self, facts: ComponentFacts) -> bool:
        """Return whether a component came by itself, as data tools do, and ends by itself."""
        manager = self._managers[self.home(facts.instance)]
        return any(p.is_guest and p.name == facts.process for p in manager.processes)

    @property
    def managers(self) -> Mapping[str, Snapshot]:
        """Return each manager's facts about itself, by its name; the first one first."""
        return self._managers

    def connector(self, connector_id: str) -> ConnectorProfile | None:
        """Return the connection of that id, or None."""
        return self._connectors.get(connector_id)

    def connectors_between(self, ends: tuple[PortRef, ...]) -> list[ConnectorProfile]:
        """Return the connections that join just these ports."""
        return [
            connector
            for connector in self._connectors.values()
            if set(connector.ports) == set(ends)
        ]

    def _locate(self, wanted: WantedComponent) -> ComponentFacts | None:
        belongs = self._belongs.get(wanted.instance, "")
        found = self._names.get((belongs, wanted.name))
        if found is not None:
            return found
        return self._by_manager(wanted, belongs) or self._namesake_of(wanted, belongs)

    def is_named(self, wanted: WantedComponent) -> bool:
        """Return whether the wanted component is to be found where its name leads."""
        belongs = self._belongs.get(wanted.instance, "")
        is_found = (belongs, wanted.name) in self._names
        return is_found or self._by_manager(wanted, belongs) is not None

    def _namesake_of(self, wanted: WantedComponent, belongs: str) -> ComponentFacts | None:
        facts = self._instances.get(wanted.instance) if self._takes_namesakes else None
        if facts is None or facts.zombie or wanted.unknown_host:
            return None
        is_home = self._lives.get(facts.instance, "") == belongs
        return facts if is_home or wanted.may_move else None

    def _by_manager(self, wanted: WantedComponent, belongs: str) -> ComponentFacts | None:
        """Return a component that its path names below its manager, or its slave."""
        host, *rest = wanted.name.split("/")
        *directories, leaf = rest
        below = [d for d in directories if d.endswith(MANAGER_SUFFIX)]
        if host != LOCAL or not below or len(below) != len(directories):
            return None
        facts = self._instances.get(leaf.removesuffix(COMPONENT_SUFFIX))
        manager = below[-1].removesuffix(MANAGER_SUFFIX)
        if facts is None:
            return None
        home = self._lives.get(facts.instance, "")
        if home == belongs and manager in (facts.process, home or self.snapshot.manager):
            return facts
        return None


def mismatch(wanted: WantedComponent, facts: ComponentFacts) -> str:
    """Return why the component found at a path is not the wanted one; empty when it is."""
    if facts.instance != wanted.instance:
        return (
            f"Instance name of component at {wanted.path} is {facts.instance},"
            f" not {wanted.instance}"
        )
    found = stated_id(facts)
    if not is_same_id(found, wanted.id):
        return f"ID of component at {wanted.path} is {found}, not {wanted.id}"
    return ""


def context_of(
    facts: ComponentFacts, wanted: WantedComponent, number: int
) -> ExecutionContextProfile | None:
    """Return the live context that the wanted one of that number means: by id, else by place.

    Those that are found by no id take the places that are left, so that no two mean the same one.
    While a composite drives the component, its context stands for those that rest meanwhile.
    """
    found = own_context_of(facts, wanted, number)
    if not facts.composite or found is None or found.is_running:
        return found
    driving = (c for c in facts.contexts if c.is_running and c.owner != facts.instance)
    return next(driving, found)


def states_of(component: WantedComponent, facts: ComponentFacts) -> Iterator[LifeCycleState]:
    """Yield the states of a component in the contexts that are wanted, as far as they live."""
    for number in range(len(component.contexts)):
        context = context_of(facts, component, number)
        if context is not None:
            yield context.state


def own_context_of(
    facts: ComponentFacts, wanted: WantedComponent, number: int
) -> ExecutionContextProfile | None:
    """Return the same, also while a composite drives the component."""
    live = {context.id: context for context in facts.contexts}
    ids = [context.id for context in wanted.contexts]
    if ids[number] in live:
        return live[ids[number]]
    own = [context for context in facts.contexts if context.owner == facts.instance]
    left = [context for context in own if context.id not in ids]
    place = sum(id not in live for id in ids[:number])
    return left[place] if place < len(left) else None


def absence(component: WantedComponent, live: LiveIndex) -> str:
    """Return why a component is not there as wanted; empty when it is."""
    entry = live.entry(component.instance)
    word = "Required component missing" if component.is_required else "Component missing"
    if entry is not None and not entry.zombie:
        return mismatch(component, entry)
    if entry is not None:
        return f"{word}: {component.path} (zombie: {entry.zombie})"
    why = live.why_unreachable(component.instance)
    if why:
        return f"{word.removesuffix('missing')}unreachable: {component.path} ({why})"
    other = live.namesake(component.instance)
    if other is not None and other.zombie:
        place = live.home(component.instance)
        return f"{word}: {component.path} (zombie in manager {place}: {other.zombie})"
    if other is not None:
        where = f"at /{other.names[0]}" if other.names else f"at no name, in {other.process}"
        if live.home(component.instance) != (component.manager or live.snapshot.manager):
            stays = "" if component.may_move else ", and stays there"
            where = f"in manager {live.home(component.instance)}{stays}"
        return f"{word}: {component.path} ({component.instance} is {where})"
    return f"{word}: {component.path}"
