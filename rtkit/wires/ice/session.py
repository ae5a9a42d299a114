"""Session with an Ice endpoint: requests under way and subscriptions, on threads of Ice.

See decision 37.
"""

from __future__ import annotations

import math
import threading
import uuid
from collections.abc import Callable
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any, NamedTuple

from rtkit.closing import Closing
from rtkit.errors import Unreachable
from rtkit.link.deadline import deadline_at
from rtkit.link.secret import Secret
from rtkit.property.messages import DONE, Answer, Payload, PropertyEvent
from rtkit.property.subscription import LEASE_S
from rtkit.wires.ice import protocol
from rtkit.wires.ice.address import IceAddress
from rtkit.wires.ice.protocol import DOOR, LONGEST

Outcome = Answer | Unreachable
OnOutcome = Callable[[Outcome], object]
Taking = Callable[[list[PropertyEvent]], object]
"""Takes events; what it returns is what the endpoint waits for before it sends more: nothing, or a
future."""
LATE = "no answer within"
_ROOM_FOR_TARGET = 1 << 14


class _Subscription(NamedTuple):
    service: Any
    target: str
    proxy: Any


class IceSession(Closing):
    """Authenticated connection; it does not reconnect when it ends.

    Args:
        timeout_s: Bound on connecting [s].
        request_s: Bound on each request, None for none [s].
        went: Called, once, with why the connection has ended; on a thread of Ice.

    Raises:
        Refused: Ice is not there, or the secret is another one.
        Unreachable: Nobody answers there.
    """

    def __init__(
        self,
        address: IceAddress,
        secret: Secret,
        timeout_s: float,
        *,
        request_s: float | None = None,
        went: Callable[[str], object] = lambda why: None,
    ) -> None:
        self._runtime = protocol.runtime()
        self._address = address
        self._request_s = request_s
        self._went = went
        self._is_over = threading.Event()
        self._lock = threading.Lock()
        self._subscriptions: dict[str, _Subscription] = {}
        self._proxies: dict[str, Any] = {}
        self._renewing: threading.Thread | None = None
        self._communicator = protocol.communicator()
        try:
            self._connection = self._connected(timeout_s)
            self._log_in(secret, timeout_s)
        except BaseException:
            self._communicator.destroy()
            raise

    def _connected(self, timeout_s: float) -> Any:
        host, port = self._address.host, self._address.port
        where = f"{DOOR}:tcp -h {host} -p {port} -t {max(1, int(timeout_s * 1000))}"
        try:
            endpoint = self._communicator.stringToProxy(where)
            connection = endpoint.ice_getConnectionAsync().result(timeout_s)
        except self._runtime.ice.TimeoutException:
            raise Unreachable(f"{LATE} {timeout_s:g} s: {self._address}") from None
        except self._runtime.ice.Exception as error:
            raise Unreachable(f"cannot reach {self._address}: {protocol.words_of(error)}") from None
        self._adapter = self._communicator.createObjectAdapter("")
        self._adapter.activate()
        connection.setAdapter(self._adapter)
        connection.setCloseCallback(lambda _: self._lost("the connection has ended"))
        return connection

    def _log_in(self, secret: Secret, timeout_s: float) -> None:
        nonce = str(self._answer(f"{DOOR}/nonce", None, timeout_s).value())
        proof = f"{secret.user} {secret.proof(nonce)}"
        self._answer(f"{DOOR}/identity", proof, timeout_s).value()

    def _answer(self, target: str, payload: Payload | None, timeout_s: float) -> Answer:
        outcomes: SimpleQueue[Outcome] = SimpleQueue()
        self.ask(target, payload, outcomes.put)
        try:
            outcome = outcomes.get(timeout=timeout_s)
        except Empty:
            raise Unreachable(f"{LATE} {timeout_s:g} s: {self._address}") from None
        if isinstance(outcome, Unreachable):
            raise Unreachable(f"cannot reach {self._address}: {outcome}")
        return outcome

    # Requests

    def ask(
        self, target: str, payload: Payload | None, on_outcome: OnOutcome, until: float = math.inf
    ) -> None:
        """GET, or SET; the outcome is passed once, on a thread of Ice or at once.

        A SET that has not begun at `until`, by the monotonic clock here [s], never does.
        """
        if self._request_s is not None:
            until = min(until, monotonic() + self._request_s)
        try:
            service, rest = self._split(target)
            if payload is None:
                future = service.getAsync(rest)
            else:
                if len(payload) * (4 if isinstance(payload, str) else 1) > LONGEST:
                    _check_size(payload)
                context = None if until == math.inf else {protocol.DEADLINE: deadline_at(until)}
                future = service.setAsync(rest, protocol.write_payload(payload), context=context)
        except (UnicodeEncodeError, _TooLarge, self._runtime.ice.Exception) as error:
            on_outcome(_refusal(error))
        else:
            future.add_done_callback(lambda done: on_outcome(self._outcome(done)))

    def _split(self, target: str) -> tuple[Any, str]:
        """Return the proxy of the service that a target names, and what is asked of it."""
        if len(target) > _ROOM_FOR_TARGET:
            raise _TooLarge("the target is too long")
        target.encode()
        path, mark, parameters = target.partition("?")
        named, slash, rest = path.rpartition("/")
        service = named if slash else self._address.service
        return self._proxy(service), f"{rest}{mark}{parameters}"

    def _proxy(self, service: str) -> Any:
        if service not in self._proxies:
            runtime = self._runtime
            bare = self._connection.createProxy(protocol.identity_of(service or DOOR))
            if self._request_s is not None:
                bare = bare.ice_invocationTimeout(max(1, int(self._request_s * 1000)))
            self._proxies[service] = runtime.slice.ServicePrx.uncheckedCast(bare)
        return self._proxies[service]

    def _outcome(self, future: Any) -> Outcome:
        try:
            result = future.result()
        except self._runtime.slice.Failure as failure:
            return Answer(failure.text, failure.code)
        except self._runtime.ice.InvocationTimeoutException:
            return Unreachable(f"{LATE} {self._request_s or LEASE_S:g} s")
        except self._runtime.ice.UnknownException as error:
            return Answer(f"Ice: {type(error).__name__}", "internal")
        except self._runtime.ice.Exception as error:
            return Unreachable(protocol.words_of(error))
        return DONE if result is None else Answer(protocol.read_payload(result))

    # Listening

    def listen(self, target: str, take: Taking, on_outcome: OnOutcome) -> str:
        """Listen to a property; return by what `leave` knows it.

        Args:
            target: ``P`` or ``P?queue=…``.
            take: Called with events, on a thread of Ice.
            on_outcome: Called with what came of it.
        """
        key = uuid.uuid4().hex
        try:
            service, rest = self._split(target)
            servant = _servant(self._runtime.slice.Listener, take)
            known = self._runtime.ice.Identity(key, "")
            bare = self._adapter.add(servant, known)
            proxy = self._runtime.slice.ListenerPrx.uncheckedCast(bare)
            future = service.listenAsync(rest, proxy)
        except (UnicodeEncodeError, _TooLarge, self._runtime.ice.Exception) as error:
            on_outcome(_refusal(error))
            return key
        with self._lock:
            self._subscriptions[key] = _Subscription(service, rest, proxy)

        def done(future: Any) -> None:
            outcome = self._outcome(future)
            if outcome != DONE:
                self._take_off(key)
            elif "lease=" not in rest:
                self._keep_renewing()
            on_outcome(outcome)

        future.add_done_callback(done)
        return key

    def leave(self, key: str) -> None:
        """Listen no longer; if the request is lost, the lease ends."""
        subscription = self._take_off(key)
        if subscription is not None:
            try:
                subscription.service.listenAsync(
                    f"{subscription.target.partition('?')[0]}?remove", subscription.proxy
                )
            except self._runtime.ice.Exception:
                return  # with the connection the listening has ended

    def _take_off(self, key: str) -> _Subscription | None:
        with self._lock:
            subscription = self._subscriptions.pop(key, None)
        if subscription is not None and not self._is_over.is_set():
            self._adapter.remove(self._runtime.ice.Identity(key, ""))
        return subscription

    def _keep_renewing(self) -> None:
        with self._lock:
            if self._renewing is None:
                self._renewing = threading.Thread(target=self._renew, name="leases", daemon=True)
                self._renewing.start()

    def _renew(self) -> None:
        while not self._is_over.wait(LEASE_S / 3):
            with self._lock:
                subscriptions = list(self._subscriptions.items())
            for key, subscription in subscriptions:
                if "lease=" not in subscription.target:
                    self._renew_one(key, subscription)

    def _renew_one(self, key: str, subscription: _Subscription) -> None:
        def done(future: Any) -> None:
            outcome = self._outcome(future)
            if isinstance(outcome, Unreachable):
                self._lost(str(outcome))
            elif outcome.error:
                self._take_off(key)  # it is there no longer, which an event has reported

        bounded = subscription.service.ice_invocationTimeout(int(LEASE_S * 1000))
        try:
            bounded.listenAsync(subscription.target, subscription.proxy).add_done_callback(done)
        except self._runtime.ice.Exception as error:
            self._lost(protocol.words_of(error))

    # The end

    def _lost(self, why: str) -> None:
        with self._lock:
            is_first = not self._is_over.is_set()
            self._is_over.set()
        if is_first:
            self._went(why)

    def close(self) -> None:
        """End the connection; not to be called on a thread of Ice."""
        self._is_over.set()
        self._connection.close(self._runtime.ice.ConnectionClose.Forcefully)
        self._communicator.destroy()


class _TooLarge(Exception):
    """Message that would end the connection by its size."""


def _refusal(error: Exception) -> Outcome:
    """Return the outcome of a request that could not be sent."""
    if isinstance(error, UnicodeEncodeError):
        return Answer(f"{error.start} expected UTF-8", "syntax")
    if isinstance(error, _TooLarge):
        return Answer(str(error), "too-large")
    return Unreachable(protocol.words_of(error))


def _check_size(payload: Payload) -> None:
    size = len(payload.encode() if isinstance(payload, str) else payload)
    most = LONGEST - 2 * _ROOM_FOR_TARGET
    if size > most:
        raise _TooLarge(f"longer than {most} bytes")


def _servant(base: Any, take: Taking) -> Any:
    def receive(self: object, events: list[Any], current: object = None) -> object:
        return take([protocol.read_event(each) for each in events])

    return type("Ear", (base,), {"hear": receive})()
