"""Ports of CSP, whose writer waits until its value is taken: ``CSPInPort`` and ``CSPOutPort``.

They do so on connectors of interface type ``csp_channel``, or data flow type ``duplex``; on all
others they are like ports of other kinds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from rtkit.component.ports.options import PortStatus
from rtkit.openrtm.absent import refuse
from rtkit.openrtm.api.ports import InPort, OutPort, PortBase
from rtkit.openrtm.csp.channel_in_port import ChannelInPort, reading
from rtkit.openrtm.csp.channel_out_port import ChannelOutPort
from rtkit.openrtm.csp.meeting import Meeting, number_in

_TIMEOUT, _USUAL_TIMEOUT_S = "channel_timeout", 10.0


class CSPPort(PortBase, ABC):
    """Base of both: they may belong to a manager, which chooses among its ports."""

    port: Any
    _csp_manager: Any = None
    _sync_mode = False

    @property
    def instance(self) -> str:
        """Name of its component; empty before it is added to one."""
        return "" if self.owner is None else str(self.owner.rtkit_component.instance)

    @property
    def timeout_s(self) -> float:
        """Longest wait [s]."""
        return number_in(self.port.properties, _TIMEOUT, _USUAL_TIMEOUT_S)

    def setManager(self, manager: Any) -> None:
        """Belong to a manager from now on, while nothing is connected."""
        self.releaseManager()
        if manager is not None:
            self._meet_at(manager.meeting)
            self._csp_manager = manager
            manager.add(self)

    def releaseManager(self) -> None:
        """Belong to no manager any more."""
        manager, self._csp_manager = self._csp_manager, None
        if manager is not None:
            manager.remove(self)
            self._meet_at(Meeting())

    def _meet_at(self, meeting: Meeting) -> None:
        if self.port.connectors:
            raise refuse(f"{type(self).__name__}: another manager while it is connected")
        self.port.meeting = meeting

    def setSyncMode(self, mode: bool) -> None:
        """Note a mode; what it chooses in OpenRTM, how locks are held, makes no difference here."""
        self._sync_mode = mode

    def getSyncMode(self) -> bool:
        """Return the mode that was set."""
        return self._sync_mode

    @abstractmethod
    def select(self) -> bool:
        """Return whether a value can be exchanged without waiting."""

    def reselect(self) -> bool:
        """Do the same as `select`."""
        return self.select()


class CSPReader(CSPPort):
    """Base of ports that take values whose writers wait for that."""

    def select(self) -> bool:
        """Return whether a value is there."""
        return bool(self.port.is_new())

    @abstractmethod
    def readData(self) -> Any:
        """Return what was not read yet, without waiting."""

    def read(self, name: str | None = None) -> Any:
        """Return the next value, after waiting for it; None when none comes in time.

        It waits for ``channel_timeout`` of the port [s], and not while it has no connector.
        """
        with reading(self.port):
            self.port.meeting.wait(self._is_done, self.timeout_s, self.instance)
        return self.readData() if self.port.is_new() else None

    def _is_done(self) -> bool:
        return self.select() or not self.isConnected()


class CSPInPort(CSPReader, InPort):
    """A port that takes values whose writers wait for that."""

    port: ChannelInPort
    port_class: ClassVar[Any] = ChannelInPort

    def __init__(self, name: str, value: Any, manager: Any = None) -> None:
        super().__init__(name, value)
        self.setManager(manager)

    def readData(self) -> Any:
        """Return the oldest value not read yet, without waiting; else the last one."""
        return InPort.read(self)


class CSPOutPort(CSPPort, OutPort):
    """A port that waits until one of those that it is connected with takes the value."""

    port: ChannelOutPort
    port_class: ClassVar[Any] = ChannelOutPort

    def __init__(self, name: str, value: Any, manager: Any = None) -> None:
        super().__init__(name, value)
        self.setManager(manager)

    def select(self) -> bool:
        """Return whether somebody waits for a value."""
        return self.port.is_writable

    def _send(self, value: Any) -> PortStatus:
        return self.port.hand_over(self._freeze(value), self.timeout_s, self.instance)

    def writeData(self, value: Any = None) -> bool:
        """Do the same as `write`; after `select` somebody waits already."""
        return self.write(value)
