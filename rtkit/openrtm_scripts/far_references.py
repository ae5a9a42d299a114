"""Components of the tree as programs for OpenRTM-aist see them: references to what is elsewhere.

Each call asks the manager, and so finds what is there at that moment.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

from rtkit.api.connect import connect
from rtkit.api.tree import Tree
from rtkit.deployment.actions import Delete, Disconnect, SetRate, Tick
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Malformed, NotFound, RtkitError, Unreachable
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.openrtm.corba.enumerations import ITEMS, OK, item_for
from rtkit.openrtm.corba.exceptions import SYSTEM_EXCEPTIONS
from rtkit.openrtm.corba.records import (
    ComponentProfile,
    ConnectorProfile,
    ExecutionContextProfile,
    PortInterfaceProfile,
    PortProfile,
    name_values,
)
from rtkit.openrtm.corba.references import ExecutionContext, PortService, RTObject
from rtkit.rtc.names import parse_path
from rtkit.rtc.profiles import ExecutionContextProfile as ContextFacts

T = TypeVar("T")
_CYCLE_S = 3600.0
"""How long a cycle may take that was asked for: its component may wait for its user [s]."""
_POLARITIES = {"Provided": "PROVIDED", "Required": "REQUIRED"}
_log = late(__name__)


@cache
def the_tree() -> Tree:
    """Return the connection of this process to the usual manager.

    Raises:
        Unreachable: It does not run.
    """
    tree = connect()
    atexit.register(tree.close)
    return tree


def asked(question: Callable[[], T]) -> T:
    """Return the answer to a question; errors are those of CORBA."""
    try:
        return question()
    except RtkitError as error:
        name = "OBJECT_NOT_EXIST"
        if isinstance(error, Unreachable):
            name = "TRANSIENT"
            the_tree.cache_clear()
        raise SYSTEM_EXCEPTIONS[name](why=str(error)) from error


def _done(work: Callable[[], object]) -> Any:
    """Do what was asked for; return its code. Why it was not done is logged."""
    try:
        work()
    except Unreachable as error:
        raise SYSTEM_EXCEPTIONS["COMM_FAILURE"](why=str(error)) from error
    except RtkitError as error:
        _log().warning("%s", error)
        is_wrong = isinstance(error, (Malformed, NotFound))
        return ITEMS["BAD_PARAMETER" if is_wrong else "PRECONDITION_NOT_MET"]
    return OK


def end_component(instance: str) -> None:
    """Have the manager end a component of this process, without waiting for that."""

    def end() -> None:
        try:
            with connect() as tree:
                tree.perform(Delete(instance))
        except RtkitError as error:
            _log().error("%s does not end: %s", instance, error)

    start_thread(end, f"end of {instance}")


class FarComponent(RTObject):
    """A component of the tree.

    Attributes:
        path: Where it is.
    """

    def __init__(self, path: str) -> None:
        self.path = path

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FarComponent) and other.path == self.path

    def __hash__(self) -> int:
        return hash(self.path)

    def _is_equivalent(self, other: object) -> bool:
        return self == other

    def _non_existent(self) -> bool:
        try:
            self.facts()
        except SYSTEM_EXCEPTIONS["OBJECT_NOT_EXIST"]:
            return True
        return False

    def facts(self) -> ComponentFacts:
        """Return all that its manager knows of it."""
        return asked(lambda: the_tree().component(self.path))

    def get_ports(self) -> list[FarPort]:
        """Return its ports, in their order."""
        return [FarPort(self, each.name) for each in self.facts().ports]

    def get_component_profile(self) -> ComponentProfile:
        """Describe it."""
        facts = self.facts()
        ports = [each.get_port_profile() for each in self.get_ports()]
        return ComponentProfile(
            facts.instance, facts.type.type_name, facts.type.description, facts.type.version,
            facts.type.vendor, facts.type.category, ports, None,
            name_values(dict(facts.properties)),
        )  # fmt: skip

    def get_owned_contexts(self) -> list[FarContext]:
        """Return the execution contexts that it owns."""
        facts = self.facts()
        return [FarContext(self, n) for n, c in enumerate(facts.contexts) if _is_own(c, facts)]

    def get_participating_contexts(self) -> list[FarContext]:
        """Return those of others that it takes part in."""
        facts = self.facts()
        return [FarContext(self, n) for n, c in enumerate(facts.contexts) if not _is_own(c, facts)]

    def get_context(self, ec_id: int) -> FarContext:
        """Return the execution context of a number."""
        return FarContext(self, ec_id)

    def get_context_handle(self, cxt: FarContext) -> int:
        """Return the number of an execution context."""
        return cxt.number

    def is_alive(self, exec_context: Any = None) -> bool:
        """Return whether it lives."""
        return not self._non_existent()

    def exit(self) -> Any:
        """End it."""
        return _done(lambda: the_tree().delete(self.path))


def _is_own(context: ContextFacts, facts: ComponentFacts) -> bool:
    return context.owner == facts.instance


def _path_of(reference: Any) -> str:
    """Return the path of a component, also of one of this process."""
    if isinstance(reference, FarComponent):
        return reference.path
    instance = reference.rtkit_component.instance
    for row in the_tree().listing().rows:
        if row.instance == instance and row.names:
            return f"/{row.names[0]}"
    raise NotFound(f"no component {instance}")


class FarPort(PortService):
    """A port of a component of the tree.

    Attributes:
        owner: That component.
    """

    def __init__(self, owner: Any, name: str) -> None:
        self.owner = owner
        self._name = name

    @property
    def path(self) -> str:
        """Its path in the tree.

        Raises:
            NotFound: Its component is of this process, and in the tree no more.
        """
        return f"{_path_of(self.owner)}:{self._name}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FarPort) and (other.owner, other._name) == (self.owner, self._name)

    def __hash__(self) -> int:
        return hash((self.owner, self._name))

    def _is_equivalent(self, other: object) -> bool:
        return self == other

    def get_port_profile(self) -> PortProfile:
        """Describe it."""
        facts = self.owner.facts()
        port = asked(lambda: _known(facts.port(self._name), self.path))
        interfaces = [
            PortInterfaceProfile(
                each.instance_name, each.type_name, ITEMS[_POLARITIES[each.polarity]]
            )
            for each in port.interfaces
        ]
        properties = {"port.port_type": str(port.port_type), **port.properties}
        return PortProfile(
            f"{facts.instance}.{self._name}", interfaces, self, self.get_connector_profiles(),
            self.owner, name_values(properties),
        )  # fmt: skip

    def get_connector_profiles(self) -> list[ConnectorProfile]:
        """Describe its connectors."""
        where = parse_path(self.path)
        instance = self.owner.facts().instance
        snapshot = asked(lambda: the_tree().led_to(where).part([instance]))
        return [
            ConnectorProfile(each.name, each.connector_id, [self], name_values({**each.properties}))
            for each in snapshot.connectors
            if (instance, self._name) in [(end.instance, end.port) for end in each.ports]
        ]

    def connect(self, connector_profile: ConnectorProfile) -> tuple[Any, ConnectorProfile]:
        """Connect the ports of a profile; return a code, and the profile as it became."""
        wanted = connector_profile
        given = {each.name.replace(".", "__"): str(each.value) for each in wanted.properties}
        made = [wanted.connector_id]

        def connect_ports() -> None:
            first, second = (port_path(each) for each in wanted.ports)
            made[0] = the_tree().connect(
                first, second, wanted.connector_id, connector_name=wanted.name, **given
            )

        code = _done(connect_ports)
        return code, ConnectorProfile(wanted.name, made[0], wanted.ports, wanted.properties)

    def disconnect(self, connector_id: str) -> Any:
        """Remove a connector."""
        where = parse_path(self.path)
        return _done(lambda: the_tree().led_to(where).perform(Disconnect(connector_id)))

    def disconnect_all(self) -> Any:
        """Remove all its connectors."""
        return _done(lambda: the_tree().disconnect(self.path))


def port_path(port: Any) -> str:
    """Return the path of a port, also of one of this process."""
    return port.path if isinstance(port, FarPort) else FarPort(port.owner, port.name()).path


def _known(port: T | None, path: str) -> T:
    if port is None:
        raise NotFound(f"no port {path}")
    return port


class FarContext(ExecutionContext):
    """An execution context of a component of the tree.

    Attributes:
        number: Its place among those of its component.
    """

    def __init__(self, component: FarComponent, number: int) -> None:
        self._component = component
        self.number = number

    def __eq__(self, other: object) -> bool:
        here = (self._component, self.number)
        return isinstance(other, FarContext) and (other._component, other.number) == here

    def __hash__(self) -> int:
        return hash((self._component, self.number))

    def _facts(self) -> ContextFacts:
        contexts = self._component.facts().contexts
        path = f"{self._component.path}, execution context {self.number}"
        found = contexts[self.number] if self.number < len(contexts) else None
        return asked(lambda: _known(found, path))

    def activate_component(self, reference: Any) -> Any:
        """Make a component Active."""
        return _done(lambda: the_tree().activate(_path_of(reference), self._id_for(reference)))

    def deactivate_component(self, reference: Any) -> Any:
        """Make a component Inactive."""
        return _done(lambda: the_tree().deactivate(_path_of(reference), self._id_for(reference)))

    def reset_component(self, reference: Any) -> Any:
        """Lead a component out of Error."""
        return _done(lambda: the_tree().reset(_path_of(reference), self._id_for(reference)))

    def _id_for(self, reference: Any) -> str:
        """Return the id by which a component knows this context."""
        context = self._facts()
        if _path_of(reference) == self._component.path:
            return context.id
        return f"{context.owner}/{context.id}"

    def get_component_state(self, reference: Any) -> Any:
        """Return the state of a component in this context; CREATED of one that is not in it."""
        wanted = self._id_for(reference)
        facts = asked(lambda: the_tree().component(_path_of(reference)))
        states = [each.state for each in facts.contexts if each.id == wanted]
        return item_for(states[0]) if states else ITEMS["CREATED_STATE"]

    def tick(self) -> Any:
        """Ask for a cycle of one that others drive, without waiting for its end.

        Raises:
            CorbaException: The manager does not answer.
        """
        where = parse_path(self._component.path)
        cycle = Tick(self._component.facts().instance, self._facts().id)
        ask = lambda: the_tree().led_to(where).begin([cycle], timeout_s=_CYCLE_S)  # noqa: E731
        answer = asked(ask)
        start_thread(lambda: _done(lambda: answer()[0].raise_for_error()), "tick")
        return OK

    def set_rate(self, rate: float) -> Any:
        """Change the rate [Hz]."""
        where = parse_path(self._component.path)
        change = SetRate(self._component.facts().instance, self._facts().id, float(rate))
        return _done(lambda: the_tree().led_to(where).perform(change))

    def get_rate(self) -> float:
        """Return the rate [Hz]."""
        return self._facts().rate

    def is_running(self) -> bool:
        """Return whether it ticks."""
        return self._facts().is_running

    def get_kind(self) -> Any:
        """Return what drives it."""
        return ITEMS[self._facts().kind.value]

    def get_profile(self) -> ExecutionContextProfile:
        """Describe it."""
        facts = self._facts()
        properties = name_values(dict(facts.properties))
        kind = ITEMS[facts.kind.value]
        return ExecutionContextProfile(kind, facts.rate, self._component, [], properties)
