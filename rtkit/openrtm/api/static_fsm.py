"""State machines whose states are classes, after Macho; ``OpenRTM_aist.StaticFSM``.

An author's class becomes a state by a decorator. The state inherits from the one around it, so
that one handles the events that it has no method for. A machine has one object of each state, and
one of its class `Data`, both for as long as it lives.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import RLock
from typing import Any, ClassVar

from rtkit.errors import Refused


class Event:
    """A call of a method of whatever state a machine is in by then.

    Args:
        handler: The method, of any state.
        arguments: What it is given.
    """

    def __init__(self, handler: Callable[..., Any], *arguments: Any) -> None:
        self.name = handler.__name__
        self.arguments = arguments


class Link:
    """Base of states; the methods of an author's class are actions and events.

    Attributes:
        superstate: The state around it; None for the outermost.
        author_class: The class as its author wrote it, which alone is asked for actions.
        has_history: Whether the machine goes back to where it was in this state.
    """

    superstate: ClassVar[type[Link] | None] = None
    author_class: ClassVar[Any]
    has_history: ClassVar[bool] = False

    def __init__(self, instance: Machine) -> None:
        self._machine = instance
        self._rtComponent = instance.getComp()

    def onInit(self) -> Any:
        """Start in the state, when it is the one that was set; may set one within it."""

    def onEntry(self) -> Any:
        """Enter the state."""

    def onExit(self) -> Any:
        """Leave the state."""

    @classmethod
    def _state_name(cls) -> str:
        return cls.__name__

    def set_state(self, state: type[Link], *arguments: Any) -> None:
        """Go to a state when the event was handled, or to where the machine last was within it.

        `onInit` of the state is given the arguments.

        Raises:
            Refused: A transition is just under way.
        """
        self._machine.set_pending(state, arguments)

    setState = set_state

    def set_state_direct(self, state: type[Link], *arguments: Any) -> None:
        """Go to a state, wherever the machine last was within it."""
        self._machine.set_pending(state, arguments)
        self._machine.forget(state)

    setStateDirect = set_state_direct

    def dispatch(self, event: Event) -> None:
        """Have an event handled next, when the machine is where it goes now."""
        self._machine.add_event(event)

    def defer(self, event: Event) -> None:
        """Have an event handled after the next transition."""
        self._machine.add_deferred(event)

    def data(self, state: type[Link] | None = None) -> Any:
        """Return the data of a state, or of this one."""
        return self._machine.data_of(state or type(self))

    box = data

    def __getitem__(self, state: type[Link]) -> Link:
        return self._machine.object_of(state)


def FSM_TOPSTATE(author_class: type) -> Any:
    """Make an author's class the outermost state of a machine."""
    return _state(author_class, None)


def FSM_SUBSTATE(superstate: type[Link]) -> Callable[[type], Any]:
    """Make an author's class a state within another one."""
    return lambda author_class: _state(author_class, superstate)


fsm_topstate, fsm_substate = FSM_TOPSTATE, FSM_SUBSTATE


def _state(author_class: type, superstate: type[Link] | None) -> Any:
    bases = (author_class,) if superstate is None else (author_class, superstate)
    body = {
        "__module__": author_class.__module__,
        "__doc__": author_class.__doc__,
        "author_class": author_class,
        "superstate": superstate,
        "has_history": False,
    }
    return type(author_class.__name__, bases, body)


def deephistory(state: Any) -> Any:
    """Have machines go back to the innermost state that they were in, within this one."""
    state.has_history = True
    return state


def State(state: type[Link]) -> type[Link]:
    """Return the state, which is its own name."""
    return state


