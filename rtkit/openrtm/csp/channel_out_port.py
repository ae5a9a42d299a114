"""An out port whose connectors may be channels, as those of CSP in OpenRTM are.

The in port of a channel asks for a value when it has room for one, and the out port hands one over
to whom asks: so the writer knows that it was taken, within a process and between two.
"""

from __future__ import annotations

from collections import deque
from typing import Any

from rtkit.component.ports.buffer import Source
from rtkit.component.ports.connector_events import ConnectorEvent
from rtkit.component.ports.options import PortStatus, is_channel
from rtkit.component.ports.out_port import OutPort
from rtkit.openrtm.csp.meeting import CHANNELS, Meeting
from rtkit.rtc.profiles import ConnectorProfile

_ASK_S = 1.0
"""How long one who asks is kept waiting [s]; less than in ports wait for an answer."""


class _Asking:
    """A reader at the other end of a channel that waits for a value."""

    def __init__(self, connector_id: str) -> None:
        self.connector_id = connector_id
        self.value: Any = None


class ChannelOutPort(OutPort[Any]):
    """An out port that hands each value over to one of those who ask for it.

    Attributes:
        meeting: What its writer and those who ask wait at.
    """

    def _begin(self) -> None:
        super()._begin()
        self.properties.update(CHANNELS)
        self.meeting = Meeting()
        self._asking: deque[_Asking] = deque()
        self._chosen: _Asking | None = None

    @property
    def is_writable(self) -> bool:
        """Return whether the next write waits for nobody."""
        return bool(self._asking) or (bool(self.connectors) and not self._has_channels)

    @property
    def _has_channels(self) -> bool:
        return any(is_channel(each.properties) for each in self.connector_profiles)

    def hand_over(self, value: Any, timeout_s: float, instance: str) -> PortStatus:
        """Write a value once somebody asks for it; TIMEOUT when nobody does in time [s].

        Raises:
            Malformed: See `OutPort.write`.
            InputEnded: The component is to be deactivated or ended.
        """
        with self.meeting.changed:
            if self._has_channels:
                self.meeting.wait(self._is_asked_or_alone, timeout_s, instance)
                if not self._asking:
                    return PortStatus.TIMEOUT
                self._chosen = self._asking.popleft()
            try:
                return self.write(value)
            finally:
                chosen, self._chosen = self._chosen, None
                if chosen is not None and chosen.value is None:
                    self._asking.appendleft(chosen)
                self.meeting.ring()

    def _is_asked_or_alone(self) -> bool:
        return bool(self._asking) or not self._has_channels

    def open_pull(self, connector: ConnectorProfile) -> Source[Any]:
        """Open a connector that is pulled; return the source of its values."""
        if not is_channel(connector.properties):
            return super().open_pull(connector)
        id = connector.connector_id

        def give(value: Any) -> PortStatus | None:
            if self._chosen is None:
                return PortStatus.TIMEOUT
            if self._chosen.connector_id == id:
                self._chosen.value = value
            return None

        self.attach(connector, give)
        return lambda: self._ask(_Asking(id))

    def _ask(self, asking: _Asking) -> Any:
        changed = self.meeting.changed
        with changed:
            self._asking.append(asking)
            changed.notify_all()
            changed.wait_for(lambda: self._is_answered(asking), _ASK_S)
            if asking.value is None:
                self._asking.remove(asking)
            return asking.value

    def _is_answered(self, asking: _Asking) -> bool:
        return asking.value is not None or asking.connector_id not in self._by_id

    def _notify(self, event: ConnectorEvent, connector: ConnectorProfile | None) -> None:
        super()._notify(event, connector)
        self.meeting.ring()
