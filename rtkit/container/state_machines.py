"""Operations of a container on state machines: structures and events, between two cycles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rtkit.container.operations import LATER, ContainerServices, Operations, in_time
from rtkit.deployment.message import Message
from rtkit.errors import Malformed, Refused, RtkitError

if TYPE_CHECKING:
    from rtkit.component.fsm import FsmComponent


class StateMachines:
    """The operations on the state machines of one process."""

    def __init__(self, host: ContainerServices) -> None:
        self._host = host
        self.operations: Operations = {
            "set_structure": self._set_structure,
            "set_events": self._set_events,
        }

    def _set_structure(self, message: Message) -> object:
        component, table = self._fsm(message), _table(message["states"])
        return self._change(message, component, lambda: component.set_structure(table))

    def _set_events(self, message: Message) -> object:
        component, events = self._fsm(message), _texts(message["events"])
        return self._change(message, component, lambda: component.set_events(events))

    def _fsm(self, message: Message) -> FsmComponent:
        from rtkit.component.fsm import FsmComponent

        component = self._host.component(message["instance"])
        if not isinstance(component, FsmComponent):
            raise Refused(f"{component.instance} has no state machine")
        return component

    def _change(
        self, message: Message, component: FsmComponent, change: Callable[[], None]
    ) -> object:
        def work() -> None:
            error: RtkitError | None = None
            if not in_time(message):
                return
            try:
                change()
            except RtkitError as failure:
                error = failure
            self._host.post(lambda: self._changed(message, component, error))

        context = next((c for c in component.participations if c.is_running), None)
        if context is None:
            work()
        else:
            context.submit(work)
        return LATER

    def _changed(self, message: Message, component: FsmComponent, error: RtkitError | None) -> None:
        if error is None:
            self._host.tell(component)
            self._host.answer(message, "")
        else:
            self._host.refuse(message, error)


def _table(data: Any) -> dict[str, dict[str, str]]:
    if not isinstance(data, Mapping):
        raise Malformed("states are a table")
    return {str(state): _texts(moves) for state, moves in data.items()}


def _texts(data: Any) -> dict[str, str]:
    if not isinstance(data, Mapping):
        raise Malformed("expected a table of texts")
    return {str(key): str(value) for key, value in data.items()}
