"""Trials: components driven by hand in a test, with time, values and services of the test."""

from __future__ import annotations

import inspect
import os
import re
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import is_dataclass
from typing import Any, Generic, TypeVar

from rtkit.closing import Closing
from rtkit.component.base import Component
from rtkit.component.configuration.kinds import kind_of
from rtkit.component.fsm import EVENT_NAME, EventPort
from rtkit.component.ports.any_port import Port
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.services.invocation import Direct, ProvidedInterface
from rtkit.component.services.service import ServicePort
from rtkit.component.types import Time
from rtkit.component.values.carried import carried
from rtkit.component.values.literal import zero_value
from rtkit.component.values.typenames import type_name
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import LifeCycleState, ReturnCode
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.profiles import ConnectorProfile

C = TypeVar("C", bound=Component)
_EXECUTION_CONTEXT = "PeriodicExecutionContext"


class Trial(Closing, Generic[C]):
    """Drives one component by hand, in this process, without a manager or a clock.

    ::

        with Trial(Scale, {"conf.default.factor": "3"}) as trial:
            trial.activate()
            trial.send("in", TimedLong(data=2))
            trial.tick()
            assert [value.data for value in trial.received("out")] == [6]

    With a `clock` it has a time of its own: each tick moves it on by a period, `wait` and
    ``time.sleep`` by as much as their argument. Code that asks the module ``time`` sees it, as long
    as one of the methods here runs it. `run` has the component do its cycles for a while.

    A test that fails in the ``with`` block is told the state of the component if it is not Active,
    and of one in Error the reason.

    Attributes:
        component: The component, initialised.
    """

    def __init__(
        self,
        component_class: type[C],
        options: Mapping[str, str] | None = None,
        *,
        clock: float | None = None,
    ) -> None:
        """Make and initialise the component.

        Args:
            component_class: Its class.
            options: As a create string has them.
            clock: When its own time begins [s since 1970]; None for the time of the machine.

        Raises:
            Refused: on_initialize failed; the message has the exception and the line.
            Malformed: An option has a value that it cannot have.
        """
        if not (isinstance(component_class, type) and issubclass(component_class, Component)):
            raise TypeError(f"a trial is of a class of components, not of {component_class!r}")
        self._clock = _Clock(clock) if clock is not None else None
        name = f"{component_class.type_profile().type_name}0"
        context = {"execution_contexts": _EXECUTION_CONTEXT}
        with self._time():
            self.component = component_class(name, {**context, **(options or {})})
        self._written: dict[str, list[Any]] = {}
        self._sinks: dict[str, Any] = {}
        with self._time():
            self.component.initialize()
        self._context = next(iter(self.component.contexts.values()))
        for port_name, port in self.component.ports.items():
            if isinstance(port, OutPort):
                self._written[port_name] = []
                port.attach("trial", self._written[port_name].append)

    @property
    def state(self) -> LifeCycleState:
        """The life-cycle state of the component."""
        return self._context.state_of(self.component)

    def activate(self) -> None:
        """Make the component active.

        Raises:
            Refused: on_activated failed, or the component is in Error.
        """
        with self._time():
            self._change(self._context.activate_component(self.component))

    def deactivate(self) -> None:
        """Make the component inactive.

        Raises:
            Refused: It is in Error.
        """
        with self._time():
            self._change(self._context.deactivate_component(self.component))

    def reset(self) -> None:
        """Bring the component from Error to Inactive.

        Raises:
            Refused: on_reset failed.
        """
        with self._time():
            self._change(self._context.reset_component(self.component))

    def tick(self, count: int = 1) -> None:
        """Have the execution context do its cycle.

        A failure leads to Error, as always; `component.cause` states why.
        """
        for _ in range(count):
            with self._time():
                self._context.tick()
            if self._clock is not None:
                self._clock.move(1 / self._context.rate)

    def run(self, duration_s: float) -> None:
        """Tick as often as the execution context does in a while [s]; no real time passes.

        Raises:
            Refused: The trial has no clock of its own.
            Malformed: Time does not go back.
        """
        self.wait(min(duration_s, 0.0))
        self.tick(round(duration_s * self._context.rate))

    def wait(self, duration_s: float) -> None:
        """Let time pass [s] without a tick.

        Raises:
            Refused: The trial has no clock of its own.
            Malformed: Time does not go back.
        """
        if self._clock is None:
            raise Refused("this trial has no clock of its own: give it one, clock=0")
        if duration_s < 0:
            raise Malformed(f"time does not go back: {duration_s:g} s")
        self._clock.move(duration_s)

    def configure(self, values: Mapping[str, Any], set_id: str = "") -> None:
        """Change parameters of a configuration set, by default of the active one, and activate it.

        The values are in force at once.

        Raises:
            NotFound: No such set or parameter.
            Malformed: A value that a parameter cannot have.
        """
        configuration = self.component.configuration
        set_id = set_id or configuration.active_set
        texts = {name: _text(value) for name, value in values.items()}
        try:
            configuration.set(set_id, texts)
        except NotFound as error:
            known = configuration.sets.get(set_id, {})
            missing = next((name for name in texts if name not in known), "") if known else set_id
            hint = did_you_mean(missing, known or configuration.sets)
            raise NotFound(f"{self.component.instance}: {error}{hint}") from None
        configuration.activate(set_id)
        configuration.update()

    def provide(self, port: str, implementation: object) -> None:
        """Connect a port that needs services to an object that does them, in place of any other.

        Raises:
            NotFound: No port of that name needs a service.
            Refused: The object lacks methods of an interface, or one of them cannot be called as
                the interface says; names them, and where it is.
        """
        found = self.component.ports.get(port)
        if not isinstance(found, ServicePort) or not found.needed:
            needing = {
                name: each
                for name, each in self.component.ports.items()
                if isinstance(each, ServicePort) and each.needed
            }
            raise self._no_port("port", port, needing, " that needs a service")
        where = f"{self.component.instance}.{port}"
        for interface in found.needed:
            interface.check(implementation, where)
        found.detach(f"trial {port}")
        targets = {
            interface.name: Direct(ProvidedInterface(interface, implementation, where, _nothing))
            for interface in found.needed
        }
        found.attach(ConnectorProfile(f"trial {port}", port, ()), targets)

    def send(self, port: str, value: Any = None, *, event: str = "") -> None:
        """Let a value arrive at an in port, by default the one with everything zero.

        Args:
            port: Name of the port.
            value: What arrives.
            event: Which event it is, at the event port of a state machine.

        Raises:
            NotFound: No such in port.
            Refused: No such event.
            Malformed: The value is none of the port's type, or of the event's; names the line that
                declares the port.
        """
        found = self.component.ports.get(port)
        if not isinstance(found, InPort):
            ins = {n: each for n, each in self.component.ports.items() if isinstance(each, InPort)}
            raise self._no_port("in port", port, ins)
        key = f"trial {port} {event}"
        if key not in self._sinks:
            properties = {EVENT_NAME: event} if event else {}
            self._sinks[key] = found.open(ConnectorProfile(key, key, (), properties))
        kind = found.events[event] if isinstance(found, EventPort) else found.data_type
        if value is None:
            with self._time():
                value = zero_value(kind, Time.now())
        try:
            if is_dataclass(kind) and not _is_like(value, kind):
                raise Malformed(f"{kind.__name__} is wanted, not {type(value).__name__}: {value!r}")
            sent = carried(kind, value)
        except Malformed as error:
            where = declared_at(self.component, found)
            raise Malformed(f"{self.component.instance}:{port}: {error} ({where})") from error
        self._sinks[key](sent)

    def received(self, port: str) -> list[Any]:
        """Return what an out port has written since the last call.

        Raises:
            NotFound: No such out port.
        """
        if port not in self._written:
            raise self._no_port("out port", port, self._written)
        values = list(self._written[port])
        self._written[port].clear()
        return values

    @property
    def trouble(self) -> str:
        """Reason of its Error: exception, file, line and callback; "" when it is not in Error."""
        is_well = self.state is not LifeCycleState.ERROR
        return "" if is_well else f"{self.component.instance} is in Error: {self.component.cause}"

    def close(self) -> None:
        """Finalise the component."""
        with self._time():
            self.component.finalize()

    def __exit__(self, *raised: object) -> None:
        if isinstance(raised[1], Exception) and self.state is not LifeCycleState.ACTIVE:
            raised[1].add_note(self.trouble or f"{self.component.instance} is {self.state}")
        self.close()

    def _no_port(self, kind: str, port: str, known: Iterable[str], more: str = "") -> NotFound:
        has = ", ".join(known) or "none"
        hint = did_you_mean(port, known)
        return NotFound(f"{self.component.instance} has no {kind} {port}{more}, but {has}{hint}")

    def _time(self) -> AbstractContextManager[None]:
        return nullcontext() if self._clock is None else self._clock.installed()

    def _change(self, code: ReturnCode) -> None:
        cause = self.component.cause
        if code is not ReturnCode.OK or self.state is LifeCycleState.ERROR:
            raise Refused(f"{self.component.instance}: {cause or code} (it is {self.state})")


