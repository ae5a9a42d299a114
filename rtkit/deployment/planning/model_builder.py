"""Builds the model of a deployment from the wanted system and the live one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtkit.component.ports.port_matching import refusal
from rtkit.deployment.creation import is_loaded
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.live_index import LiveIndex, absence, mismatch, states_of
from rtkit.deployment.multi_manager import homes_in
from rtkit.deployment.packages import NO_PACKAGES, Packages, unused
from rtkit.deployment.planning import component_settings
from rtkit.deployment.planning import model as var
from rtkit.deployment.planning.component_settings import ComponentSetting
from rtkit.deployment.planning.feasibility import NOTHING_KNOWN, Feasibility, place_name
from rtkit.deployment.planning.model import (
    ComponentVariable,
    ConnectionVariable,
    Model,
    ParameterVariable,
    Wish,
    is_granted,
    key_of,
)
from rtkit.deployment.planning.parameter_values import Values
from rtkit.deployment.planning.stale import Stale
from rtkit.deployment.planning.step_costs import USUAL, Costs
from rtkit.deployment.system import WantedComponent, WantedConnector, WantedSystem, address
from rtkit.deployment.wiring import is_same_connector, missing_end
from rtkit.errors import Impossible
from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.rtc.create import CreateString, parse_create
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.names import split_manager
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef, split_module


@dataclass(frozen=True, slots=True)
class BuiltModel:
    """A model of the live system and the wanted one.

    Attributes:
        notes: Parts of the wanted system that are left out, as they cannot be.
        unmet: Those of them without which a required component is not what is wanted.
    """

    model: Model
    notes: tuple[str, ...]
    unmet: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class WantedDeployment:
    """A wanted system, and how it is to be reached.

    Attributes:
        state: In which every component is to be; None for as it is.
        ranks: Components of lower numbers are activated before those of higher ones.
        parallel: Most actions that are under way at once; 0 for no bound.
        feasibility: Knowledge of components that do not live yet.
        states: In which single components are to be, instead of `state`.
        absent: Components that are not to be there, by name.
        dropped: Ids of connections that are not to be there.
        replaces: Components that cannot be changed in place are created again.
        prunes: Components that are not in the system are not to be there.
        is_strict: Steps that would be done with a note are to fail instead.
        packages: Those that components need.
    """

    system: WantedSystem
    state: LifeCycleState | None = LifeCycleState.ACTIVE
    ranks: Mapping[str, int] = field(default_factory=dict)
    costs: Costs = USUAL
    parallel: int = 0
    feasibility: Feasibility = NOTHING_KNOWN
    states: Mapping[str, LifeCycleState | None] = field(default_factory=dict)
    absent: frozenset[str] = frozenset()
    dropped: frozenset[str] = frozenset()
    replaces: bool = False
    prunes: bool = False
    is_strict: bool = False
    packages: Packages = NO_PACKAGES


class ModelBuilder:
    """Builds the model of a wanted deployment over what lives."""

    def __init__(
        self,
        wanted: WantedDeployment,
        live: LiveIndex,
        began: Snapshot | None = None,
        *,
        is_back: bool = False,
    ) -> None:
        """Begin with nothing in the model.

        Args:
            wanted: The wanted system.
            live: Facts of the live system.
            began: Facts of the beginning; a moving component keeps connections and values of then.
            is_back: For the way back: what turned out to be another than wanted is taken in too.
        """
        self.wanted = wanted
        self.system = wanted.system
        self.live = live
        self.is_back = is_back
        self._began = began or live.snapshot
        # Things that were otherwise before are to be so again, and new ones are to go again.
        self.replaces = wanted.replaces or is_back
        self._joined = {connector.connector_id: connector for connector in self._began.connectors}
        self._before = {facts.instance: facts for facts in self._began.components}
        for name in (c.instance for c in self.system.components if c.may_move):
            was, manager = self._before.get(name), homes_in(self._began).get(name, "")
            if was is not None and manager != live.home(name):
                # A slave of that name is another one there.
                process = place_name(manager, was.process)
                self._before[name] = replace(was, process=process)
        self._units: dict[str, ComponentVariable] = {}
        self._connectors: dict[str, ConnectionVariable] = {}
        self._keys: dict[str, ParameterVariable] = {}
        self._live: dict[str, str] = {}
        self._desired: dict[str, Wish] = {}
        self._notes: list[str] = []
        self._problems: list[str] = []
        self._unmet: list[str] = []
        self._named = {component.instance for component in self.system.components}
        self._replaced: set[str] = set()
        self._stale = Stale(self.live, self._named, self.wanted.feasibility.code)

    def run(self) -> BuiltModel:
        """Return the model.

        Raises:
            Impossible: Something else lives where a required component belongs, or one would have
                to be created again, and that is not allowed.
        """
        managers = self.live.managers
        for name, snapshot in managers.items():
            self._live[f"mgr:{name}"] = var.UP if snapshot.pid else var.DOWN
        known = self.wanted.packages.installed
        self._live.update((f"pkg:{each}", var.INSTALLED) for each in sorted(known))
        for component in self.system.components:
            self._component(component)
        for connector in self.system.connectors:
            self._connector(connector)
        if self.wanted.prunes:
            self._prune()
        self._surplus([*self.live.snapshot.connectors, *self._began.connectors])
        for component in self.system.components:
            self._attachments(component)
        self._surplus_packages()
        if self._problems:
            raise Impossible("; ".join(self._problems))
        model = Model(
            dict.fromkeys(managers),
            self._units,
            self._connectors,
            self._keys,
            self._live,
            self._desired,
            self.wanted.costs.values,
            slaves_need_modules=True,
            hosts={name: host for name in managers if (host := split_manager(name)[1])},
        )
        return BuiltModel(model, tuple(self._notes), tuple(self._unmet))

    # components

    def _component(self, component: WantedComponent) -> None:
        entry = self.live.entry(component.instance)
        facts = self.live.at(component.instance)
        wrong = mismatch(component, facts) if facts is not None else ""
        if component.instance in self.wanted.absent:
            if facts is not None and not wrong:
                self._leaving(component, facts)
            return
        why_not = "" if facts is not None else self._why_not(component)
        is_namesake = facts is not None and facts.instance == component.instance
        if wrong and facts is not None and not (self.replaces and is_namesake and component.create):
            if self.is_back and is_namesake:
                self._leaving(component, facts)
            hint = "; --replace makes it again" if is_namesake and component.create else ""
            self._trouble(component, f"{wrong}{hint}")
            return
        if why_not and not component.is_required:
            self._notes.append(why_not)
            return
        settings, reasons = self._manner(component, facts, wrong)
        is_another = bool(wrong or (reasons and component.pattern is not None))
        if is_another:
            self._replaced.add(component.instance)
        name = component.instance
        create = self.live.create_of(component)
        made = parse_create(create) if create else CreateString("")
        place = place_name(self.live.destination(name), made.place)
        lack = why_not or self._lack(component)
        places = () if lack or not create else (place,)
        why = lack or ("" if create else f"nothing tells how to make {component.path}")
        mates = self._stale.mates(name)
        package = self.wanted.packages.of.get(name, "")
        self._units[name] = ComponentVariable(
            name, self._module(component), places, why, made.members, mates, package
        )
        is_stated = (bool(component.create) or entry is None) and not made.is_place_open
        self._desired[f"cmp:{name}"] = self._desired_place(component, facts, place, is_stated)
        if facts is not None:
            self._live[f"cmp:{name}"] = self._place(name, facts.process)
        # Of another one in its place nothing is kept.
        self._parameters(component, None if is_another else facts)
        self._take(component, settings)
        if is_another and facts is not None:
            self._note(facts)
        self._activity(component, facts)

    def _manner(
        self, component: WantedComponent, facts: ComponentFacts | None, wrong: str
    ) -> tuple[list[ComponentSetting], list[str]]:
        """Return what a component is beside its parameters, and why it is created again."""
        was = self._before.get(component.instance)
        found = list(component_settings.settings(component, None if wrong else facts, was))
        is_named = None if facts is None else self.live.is_named(component)
        had_name = was is None or bool(was.zombie) or component.name in was.names
        if is_named is False or not had_name:
            found.append(component_settings.name(component, is_named))
        reasons = self._reasons(component, facts)
        if facts is not None and not self.is_back:
            if self.replaces and not wrong:
                reasons += self._stale.reasons(facts)
            self._notes += () if reasons else self._stale.notes(facts, component.path)
        if self.replaces and (reasons or self._reasons(component, was)):
            found.append(component_settings.making(component, facts, reasons))
        elif reasons:
            text = f"{component.path} cannot be changed in place: {'; '.join(reasons)}"
            self._trouble(component, f"{text}; --replace makes it again")
        return found, reasons if self.replaces else []

    def _trouble(self, component: WantedComponent, why: str) -> None:
        is_fatal = component.is_required and not self.is_back
        (self._problems if is_fatal else self._notes).append(why)

    def _reasons(self, component: WantedComponent, facts: ComponentFacts | None) -> list[str]:
        """Return why a component would have to be created again."""
        if facts is None or facts.zombie:
            return []
        wrong = mismatch(component, facts)
        return [wrong] if wrong else list(component_settings.reasons(component, facts))

    def _prune(self) -> None:
        """Have live, unwanted components end; those of attached processes end by themselves."""
        alive = {facts.instance for facts in self.live.snapshot.components if not facts.zombie}
        now = {facts.instance: facts for facts in self.live.snapshot.components}
        for name, facts in {**self._before, **now}.items():
            if name in self._named or facts.zombie or self.live.is_guest(facts):
                continue
            self._units[name] = ComponentVariable(name, members=facts.members)
            self._desired[f"cmp:{name}"] = var.ABSENT
            if name in alive:
                self._live[f"cmp:{name}"] = self._place(name, facts.process)
                self._live_state(name, {context.state for context in facts.contexts})
            self._note(facts, is_alive=name in alive)

    def _note(self, facts: ComponentFacts, *, is_alive: bool = True) -> None:
        """Take in the configuration of a component that is to go: a way back restores it."""
        for each in component_settings.kept(facts):
            key = key_of(facts.instance, each.parameter)
            self._keys.setdefault(key, each.key)
            if is_alive and each.live is not None:
                self._live.setdefault(f"cfg:{key}", each.live)

    def _leaving(self, component: WantedComponent, facts: ComponentFacts) -> None:
        """Take in a component that lives and is to be ended."""
        name = component.instance
        self._units[name] = ComponentVariable(name, self._module(component))
        self._live[f"cmp:{name}"] = self._place(name, facts.process)
        self._desired[f"cmp:{name}"] = var.ABSENT
        self._live_state(name, set(states_of(component, facts)))

    def _why_not(self, component: WantedComponent) -> str:
        """Return why a component that is not there cannot be made; empty when it can."""
        live = self.live
        other = live.namesake(component.instance)
        if other is not None and not other.zombie:
            return absence(component, live)
        if not live.create_of(component):
            hint = "nothing tells how to make it; --stand-in generates it"
            return f"{absence(component, live)} ({hint})"
        if component.unknown_host:
            host = component.unknown_host
            hint = f"--map {host}=localhost makes it here"
            return f"no such host: {host} (component {component.instance}); {hint}"
        return self._lack(component)

    def _lack(self, component: WantedComponent) -> str:
        """Return why nothing could be made of a component's type; empty when it may be."""
        lack = self.wanted.feasibility.lacks.get(component.instance, "")
        return f"{component.path}: {lack}" if lack else ""

    def _desired_place(
        self, component: WantedComponent, facts: ComponentFacts | None, place: str, is_stated: bool
    ) -> Wish:
        if facts is None:
            return place if is_stated and self._units[component.instance].places else var.ANY
        manager = self.live.home(component.instance)
        now = place_name(manager, facts.process)
        if not is_stated and self.live.destination(component.instance) == manager:
            return var.ANY
        if self.live.is_guest(facts):
            return now  # its user has started it there
        lack = self._lack(component)
        if lack and not component.is_required:
            self._notes.append(f"{lack}; it stays where it is")
            return now
        is_any_slave = place == f"{manager}:slave" and now != f"{manager}:inproc"
        return (now, place) if is_any_slave else place

    def _place(self, name: str, process: str) -> str:
        return place_name(self.live.home(name), process)

    def _module(self, component: WantedComponent) -> str:
        """Return the module that a component needs, and note whether it is loaded."""
        if not component.module or component.pattern is not None:
            return ""
        path, init = split_module(component.module)
        name = component.instance
        for manager in {self.live.home(name), self.live.destination(name)}:
            loaded = self.live.managers[manager].modules
            if any(is_loaded(known, path, init) for known in loaded):
                self._live[f"mod:{manager}/{component.module}"] = var.LOADED
        return component.module

    def _parameters(self, component: WantedComponent, facts: ComponentFacts | None) -> None:
        was = self._before.get(component.instance)
        declared = self.wanted.feasibility.parameters.get(component.instance)
        values = Values(component, facts, was, declared)
        missing = [*values.missing, *component_settings.unlike(component, facts)]
        self._notes += missing
        for why in values.misfits:
            self._trouble(component, why)
        if component.is_required:
            self._unmet += missing
        self._take(component, values.settings)

    def _take(self, component: WantedComponent, settings: Iterable[ComponentSetting]) -> None:
        for each in settings:
            key = key_of(component.instance, each.parameter)
            self._keys[key] = each.key
            self._desired[f"cfg:{key}"] = each.wanted
            if each.live is not None:
                self._live[f"cfg:{key}"] = each.live

    def _activity(self, component: WantedComponent, facts: ComponentFacts | None) -> None:
        variable = f"act:{component.instance}"
        state = self.wanted.states.get(component.instance, self.wanted.state)
        is_wished = state is not None and bool(component.contexts)
        if facts is not None and is_wished and len(list(states_of(component, facts))) == 0:
            self._notes.append(f"Component {component.path} has no execution context")
            is_wished = False
        if is_wished:
            is_up = state is LifeCycleState.ACTIVE
            self._desired[variable] = var.ACTIVE if is_up else var.INACTIVE
        if facts is not None:
            self._live_state(component.instance, set(states_of(component, facts)))

    def _live_state(self, name: str, states: set[LifeCycleState]) -> None:
        variable = f"act:{name}"
        if LifeCycleState.ERROR in states:
            self._live[variable] = var.ERROR
        elif LifeCycleState.ACTIVE in states:
            # In some contexts only: it counts as what has to be done with it.
            is_partly = len(states) > 1 and self._desired.get(variable) == var.ACTIVE
            self._live[variable] = (
                var.INACTIVE if is_partly and self._is_settled(name) else var.ACTIVE
            )

    def _is_settled(self, name: str) -> bool:
        keys = (v for v in self._desired if v.startswith(f"cfg:{key_of(name, '')}"))
        return all(is_granted(self._desired[v], self._live.get(v, var.UNKNOWN)) for v in keys)

    # connections

    def _connector(self, wanted: WantedConnector) -> None:
        connector, live = wanted.profile, self.live
        id = connector.connector_id
        if any(end.instance not in self._units for end in connector.ports):
            return  # that an end is left out is reported already
        known = live.connector(id)
        names = [end.instance for end in connector.ports]
        pending = [each for each in names if live.at(each) is None or each in self._replaced]
        why = missing_end(self.system, live, connector, pending) or self._refused(wanted, pending)
        if why and not wanted.is_required and known is None:
            self._notes.append(why)
            return
        ends = tuple(end.instance for end in connector.ports)
        self._connectors[id] = ConnectionVariable(ends, why, self._text(id, connector.ports))
        if self.wanted.absent.isdisjoint(ends):
            self._desired[f"con:{id}"] = var.YES
        for other in filter(None, (known, self._joined.get(id))):
            # Components that it joins now, or joined before, have to do with it.
            for end in other.ports:
                if end.instance not in self._units and not self._is_gone(end.instance):
                    self._bystander(end.instance)
        if known is not None:
            self._live[f"con:{id}"] = var.YES if is_same_connector(known, connector) else var.OTHER

    def _text(self, id: str, ports: tuple[PortRef, ...]) -> str:
        return f"{' to '.join(map(str, ports))} ({id})"

    def _refused(self, wanted: WantedConnector, pending: list[str]) -> str:
        """Return why two ports cannot be connected; empty when they can, or nobody knows yet."""
        found = []
        for end in wanted.profile.ports:
            port = self._port(end, is_pending=end.instance in pending)
            if port is None:
                is_known = (
                    end.instance in pending and end.instance in self.wanted.feasibility.described
                )
                path = address(self.system, end)
                return f"port missing: {path} (its type has none)" if is_known else ""
            found.append(port)
        why = refusal(found, wanted.profile.properties)
        ends = " to ".join(address(self.system, end) for end in wanted.profile.ports)
        return f"{ends}: {why}" if why else ""

    def _port(self, end: PortRef, *, is_pending: bool) -> PortProfile | None:
        """Return a port that lives, or as it will be when its component lives."""
        facts = self.live.at(end.instance)
        if not is_pending:
            return facts.port(end.port) if facts is not None else None
        component = self.system.component(end.instance)
        if component.pattern is not None:
            return component.port(end.port)
        known = self.wanted.feasibility.ports.get(end.instance, ())
        return next((port for port in known if port.name == end.port), None)

    def _surplus(self, connectors: Iterable[ConnectorProfile]) -> None:
        """Take in connections of wanted components that nobody names: who moves keeps them."""
        for connector in connectors:
            id = connector.connector_id
            names = [end.instance for end in connector.ports]
            if id in self._connectors or not any(name in self._units for name in names):
                continue
            if any(name not in self._units and self._is_gone(name) for name in names):
                continue
            for name in names:
                if name not in self._units:
                    self._bystander(name)
            self._connectors[id] = ConnectionVariable(
                tuple(names), "", self._text(id, connector.ports)
            )
            is_kept = id not in self.wanted.dropped and (
                not self.wanted.prunes or any(self._units[name].why_not for name in names)
            )
            if self.wanted.absent.isdisjoint(names):
                self._desired[f"con:{id}"] = var.YES if is_kept else var.NO
            self._live[f"con:{id}"] = var.NO if self.live.connector(id) is None else var.YES

    def _surplus_packages(self) -> None:
        """Have packages removed of which nothing will be there, and their modules unloaded."""
        ended = {v[4:] for v, wish in self._desired.items() if wish == var.ABSENT} | self._replaced
        for package, modules in unused(self.wanted.packages, self.live, ended):
            self._desired[f"pkg:{package}"] = var.ABSENT
            for each in modules:
                self._live[f"mod:{each}"], self._desired[f"mod:{each}"] = var.LOADED, var.ABSENT

    def _is_gone(self, name: str) -> bool:
        facts = self.live.namesake(name)
        return facts is None or bool(facts.zombie)

    def _bystander(self, name: str) -> None:
        facts = self.live.namesake(name)
        process = facts.process if facts is not None else ""
        self._units[name] = ComponentVariable(name, why_not=f"{name} is not in the profile")
        self._live[f"cmp:{name}"] = self._place(name, process)
        self._desired[f"cmp:{name}"] = var.ANY

    def _attachments(self, component: WantedComponent) -> None:
        facts = self.live.at(component.instance)
        driven = {c.id: c.participants for c in facts.contexts} if facts is not None else {}
        for context, participant in component.guests:
            if participant not in self._units or component.instance not in self._units:
                continue
            id = attachment(component.instance, context, participant)
            text = f"{participant} to execution context {context} of {component.instance}"
            self._connectors[id] = ConnectionVariable((component.instance, participant), "", text)
            if self.wanted.absent.isdisjoint((component.instance, participant)):
                self._desired[f"con:{id}"] = var.YES
            self._live[f"con:{id}"] = var.YES if participant in driven.get(context, ()) else var.NO


def attachment(owner: str, context: str, participant: str) -> str:
    """Return how it is called here that a context of one component drives another."""
    return f"{owner}\n{context}\n{participant}"
