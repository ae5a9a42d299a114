"""Ports that events of a state machine arrive at; ``OpenRTM_aist.EventPort``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from rtkit.component.fsm import EventPort
from rtkit.openrtm.api.ports import PortBase
from rtkit.openrtm.api.static_fsm import Event, Machine
from rtkit.openrtm.corba.twins import frozen_class_of, thawer_of


class EventInPort(PortBase):
    """A port whose events a machine handles, at its next `run_event`.

    A connector brings the event of its property ``fsm_event_name``, else of its own name or that
    of the out port.
    """

    port: EventPort
    port_class: ClassVar[type[EventPort]] = EventPort

    def __init__(self, name: str, fsm: Machine, *_: Any, **__: Any) -> None:
        super().__init__(name)
        self.port = self.port_class(name)
        self._makers: dict[str, Callable[[Any], Event]] = {}
        fsm.sources.append(self._take)

    def bindEvent0(self, name: str, handler: Callable[..., Any]) -> None:
        """Have a method of the state called at each event of a name, whatever its value."""
        self._bind(name, bytes, lambda _value: Event(handler))

    def bindEvent1(self, name: str, handler: Callable[..., Any], data_type: Any) -> None:
        """Have a method of the state called with the value of each event of a name."""
        cls = frozen_class_of(data_type)
        thaw = thawer_of(cls)
        self._bind(name, cls, lambda value: Event(handler, thaw(value)))

    def _bind(self, name: str, cls: type, make: Callable[[Any], Event]) -> None:
        self._makers[name] = make
        self.port.events = {**self.port.events, name: cls}

    def _take(self) -> Event | None:
        item = self.port.take()
        return None if item is None else self._makers[item[0]](item[1])
