"""Serves an object as a property service with endpoints: ``rtkit.serve(thing, "name")``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack

from rtkit.closing import Closing
from rtkit.link.places import host_name
from rtkit.property.access import AccessPolicy, read_policy
from rtkit.property.objects import Exported
from rtkit.property.requests import Requester
from rtkit.property.service import Service
from rtkit.property.standard import add_standard
from rtkit.rtc.names import check_host_name, is_local_host
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.refusals import Refusals
from rtkit.wires.line.endpoint import open_unix
from rtkit.wires.table import WIRES, wire_of
from rtkit.wires.wire import Wire, WireSettings, service_name
from rtkit.wires.zenoh.on_demand import open_when_needed


class ValuePublisher:
    """Puts an attribute of a served object in force, and sends it at once, also if it is equal.

    Whoever listens with ``mode=all`` and a queue gets each value, in order, which polling does not
    promise. Called from any thread, but not from a getter.

    Attributes:
        socket: The path of the unix socket of the service.
    """

    def __init__(
        self, host: PropertyEventLoop, service: Service, thing: object, socket: str
    ) -> None:
        self.socket = socket
        self._host, self._service, self._thing = host, service, thing

    def __call__(self, name: str, value: object) -> None:
        """Set an attribute, and send its event."""
        from rtkit.property.conversion import to_value

        def change() -> None:
            setattr(self._thing, name, value)
            self._service.push(name, to_value(value))

        self._host.change(change)


class ServedObject(Closing):
    """Service with its endpoints; close it, or use it as a context.

    Attributes:
        name: Under which it is found.
        socket: The path of its unix socket.
        addresses: Of its other endpoints, by scheme.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        service: Service,
        socket: str,
        addresses: dict[str, str],
        entered: ExitStack,
    ) -> None:
        self.name = service.name
        self.socket = socket
        self.addresses = addresses
        self.service = service
        self._host = host
        self._entered = entered

    @property
    def port(self) -> int | None:
        """Return the port of its TCP endpoint, None if it has none."""
        return self._port("tcp")

    @property
    def http(self) -> int | None:
        """Return the port of its HTTP endpoint, None if it has none."""
        return self._port("http")

    @property
    def ice(self) -> int | None:
        """Return the port of its Ice endpoint, None if it has none."""
        return self._port("ice")

    def _port(self, scheme: str) -> int | None:
        address = self.addresses.get(scheme)
        return None if address is None else int(address.rpartition(":")[2].partition("/")[0])

    def update(self, name: str, value: object) -> None:
        """Publish a new value of a property that is kept here."""
        from rtkit.property.conversion import to_value

        self._host.change(lambda: self.service.update(name, to_value(value)))

    def owned(self, work: Callable[[], object]) -> None:
        """Run something as the owner of the service, and wait until it is done."""
        self._host.call(work)

    def close(self) -> None:
        """Serve it no longer; then leave the object, if it was entered."""
        self._host.close()
        self._entered.close()


