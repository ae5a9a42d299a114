"""Stand-ins: components generated from a pattern, for types whose code is not at hand.

A stand-in has the ports, configuration sets, contexts and identity that the pattern says. It
may write values: those of the pattern's script one after another, or, with the option
``standin.transmit=default``, the zero value of each out port's type, once each period. With that
option it also answers calls of the interfaces it provides, where their operations are known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import cycle
from typing import Any

from rtkit.component.base import ACTIVE_SET, Component
from rtkit.component.ports.any_port import Port
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.services.service import ServicePort
from rtkit.component.types import Time
from rtkit.component.values.literal import Literal, zero_value
from rtkit.component.values.typenames import type_by_name
from rtkit.errors import Malformed, NotFound
from rtkit.rtc.enums import PortType, ReturnCode
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import PortProfile

TRANSMIT = "standin.transmit"
_CONTEXT_OPTIONS = ("execution_contexts", "exec_cxt.periodic.rate", "exec_cxt.periodic.type")


class StandIn(Component):
    """A component that has the outside of another and no code of its own."""

    is_stand_in = True

    def __init__(
        self, pattern: ComponentPattern, instance: str, options: Mapping[str, str] | None = None
    ) -> None:
        self._pattern = pattern
        super().__init__(instance, options)
        self.type = pattern.type
        for port in pattern.ports:
            self._add(_port(port, answers=_talks(self.options)))

    def _wanted_contexts(self) -> tuple[ContextPattern, ...]:
        if any(key in self.options for key in _CONTEXT_OPTIONS):
            return super()._wanted_contexts()
        return self._pattern.contexts

    def _configure(self) -> None:
        self.configuration.adopt(self._pattern.sets, self._pattern.active_set)
        self._declare_options()
        if ACTIVE_SET in self.options:
            self.configuration.activate(self.options[ACTIVE_SET])
            self.configuration.update()


class Transmitter(StandIn):
    """A stand-in that writes values while it is active."""

    def __init__(
        self, pattern: ComponentPattern, instance: str, options: Mapping[str, str] | None = None
    ) -> None:
        super().__init__(pattern, instance, options)
        self._writers = list(self._make_writers())

    def on_execute(self, context: str) -> ReturnCode | None:
        """Write the next value of each out port."""
        now = Time.now()
        for write in self._writers:
            write(now)
        return None

    def _make_writers(self) -> list[Callable[[Time], Any]]:
        writers = []
        for name, texts in self._pattern.script.items():
            port = self.ports.get(name)
            if not isinstance(port, OutPort):
                raise NotFound(f"{self.instance}: the script names no out port: {name}")
            if texts:
                writers.append(_scripted(port, texts))
        if _talks(self.options):
            writers += [
                _idle(port)
                for port in self.ports.values()
                if isinstance(port, OutPort) and not self._pattern.script.get(port.name)
            ]
        return writers


def stand_in(
    pattern: ComponentPattern, instance: str, options: Mapping[str, str] | None = None
) -> StandIn:
    """Return a stand-in for the pattern; a stand-in that never writes has no on_execute.

    Raises:
        Malformed: A value of the script is not of its port's type; names port and field.
        NotFound: The script names a port that is no out port.
    """
    kind = Transmitter if pattern.script or _talks(options or {}) else StandIn
    return kind(pattern, instance, options)


def _talks(options: Mapping[str, str]) -> bool:
    """Return whether it is to write default values, and to answer with them.

    Raises:
        Malformed: That cannot be read.
    """
    talks = options.get(TRANSMIT, "").strip().lower()
    if talks not in ("", "none", "default"):
        raise Malformed(f"{TRANSMIT}={talks}: not default or none")
    return talks == "default"


def is_stand_in(component: Component) -> bool:
    """Return whether the component was generated from data."""
    return isinstance(component, StandIn)


def _port(profile: PortProfile, *, answers: bool) -> Port:
    if profile.port_type is PortType.SERVICE:
        service = _service_port(profile, answers=answers)
        service.properties = dict(profile.properties)
        return service
    kind: type[InPort[Any]] | type[OutPort[Any]] = (
        InPort if profile.port_type is PortType.IN else OutPort
    )
    port: Port = kind(type_by_name(profile.data_type) or bytes, profile.name)
    port.properties = dict(profile.properties)
    return port


def _service_port(profile: PortProfile, *, answers: bool) -> ServicePort:
    if not answers or not profile.definition:
        return ServicePort(profile.name, profile.interfaces)
    from rtkit.component.standin_services import answering  # it reads IDL

    return answering(profile)


def _scripted(port: OutPort[Any], texts: tuple[str, ...]) -> Callable[[Time], Any]:
    try:
        values = cycle([Literal(port.data_type, text) for text in texts])
    except Malformed as error:
        raise Malformed(f"script of port {port.name}: {error}") from None
    return lambda now: port.write(next(values).at(now))


def _idle(port: OutPort[Any]) -> Callable[[Time], Any]:
    return lambda now: port.write(zero_value(port.data_type, now))
