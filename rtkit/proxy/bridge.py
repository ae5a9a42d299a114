"""Proxy as a whole: the uplink to an owner, a relay of it, and the endpoint opened for it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from rtkit.closing import Closing
from rtkit.errors import Malformed, Unreachable
from rtkit.property.codes import PropertyError
from rtkit.proxy.addresses import open_endpoint, source_of
from rtkit.proxy.prefix import Allowed, PrefixedNames
from rtkit.proxy.relay import ITSELF, Relay
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.wire import WireSettings


class Bridge(Closing):
    """Running proxy; close it, or use it as a context.

    Attributes:
        address: Where its endpoint is.
    """

    def __init__(self, host: PropertyEventLoop, address: str) -> None:
        self._host = host
        self.address = address

    def close(self) -> None:
        """Close the proxy: its endpoint closes, and waiting callers get an error."""
        self._host.close()


class _OwnerStatus:
    """Reports about the owner: only when it comes and goes, and from the first time on."""

    def __init__(self, on_status: Callable[[str], None]) -> None:
        self._on_status = on_status
        self._reported: bool | str | None = None
        self.why = ""
        self.is_known = threading.Event()

    def __call__(self, why: str) -> None:
        # Why it cannot be reached may change with each attempt; a loop is reported by itself.
        delta: bool | str = why if why == ITSELF else not why
        if self._reported is None:
            self.why = why
            self.is_known.set()
        elif self._reported != delta and not (isinstance(self._reported, str) and delta is False):
            self._on_status(why)
        else:
            return
        self._reported = delta


def bridge(
    source: str,
    target: str,
    *,
    prefix: str = "",
    allow_set: Sequence[str] = (),
    cwd: str = "/",
    timeout_s: float = 5.0,
    on_status: Callable[[str], None] = lambda why: None,
    on_refusal: Callable[[str, str, str], object] | None = None,
    is_insecure: bool = False,
) -> Bridge:
    """Open an endpoint for the properties of another service.

    Args:
        source: Its address.
        target: Address of the endpoint.
        prefix: Put in front of all names.
        allow_set: Patterns of the names that may be set; actions are started by that too.
        cwd: Working directory in the tree, for paths.
        timeout_s: Bound on each attempt to connect [s].
        on_status: Called, on the loop, with why when the owner goes, with nothing when it is back.
        on_refusal: Hears of each request that was denied: who, method, target.
        is_insecure: Other hosts may be talked with without TLS, which ``rtls -l`` then shows.

    Raises:
        RtkitError: An address is none; the owner cannot be reached, or is this proxy itself; the
            endpoint cannot be opened.
    """
    host = PropertyEventLoop()
    # SETs have been allowed or denied here: endpoints pass on all that comes through.
    settings = WireSettings(host, timeout_s, settable=("*",), is_insecure=is_insecure)
    status = _OwnerStatus(on_status)
    try:
        names = _names(prefix)
        found = source_of(source, cwd, settings)
        relay = Relay(
            host, found.connect, names=names, allowed=Allowed(allow_set), on_status=status
        )
        relay.name, relay.on_refusal = found.name, on_refusal
        host.at_end(lambda: _locked(host, relay.uplink.close))
        host.start()
        relay.uplink.start()
        if not status.is_known.wait(2 * timeout_s):
            raise Unreachable(f"no answer within {2 * timeout_s:g} s: {source}")
        if status.why:
            raise PropertyError("no-service", f"{source}: {status.why}")
        address: str = host.call(lambda: open_endpoint(target, relay, settings))
    except BaseException:
        host.close()
        raise
    return Bridge(host, address)


def _names(prefix: str) -> PrefixedNames:
    try:
        return PrefixedNames(prefix)
    except PropertyError:
        raise Malformed(f"not a name to put in front: {prefix!r}") from None


def _locked(host: PropertyEventLoop, work: Callable[[], None]) -> None:
    with host.lock:
        work()