class _Clock:
    """A clock that advances only by hand."""

    def __init__(self, begin_s: float) -> None:
        self._now_ns = round(begin_s * 1e9)

    def move(self, duration_s: float) -> None:
        """Let time pass [s]."""
        self._now_ns += round(duration_s * 1e9)

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Have the module `time` return this time."""
        clocks = {
            name: lambda: self._now_ns / 1e9 for name in ("time", "monotonic", "perf_counter")
        }
        clocks_ns = {f"{name}_ns": lambda: self._now_ns for name in clocks}
        with ExitStack() as stack:
            for name, function in {**clocks, **clocks_ns, "sleep": self.move}.items():
                stack.callback(setattr, time, name, getattr(time, name))
                setattr(time, name, function)
            yield


def declared_at(component: Component, port: Port) -> str:
    """Return ``Scale.py:12``, the line that declares a port, or where its component's class begins.

    A port that is no attribute of the class was added when the component was made.
    """
    for cls in type(component).__mro__:
        for attribute, value in vars(cls).items():
            if isinstance(value, Port) and getattr(component, attribute) is port:
                return _line_of(cls, rf"\s+{attribute}\s*[:=]")
    return _line_of(type(component), "")


def _line_of(cls: type, pattern: str) -> str:
    try:
        lines, first = inspect.getsourcelines(cls)
    except (OSError, TypeError):  # typed into a shell, or not written in Python
        return f"{cls.__module__}.{cls.__qualname__}"
    numbers = (number for number, line in enumerate(lines, first) if re.match(pattern, line))
    return f"{os.path.basename(inspect.getfile(cls))}:{next(numbers, first)}"


def _is_like(value: object, kind: type) -> bool:
    """Return whether a value is of a data type, perhaps of another import of its module."""
    cls = type(value)
    return isinstance(value, kind) or (is_dataclass(cls) and type_name(cls) == type_name(kind))


def _text(value: Any) -> str:
    return value if isinstance(value, str) else kind_of(value).write(value)


def _nothing() -> None:
    """Receive a call and do nothing about it."""
