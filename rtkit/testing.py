"""What tests of components need: one driven by hand, and a manager that nobody else sees."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rtkit.closing import Closing
from rtkit.component.base import Component
from rtkit.component.fsm import EVENT_NAME, EventPort
from rtkit.component.literal import zero_value
from rtkit.component.port import InPort, OutPort
from rtkit.component.types import Time
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import LifeCycleState, ReturnCode
from rtkit.rtc.profiles import ConnectorProfile

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

C = TypeVar("C", bound=Component)
_TIMEOUT_S = 20.0
_EXECUTION_CONTEXT = "PeriodicExecutionContext"


class Trial(Closing, Generic[C]):
    """A component of its own, driven by hand, in this process, without a manager or a clock.

    ::

        with Trial(Scale, {"conf.default.factor": "3"}) as trial:
            trial.activate()
            trial.send("in", TimedLong(data=2))
            trial.tick()
            assert [value.data for value in trial.received("out")] == [6]

    Attributes:
        component: The component, initialised.
    """

    def __init__(self, component_class: type[C], options: Mapping[str, str] | None = None) -> None:
        name = f"{component_class.type_profile().type_name}0"
        context = {"execution_contexts": _EXECUTION_CONTEXT}
        self.component = component_class(name, {**context, **(options or {})})
        self._written: dict[str, list[Any]] = {}
        self._sinks: dict[str, Any] = {}
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
        self._change(self._context.activate_component(self.component))

    def deactivate(self) -> None:
        """Make the component inactive.

        Raises:
            Refused: It is not active.
        """
        self._change(self._context.deactivate_component(self.component))

    def reset(self) -> None:
        """Bring the component from Error to Inactive.

        Raises:
            Refused: It is not in Error, or on_reset failed.
        """
        self._change(self._context.reset_component(self.component))

    def tick(self, count: int = 1) -> None:
        """Have the execution context do its cycle.

        A failure leads to Error, as always; `component.cause` tells why.
        """
        for _ in range(count):
            self._context.tick()

    def send(self, port: str, value: Any = None, *, event: str = "") -> None:
        """Let a value arrive at an in port, by default the one with everything zero.

        Args:
            port: Name of the port.
            value: What arrives.
            event: Which event it is, at the event port of a state machine.

        Raises:
            NotFound: No such in port.
            Refused: No such event.
        """
        found = self.component.ports.get(port)
        if not isinstance(found, InPort):
            raise NotFound(f"{self.component.instance} has no in port {port}")
        key = f"trial {port} {event}"
        if key not in self._sinks:
            properties = {EVENT_NAME: event} if event else {}
            self._sinks[key] = found.open(ConnectorProfile(key, key, (), properties))
        if value is None:
            kind = found.events[event] if isinstance(found, EventPort) else found.data_type
            value = zero_value(kind, Time.now())
        self._sinks[key](value)

    def received(self, port: str) -> list[Any]:
        """Return what an out port has written since this was asked last.

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
        self.component.finalize()

    def _change(self, code: ReturnCode) -> None:
        cause = self.component.cause
        if code is not ReturnCode.OK or self.state is LifeCycleState.ERROR:
            raise Refused(f"{self.component.instance}: {cause or code} (it is {self.state})")


@contextmanager
def own_manager(*folders: str | Path) -> Iterator[Tree]:
    """Start a manager in folders of its own, and end it with all that it made.

    It looks for modules in `folders`. Until it has ended, `rtkit.connect` leads to it. ::

        with own_manager(Path(__file__).parent) as tree:
            tree.create("Scale?manager_name=other")

    Raises:
        Refused: It cannot be started.
    """
    from rtkit.manager.launch import start
    from rtkit.manager.settings.configuration import Wanted
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
            pid = start("manager", Wanted(str(base / "rtc.conf")), _TIMEOUT_S).pid
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
