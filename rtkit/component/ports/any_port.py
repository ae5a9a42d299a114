"""Base of data ports and service ports: a name, properties, connectors."""

from __future__ import annotations

from collections.abc import Mapping
from threading import Lock

from rtkit.errors import Refused
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import PortProfile

_UNLIMITED = -1


class Port:
    """Base of all ports: a name, properties, and the ids of its connectors.

    Declared on a component class a port is a pattern; each instance gets one of its own.
    """

    port_type: PortType
    limit_key = "connection_limit"

    def __init__(
        self, name: str, properties: Mapping[str, str] | None = None, *, doc: str = ""
    ) -> None:
        self.name = name
        self.properties: dict[str, str] = {"port.port_type": self.port_type.value}
        if doc:
            self.properties["description"] = doc
        self.properties.update(properties or {})
        self._lock = Lock()
        self._connectors: tuple[str, ...] = ()

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self.name or name.rstrip("_")

    @property
    def connectors(self) -> tuple[str, ...]:
        """Ids of the connectors that are open."""
        return self._connectors

    @property
    def profile(self) -> PortProfile:
        """The port as others see it."""
        return PortProfile(self.name, self.port_type, dict(self.properties))

    def copy(self) -> Port:
        """Return a port of the same kind without connectors, for another instance."""
        return type(self)(self.name, self.properties)

    def _admit(self, connector_id: str) -> None:
        if connector_id in self._connectors:
            raise Refused(f"port {self.name} has a connector of id {connector_id} already")
        text = self.properties.get(self.limit_key, "").strip()
        limit = int(text) if text.isascii() and text.isdigit() else _UNLIMITED
        if 0 <= limit <= len(self._connectors):
            raise Refused(f"port {self.name} takes no more than {limit} connectors")
        self._connectors = (*self._connectors, connector_id)

    def _dismiss(self, connector_id: str) -> None:
        self._connectors = tuple(each for each in self._connectors if each != connector_id)
