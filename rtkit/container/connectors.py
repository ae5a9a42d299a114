"""Operations of a container on connectors: joins ports, opens ends, finds others, cuts.

Ports of one process are joined directly. Between two processes the end that is waited at is opened
first; the other one finds it on a thread of its own, because that process may be stopped.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, TypeVar

from rtkit import fault
from rtkit.component.base import Component
from rtkit.component.contexts.waiting import waiting
from rtkit.component.ports.any_port import Port
from rtkit.component.ports.data_port import DataPort
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.options import parse_options
from rtkit.component.ports.out_port import OutPort
from rtkit.component.services import invocation
from rtkit.component.services.invocation import CallRouting, CallTarget, Direct, Remote
from rtkit.component.services.reentrancy import Reentrancy
from rtkit.component.services.service import ServicePort
from rtkit.container.operations import LATER, ContainerServices, Operations
from rtkit.container.port_wiring import PortWiring
from rtkit.deployment.message import Message
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.link.ends import CallerEnd, Fetcher, Outlet
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.rtc.enums import Polarity
from rtkit.rtc.port_types import WRONG_TYPE
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode

_log = late(__name__)
_FLUSH_S = 1.0
"""How long the values of a connector that is moved may take until they have arrived [s]."""
MOST_ASIDE = 16
"""How many calls between components of one process run on threads of their own at a time."""
_aside = threading.BoundedSemaphore(MOST_ASIDE)
P = TypeVar("P", bound=Port)
E = TypeVar("E", Outlet, Fetcher, CallerEnd)


class _Held:
    """A connector that is open, or being opened, and its ports in this process.

    Attributes:
        opened: The endpoint at which it is waited for here; empty where it is not.
        reached: The endpoint at which its other end was found; empty until then.
    """

    def __init__(self, connector: ConnectorProfile) -> None:
        self.connector = connector
        self.ports: list[Port] = []
        self.opened = self.reached = ""


class Connectors:
    """The connectors of one process."""

    def __init__(self, host: ContainerServices, wiring: PortWiring) -> None:
        self._host = host
        self._wiring = wiring
        self._reentrancy = Reentrancy()
        self._held: dict[str, _Held] = {}
        opening: dict[str, Callable[[Message, ConnectorProfile], object]] = {
            "link": self._link,
            "sink": self._sink,
            "source": self._source,
            "serve": self._serve,
            "fetch": self._fetch,
            "offer": self._offer,
            "consult": self._consult,
            "keep": self._keep,
        }
        self.operations: Operations = {
            **{op: partial(_with_connector, work) for op, work in opening.items()},
            "unlink": lambda message: self.cut(message["connector_id"]),
            "hold": self._hold_values,
        }

    @property
    def held(self) -> Iterator[ConnectorProfile]:
        """The connectors that are open, or being opened, here."""
        return (held.connector for held in self._held.values())

    def cut(self, connector_id: str) -> None:
        """Close whatever this process holds of a connector."""
        held = self._held.pop(connector_id, None)
        for port in held.ports if held is not None else ():
            if isinstance(port, InPort):
                port.close(connector_id)
            elif isinstance(port, (OutPort, ServicePort)):
                port.detach(connector_id)
        self._wiring.cut(connector_id)

    def _hold_values(self, message: Message) -> object:
        """Close a connector once all that was sent has arrived; its out port keeps what follows."""
        id = message["connector_id"]
        held = self._held.get(id)
        outs = [port for port in held.ports if isinstance(port, OutPort)] if held else []
        if held is None or not outs or parse_options(held.connector.properties).dataflow == "pull":
            self.cut(id)
            return ""
        for port in outs:
            port.hold(held.connector)

        def run() -> None:
            self._wiring.send_rest(id, _FLUSH_S)
            self._host.post(finish)

        def finish() -> None:
            if self._held.get(id) is held:
                held.ports = [port for port in held.ports if port not in outs]
                self.cut(id)
            self._host.answer(message, "")

        start_thread(run, f"flush {id}")
        return LATER

    def part(self, component: Component) -> None:
        """Close every connector at a component's own ports, those too that are being opened."""
        own = {id(port) for name, port in component.ports.items() if name == port.name}
        for held in list(self._held.values()):
            if any(id(port) in own for port in held.ports):
                self.cut(held.connector.connector_id)

    # data

    def _link(self, _message: Message, connector: ConnectorProfile) -> None:
        if isinstance(self._port(connector, 0, Port), ServicePort):
            self._link_services(connector)
            return
        out, into = self._port(connector, 0, OutPort), self._port(connector, 1, InPort)
        self._wiring.join(connector, out, into)
        self._hold(connector, out, into)

    def _sink(self, _message: Message, connector: ConnectorProfile) -> str:
        port = self._port(connector, 1, InPort)
        return self._wait(connector, port, lambda: self._wiring.receive(connector, port))

    def _serve(self, _message: Message, connector: ConnectorProfile) -> str:
        port = self._port(connector, 0, OutPort)
        return self._wait(connector, port, lambda: self._wiring.serve(connector, port))

    def _wait(self, connector: ConnectorProfile, port: Port, listen: Callable[[], str]) -> str:
        """Open the end that is waited at, unless it is open; return its endpoint."""
        held = self._held.get(connector.connector_id)
        if held is None or not held.opened:
            endpoint = listen()
            held = self._hold(connector, port)
            held.opened = endpoint
        return held.opened

    def _source(self, message: Message, connector: ConnectorProfile) -> object:
        port, wiring = self._port(connector, 0, OutPort), self._wiring
        use = partial(wiring.send, connector, port)
        return self._open(message, connector, port, wiring.find_receiver, use)

    def _fetch(self, message: Message, connector: ConnectorProfile) -> object:
        port, wiring = self._port(connector, 1, InPort), self._wiring
        use = partial(wiring.fetch, connector, port)
        return self._open(message, connector, port, wiring.find_source, use)

    def _open(
        self,
        message: Message,
        connector: ConnectorProfile,
        port: Port,
        find: Callable[[ConnectorProfile, str], E],
        use: Callable[[E], None],
    ) -> object:
        endpoint, known = message["endpoint"], self._held.get(connector.connector_id)
        if known is not None and not known.reached:
            raise Refused(f"connection {connector.connector_id} is open, or being opened, here")
        if known is not None and known.reached == endpoint:
            return ""
        self.cut(connector.connector_id)  # its other end has been made again elsewhere
        held = self._hold(connector, port)
        return self._reach(message, held, partial(find, connector, endpoint), use)

    # services

    def _link_services(self, connector: ConnectorProfile) -> None:
        """Connect two service ports of this process: each calls what the other provides."""
        one, other = (self._port(connector, end, ServicePort) for end in (0, 1))
        try:
            for end, port, peer in ((0, one, other), (1, other, one)):
                caller, provider = connector.ports[end], connector.ports[1 - end]
                names, label = (caller.instance, provider.instance), f"{caller}: {provider}"
                passage = CallRouting(*names, label, self._reentrancy, run_aside)
                targets = {s.interface.name: Direct(s, passage) for s in peer.served}
                self._attach(connector, port, targets)
        except RtkitError:
            self.cut(connector.connector_id)
            raise

    def _offer(self, message: Message, connector: ConnectorProfile) -> str:
        """Be called over a connector; answer with the endpoint to call at."""
        end = int(message["end"])
        port = self._port(connector, end, ServicePort)
        served = port.served

        def reply(request: bytes) -> bytes:
            return invocation.answer(request, served, time.monotonic_ns())

        def listen() -> str:
            self._attach(connector, port, {})
            return self._wiring.serve_calls(connector, end, reply)

        return self._wait(connector, port, listen)

    def _consult(self, message: Message, connector: ConnectorProfile) -> object:
        """Call over a connector what is offered at an endpoint."""
        end = int(message["end"])
        port, peer = self._port(connector, end, ServicePort), str(connector.ports[1 - end])
        known = self._held.get(connector.connector_id)
        if known is not None and known.reached == message["endpoint"]:
            return ""
        held = self._attach(connector, port, {})

        def use(caller: CallerEnd) -> None:
            needed = [i for i in port.interfaces if i.polarity is Polarity.REQUIRED]
            label, call = f"{connector.ports[end]}: {peer}", _patient(caller)
            targets = {
                each.type_name: Remote(each.type_name, label, call, time.monotonic_ns)
                for each in needed
            }
            self._attach(connector, port, targets)
            self._wiring.keep(connector, caller)

        find = partial(self._wiring.find_provider, connector, 1 - end, message["endpoint"])
        return self._reach(message, held, find, use)

    def _keep(self, message: Message, connector: ConnectorProfile) -> None:
        """Note a connector over which nothing is called: no interface of it is known."""
        self._attach(connector, self._port(connector, int(message["end"]), ServicePort), {})

    def _attach(
        self, connector: ConnectorProfile, port: ServicePort, targets: Mapping[str, CallTarget]
    ) -> _Held:
        port.attach(connector, targets)
        return self._hold(connector, port)

    # ends and ports

    def _reach(
        self, message: Message, held: _Held, find: Callable[[], E], use: Callable[[E], None]
    ) -> object:
        """Find the other end on a thread of its own, then use it here if it is still wanted."""
        endpoint = message["endpoint"]

        def run() -> None:
            try:
                end = find()
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
        return LATER

    def _found(self, message: Message, held: _Held, end: E, use: Callable[[E], None]) -> None:
        id = held.connector.connector_id
        try:
            if self._held.get(id) is not held:
                raise Refused(f"connection {id} was removed while it was made")
            fault.point("holder.found_end")
            use(end)
            held.reached = message["endpoint"]
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

    def _hold(self, connector: ConnectorProfile, *ports: Port) -> _Held:
        held = self._held.setdefault(connector.connector_id, _Held(connector))
        held.ports.extend(port for port in ports if port not in held.ports)
        return held

    def _forget(self, held: _Held) -> None:
        if self._held.get(held.connector.connector_id) is held:
            self.cut(held.connector.connector_id)

    def _port(self, connector: ConnectorProfile, index: int, kind: type[P]) -> P:
        end = connector.ports[index]
        port = self._host.component(end.instance).ports.get(end.port)
        if port is None:
            raise NotFound(f"Port not found: {end}")
        if not isinstance(port, kind):
            raise Refused(WRONG_TYPE)
        if isinstance(port, DataPort):
            port.announce = self._host.announce
        return port


