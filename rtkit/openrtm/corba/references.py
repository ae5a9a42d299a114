"""Objects of the RTC model that components hold references to: components, ports, contexts.

Within a process a reference is the object itself, so narrowing it changes nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtkit.openrtm.corba.enumerations import ITEMS, item_for
from rtkit.openrtm.corba.records import ExecutionContextProfile, name_values
from rtkit.rtc.enums import LifeCycleState, ReturnCode, Transition

if TYPE_CHECKING:
    from rtkit.component.contexts.context import ExecutionContext as Context


class Reference:
    """Base of objects that are referred to."""

    _nil = None

    def _narrow(self, kind: type) -> Any:
        return self if isinstance(self, kind) else None

    def _this(self) -> Any:
        return self

    def _is_equivalent(self, other: object) -> bool:
        return self is other

    def _non_existent(self) -> bool:
        return False

    def _duplicate(self) -> Any:
        return self


class PortService(Reference):
    """A port."""


class RTObject(Reference):
    """A component."""


DataFlowComponent = RTObject


class ExecutionContext(Reference):
    """An execution context."""


ExecutionContextService = ExecutionContext


class OwnExecutionContext(ExecutionContext):
    """An execution context that drives a component of this process."""

    def __init__(self, context: Context) -> None:
        self._context = context

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OwnExecutionContext) and other._context is self._context

    def __hash__(self) -> int:
        return hash(id(self._context))

    def activate_component(self, reference: Any) -> Any:
        """Ask for a component to become Active; its context does so between two cycles."""
        return self._request(reference, Transition.ACTIVATE, LifeCycleState.INACTIVE)

    def deactivate_component(self, reference: Any) -> Any:
        """Ask for a component to become Inactive."""
        return self._request(reference, Transition.DEACTIVATE, LifeCycleState.ACTIVE)

    def reset_component(self, reference: Any) -> Any:
        """Ask for a component to leave Error."""
        return self._request(reference, Transition.RESET, LifeCycleState.ERROR)

    def _request(self, reference: Any, transition: Transition, wanted: LifeCycleState) -> Any:
        component = getattr(reference, "rtkit_component", None)
        if component is None or component not in self._context.participants:
            return ITEMS["BAD_PARAMETER"]
        if self._context.state_of(component) is not wanted:
            return ITEMS["PRECONDITION_NOT_MET"]
        self._context.request(component, transition, _ignore)
        return ITEMS["RTC_OK"]

    def get_component_state(self, reference: Any) -> Any:
        """Return the state of a component in this context; CREATED of one that is not in it."""
        component = reference.rtkit_component
        if component not in self._context.participants:
            return ITEMS["CREATED_STATE"]
        return item_for(self._context.state_of(component))

    def set_rate(self, rate: float) -> Any:
        """Change the rate [Hz]."""
        return item_for(self._context.set_rate(float(rate)))

    def get_rate(self) -> float:
        """Return the rate [Hz]."""
        return self._context.rate

    def is_running(self) -> bool:
        """Return whether it ticks."""
        return self._context.is_running

    def start(self) -> Any:
        """Begin to tick."""
        return self._switch(self._context.start, is_running=True)

    def stop(self) -> Any:
        """Cease to tick."""
        return self._switch(self._context.stop, is_running=False)

    def _switch(self, switch: Any, *, is_running: bool) -> Any:
        if self._context.is_running is is_running:
            return ITEMS["PRECONDITION_NOT_MET"]
        self._context.submit(switch)
        return ITEMS["RTC_OK"]

    def tick(self) -> Any:
        """Ask for a cycle of one that others drive; it does so when it is idle."""
        if self._context.is_periodic:
            return ITEMS["PRECONDITION_NOT_MET"]
        self._context.request_tick(_ignore)
        return ITEMS["RTC_OK"]

    def get_kind(self) -> Any:
        """Return what drives it."""
        return ITEMS[self._context.kind.value]

    def get_profile(self) -> ExecutionContextProfile:
        """Describe it."""
        context = self._context
        references = [getattr(each, "servant", each) for each in context.participants]
        owner = next((each for each in references if _name(each) == context.owner), None)
        others = [each for each in references if each is not owner]
        properties = name_values(dict(context.properties))
        return ExecutionContextProfile(self.get_kind(), context.rate, owner, others, properties)


def _name(reference: Any) -> str:
    component = getattr(reference, "rtkit_component", reference)
    return str(component.instance)


def _ignore(code: ReturnCode, why: str) -> None:
    """Leave the outcome of a request to the log of the component."""
