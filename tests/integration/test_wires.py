"""Every wire of the table carries requests and events alike: through proxies and to clients."""

from __future__ import annotations

import contextlib
import re
import socket
import threading
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from time import monotonic

import pytest
from conformance import ROWS, Door, check_answers, check_events, check_once, subject
from property_endpoints import BOUND_S, Lines, WirePlaces, client_at, params

from rtkit.errors import RtkitError, Unreachable
from rtkit.link import secret
from rtkit.property.codes import PropertyError
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.tree.property_connections import PropertyConnections
from rtkit.wires.line.client import connect_unix
from rtkit.wires.property_client import failure
from rtkit.wires.serve import ServedObject, serve
from rtkit.wires.table import WIRES, wire_of

ROOT = Path(__file__).parents[2]
FOR_CLIENTS = [each for each in WIRES if wire_of(each).client is not None]
FOR_SERVICES = [each for each in FOR_CLIENTS if wire_of(each).client.has_services]  # type: ignore[union-attr]


@pytest.fixture(params=params(*WIRES))
def through_proxies(
    request: pytest.FixtureRequest, served: ServedObject, place: str, ends: ExitStack
) -> Iterator[Door]:
    """A way to the service through two proxies with the wire between them."""
    address = WirePlaces(place, ends).opened(wire_of(request.param), "robot")
    ends.enter_context(
        bridge(address, f"unix:{place}/far.sock", allow_set=["*"], timeout_s=BOUND_S)
    )
    endpoint = Lines(lambda: connect_unix(f"{place}/far.sock", BOUND_S))
    yield endpoint
    endpoint.close()
    ends.close()


@pytest.fixture(params=params(*FOR_CLIENTS))
def of_client(
    request: pytest.FixtureRequest, served: ServedObject, place: str, ends: ExitStack
) -> Iterator[Door]:
    """A client of the wire at the endpoint of a proxy."""
    address = WirePlaces(place, ends).opened(wire_of(request.param), "robot")
    endpoint = client_at(request.param, address)
    yield endpoint
    endpoint.close()
    ends.close()


SHORT = tuple(row for row in ROWS if len(str(row[1])) < 100_000)
"""Rows that do not take minutes on a serial line."""


def test_requests_through_proxies(through_proxies: Door) -> None:
    check_answers(through_proxies, SHORT)


def test_events_through_proxies(
    through_proxies: Door, served: ServedObject, service: Service
) -> None:
    check_events(through_proxies, service, served.owned)


def test_a_request_that_is_repeated_with_its_id_acts_once(
    through_proxies: Door, place: str
) -> None:
    check_once(f"{place}/far.sock")


def test_a_silent_owner_is_given_up_in_time(through_proxies: Door, served: ServedObject) -> None:
    """What a requester states bounds its request on each wire, whatever the bounds of the wire."""
    check_silence(through_proxies, served)


def test_a_client_gives_up_a_silent_service_in_time(of_client: Door, served: ServedObject) -> None:
    check_silence(of_client, served)


@pytest.mark.parametrize("scheme", params(*FOR_SERVICES))
def test_a_target_bounds_also_what_is_asked_before_it(place: str, scheme: str) -> None:
    """A silent endpoint, as one of a stopped process, is asked for its services first."""
    secret.make()
    side = wire_of(scheme).client
    assert side is not None
    with _silent(wire_of(scheme).source, place) as form:
        typed = f"{form.replace('SERVICE', 'robot')}/count?timeout=0.3"
        with contextlib.closing(PropertyConnections("/", "", BOUND_S)) as connections:
            begin = monotonic()
            with pytest.raises(PropertyError) as raised:
                connections.find(typed)
            assert monotonic() - begin < 3.0
    assert raised.value.code == "timeout"