def _with_connector(
    work: Callable[[Message, ConnectorProfile], object], message: Message
) -> object:
    return work(message, decode(ConnectorProfile, message["connector"]))


def _patient(caller: CallerEnd) -> Callable[[bytes, float], bytes]:
    """Return how to call so that the callback that does may wait for the answer."""

    def call(request: bytes, timeout_s: float) -> bytes:
        with waiting(timeout_s):
            return caller.call(request, timeout_s)

    return call


def run_aside(work: Callable[[], Any], timeout_s: float) -> Any:
    """Do something on a thread of its own; return its result or raise its error.

    Raises:
        TimeoutError: It has not come back within `timeout_s` [s], or too many others have not.
    """
    outcome: queue.SimpleQueue[tuple[Any, BaseException | None]] = queue.SimpleQueue()

    def run() -> None:
        try:
            outcome.put((work(), None))
        except BaseException as error:
            outcome.put((None, error))
        finally:
            _aside.release()

    if not _aside.acquire(timeout=timeout_s):
        raise TimeoutError(f"{MOST_ASIDE} earlier calls have not come back")
    try:
        start_thread(run, "call aside")
    except Refused:
        _aside.release()
        raise
    try:
        with waiting(timeout_s):
            value, error = outcome.get(timeout=timeout_s)
    except queue.Empty:
        raise TimeoutError from None
    if error is not None:
        raise error
    return value
