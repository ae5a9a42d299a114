"""Operations of a container on data connectors: opens ends, connects to others, cuts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, TypeVar

from rtkit import fault
from rtkit.component.base import Component
from rtkit.component.port import InPort, OutPort
from rtkit.component.service import ServicePort
from rtkit.container.operations import LATER, ContainerServices, Operations
from rtkit.container.port_wiring import PortWiring
from rtkit.container.service_connectors import ServiceConnectors
from rtkit.deployment.message import Message
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.link.ends import Fetcher, Outlet
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.rtc.port_types import WRONG_TYPE
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode

_log = late(__name__)
E = TypeVar("E", Outlet, Fetcher)


class _Held(NamedTuple):
    """A connector that is open, or being opened, and its ports in this process."""

    wire: ConnectorProfile
    ports: tuple[InPort[Any] | OutPort[Any], ...]


class DataConnectors:
    """Data connectors of one process."""

    def __init__(self, host: ContainerServices, wires: PortWiring) -> None:
        self._host = host
        self._wires = wires
        self._services = ServiceConnectors(host, wires)
        self._held: dict[str, _Held] = {}
        self.operations: Operations = {
            "link": self._link,
            "sink": self._sink,
            "source": self._source,
            "serve": self._serve,
            "fetch": self._fetch,
            "unlink": lambda message: self.cut(message["connector_id"]),
            **self._services.operations,
        }

    @property
    def wires(self) -> Iterator[ConnectorProfile]:
        """The connectors that are open, or being opened, here."""
        yield from (held.wire for held in self._held.values())
        yield from (connector for connector, _ in self._services.ends)

    def cut(self, connector_id: str) -> None:
        """Close whatever this process holds of a connector."""
        held = self._held.pop(connector_id, None)
        for port in held.ports if held is not None else ():
            if isinstance(port, OutPort):
                port.detach(connector_id)
            else:
                port.close(connector_id)
        self._services.cut(connector_id)
        self._wires.cut(connector_id)

    def part(self, component: Component) -> None:
        """Close every connector at a component's own ports, those too that are being opened."""
        own = {id(port) for name, port in component.ports.items() if name == port.name}
        ends = [(held.wire, held.ports) for held in self._held.values()]
        for connector, ports in (*ends, *self._services.ends):
            if any(id(port) in own for port in ports):
                self.cut(connector.connector_id)

    def _link(self, message: Message) -> None:
        connector = decode(ConnectorProfile, message["connector"])
        if isinstance(self._port(connector, 0), ServicePort):
            self._services.join(connector)
            return
        out, into = self._out_port(connector), self._in_port(connector)
        self._wires.join(connector, out, into)
        self._held[connector.connector_id] = _Held(connector, (out, into))

    def _sink(self, message: Message) -> str:
        connector = decode(ConnectorProfile, message["connector"])
        port = self._in_port(connector)
        endpoint = self._wires.receive(connector, port)
        self._held[connector.connector_id] = _Held(connector, (port,))
        return endpoint

    def _serve(self, message: Message) -> str:
        connector = decode(ConnectorProfile, message["connector"])
        port = self._out_port(connector)
        endpoint = self._wires.serve(connector, port)
        self._held[connector.connector_id] = _Held(connector, (port,))
        return endpoint

    def _source(self, message: Message) -> object:
        connector = decode(ConnectorProfile, message["connector"])
        port = self._out_port(connector)
        held = self._opening(connector, port)
        self._reach(
            message,
            held,
            self._wires.find_receiver,
            lambda outlet: self._wires.send(connector, port, outlet),
        )
        return LATER

    def _fetch(self, message: Message) -> object:
        connector = decode(ConnectorProfile, message["connector"])
        port = self._in_port(connector)
        held = self._opening(connector, port)
        self._reach(
            message,
            held,
            self._wires.find_source,
            lambda fetcher: self._wires.fetch(connector, port, fetcher),
        )
        return LATER

    def _opening(self, connector: ConnectorProfile, port: InPort[Any] | OutPort[Any]) -> _Held:
        if connector.connector_id in self._held:
            raise Refused(f"connection {connector.connector_id} is open, or being opened, here")
        held = self._held[connector.connector_id] = _Held(connector, (port,))
        return held

    def _reach(
        self,
        message: Message,
        held: _Held,
        find: Callable[[ConnectorProfile, str], E],
        use: Callable[[E], None],
    ) -> None:
        """Find the other end on a thread of its own, then use it here if it is still wanted."""
        endpoint = message["endpoint"]

        def run() -> None:
            try:
                end = find(held.wire, endpoint)
            except Exception as failure:
                error = failure  # the name of an except clause is gone when this is called
                self._host.post(lambda: self._not_found(message, held, endpoint, error))
            else:
                self._host.post(lambda: self._found(message, held, end, use))

        try:
            start_thread(run, f"open {endpoint}")
        except Refused:
            self._forget(held)
            raise

    def _found(self, message: Message, held: _Held, end: E, use: Callable[[E], None]) -> None:
        id = held.wire.connector_id
        try:
            if self._held.get(id) is not held:
                raise Refused(f"connection {id} was removed while it was made")
            fault.point("holder.found_end")
            use(end)
            fault.point("holder.joined")
        except RtkitError as error:
            end.close()
            self._forget(held)
            self._host.refuse(message, error)
        else:
            self._host.answer(message, "")

    def _not_found(self, message: Message, held: _Held, endpoint: str, error: Exception) -> None:
        self._forget(held)
        if not isinstance(error, RtkitError):
            _log().error("cannot reach %s", endpoint, exc_info=error)
            error = Unreachable(f"cannot reach {endpoint}: {error}")
        self._host.refuse(message, error)

    def _forget(self, held: _Held) -> None:
        if self._held.get(held.wire.connector_id) is held:
            del self._held[held.wire.connector_id]

    def _out_port(self, connector: ConnectorProfile) -> OutPort[Any]:
        port = self._port(connector, 0)
        if not isinstance(port, OutPort):
            raise Refused(WRONG_TYPE)
        return port

    def _in_port(self, connector: ConnectorProfile) -> InPort[Any]:
        port = self._port(connector, 1)
        if not isinstance(port, InPort):
            raise Refused(WRONG_TYPE)
        return port

    def _port(self, connector: ConnectorProfile, index: int) -> object:
        end = connector.ports[index]
        port = self._host.component(end.instance).ports.get(end.port)
        if port is None:
            raise NotFound(f"Port not found: {end}")
        return port
