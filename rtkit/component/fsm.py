"""Components with a state machine: events arrive at a port of their own and move it.

::

    class Door(FsmComponent):
        states: ClassVar = {
            "Closed": {"open": "Open"},
            "Open": {"close": "Closed"},
        }
        events: ClassVar = {"open": TimedLong, "close": TimedLong}

        def on_entry(self, state):
            self.logger.info("now %s", state)

The actions of a state may be written as a class of its own, with a method for each event::

    class Open(State):
        def on_entry(self):
            self.component.logger.info("somebody may come in")

        @takes("close")
        def close(self, value):
            return None  # as the table says

    class Door(FsmComponent):
        ...
        state_classes: ClassVar = {"Open": Open}

An out port is connected to the event port (``event`` by default) for one event: the one that the
connector property ``fsm_event_name`` says, else the one of the connector's or the out port's name.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, TypeVar

from rtkit.component.base import Component
from rtkit.component.ports.buffer import Sink, Source
from rtkit.component.ports.connector_events import ConnectorEvent, receiving
from rtkit.component.ports.in_port import InPort, Listener, Renew
from rtkit.component.ports.options import PortStatus
from rtkit.component.state_table import StateTable, StateTransition, Table, lineage
from rtkit.component.values.typenames import type_by_name, type_name
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.data_types import is_same_type, scoped_name
from rtkit.rtc.enums import ReturnCode
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.profiles import ConnectorProfile

EVENT_NAME = "fsm_event_name"
"""Connector property: name of the event that its values are."""

PROFILES = "fsm.events"
"""Port property that lists the events, ``open:RTC::TimedLong,…``."""

_LONGEST_QUEUE = 1024
_TAKES = "_rtkit_takes"
F = TypeVar("F", bound=Callable[..., Any])


def takes(event: str) -> Callable[[F], F]:
    """Make a method of a `State` the one that takes an event.

    It is given the value of the event, and returns what `FsmComponent.on_event` returns.
    """

    def mark(method: F) -> F:
        setattr(method, _TAKES, event)
        return method

    return mark


class State:
    """Behaviour of a component in one state of its machine; each component has its own instance.

    Attributes:
        component: The component.
        events: Names of the methods that take events, by event.
    """

    events: ClassVar[Mapping[str, str]] = {}

    def __init__(self, component: Any) -> None:
        self.component = component

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        own = {getattr(value, _TAKES, ""): name for name, value in vars(cls).items()}
        own.pop("", None)
        cls.events = {**cls.events, **own}

    def on_entry(self) -> None:
        """Enter the state."""

    def on_exit(self) -> None:
        """Leave the state."""


class EventPort(InPort[Any]):
    """An in port that takes the events of a state machine, each with a value of its own type.

    Events keep their order over all connectors; when more than 1024 wait, further ones are
    refused.
    """

    def __init__(
        self, name: str = "", properties: Mapping[str, str] | None = None, *, doc: str = ""
    ) -> None:
        super().__init__(bytes, name, properties, doc=doc)
        self.properties.setdefault(PROFILES, "")
        self._events: dict[str, type] = {}
        self._queue: deque[tuple[str, Any]] = deque()

    @property
    def events(self) -> Mapping[str, type]:
        """The data type of each event."""
        return self._events

    @events.setter
    def events(self, events: Mapping[str, type]) -> None:
        self._events = dict(events)
        pairs = (f"{event}:{scoped_name(type_name(cls)) or 'Any'}" for event, cls in events.items())
        self.properties = {**self.properties, PROFILES: ",".join(pairs)}

    def copy(self) -> EventPort:
        """Return a port of the same kind without connectors, for another instance."""
        made = EventPort(self.name, self.properties)
        made.events = self._events
        return made

    def is_new(self) -> bool:
        """Return whether an event is there that was not taken yet."""
        return bool(self._queue)

    def take(self) -> tuple[str, Any] | None:
        """Remove and return the oldest event and its value, None when there is none."""
        try:
            item = self._queue.popleft()
        except IndexError:
            return None
        self.read_count += 1
        return item

    def read(self) -> Any:
        """Return the value of the oldest event not taken yet, None when there is none."""
        item = self.take()
        return None if item is None else item[1]

    def read_all(self) -> list[Any]:
        """Return the values of all events not taken yet."""
        items = [self.take() for _ in range(len(self._queue))]
        return [item[1] for item in items if item is not None]

    def clear(self) -> None:
        """Forget the events that wait."""
        self._queue.clear()

    def data_type_for(self, connector: ConnectorProfile) -> type:
        """Return the data type of the event that a connector brings.

        Raises:
            Refused: It names none of the port's events, or has values of another type.
        """
        return self._events[self._event_of(connector)]

    def open(self, connector: ConnectorProfile, renew: Renew[Any] | None = None) -> Sink[Any]:
        """Open a push connector; see `InPort.open`.

        Raises:
            Refused: It names none of the port's events, or has values of another type.
        """
        event = self._event_of(connector)
        with self._lock:
            self._enter(connector)
        self._notify(ConnectorEvent.CONNECTED, connector)

        def write(value: Any) -> PortStatus | None:
            if len(self._queue) >= _LONGEST_QUEUE:
                return PortStatus.FULL
            self._queue.append((event, value))
            if self._listener is not None:
                self._listener()
            return None

        def write_notifying(value: Any) -> PortStatus | None:
            listeners = self._listeners
            if listeners is None:
                return write(value)
            return receiving(listeners, connector, self._queue, write)(value)

        return write_notifying

    def open_pull(self, connector: ConnectorProfile, source: Source[Any]) -> None:
        """Refuse: events are pushed.

        Raises:
            Refused: Always.
        """
        raise Refused(f"port {self.name} takes events, which are pushed, not pulled")

    def listen(self, listener: Listener | None) -> None:
        """Have `listener` called after each event, by the thread that brings it."""
        self._listener = listener

    def _type_of(self, connector: ConnectorProfile) -> type:
        return self.data_type_for(connector)

    def _event_of(self, connector: ConnectorProfile) -> str:
        properties = connector.properties
        named = properties.get(EVENT_NAME, "") or properties.get(f"dataport.{EVENT_NAME}", "")
        source = connector.ports[0].port if connector.ports else ""
        candidates = [named] if named else [connector.name, source]
        event = next((each for each in candidates if each in self._events), "")
        if not event:
            known = ", ".join(self._events) or "none"
            what = f"no event {named}" if named else f"which event it is; say {EVENT_NAME}=NAME"
            raise Refused(f"port {self.name}: {what} (events: {known})")
        carried = properties.get("dataport.data_type", "")
        if not is_same_type(carried, type_name(self._events[event])):
            own = scoped_name(type_name(self._events[event]))
            raise Refused(f"event {event} carries {own}, not {scoped_name(carried)}")
        return event


class FsmComponent(Component):
    """A component that a state machine describes; driven by events unless asked otherwise.

    The machine begins in its initial state at each activation; events that came before are
    dropped. One that overrides `on_activated` or `on_execute` calls those of this class.

    Attributes:
        states: The table: state, event, next state (see `rtkit.component.state_table`).
        events: Data type of each event; ``bytes`` takes any.
        event_port: Name of the port that events arrive at.
        state_classes: Class of each state that has one of its own.
        machine: The machine that is in force.
        state: Its present state, the innermost one; empty before the first activation.
        ignored: Events that came while the present state did not know them.
    """

    execution_type = "EventDrivenExecutionContext"
    has_machine = True
    own_attributes = (
        *Component.own_attributes,
        "_states",
        "event_in",
        "ignored",
        "machine",
        "state",
    )
    states: ClassVar[Table] = {}
    events: ClassVar[Mapping[str, type]] = {}
    event_port: ClassVar[str] = "event"
    state_classes: ClassVar[Mapping[str, type[State]]] = {}

    def __init__(self, instance: str, options: Mapping[str, str] | None = None) -> None:
        self.machine = StateTable(self.states)
        self.state = ""
        self.ignored = 0
        super().__init__(instance, options)
        unknown = sorted(set(self.events) - set(self.machine.events))
        if unknown:
            raise Malformed(f"{instance}: no state knows event {', '.join(unknown)}")
        self._check_state_classes()
        self._states = {state: cls(self) for state, cls in self.state_classes.items()}
        self.event_in = self._add(EventPort(self.event_port))
        self.event_in.events = self.events

    def on_entry(self, state: str) -> None:
        """Enter a state: called for each one entered, outer ones first.

        By default the class of the state enters it.
        """
        if state in self._states:
            self._states[state].on_entry()

    def on_exit(self, state: str) -> None:
        """Leave a state: called for each one left, inner ones first.

        By default the class of the state leaves it.
        """
        if state in self._states:
            self._states[state].on_exit()

    def on_event(self, event: str, value: Any) -> str | None:
        """Take an event that the present state knows, before it is left.

        Return another state to go there instead of where the table leads; the present one as
        `state` says it to stay, which leaves and enters nothing. By default the class of the
        state whose event it is, the present one or one around it, takes it.
        """
        knows = (each for each in lineage(self.state) if event in self.machine.table[each])
        own = self._states.get(next(knows, ""))
        name = own.events.get(event) if own is not None else None
        chosen: str | None = getattr(own, name)(value) if name else None
        return chosen

    def on_action(self, context: str) -> ReturnCode | None:
        """React to a transition: called after each, by the thread that drives the component."""

    def on_activated(self, context: str) -> ReturnCode | None:
        """Begin in the initial state."""
        self.event_in.clear()
        self._carry_out(self.machine.beginning())
        return None

    def on_execute(self, context: str) -> ReturnCode | None:
        """Work on the events that have come, one after the other."""
        count = 0
        while (item := self.event_in.take()) is not None:
            count += self._dispatch(context, *item)
        if count:
            self.participation(context).changed(self)
        return None

    def _check_state_classes(self) -> None:
        table = self.machine.table
        for state, cls in self.state_classes.items():
            if state not in table:
                hint = did_you_mean(state, table)
                raise Malformed(f"{self.instance}: {cls.__name__} is of no state {state}{hint}")
            unknown = [event for event in cls.events if event not in table[state]]
            if unknown:
                hint = did_you_mean(unknown[0], table[state])
                raise Malformed(
                    f"{self.instance}: state {state} does not know event {unknown[0]}{hint}"
                )

    def set_structure(self, table: Table) -> None:
        """Put another table in force; only for the thread that drives the component.

        The present state is kept where the new table has it, else it begins anew.

        Raises:
            Malformed: The table is none.
        """
        machine = StateTable(table)
        self.machine = machine
        if self.state and self.state not in machine.table:
            self.state = machine.initial
        elif self.state:
            self.state = machine.innermost(self.state)

    def set_events(self, profiles: Mapping[str, str]) -> None:
        """Put other events in force, each with the name of its data type.

        Connectors that are open go on with the event that they were opened for.

        Raises:
            NotFound: A data type is not known here.
        """
        found: dict[str, type] = {}
        for event, text in profiles.items():
            cls = type_by_name(text) if scoped_name(text) else bytes
            if cls is None:
                raise NotFound(f"event {event}: no data type {text}")
            found[event] = cls
        self.event_in.events = found

    def _dispatch(self, context: str, event: str, value: Any) -> bool:
        """Work on one event; return whether the state may have changed."""
        target = self.machine.target(self.state, event)
        if target is None:
            self.ignored += 1
            return False
        chosen = self.on_event(event, value)
        if chosen is not None and chosen == self.state:
            return False
        self._carry_out(self.machine.move(self.state, event, chosen or target))
        code = self.on_action(context)
        if code not in (None, ReturnCode.OK):
            raise Refused(f"on_action returned {code}")
        return True

    def _carry_out(self, move: StateTransition) -> None:
        for state in move.exited:
            self.on_exit(state)
        self.state = move.target
        for state in move.entered:
            self.on_entry(state)