def serve(
    thing: object,
    name: str,
    *,
    settable: Iterable[str] = (),
    hide: Iterable[str] = (),
    history: Mapping[str, int] | None = None,
    rules: str | AccessPolicy = "",
    notify: Iterable[str] = (),
    hosts: Iterable[str] = (),
    is_on_zenoh: bool = True,
    is_insecure: bool = False,
    **endpoints: int | str | None,
) -> ServedObject:
    """Serve an object: its attributes are properties, its methods actions; its class stays as is.

    Commands of the same user find it by its name (``rtget NAME.PROPERTY``). Methods are called on
    threads of their own; getters and setters on one other thread, or on a further one where that
    is held up; coroutine functions are awaited on a loop of asyncio. Whatever they raise, and
    however long they take, others are answered meanwhile. An object with a method ``__served__`` is
    given ``publish(name, value)`` by it: from any thread but that of a getter, this sets an
    attribute and sends its event at once, also if the value is equal; ``publish.socket`` is the
    path of its unix socket.

    Example::

        with rtkit.serve(motor, "motor"):
            motor.run()

    Args:
        thing: Any object, or a `Service` that is there already.
        name: Parts joined by slashes.
        settable: Patterns of names that may be set over a serial line; none may, unless told.
        hide: Names that are not to be seen.
        history: Patterns of names, and how many values of each ``NAME.history`` tells.
        rules: Who may do what through which endpoint, and how much: `rtkit.property.access`.
        notify: Patterns of ``SERVICE/NAME``, of your services on this host, or of addresses
            (``tcp:HOST:PORT/SERVICE/NAME``), to which events may be SET
            (``SET P.listen SERVICE/NAME``); none may, unless told.
        hosts: Names of other hosts whose services may ask and set it, through the managers that
            link them; a manager's own host may ask those of hosts that it links, without this.
        is_on_zenoh: Also answer zenoh queries, as soon as a manager runs here or somebody connects
            to the zenoh socket of the service.
        is_insecure: Other hosts may reach endpoints without TLS, too, which ``rtls -l`` then shows.
        endpoints: Further endpoints to open, None for none. ``port=`` is a TCP port of the host, 0
            for any, to clients that know the user's secret; ``http=`` and ``ice=`` likewise;
            ``serial=`` is a device, ``DEVICE[?baud=N&check=auto|1|0]``, opened when it is there.

    Raises:
        Refused: A service of that name runs; a port would be open to others without TLS.
        Malformed: It is no name, no port or no serial line; a rule cannot be read.
        Unreachable: A port is taken.
        TypeError: There is no endpoint of that name.
    """
    asked = _asked(endpoints)
    policy = read_policy(rules, endpoints=WIRES) if isinstance(rules, str) else rules
    host = PropertyEventLoop(policy)
    service = thing if isinstance(thing, Service) else Service()
    service.values.user_code, service.host = host.user_code, host
    service.name = service_name(name)
    for pattern, most in (history or {}).items():
        service.remember(pattern, most)
    service.on_refusal = Refusals()
    if allowed := tuple(notify):
        service.extensions.notifies = _notifying(host, service, allowed)
    host.add(service)
    entered = ExitStack()
    try:
        socket = open_unix(host, service.name)
        settings = WireSettings(host, settable=tuple(settable), is_insecure=is_insecure)
        addresses = {wire.scheme: wire.open(value, service, settings) for wire, value in asked}
        if is_on_zenoh:
            open_when_needed(host, service, _others(hosts))
        add_standard(service.values, service.name, thing)
        if not isinstance(thing, Service):
            exported = Exported(service, thing, hide)
            if hasattr(type(thing), "__served__"):
                thing.__served__(ValuePublisher(host, service, thing, socket))  # type: ignore[attr-defined]
            if _enter(thing, entered):
                exported.refresh()
    except BaseException:
        host.close()
        entered.close()
        raise
    host.start()
    return ServedObject(host, service, socket, addresses, entered)


def _enter(thing: object, entered: ExitStack) -> bool:
    """Enter a context manager, or those that a dictionary holds; return whether there is one."""
    things = [*thing.values()] if isinstance(thing, Mapping) else [thing]
    managers = [each for each in things if hasattr(type(each), "__exit__")]
    for each in managers:
        entered.enter_context(each)  # type: ignore[arg-type]
    return bool(managers)


def _asked(endpoints: Mapping[str, int | str | None]) -> list[tuple[Wire, str]]:
    """Return the wires to open, in the order of the table, and what to open them at."""
    given = {name: str(value) for name, value in endpoints.items() if value is not None}
    options = {each.option.name: scheme for scheme, each in WIRES.items() if each.option}
    if unknown := given.keys() - options.keys():
        raise TypeError(f"no such endpoint: {' '.join(unknown)} (there is {' '.join(options)})")
    return [(wire_of(scheme), given[name]) for name, scheme in options.items() if name in given]


def _others(hosts: Iterable[str]) -> list[str]:
    """Return the names of other hosts, each once; this one asks anyway."""
    own = host_name()
    return [check_host_name(each) for each in dict.fromkeys(hosts) if not is_local_host(each, own)]


def _notifying(
    host: PropertyEventLoop, service: Service, allowed: tuple[str, ...]
) -> Callable[[str, str], Requester]:
    from rtkit.wires.notified import Notifying

    return Notifying(host, service, allowed).caller_for
