"""Operations of a container between two cycles: on execution contexts, and on state machines.

Transitions, rates, ticks and participants of contexts; structures and events of machines.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from rtkit.component.base import Component
from rtkit.component.contexts.context import ExecutionContext, always
from rtkit.component.contexts.input_wait import allow_input, leave_input
from rtkit.component.contexts.participant import DrivenComponent
from rtkit.component.contexts.period import check_rate
from rtkit.component.ports.in_port import InPort
from rtkit.container.composites import is_composite
from rtkit.container.context_thread import check
from rtkit.container.operations import LATER, ContainerServices, Operations, answer_code, in_time
from rtkit.deployment.message import Message
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.link.threads import start_thread
from rtkit.rtc.context_settings import SETTINGS, SOME
from rtkit.rtc.enums import LifeCycleState, ReturnCode, Transition

if TYPE_CHECKING:
    from rtkit.component.fsm import FsmComponent

_DRAIN_STEP_S = 0.005


class ExecutionContexts:
    """The operations on the execution contexts of one process."""

    def __init__(self, host: ContainerServices) -> None:
        self._host = host
        self.operations: Operations = {
            "change_state": self._change_state,
            "set_rate": self._set_rate,
            "set_context": self._set_context,
            "tick": self._tick,
            "attach": self._attach,
            "detach": self._detach,
        }

    def _change_state(self, message: Message) -> object:
        component, context = self._of(message)
        is_awaited = message.get("wait", True)

        transition = Transition(message["transition"])

        def done(code: ReturnCode, why: str) -> None:
            _let_wait(component)
            if is_awaited:
                self._later(message, code, _of_component(code, why, component))

        is_wanted = partial(in_time, message) if is_awaited else always

        def request() -> None:
            if transition is Transition.DEACTIVATE:
                _end_waits(component)
            context.request(component, transition, done, is_wanted)

        if message.get("drains_s"):

            def run() -> None:
                _drain(component, float(message["drains_s"]))
                self._host.post(request)

            start_thread(run, f"drain {component.instance}")
        else:
            request()
        return LATER if is_awaited else ""

    def _set_rate(self, message: Message) -> None:
        _, context = self._of(message)
        if not context.is_periodic:
            raise Refused(
                f"execution context {context.id} of {context.owner} has no rate:"
                f" its kind is {context.kind}"
            )
        context.set_rate(check_rate(message["rate"]))
        for each in context.participants:
            self._host.report(each)

    def _set_context(self, message: Message) -> None:
        component, context = self._of(message)
        if context.owner != component.instance:
            raise Refused(f"execution context {context.id} is one of {context.owner}: set it there")
        settings = message["settings"]
        check({f"{SOME}{context.id}.{key}": text for key, text in settings.items()})
        unknown = [key for key in settings if key not in SETTINGS]
        if unknown:
            raise Malformed(f"no setting of execution contexts: {', '.join(unknown)}")
        whole = {**context.properties, **settings}
        context.set_properties({key: text for key, text in whole.items() if text.strip()})
        for each in context.participants:
            self._host.report(each)

    def _tick(self, message: Message) -> object:
        component, context = self._of(message)

        def done(code: ReturnCode, why: str) -> None:
            why = _of_component(code, why, component)
            if code is ReturnCode.OK and (why := _idle(component, context)):
                code = ReturnCode.PRECONDITION_NOT_MET
            self._later(message, code, why)

        context.request_tick(done, partial(in_time, message))
        return LATER

    def _attach(self, message: Message) -> object:
        context, participant = self._shared(message)
        if participant in context.participants:
            raise Refused(
                f"{participant.instance} takes part in execution context {context.id}"
                f" of {context.owner} already"
            )
        self._between_cycles(message, context, lambda: context.add_component(participant))
        return LATER

    def _detach(self, message: Message) -> object:
        context, participant = self._shared(message)
        if participant not in context.participants:
            raise NotFound(
                f"{participant.instance} takes no part in execution context {context.id}"
                f" of {context.owner}"
            )
        owner = self._host.component(message["instance"])
        if participant.composite is not None and is_composite(owner):
            raise Refused(
                f"{participant.instance} is a member of {participant.composite.instance};"
                " take it out of there"
            )
        _end_waits(participant)
        self._between_cycles(message, context, lambda: _removed(context, participant))
        return LATER

    def _of(self, message: Message) -> tuple[Component, ExecutionContext]:
        component = self._host.component(message["instance"])
        id = message["context"]
        try:
            return component, component.participation(id)
        except NotFound:
            raise NotFound(f"no execution context {id} on {component.instance}") from None

    def _shared(self, message: Message) -> tuple[ExecutionContext, Component]:
        owner = self._host.component(message["instance"])
        participant = self._host.component(message["participant"])
        context = owner.contexts.get(message["context"])
        if context is None:
            raise NotFound(f"no execution context {message['context']} on {owner.instance}")
        if participant is owner:
            raise Refused(f"{owner.instance} owns execution context {context.id}")
        return context, participant

    def _between_cycles(
        self, message: Message, context: ExecutionContext, change: Callable[[], ReturnCode]
    ) -> None:
        """Change who takes part, on the thread that ticks, and answer."""
        why = f"precondition not met (execution context {context.id} of {context.owner})"

        def work() -> None:
            if in_time(message):
                self._later(message, change(), why)

        context.submit(work)

    def _later(self, message: Message, code: ReturnCode, why: str) -> None:
        self._host.post(lambda: answer_code(self._host, message, code, why))


def _of_component(code: ReturnCode, why: str, component: Component) -> str:
    """Return why a component refused, with its name; empty if it did not refuse."""
    return why if code is ReturnCode.OK else f"{why}: {component.instance}"


def _idle(component: Component, context: ExecutionContext) -> str:
    """Return why a cycle was none of this component: it failed, or all are at rest."""
    state = context.state_of(component)
    if state is LifeCycleState.ERROR:
        return f"{component.instance} is in Error: {component.cause}"
    if any(context.state_of(each) is LifeCycleState.ACTIVE for each in context.participants):
        return ""
    return f"{component.instance} is {state}: nothing in execution context {context.id} is active"


def release(
    component: Component,
    is_resting: Callable[[ExecutionContext], bool],
    rested: Callable[[], object],
) -> int:
    """Have every context deactivate a component, and let it go if it is not its own.

    Args:
        component: The one that is to end.
        is_resting: Whether a context of its own has no thread at work, nor a reason for one.
        rested: Called by each context that had something to do, on its own thread.

    Returns:
        How many those are.
    """
    count = 0
    _end_waits(component)
    for context in component.participations:
        if context.owner != component.instance:
            context.submit(partial(_let_go, context, component, rested))
        elif is_resting(context) and context.state_of(component) is not LifeCycleState.ACTIVE:
            continue  # which saves a thread
        elif context.is_running:
            context.request(component, Transition.DEACTIVATE, lambda _code, _why: rested())
        else:
            continue
        count += 1
    return count


def _end_waits(component: DrivenComponent) -> None:
    """Have what it, or a member of it, waits for from people be waited for no longer."""
    leave_input(component.instance)
    for member in component.member_components:
        _end_waits(member)


def _let_wait(component: DrivenComponent) -> None:
    allow_input(component.instance)
    for member in component.member_components:
        _let_wait(member)


def _removed(context: ExecutionContext, participant: Component) -> ReturnCode:
    code = context.remove_component(participant)
    _let_wait(participant)
    return code


def _let_go(context: ExecutionContext, component: Component, rested: Callable[[], object]) -> None:
    context.remove_component(component)
    rested()


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
            self._host.report(component)
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


def _drain(component: Component, timeout_s: float) -> None:
    """Wait until a component has read all that arrived, for so long at most [s]."""
    until = monotonic() + timeout_s
    ports = [port for port in component.ports.values() if isinstance(port, InPort)]
    while any(port.unread for port in ports) and monotonic() < until:
        sleep(_DRAIN_STEP_S)