class Machine:
    """A machine, in the state that the outermost one leads to.

    Args:
        TOP: The outermost state.
        comp: The component that it belongs to.

    Attributes:
        sources: Each returns the next event of a port; None when there is none.
    """

    def __init__(self, TOP: type[Link], comp: Any = None) -> None:
        self.sources: list[Callable[[], Event | None]] = []
        self._component = comp
        self._lock = RLock()
        self._current: type[Link] | None = None
        self._pending: tuple[type[Link], tuple[Any, ...]] | None = None
        self._is_moving = False
        self._events: deque[Event] = deque()
        self._deferred: list[Event] = []
        self._objects: dict[type[Link], Link] = {}
        self._data: dict[type[Link], Any] = {}
        self._history: dict[type[Link], type[Link]] = {}
        with self._lock:
            self.set_pending(TOP, ())
            self._settle()

    def getComp(self) -> Any:
        """Return the component that it belongs to."""
        return self._component

    def run_event(self) -> None:
        """Handle the events that have come to the ports of the machine."""
        for take in self.sources:
            while (event := take()) is not None:
                self.dispatch(event)

    def dispatch(self, event: Event, destroy: bool = True) -> None:
        """Handle an event, with all that follows from it; ignore it after the end."""
        with self._lock:
            self._handle(event)
            self._settle()

    def is_current(self, state: type[Link]) -> bool:
        """Return whether it is in a state, or in one within it."""
        return state in _around(self._current)

    def is_current_direct(self, state: type[Link]) -> bool:
        """Return whether it is in a state itself."""
        return self._current is state

    def shutdown(self) -> None:
        """Leave all states."""
        with self._lock:
            for state in _around(self._current):
                self._act(state, "onExit")
            self._current = None

    exit = shutdown

    # what states ask for

    def set_pending(self, state: type[Link], arguments: tuple[Any, ...]) -> None:
        """Have it go to a state next.

        Raises:
            Refused: It is just on its way.
        """
        if self._is_moving:
            raise Refused(f"state {state.__name__} cannot be set in onEntry or onExit")
        self._pending = (state, arguments)

    def forget(self, state: type[Link]) -> None:
        """Forget where it was within a state."""
        self._history.pop(state, None)

    def add_event(self, event: Event) -> None:
        """Have an event handled next."""
        self._events.append(event)

    def add_deferred(self, event: Event) -> None:
        """Have an event handled after the next transition."""
        self._deferred.append(event)

    def object_of(self, state: type[Link]) -> Link:
        """Return the object of a state."""
        if state not in self._objects:
            self._objects[state] = state(self)
        return self._objects[state]

    def data_of(self, state: type[Link]) -> Any:
        """Return the data of a state: of the class `Data` of it, or of one around it; else None."""
        if state not in self._data and hasattr(state, "Data"):
            self._data[state] = state.Data()
        return self._data.get(state)

    # transitions

    def _handle(self, event: Event) -> None:
        if self._current is not None:
            getattr(self.object_of(self._current), event.name)(*event.arguments)

    def _settle(self) -> None:
        """Go on until nothing is left to do."""
        while self._pending or self._events:
            while self._pending:
                self._go(*self._pending)
            if self._events:
                self._handle(self._events.popleft())

    def _go(self, target: type[Link], arguments: tuple[Any, ...]) -> None:
        self._pending = None
        self._move(target)
        last = self._history.pop(target, None)
        if target.has_history and last is not None:
            self.set_pending(last, arguments)
        else:
            self._act(target, "onInit", *arguments)
        deferred, self._deferred = self._deferred, []
        for event in deferred:
            self._handle(event)

    def _move(self, target: type[Link]) -> None:
        left, inner_first = _around(self._current), _around(target)
        self._is_moving = True
        try:
            for state in left:
                if state in inner_first[1:]:
                    break
                self._act(state, "onExit")
            for state in left[1:]:
                self._history[state] = left[0]
            self._current = target
            for state in reversed(inner_first):
                if state is target or state not in left:
                    self._act(state, "onEntry")
        finally:
            self._is_moving = False

    def _act(self, state: type[Link], action: str, *arguments: Any) -> None:
        """Call an action of an author's class; an inherited one is that of another state."""
        getattr(state.author_class, action)(self.object_of(state), *arguments)


def _around(state: type[Link] | None) -> list[type[Link]]:
    """Return a state and those around it, innermost first."""
    found = []
    while state is not None:
        found.append(state)
        state = state.superstate
    return found
