"""Tools for tests of components: a trial driven by hand, and a private manager."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rtkit.closing import Closing
from rtkit.component.base import Component
from rtkit.component.carried import carried
from rtkit.component.fsm import EVENT_NAME, EventPort
from rtkit.component.invocation import Direct, ProvidedInterface
from rtkit.component.kinds import kind_of
from rtkit.component.literal import zero_value
from rtkit.component.port import InPort, OutPort
from rtkit.component.service import ServicePort
from rtkit.component.types import Time
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import LifeCycleState, ReturnCode
from rtkit.rtc.profiles import ConnectorProfile

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

C = TypeVar("C", bound=Component)
_TIMEOUT_S = 20.0
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
    as one of the methods here runs it.

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
        """
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
            Refused: on_activated failed, or the component is not Inactive.
        """
        with self._time():
            self._change(self._context.activate_component(self.component))

    def deactivate(self) -> None:
        """Make the component inactive.

        Raises:
            Refused: It is not active.
        """
        with self._time():
            self._change(self._context.deactivate_component(self.component))

    def reset(self) -> None:
        """Bring the component from Error to Inactive.

        Raises:
            Refused: It is not in Error, or on_reset failed.
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

    def wait(self, duration_s: float) -> None:
        """Let time pass [s] without a tick.

        Raises:
            Refused: The trial has no clock of its own.
        """
        if self._clock is None:
            raise Refused("this trial has no clock of its own: give it one, clock=0")
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
        configuration.set(set_id, texts)
        configuration.activate(set_id)
        configuration.update()

    def provide(self, port: str, implementation: object) -> None:
        """Connect a port that needs services to an object that does them, in place of any other.

        Raises:
            NotFound: No port of that name needs a service.
            Refused: The object lacks methods of an interface; names them.
        """
        found = self.component.ports.get(port)
        if not isinstance(found, ServicePort) or not found.needed:
            raise NotFound(f"{self.component.instance} has no port {port} that needs a service")
        where = f"{self.component.instance}.{port}"
        for interface in found.needed:
            missing = ", ".join(interface.missing_in(implementation))
            if missing:
                what = f"{type(implementation).__name__} does not implement {interface.name}"
                raise Refused(f"{where}: {what}: it lacks {missing}")
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
            Malformed: The value is none of the port's type, or of the event's.
        """
        found = self.component.ports.get(port)
        if not isinstance(found, InPort):
            raise NotFound(f"{self.component.instance} has no in port {port}")
        key = f"trial {port} {event}"
        if key not in self._sinks:
            properties = {EVENT_NAME: event} if event else {}
            self._sinks[key] = found.open(ConnectorProfile(key, key, (), properties))
        kind = found.events[event] if isinstance(found, EventPort) else found.data_type
        if value is None:
            with self._time():
                value = zero_value(kind, Time.now())
        try:
            sent = carried(kind, value)
        except Malformed as error:
            raise Malformed(f"{self.component.instance}:{port}: {error}") from error
        self._sinks[key](sent)

    def received(self, port: str) -> list[Any]:
        """Return what an out port has written since the last call.

        Raises:
            NotFound: No such out port.
        """
        if port not in self._written:
            raise NotFound(f"{self.component.instance} has no out port {port}")
        values = list(self._written[port])
        self._written[port].clear()
        return values

    def close(self) -> None:
        """Finalise the component."""
        with self._time():
            self.component.finalize()

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


def _text(value: Any) -> str:
    return value if isinstance(value, str) else kind_of(value).write(value)


def _nothing() -> None:
    """Receive a call and do nothing about it."""


@contextmanager
def own_manager(*folders: str | Path) -> Iterator[Tree]:
    """Start a manager in temporary folders; end it, and all that it created, on exit.

    The manager looks for modules in `folders`. `rtkit.connect` reaches it until it has ended. ::

        with own_manager(Path(__file__).parent) as tree:
            tree.create("Scale?manager_name=other")

    Raises:
        Refused: It cannot be started.
    """
    from rtkit.manager.launch import start
    from rtkit.settings.configuration import CommandLineSettings
    from rtkit.tree.connect import connect
    from rtkit.tree.managers import stop

    # A socket's path may have 107 bytes, less than folders made for tests often take.
    base = Path(tempfile.mkdtemp(prefix="rtk"))
    for name in ("run", "state"):
        (base / name).mkdir(mode=0o700)
    (base / "rtc.conf").touch(mode=0o600)
    wished = {
        "RTKIT_RUNTIME_DIR": str(base / "run"),
        "RTKIT_STATE_DIR": str(base / "state"),
        "RTKIT_MODULE_PATH": os.pathsep.join(str(Path(each).resolve()) for each in folders),
        "RTKIT_PORT": "none",
        "RTKIT_MANAGER": "manager",
    }
    with _environment(wished):
        try:
            pid = start("manager", CommandLineSettings(str(base / "rtc.conf")), _TIMEOUT_S).pid
            try:
                with connect("manager", _TIMEOUT_S) as tree:
                    yield tree
            finally:
                stop("manager", _TIMEOUT_S)
                os.waitpid(pid, 0)
        finally:
            shutil.rmtree(base)


@contextmanager
def _environment(wished: Mapping[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in wished}
    os.environ.update(wished)
    try:
        yield
    finally:
        for name, text in before.items():
            if text is None:
                del os.environ[name]
            else:
                os.environ[name] = text
