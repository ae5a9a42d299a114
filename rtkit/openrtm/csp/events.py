"""State machines whose events come over ports of CSP: ``CSPEventPort`` and ``CSPMachine``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from rtkit.component.fsm import EventPort
from rtkit.openrtm.api.event_port import EventInPort
from rtkit.openrtm.api.static_fsm import Link, Machine
from rtkit.openrtm.csp.channel_in_port import ChannelInPort, ChannelRing
from rtkit.openrtm.csp.manager import CSPManager
from rtkit.openrtm.csp.ports import CSPOutPort, CSPPort, CSPReader
from rtkit.rtc.profiles import ConnectorProfile


class ChannelEventPort(ChannelInPort, EventPort):
    """A port for events, which it asks for over its channels.

    They ask while all events that were not taken are fewer than there is room for; each of several
    may bring one more.
    """

    def _begin(self) -> None:
        super()._begin()
        self._rings: dict[str, ChannelRing] = {}

    def take(self) -> tuple[str, Any] | None:
        """See `EventPort.take`."""
        with self.meeting.changed:
            self.meeting.changed.notify_all()
            return super().take()

    def close(self, connector_id: str) -> None:
        """Close a connector."""
        super().close(connector_id)
        ring = self._rings.pop(connector_id, None)
        if ring is not None:
            ring.close()

    def _wire(self, connector: ConnectorProfile, ring: ChannelRing) -> None:
        ring.use(self.open(connector))
        ring.share(self._queue)
        self._rings[connector.connector_id] = ring

    def _keep(self, connector: ConnectorProfile, ring: ChannelRing) -> None:
        """Do nothing: events are kept without the channel that they came by."""


class CSPEventPort(CSPReader, EventInPort):
    """A port whose events a machine handles, and whose writers wait until they are taken."""

    port: ChannelEventPort
    port_class: ClassVar[Any] = ChannelEventPort

    def __init__(self, name: str, fsm: Machine, manager: CSPManager | None = None) -> None:
        super().__init__(name, fsm)
        self._dispatch = fsm.dispatch
        self.setManager(manager)

    def readData(self) -> Callable[[], None]:
        """Return what has the machine handle the oldest event; does nothing without one."""
        event = self._take()
        return lambda: None if event is None else self._dispatch(event)


class CSPMachine(Machine):
    """A machine that handles the events of the ports of a manager.

    Args:
        TOP: The outermost state.
        comp: The component that it belongs to.
        cspmgr: The manager; without it events are handled as those of `Machine`.
    """

    def __init__(self, TOP: type[Link], comp: Any = None, cspmgr: CSPManager | None = None) -> None:
        super().__init__(TOP, comp)
        self._manager = cspmgr

    def run_event(self, timeout: float = 10) -> CSPPort | None:  # type: ignore[override]
        """Handle the next event, or write to who waits for a value; return the port, if any.

        It waits at most so long [s].
        """
        if self._manager is None:
            super().run_event()
            return None
        _, out, into = self._manager.select(timeout)
        if isinstance(out, CSPOutPort):
            out.write()
        elif into is not None:
            into.readData()()
        return out or into