@contextlib.contextmanager
def _silent(form: str, place: str) -> Iterator[str]:
    """Listen, and say nothing, at a port or path of an address; return that filled in."""
    is_path = "PATH" in form
    assert is_path or "HOST:PORT" in form, f"clients connect neither to PATH nor HOST:PORT: {form}"
    with socket.socket(socket.AF_UNIX if is_path else socket.AF_INET) as silent:
        silent.bind(f"{place}/silent.sock" if is_path else ("127.0.0.1", 0))
        silent.listen()
        at = silent.getsockname()
        where = ("PATH", at) if is_path else ("HOST:PORT", f"localhost:{at[1]}")
        yield form.replace(*where)


def test_targets_with_other_bounds_have_connections_of_their_own(served: ServedObject) -> None:
    with (
        serve(subject(), "other", is_on_zenoh=False, port=0) as far,
        contextlib.closing(PropertyConnections("/", str(far.port), BOUND_S)) as connections,
    ):
        _, short = connections.find("other.count?timeout=0.3")
        _, long = connections.find("other.count")
        assert short is not long
        assert connections.find("other.name")[1] is long


def check_silence(endpoint: Door, served: ServedObject) -> None:
    stands, goes_on = threading.Event(), threading.Event()

    def stand() -> None:
        stands.set()
        goes_on.wait()

    stops = threading.Thread(target=served.owned, args=(stand,))
    assert endpoint.ask("count").payload == "7"
    stops.start()
    assert stands.wait(BOUND_S)
    try:
        for target, payload in (("count?timeout=0.5", None), ("count?timeout=0.5", "7")):
            begin = monotonic()
            try:
                answer = endpoint.ask(target, payload)
            except Unreachable as error:
                answer = failure(error)
            assert answer.error == "timeout"
            assert monotonic() - begin < 3.0
    finally:
        goes_on.set()
        stops.join()
    for _ in range(2):
        assert endpoint.ask("name").payload == '"rover"'  # not what was given up


def test_requests_of_a_client(of_client: Door) -> None:
    check_answers(of_client, SHORT)


def test_events_to_a_client(of_client: Door, served: ServedObject, service: Service) -> None:
    check_events(of_client, service, served.owned)


@pytest.mark.parametrize("scheme", WIRES)
@pytest.mark.parametrize("rest", ["", "?", "//", ":", "nobody@nowhere:x/y", "localhost:99999/x"])
def test_what_is_no_address_is_refused(place: str, scheme: str, rest: str) -> None:
    with pytest.raises(RtkitError):
        bridge(f"{scheme}:{rest}", "far", timeout_s=0.5)


@pytest.mark.parametrize("scheme", WIRES)
def test_nothing_is_opened_at_no_address(served: ServedObject, scheme: str) -> None:
    with pytest.raises(RtkitError):
        bridge("robot", f"{scheme}:")


@pytest.mark.parametrize("scheme", WIRES)
def test_a_record_is_whole(scheme: str) -> None:
    wire = wire_of(scheme)
    assert wire.scheme == scheme
    assert wire.summary.endswith(".")
    assert all(form.startswith(f"{scheme}:") for form in (wire.source, wire.target))
    assert wire.client is None or wire.source.startswith(wire.client.prefix)
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    assert not wire.extra or wire.extra in extras


def test_an_endpoint_that_there_is_none_of_is_refused(place: str) -> None:
    with pytest.raises(TypeError, match="there is port tls serial http https ice"):
        serve(subject(), "robot", ftp=1)


def test_no_other_room_knows_the_wires_by_name() -> None:
    """What depends on the wire is in its record, so that a new one is its package and a line."""
    schemes = "|".join(each for each in WIRES if each not in ("unix", "zenoh"))
    address = re.compile(rf'["\'](?:{schemes})(?::|["\'])')
    found = [
        f"{file.relative_to(ROOT)}: {line.strip()}"
        for room in ("cli", "property", "proxy", "serving", "tree")
        for file in sorted((ROOT / "rtkit" / room).rglob("*.py"))
        for line in file.read_text(encoding="utf-8").splitlines()
        if address.search(line) and not line.strip().startswith("(")
    ]
    assert found == []
