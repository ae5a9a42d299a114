"""An owner that ends and begins again at once is followed over every wire, by all who listen."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import pytest
from conformance import subject
from property_endpoints import BOUND_S, Lines
from serialkit import Cable

from rtkit.proxy.bridge import bridge
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve

WIRES: dict[str, Callable[[ServedObject, Cable], str]] = {
    "unix": lambda served, cable: f"unix:{served.socket}",
    "tcp": lambda served, cable: f"tcp:localhost:{served.port}",
    "zenoh": lambda served, cable: "zenoh:robot",
    "http": lambda served, cable: f"http://localhost:{served.http}/ps/robot",
    "serial": lambda served, cable: f"serial:{cable.near}?check=1",
}


@pytest.mark.parametrize("wire", WIRES)
def test_who_listens_hears_the_new_owner(place: str, cable: Cable, wire: str) -> None:
    def begin(port: int, http: int, count: int) -> ServedObject:
        service = subject()
        service.update("count", count)
        if count != 7:
            service.remove("mode")
        is_on = wire == "zenoh"
        return serve(service, "robot", port=port, http=http, serial=cable.far,
                     settable=["*"], is_on_zenoh=is_on)  # fmt: skip

    with ExitStack() as ends:
        served = begin(0, 0, 7)
        near = bridge(WIRES[wire](served, cable), f"unix:{place}/near.sock", allow_set=["*"])
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
        assert served.port is not None
        assert served.http is not None
        again = ends.enter_context(begin(served.port, served.http, 8))
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
