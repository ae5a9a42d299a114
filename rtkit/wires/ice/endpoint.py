"""Ice endpoint: a port, for clients that know the user's secret; each service is an object.

Threads of Ice read and write; requests are answered on the loop, or at once where nothing of the
user's is called.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from logging import getLogger
from time import monotonic
from typing import Any

from rtkit.errors import Unreachable
from rtkit.link import secret
from rtkit.link.deadline import deadline_from_text
from rtkit.property.messages import Answer, failed
from rtkit.serving.acceptor import LOOPBACK
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.quota import EndpointQuota
from rtkit.wires.ice import protocol
from rtkit.wires.ice.served_client import IceRequest, ServedIceClient
from rtkit.wires.ice.subscriber import STUCK_S
from rtkit.wires.line.login import PATIENCE_S, Login
from rtkit.wires.wire import WireSettings, place_to_open

_CHECK_S = 0.25
_SETTINGS = {
    "Ice.MessageSizeMax": protocol.LONGEST >> 10,
    "Ice.ACM.Server.Timeout": PATIENCE_S,
    "Ice.ACM.Server.Close": 4,  # whoever says nothing, whatever is under way
    "Ice.ACM.Server.Heartbeat": 0,
}
_ENDED = Answer("the service has ended", "no-service")

Settling = Callable[[Answer], None]


class IceEndpoint(IOHandler):
    """Adapter of Ice.

    Attributes:
        port: At which it listens.

    Raises:
        Refused: Ice is not there.
        Unreachable: The port is taken.
    """

    def __init__(self, host: PropertyEventLoop, port: int) -> None:
        self._runtime = protocol.runtime()
        self._host = host
        self._secret = secret.read()
        self._clients: dict[Any, ServedIceClient] = {}
        self._quota = EndpointQuota(host.policy, "ice", lambda: list(self._clients.values()))
        self._lock = threading.Lock()
        self._pending: dict[Any, Settling] = {}
        self._has_ended = False
        self._communicator = protocol.communicator(_SETTINGS)
        where = f"tcp -h {LOOPBACK} -p {port} -t {int(STUCK_S * 1000)}"
        try:
            adapter = self._communicator.createObjectAdapterWithEndpoints("properties", where)
            self.port = int(adapter.getEndpoints()[0].getInfo().port)
            adapter.addDefaultServant(_servant(self._take), "")
            adapter.activate()
        except self._runtime.ice.SocketException as error:
            self._communicator.destroy()
            why = os.strerror(error.error)
            raise Unreachable(f"cannot listen on port {port}: {why}") from error
        host.at_end(self._close)

    # On threads of Ice

    def _take(self, current: Any, target: str, payload: Any, listener: Any) -> Any:
        """Return the future of an answer."""
        future = self._runtime.ice.Future()
        settle = _settling(future, has_value=listener is None)
        with self._lock:
            if self._has_ended:
                settle(_ENDED)
                return future
            self._pending[future] = settle
        asked = IceRequest(
            protocol.name_of(current.id),
            target,
            None if payload is None else protocol.read_payload(payload),
            lambda reply: self._answer(future, reply),
            listener,
            deadline_from_text(current.ctx.get(protocol.DEADLINE, "")),
        )
        host = self._host
        if listener is None and self._is_plain(asked) and host.lock.acquire(blocking=False):
            try:
                self._work(current.con, asked)
            finally:
                host.lock.release()
        else:
            host.post(lambda: self._work(current.con, asked))
        return future

    def _is_plain(self, asked: IceRequest) -> bool:
        service = self._host.services.get(asked.service)
        return service is not None and not self._host.has_posted and service.is_plain(asked.target)

    # By who holds the lock of the host

    def _work(self, connection: Any, asked: IceRequest) -> None:
        try:
            client = self._clients.get(connection)
            if client is None:
                client = self._entered(connection, asked)
            if client is not None:
                client.take(asked)
        except Exception as error:  # Ice would tell the far side where in our files it was
            getLogger("rtkit.properties").exception("%s", asked.target)
            asked.answer(failed(error))

    def _entered(self, connection: Any, asked: IceRequest) -> ServedIceClient | None:
        most = self._quota.limits.connections
        if len(self._clients) >= most:
            asked.answer(Answer(f"there are {most} connections", "busy"))
            connection.close(self._runtime.ice.ConnectionClose.Gracefully)
            return None
        login = Login(self._secret, monotonic(), self._host.services)
        client = ServedIceClient(self._host, connection, login, self._quota)
        self._clients[connection] = client
        connection.setCloseCallback(lambda _: self._host.post(lambda: self._left(connection)))
        self._host.mark(self)
        return client

    def _left(self, connection: Any) -> None:
        client = self._clients.pop(connection, None)
        if client is not None:
            client.leave()

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`: wait for those who have not said who they are."""
        unknown = [each for each in self._clients.values() if not each.identity]
        for client in unknown:
            client.check(now)
        return now + _CHECK_S if unknown else None

    # Answers

    def _answer(self, future: Any, reply: Answer) -> None:
        with self._lock:
            settle = self._pending.pop(future, None)
        if settle is not None:  # else the endpoint was closed meanwhile
            settle(reply)

    def _close(self) -> None:
        """Answer whoever waits, then end all connections; Ice waits for the former."""
        with self._lock:
            self._has_ended = True
            pending, self._pending = list(self._pending.values()), {}
        for settle in pending:
            settle(_ENDED)
        for client in list(self._clients.values()):
            client.cut_off()
        self._communicator.destroy()


def _settling(future: Any, *, has_value: bool) -> Settling:
    """Return what answers a request."""

    def settle(reply: Answer) -> None:
        if reply.error:
            text = str(reply.payload).encode("utf-8", "replace").decode()
            future.set_exception(protocol.runtime().slice.Failure(reply.error, text))
        else:
            future.set_result(protocol.write_payload(reply.payload) if has_value else None)

    return settle


def _servant(take: Callable[[Any, str, Any, Any], Any]) -> Any:
    """Return the object that stands for all services."""
    slice_ = protocol.runtime().slice

    def get(self: object, target: str, current: Any) -> Any:
        return take(current, target, None, None)

    def set_(self: object, target: str, value: Any, current: Any) -> Any:
        return take(current, target, value, None)

    def listen(self: object, target: str, who: Any, current: Any) -> Any:
        if who is None:
            raise slice_.Failure("bad-value", "nobody to call")
        return take(current, target, None, who.ice_getIdentity())

    methods = {"get": get, "set": set_, "listen": listen}
    return type("Properties", (slice_.Service,), methods)()


def open_ice(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    """Open a port of this host, 0 for any, to those who know the user's secret.

    Raises:
        Refused: Ice is not there, or the secret cannot be made.
        Unreachable: The port is taken.
    """
    _, port = place_to_open("ice", address, settings)
    protocol.runtime()
    secret.make()
    return f"ice://localhost:{IceEndpoint(settings.host, port).port}/{provider.name}"
