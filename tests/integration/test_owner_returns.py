"""An owner that ends and begins again at once is followed over every wire, by all who listen."""

from __future__ import annotations

import re
from contextlib import ExitStack

import pytest
from conformance import subject
from property_endpoints import BOUND_S, SERVED, Lines, WirePlaces, params

from rtkit.proxy.bridge import bridge
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve
from rtkit.wires.table import PORT, PUBLIC, WIRES, wire_of


@pytest.mark.parametrize("scheme", params("unix", "zenoh", *SERVED))
def test_who_listens_hears_the_new_owner(place: str, scheme: str) -> None:
    def begin(value: str, count: int) -> ServedObject:
        service = subject()
        service.update("count", count)
        if count != 7:
            service.remove("mode")
        opened = {option.name: value} if option is not None else {}
        is_on = scheme == "zenoh"
        return serve(service, "robot", settable=["*"], is_on_zenoh=is_on, **opened)

    option = WIRES[scheme].option
    with ExitStack() as ends:
        target, found = WirePlaces(place, ends).address(wire_of(scheme))
        value = target.partition(":")[2]
        served = begin(value, 7)
        known = {"unix": f"unix:{served.socket}", "zenoh": "zenoh:robot", **served.addresses}
        address = found or known[scheme]
        near = bridge(address, f"unix:{place}/near.sock", allow_set=["*"])
        ends.enter_context(near)
        ends.enter_context(bridge(near.address, f"unix:{place}/far.sock", allow_set=["*"]))
        endpoint = Lines(lambda: connect_unix(f"{place}/far.sock", BOUND_S))
        ends.callback(endpoint.close)
        counts = ends.enter_context(endpoint.listen("count?queue=100"))
        modes = ends.enter_context(endpoint.listen("mode?queue=100"))
        latest = ends.enter_context(endpoint.listen("speed"))
        assert (next(counts).payload, next(modes).payload) == ("7", "idle")
        assert next(latest).payload == "0.25"
        served.close()
        if option is not None and option.metavar in (PORT, PUBLIC):
            value = re.findall(r":(\d+)", address)[0]
        again = ends.enter_context(begin(value, 8))
        while (event := next(counts)).payload != "8":
            assert (event.payload, event.quality) == ("7", "stale")
        assert event.quality == "good"
        while not (event := next(modes)).code:
            assert (event.payload, event.quality) == ("idle", "stale")
        assert event.code == "unknown"
        assert endpoint.ask("speed", "0.5").error == ""
        while next(latest).payload != "0.5":
            pass
        again.owned(lambda: again.service.update("count", 9))
        while next(counts).payload != "9":
            pass
        ends.close()
