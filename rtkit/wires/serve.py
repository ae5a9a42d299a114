"""Serves an object as a property service with endpoints: ``rtkit.serve(thing, "name")``."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping

from rtkit.closing import Closing
from rtkit.errors import Malformed
from rtkit.guard import GuardedResult, guarded
from rtkit.property.access import AccessPolicy, read_policy
from rtkit.property.codes import PropertyError
from rtkit.property.naming import canonical_segment
from rtkit.property.objects import Exported
from rtkit.property.requests import Requester
from rtkit.property.service import Service
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.refusals import Refusals
from rtkit.wires.line.endpoint import open_tcp, open_unix


class ServedObject(Closing):
    """Service with its endpoints; close it, or use it as a context.

    Attributes:
        name: Under which it is found.
        socket: The path of its unix socket.
        port: Of its TCP endpoint, None if it has none.
        http: Port of its HTTP endpoint, None if it has none.
        ice: Port of its Ice endpoint, None if it has none.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        service: Service,
        socket: str,
        port: int | None,
        http: int | None = None,
        ice: int | None = None,
    ) -> None:
        self.name = service.name
        self.socket = socket
        self.port = port
        self.http = http
        self.ice = ice
        self.service = service
        self._host = host

    def update(self, name: str, value: object) -> None:
        """Publish a new value of a property that is kept here."""
        from rtkit.property.conversion import to_value

        with self._host.lock:
            self.service.update(name, to_value(value))

    def owned(self, work: Callable[[], object]) -> None:
        """Run something as the owner of the service, and wait until it is done."""
        done = threading.Event()
        outcomes: list[GuardedResult] = []

        def run() -> None:
            outcomes.append(guarded(work))
            done.set()

        self._host.post(run)
        done.wait()
        if outcomes[0].error is not None:
            raise outcomes[0].error

    def close(self) -> None:
        """Serve it no longer."""
        self._host.close()


def serve(
    thing: object,
    name: str,
    *,
    port: int | None = None,
    serial: str | None = None,
    settable: Iterable[str] = (),
    http: int | None = None,
    ice: int | None = None,
    hide: Iterable[str] = (),
    history: Mapping[str, int] | None = None,
    rules: str | AccessPolicy = "",
    notify: Iterable[str] = (),
    is_on_zenoh: bool = True,
) -> ServedObject:
    """Serve an object: its attributes are properties, its methods actions; its class stays as is.

    Commands of the same user find it by its name (``rtget NAME.PROPERTY``). Methods are called on
    threads of their own; getters and setters on one other thread, or on a further one where that
    is held up; coroutine functions are awaited on a loop of asyncio. Whatever they raise, and
    however long they take, others are answered meanwhile.

    Example::

        with rtkit.serve(motor, "motor"):
            motor.run()

    Args:
        thing: Any object, or a `Service` that is there already.
        name: Parts joined by slashes.
        port: Also open this TCP port of the host, 0 for any, to who knows the user's secret.
        serial: Also open this serial line, ``DEVICE[?baud=N&check=auto|1|0]``, when it is there.
        settable: Patterns of names that may be set over it; none may, unless told.
        http: Also open this port of the host, 0 for any, for HTTP, likewise.
        ice: Also open this port of the host, 0 for any, for Ice, likewise.
        hide: Names that are not to be seen.
        history: Patterns of names, and how many values of each ``NAME.history`` tells.
        rules: Who may do what through which endpoint, and how much: `rtkit.property.access`.
        notify: Patterns of ``SERVICE/NAME``, of your services on this host, to which events may be
            SET (``SET P.listen SERVICE/NAME``); none may, unless told.
        is_on_zenoh: Also answer zenoh queries, through the manager where one runs.

    Raises:
        Refused: A service of that name runs.
        Malformed: It is no name, or no serial line; a rule cannot be read.
        Unreachable: A port is taken.
    """
    host = PropertyEventLoop(read_policy(rules) if isinstance(rules, str) else rules)
    service = thing if isinstance(thing, Service) else Service()
    service.user_code = host.user_code
    try:
        service.name = "/".join(map(canonical_segment, name.split("/")))
    except PropertyError as error:
        raise Malformed(f"not a name of a service: {name!r}") from error
    for pattern, most in (history or {}).items():
        service.remember(pattern, most)
    if not isinstance(thing, Service):
        Exported(service, thing, hide)
    service.on_refusal = Refusals()
    if allowed := tuple(notify):
        service.notifies = _notifying(host, service, allowed)
    host.add(service)
    try:
        socket = open_unix(host, service.name)
        if serial is not None:
            from rtkit.wires.serial.address import read_address
            from rtkit.wires.serial.endpoint import open_serial

            open_serial(host, read_address(serial), service.name, tuple(settable))
        opened = None if port is None else open_tcp(host, service.name, port)
        web = None if http is None else _open_http(host, http)
        objects = None if ice is None else _open_ice(host, ice)
        if is_on_zenoh:
            from rtkit.wires.zenoh.endpoint import open_zenoh

            open_zenoh(host, service)
    except BaseException:
        host.close()
        raise
    host.start()
    return ServedObject(host, service, socket, opened, web, objects)


def _notifying(
    host: PropertyEventLoop, service: Service, allowed: tuple[str, ...]
) -> Callable[[str, str], Requester]:
    from rtkit.wires.notified import Notifying

    return Notifying(host, service, allowed).caller_for


def _open_http(host: PropertyEventLoop, port: int) -> int:
    from rtkit.wires.http.endpoint import open_http

    return open_http(host, port)


def _open_ice(host: PropertyEventLoop, port: int) -> int:
    from rtkit.wires.ice.endpoint import open_ice

    return open_ice(host, port)
