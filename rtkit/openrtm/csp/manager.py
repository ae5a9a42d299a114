"""Choice among several ports of CSP: ``CSPManager``."""

from __future__ import annotations

from typing import Any

from rtkit.openrtm.api.ports import PortBase
from rtkit.openrtm.csp.channel_in_port import reading
from rtkit.openrtm.csp.meeting import Meeting
from rtkit.openrtm.csp.ports import CSPOutPort, CSPPort, CSPReader


class CSPManager:
    """Waits until one of several ports can exchange a value.

    Attributes:
        meeting: What all threads that have to do with its ports wait at.
    """

    def __init__(self) -> None:
        self.meeting = Meeting()
        self._ports: list[CSPPort] = []

    def select(self, timeout: float) -> tuple[bool, CSPOutPort | None, CSPReader | None]:
        """Return whether a port can exchange a value, and that port as the second or the third.

        It waits for one, so long at most [s]; those that were chosen before have their turn last.
        """
        ports = list(self._ports)
        instance = next((each.instance for each in ports if each.instance), "")
        with reading(*(each.port for each in ports if isinstance(each, CSPReader))):
            find = lambda: next((each for each in ports if each.select()), None)  # noqa: E731
            found = self.meeting.wait(find, timeout, instance)
        if found is None:
            return False, None, None
        self._ports.remove(found)
        self._ports.append(found)
        if isinstance(found, CSPOutPort):
            return True, found, None
        return True, None, found if isinstance(found, CSPReader) else None

    def add(self, port: CSPPort) -> None:
        """Choose among one port more."""
        if port not in self._ports:
            self._ports.append(port)

    def remove(self, port: CSPPort) -> None:
        """Choose it no more."""
        if port in self._ports:
            self._ports.remove(port)

    addInPort = addOutPort = add
    removeInPort = removeOutPort = remove

    def reset(self) -> None:
        """Let go of all ports."""
        for each in list(self._ports):
            each.releaseManager()

    def selectInPort(self) -> tuple[bool, Any]:
        """Return whether one of its in ports has a value, and which; do not wait."""
        return self._ready(CSPReader)

    def selectOutPort(self) -> tuple[bool, Any]:
        """Return whether somebody waits for a value of one of its out ports, and which."""
        return self._ready(CSPOutPort)

    def _ready(self, kind: type[PortBase]) -> tuple[bool, Any]:
        mine = (each for each in self._ports if isinstance(each, kind))
        found = next((each for each in mine if each.select()), None)
        return found is not None, found
