"""The execution context: drives components, as a state machine without a thread.

A pacer calls `tick`: at the rate (PERIODIC), after something happened (EVENT_DRIVEN), or when
somebody asked for it (OTHER). `request`, `request_tick`, `submit`, `stir` and `set_rate` may come
from any thread. Everything that runs component code here runs in the thread that ticks. For
`start`, `stop`, `add_component` and `remove_component` no tick may be under way: while a pacer
drives the context they are handed in with `submit`.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress

from rtkit.component.contexts.callbacks import Failure, attempt
from rtkit.component.contexts.lifecycle import (
    ACTIVE,
    CALLBACK,
    ERROR,
    TARGET,
    LifeCycleEvent,
    next_state,
    refusal,
)
from rtkit.component.contexts.participant import DrivenComponent, Participant
from rtkit.component.contexts.period import check_rate
from rtkit.component.current import current
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, ReturnCode, Transition
from rtkit.rtc.profiles import NOTHING, ExecutionContextProfile

Done = Callable[[ReturnCode, str], object]
_OK = (ReturnCode.OK, "")
_UNWANTED = (ReturnCode.ERROR, "it is not wanted any more")


def always() -> bool:
    """Return True: a request without condition is wanted whenever its turn comes."""
    return True


def nothing() -> None:
    """Do nothing."""


def ignore(component: DrivenComponent) -> None:
    """Ignore a change."""


class ExecutionContext:
    """Drives its participants: life cycle, two passes per period, configuration.

    Attributes:
        id: Its name within the component that owns it.
        owner: Instance name of that component.
        properties: Its further properties, with those of `rtkit.rtc.context_settings`.
        deadline_ns: When the present cycle of a periodic one was due, monotonic [ns].
        missed: Periods at which nothing was done, since it was made.
        trouble: Settings that the system refused; empty for none.
        is_running: Whether ticks do anything.
        wake: Called after a request was queued, by the thread that asked.
        changed: Called by the ticking thread after each change of state or active set.
        watch: Called with instance and callback name before each callback, with two empty texts
            after it; None while nobody watches.
    """

    def __init__(
        self,
        id: str,
        kind: ExecutionKind,
        rate: float,
        owner: str,
        properties: Mapping[str, str] = NOTHING,
    ) -> None:
        self.id = id
        self.kind = kind
        self.owner = owner
        self.properties = properties
        self.deadline_ns = 0
        self.missed = 0
        self.trouble = ""
        self.is_running = False
        self.wake: Callable[[], None] = nothing
        self.changed: Callable[[DrivenComponent], None] = ignore
        self.watch: Callable[[str, str], None] | None = None
        self.is_periodic = kind is ExecutionKind.PERIODIC
        self._rate = check_rate(rate) if self.is_periodic else rate
        self._participants: tuple[Participant, ...] = ()
        self._requests: deque[Callable[[], object]] = deque()
        self._is_stirred = False
        self._has_new_rate = False

    @property
    def rate(self) -> float:
        """Ticks per second [Hz]; 0 where the kind has none."""
        return self._rate

    @property
    def participants(self) -> tuple[DrivenComponent, ...]:
        """The components that it drives, in the order of their execution."""
        return tuple(each.component for each in self._participants)

    @property
    def has_requests(self) -> bool:
        """Return whether anything waits to be done by the ticking thread."""
        return bool(self._requests)

    @property
    def has_work(self) -> bool:
        """Return whether a cycle calls any participant."""
        return self.is_running and any(each.has_work for each in self._participants)

    @property
    def is_idle(self) -> bool:
        """Return whether nothing is to be done before the next `wake`, nor likely to be soon."""
        if self._requests:
            return False
        if not self.is_running:
            return True
        if self._has_new_rate:
            return False
        return not any(
            each.has_work or each.component.takes_settings_from(self) for each in self._participants
        )

    @property
    def is_due(self) -> bool:
        """Return whether a context that is not periodic has reason to tick now."""
        if not self.is_running:
            return False
        return self._is_stirred or any(
            each.component.takes_settings_from(self) for each in self._participants
        )

    def handle_for(self, component: DrivenComponent) -> str:
        """Return the id by which a component knows this context: ``OWNER/ID`` if not its own."""
        return self.id if component.instance == self.owner else f"{self.owner}/{self.id}"

    def state_of(self, component: DrivenComponent) -> LifeCycleState:
        """Return the state of a participant.

        Raises:
            NotFound: It takes no part in this context.
        """
        return self._find(component).state

    def has_work_for(self, component: DrivenComponent) -> bool:
        """Return whether a cycle calls a participant.

        Raises:
            NotFound: It takes no part in this context.
        """
        return self.is_running and self._find(component).has_work

    def profile_for(self, component: DrivenComponent) -> ExecutionContextProfile:
        """Describe this context as one participant sees it.

        Raises:
            NotFound: It takes no part in this context.
        """
        return ExecutionContextProfile(
            id=self.handle_for(component),
            kind=self.kind,
            rate=self._rate,
            owner=self.owner,
            is_running=self.is_running,
            state=self.state_of(component),
            participants=tuple(
                each.component.instance
                for each in self._participants
                if each.component.instance != self.owner
            ),
            properties=self.properties,
            missed=self.missed,
            trouble=self.trouble,
        )

    def start(self) -> ReturnCode:
        """Begin to tick, after on_startup of every participant."""
        if self.is_running:
            return ReturnCode.PRECONDITION_NOT_MET
        for each in self._participants:
            self._report(each, "on_startup")
        self.is_running = True
        self.wake()
        return ReturnCode.OK

    def stop(self) -> ReturnCode:
        """Cease to tick, then on_shutdown of every participant; states stay as they are."""
        if not self.is_running:
            return ReturnCode.PRECONDITION_NOT_MET
        self.is_running = False
        self.serve_requests()
        for each in self._participants:
            self._report(each, "on_shutdown")
        return ReturnCode.OK

    def set_rate(self, hz: float) -> ReturnCode:
        """Change the rate [Hz]; on_rate_changed of every participant follows at the next tick."""
        if not self.is_periodic:
            return ReturnCode.UNSUPPORTED
        try:
            self._rate = check_rate(hz)
        except Malformed:
            return ReturnCode.BAD_PARAMETER
        self._has_new_rate = True
        self._wake_if_possible()
        return ReturnCode.OK

    def set_properties(self, properties: Mapping[str, str]) -> None:
        """Replace the further properties; a thread takes them over, or one tries them."""
        self.properties = properties
        self._wake_if_possible()

    def add_component(self, component: DrivenComponent) -> ReturnCode:
        """Take a living component in, Inactive."""
        if any(each.component is component for each in self._participants):
            return ReturnCode.PRECONDITION_NOT_MET
        if not component.is_alive:
            return ReturnCode.PRECONDITION_NOT_MET
        handle = self.handle_for(component)
        self._participants = (*self._participants, Participant(component, handle))
        component.take_part(self)
        self.notify()
        return ReturnCode.OK

    def remove_component(self, component: DrivenComponent) -> ReturnCode:
        """Let a component go, after it was deactivated if it was Active."""
        try:
            each = self._find(component)
        except NotFound:
            return ReturnCode.BAD_PARAMETER
        if each.state is ACTIVE:
            self._apply(each, Transition.DEACTIVATE)
        self._participants = tuple(other for other in self._participants if other is not each)
        component.leave(self)
        self.changed(component)
        self.notify()
        return ReturnCode.OK

    def order(self, first: tuple[DrivenComponent, ...]) -> None:
        """Execute these participants one after the other, in the place of the first of them."""
        places = {component: place for place, component in enumerate(first)}
        meant = sorted(
            (each for each in self._participants if each.component in places),
            key=lambda each: places[each.component],
        )
        others = [each for each in self._participants if each.component not in places]
        before = itertools.takewhile(lambda p: p.component not in places, self._participants)
        at = len(list(before))
        self._participants = (*others[:at], *meant, *others[at:])

    def activate_component(self, component: DrivenComponent) -> ReturnCode:
        """Activate now; only for the ticking thread, others use `request`."""
        return self.perform(component, Transition.ACTIVATE)[0]

    def deactivate_component(self, component: DrivenComponent) -> ReturnCode:
        """Deactivate now; only for the ticking thread, others use `request`."""
        return self.perform(component, Transition.DEACTIVATE)[0]

    def reset_component(self, component: DrivenComponent) -> ReturnCode:
        """Reset now; only for the ticking thread, others use `request`."""
        return self.perform(component, Transition.RESET)[0]

    def request(
        self,
        component: DrivenComponent,
        transition: Transition,
        done: Done,
        is_wanted: Callable[[], bool] = always,
    ) -> None:
        """Ask for a transition, from any thread; `done` is called once, by the ticking thread.

        Nothing is done if `is_wanted` says no when its turn comes: a callback may have held it up.
        """
        self.submit(
            lambda: done(*(self.perform(component, transition) if is_wanted() else _UNWANTED))
        )

    def request_tick(self, done: Done, is_wanted: Callable[[], bool] = always) -> None:
        """Ask for one cycle, from any thread; as `request`."""
        self.submit(lambda: done(*(self._tick_once() if is_wanted() else _UNWANTED)))

    def submit(self, work: Callable[[], object]) -> None:
        """Have something done between two cycles by the ticking thread, from any thread.

        Raises:
            Refused: Nothing can tick: it will not be done.
        """
        self._requests.append(work)
        try:
            self.wake()
        except Refused:
            self._requests.remove(work)
            raise

    def stir(self) -> None:
        """Ask an event-driven context for a cycle because something happened, from any thread."""
        self._is_stirred = True
        if any(each.has_work for each in self._participants):
            self._wake_if_possible()

    def _wake_if_possible(self) -> None:
        """Wake the pacer; if that is refused, the next reason to tick finds the noted request."""
        with suppress(Refused):
            self.wake()

    def tick(self) -> None:
        """Do what was requested, then one cycle: all execute, then all update.

        A context that is not periodic has a cycle only after it was stirred, and further ones
        while its components read what had arrived.
        """
        if self._requests:
            self.serve_requests()
        if not self.is_running:
            return
        if self.is_periodic:
            self._cycle()
        elif self._is_stirred:
            self._is_stirred = False
            reads = self._read_count()
            self._cycle()
            if self._read_count() > reads and any(p.component.has_changes for p in self._active()):
                self._is_stirred = True
        else:
            for each in self._participants:
                if each.component.takes_settings_from(self):
                    self._take_settings_over(each)

    def _cycle(self) -> None:
        participants = self._participants
        if self._has_new_rate:
            self._announce_rate(participants)
        for each in participants:
            if each.state is ACTIVE:
                if each.executes:
                    self._work(each, "on_execute")
            elif each.state is ERROR and each.handles_error:
                self._endure(each)
        for each in participants:
            if each.state is ACTIVE and each.updates:
                self._work(each, "on_state_update")
            if each.component.takes_settings_from(self):
                self._take_settings_over(each)

    def _tick_once(self) -> tuple[ReturnCode, str]:
        if self.is_periodic:
            why = f"execution context {self.id} is periodic, it ticks by itself"
            return ReturnCode.UNSUPPORTED, why
        if not self.is_running:
            return self._not_running()
        self._cycle()
        return _OK

    def _active(self) -> list[Participant]:
        return [each for each in self._participants if each.state is ACTIVE]

    def _read_count(self) -> int:
        return sum(each.component.read_count for each in self._participants)

    def _take_settings_over(self, each: Participant) -> None:
        before = current.set(each.component.instance)  # whom those who listen to it belong to
        each.component.configuration.update()
        current.reset(before)
        self.changed(each.component)

    def serve_requests(self) -> None:
        """Do what was requested, without a cycle; only for the ticking thread."""
        for _ in range(len(self._requests)):
            self._requests.popleft()()

    def _not_running(self, composite: DrivenComponent | None = None) -> tuple[ReturnCode, str]:
        why = f"execution context {self.id} is not running"
        if composite is not None:
            why = f"a member of {composite.instance} changes its state with that"
        return ReturnCode.PRECONDITION_NOT_MET, f"precondition not met ({why})"

    def perform(self, component: DrivenComponent, transition: Transition) -> tuple[ReturnCode, str]:
        """Perform a transition now and return its outcome; only for the ticking thread."""
        try:
            each = self._find(component)
        except NotFound as error:
            return ReturnCode.BAD_PARAMETER, str(error)
        if not self.is_running:
            return self._not_running(component.composite)
        if transition is Transition.RESET and component.member_components:
            return self._reset_all(each)
        return self._apply(each, transition)

    def _reset_all(self, composite: Participant) -> tuple[ReturnCode, str]:
        """Reset the members of a composite that failed, then itself; all work together again."""
        failures = []
        for member in composite.component.member_components:
            each = next((p for p in self._participants if p.component is member), None)
            if each is None or not (each.state is ERROR or member.member_components):
                continue
            code, why = self.perform(member, Transition.RESET)
            if code is ReturnCode.OK and composite.state is ACTIVE:
                code, why = self.perform(member, Transition.ACTIVATE)
            if code is not ReturnCode.OK:
                failures.append(f"member {member.instance}: {why}")
        if failures:
            return ReturnCode.ERROR, "; ".join(failures)
        return self._apply(composite, Transition.RESET) if composite.state is ERROR else _OK

    def _apply(self, each: Participant, transition: Transition) -> tuple[ReturnCode, str]:
        if each.state is TARGET[transition]:
            return _OK
        event = LifeCycleEvent(transition.value)
        target = next_state(each.state, event)
        if target is None:
            return ReturnCode.PRECONDITION_NOT_MET, refusal(each.state)
        name = CALLBACK[event]
        failure = self._call(each, name)
        if failure and event is LifeCycleEvent.ACTIVATE:
            self._abort(each, name, failure)
            return ReturnCode.ERROR, f"{name} failed: {failure}"
        if failure and event is LifeCycleEvent.RESET:
            each.component.keep_failure(name, failure)
            self.changed(each.component)
            return ReturnCode.ERROR, f"{name} failed: {failure}"
        if failure:
            each.component.report(f"{name} failed: {failure}")
        if event is LifeCycleEvent.RESET:
            each.component.cause = ""
            each.reported = ""
        each.state = target
        self.changed(each.component)
        if self.kind is ExecutionKind.EVENT_DRIVEN:
            self.stir()
        return (ReturnCode.OK, f"{name} failed: {failure}") if failure else _OK

    def _work(self, each: Participant, name: str) -> None:
        failure = self._call(each, name)
        if failure:
            self._abort(each, name, failure)

    def _abort(self, each: Participant, callback: str, failure: Failure) -> None:
        each.state = ERROR
        each.component.keep_failure(callback, failure)
        self._report(each, CALLBACK[LifeCycleEvent.FAIL])
        self.changed(each.component)

    def _endure(self, each: Participant) -> None:
        failure = self._call(each, "on_error")
        if failure and failure != each.reported:
            each.reported = failure
            each.component.report(f"on_error failed: {failure}")

    def _announce_rate(self, participants: tuple[Participant, ...]) -> None:
        self._has_new_rate = False
        for each in participants:
            failure = self._call(each, "on_rate_changed")
            if failure and each.state is not ERROR:
                self._abort(each, "on_rate_changed", failure)
            elif failure:
                each.component.report(f"on_rate_changed failed: {failure}")

    def _report(self, each: Participant, name: str) -> None:
        failure = self._call(each, name)
        if failure:
            each.component.report(f"{name} failed: {failure}")

    def _call(self, each: Participant, name: str) -> Failure:
        callback = getattr(each.component, name)
        if self.watch is None:
            return attempt(callback, each.handle)
        self.watch(each.component.instance, name)
        before = current.set(each.component.instance)
        failure = attempt(callback, each.handle)
        current.reset(before)
        self.watch("", "")
        return failure

    def notify(self) -> None:
        """Have the facts of every participant reported; only for the ticking thread."""
        for each in self._participants:
            self.changed(each.component)

    def _find(self, component: DrivenComponent) -> Participant:
        for each in self._participants:
            if each.component is component:
                return each
        raise NotFound(f"{component.instance} takes no part in execution context {self.id}")
