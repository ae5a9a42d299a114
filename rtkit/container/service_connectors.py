"""Operations of a container on service connectors: direct in a process, by calls between two."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rtkit.component.invocation import (
    CallRouting,
    CallTarget,
    Direct,
    ProvidedInterface,
    Remote,
    answer,
)
from rtkit.component.reentrancy import Reentrancy
from rtkit.component.service import ServicePort
from rtkit.component.waiting import waiting
from rtkit.container.operations import LATER, ContainerServices, Operations
from rtkit.container.port_wiring import PortWiring
from rtkit.deployment.message import Message
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.link.ends import CallerEnd
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.rtc.enums import Polarity
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode

_log = late(__name__)
MOST_ASIDE = 16
"""How many calls between components of one process run on threads of their own at a time."""

_aside = threading.BoundedSemaphore(MOST_ASIDE)


class ServiceConnectors:
    """The service connectors of one process."""

    def __init__(self, host: ContainerServices, wires: PortWiring) -> None:
        self._host = host
        self._wires = wires
        self._crossings = Reentrancy()
        self._open: dict[str, tuple[ConnectorProfile, list[ServicePort]]] = {}
        self.operations: Operations = {
            "offer": self._offer,
            "consult": self._consult,
            "keep": self._keep,
        }

    @property
    def ends(self) -> list[tuple[ConnectorProfile, list[ServicePort]]]:
        """The connectors that are open, or being opened, and their ports in this process."""
        return list(self._open.values())

    def join(self, connector: ConnectorProfile) -> None:
        """Connect two service ports of this process: each calls what the other provides."""
        one, other = (self._port(connector, end) for end in (0, 1))
        try:
            for end, port, peer in ((0, one, other), (1, other, one)):
                caller, provider = connector.ports[end], connector.ports[1 - end]
                label = f"{caller}: {provider}"
                passage = CallRouting(
                    caller.instance, provider.instance, label, self._crossings, run_aside
                )
                targets = {s.interface.name: Direct(s, passage) for s in peer.served}
                self._attach(connector, port, targets)
        except RtkitError:
            self.cut(connector.connector_id)
            raise

    def cut(self, connector_id: str) -> None:
        """Close a connector's ports; its ends are those of `PortWiring`."""
        _, ports = self._open.pop(connector_id, (None, []))
        for port in ports:
            port.detach(connector_id)

    def _offer(self, message: Message) -> str:
        """Be called over a connector; answer with the endpoint to call at."""
        connector, end = decode(ConnectorProfile, message["connector"]), int(message["end"])
        port = self._port(connector, end)
        served = port.served
        self._attach(connector, port, {})
        return self._wires.serve_calls(connector, end, lambda request: _reply(request, served))

    def _consult(self, message: Message) -> object:
        """Call over a connector what is offered at an endpoint, which is found on a thread."""
        connector, end = decode(ConnectorProfile, message["connector"]), int(message["end"])
        self._attach(connector, self._port(connector, end), {})
        endpoint = message["endpoint"]

        def run() -> None:
            try:
                caller = self._wires.find_provider(connector, 1 - end, endpoint)
            except Exception as failure:
                error = failure  # the name of an except clause is gone when this is called
                self._host.post(lambda: self._not_found(message, endpoint, error))
            else:
                self._host.post(lambda: self._found(message, connector, end, caller))

        start_thread(run, f"open {endpoint}")
        return LATER

    def _keep(self, message: Message) -> None:
        """Note a connector over which nothing is called: no interface of it is known."""
        connector = decode(ConnectorProfile, message["connector"])
        self._attach(connector, self._port(connector, int(message["end"])), {})

    def _found(
        self, message: Message, connector: ConnectorProfile, end: int, caller: CallerEnd
    ) -> None:
        try:
            if connector.connector_id not in self._open:
                raise Refused(f"connection {connector.connector_id} was removed while it was made")
            port, peer = self._port(connector, end), str(connector.ports[1 - end])
            needed = [i for i in port.interfaces if i.polarity is Polarity.REQUIRED]
            label = f"{connector.ports[end]}: {peer}"
            targets = {
                each.type_name: Remote(each.type_name, label, _patient(caller), time.monotonic_ns)
                for each in needed
            }
            self._attach(connector, port, targets)
        except RtkitError as error:
            caller.close()
            self._host.refuse(message, error)
        else:
            self._wires.keep(connector, caller)
            self._host.answer(message, "")

    def _not_found(self, message: Message, endpoint: str, error: Exception) -> None:
        if not isinstance(error, RtkitError):
            _log().error("cannot reach %s", endpoint, exc_info=error)
            error = Unreachable(f"cannot reach {endpoint}: {error}")
        self._host.refuse(message, error)

    def _attach(
        self, connector: ConnectorProfile, port: ServicePort, targets: Mapping[str, CallTarget]
    ) -> None:
        port.attach(connector, targets)
        self._open.setdefault(connector.connector_id, (connector, []))[1].append(port)

    def _port(self, connector: ConnectorProfile, end: int) -> ServicePort:
        ref = connector.ports[end]
        port = self._host.component(ref.instance).ports.get(ref.port)
        if port is None:
            raise NotFound(f"Port not found: {ref}")
        if not isinstance(port, ServicePort):
            raise Refused("Wrong port type.")
        return port


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


def _reply(request: bytes, served: Sequence[ProvidedInterface]) -> bytes:
    return answer(request, served, time.monotonic_ns())
