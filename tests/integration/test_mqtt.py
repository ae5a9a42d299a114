"""Properties through a real broker: mosquitto, begun by the test on a free port of this host."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from queue import SimpleQueue

import pytest
from conformance import Door, subject
from mosquittokit import MOSQUITTO, PASSWORD, Mosquitto, Stranger
from property_endpoints import BOUND_S, Lines

from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.keys import authority, folder
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve

pytestmark = pytest.mark.skipif(MOSQUITTO is None, reason="there is no mosquitto")


@pytest.fixture
def broker(place: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[Mosquitto]:
    monkeypatch.setenv("RTKIT_MQTT_PASSWORD", PASSWORD)
    broker = Mosquitto(Path(place))
    yield broker
    broker.stop()


@pytest.fixture
def stranger(broker: Mosquitto) -> Iterator[Stranger]:
    stranger = Stranger(broker.port, "lab/robot/#")
    yield stranger
    stranger.close()


@pytest.fixture
def endpoint(
    served: ServedObject, broker: Mosquitto, place: str, ends: ExitStack
) -> Iterator[Door]:
    """A way to the service through two proxies with the broker between them."""
    near = ends.enter_context(bridge("robot", broker.address("lab"), allow_set=["*"]))
    assert near.address == broker.address("lab/robot")
    far = f"unix:{place}/far.sock"
    ends.enter_context(bridge(near.address, far, allow_set=["*"], timeout_s=BOUND_S))
    endpoint = Lines(lambda: connect_unix(f"{place}/far.sock", BOUND_S))
    yield endpoint
    endpoint.close()
    ends.close()


def test_values_are_retained_and_described(
    served: ServedObject, service: Service, broker: Mosquitto, stranger: Stranger, ends: ExitStack
) -> None:
    known = stranger.known
    ends.enter_context(bridge("robot", broker.address("lab")))
    stranger.awaits(lambda: known.get("lab/robot/$state") == b"ready")
    stranger.awaits(lambda: b"location" in known.get("lab/robot/$properties", b""))
    expected = {
        "speed": b"0.25",
        "speed/$datatype": b"float",
        "speed/$unit": b"m/s",
        "speed/$format": b"-1:1",
        "speed/$settable": b"false",  # a proxy that lets nothing be set says so
        "serial/$settable": b"false",
        "mode/$datatype": b"enum",
        "mode/$format": b"idle,drive",
        "count/$datatype": b"integer",
        "arm/joint/1": b"0.5",
        "a%20b": b"1",
        "blob": b"\x00\xff\n{}",
    }
    stranger.awaits(lambda: all(known.get(f"lab/robot/{key}") == each
                                for key, each in expected.items()))  # fmt: skip
    assert "lab/robot/door_code" not in known
    served.owned(lambda: service.update("speed", 0.5))
    stranger.awaits(lambda: known["lab/robot/speed"] == b"0.5")
    served.owned(lambda: service.add("gripper.force", 3, "number"))
    stranger.awaits(lambda: known.get("lab/robot/gripper/force") == b"3")
    stranger.awaits(lambda: known.get("lab/robot/gripper/force/$datatype") == b"float")
    served.owned(lambda: service.remove("gripper"))
    stranger.awaits(lambda: not any("gripper" in topic for topic in known))
    late = Stranger(broker.port, "lab/robot/#")
    late.awaits(lambda: late.known.get("lab/robot/speed") == b"0.5")
    late.close()
    ends.close()
    stranger.awaits(lambda: known["lab/robot/$state"] == b"disconnected")


def test_anybody_sets_what_is_allowed_and_hears_what_is_not(
    served: ServedObject, broker: Mosquitto, stranger: Stranger, ends: ExitStack
) -> None:
    ends.enter_context(bridge("robot", broker.address("lab"), allow_set=["speed", "double"]))
    stranger.awaits(lambda: stranger.known.get("lab/robot/$state") == b"ready")
    stranger.publish("lab/robot/speed/set", "0.75")
    stranger.awaits(lambda: stranger.known.get("lab/robot/speed") == b"0.75")
    for number, (topic, payload) in enumerate(
        [
            ("speed/set", "7"),
            ("count/set", "8"),
            ("speed/get", ""),
            ("nope/get", ""),
            ("$odd/get", ""),
            ("count/listen/set", "elsewhere"),
            ("arm/properties/get", ""),
        ]
    ):
        stranger.publish(f"lab/robot/{topic}", payload, b"%d" % number)
    stranger.awaits(lambda: len(stranger.replies) == 6)
    told = {mark: more.get("code") or payload for payload, more, mark in stranger.replies}
    assert told == {
        b"0": "bad-value",
        b"1": "denied",
        b"2": b"0.75",
        b"3": "unknown",
        b"5": "denied",
        b"6": b"(angle joint)",
    }
    ends.close()


def test_rubbish_is_answered_and_harms_nobody(
    served: ServedObject, broker: Mosquitto, stranger: Stranger, ends: ExitStack
) -> None:
    ends.enter_context(bridge("robot", broker.address("lab"), allow_set=["*"]))
    stranger.awaits(lambda: stranger.known.get("lab/robot/$state") == b"ready")
    rubbish = {
        b"utf-8": ("speed/set", b"\xff\xfe"),
        b"nested": ("speed/set", b"(" * 1_000_000),
        b"no number": ("speed/set", b"NaN"),
        b"half": ("speed/set", b"(1"),
        b"nothing": ("speed/set", b"\0\r\n"),
        b"spelling": ("%zz/get", b""),
        b"name": ("a//b/get", b""),
        b"twice": ("%73peed/get", b""),
    }
    for mark, (topic, payload) in rubbish.items():
        stranger.publish(f"lab/robot/{topic}", payload, mark)
    stranger.publish("lab/robot/speed/get", "", b"last")
    stranger.awaits(lambda: any(mark == b"last" for _, _, mark in stranger.replies))
    told = {mark: more.get("code") or payload for payload, more, mark in stranger.replies}
    assert told.pop(b"last") == told.pop(b"twice") == b"0.25"
    assert told.pop(b"nested") == "too-large"
    assert told.pop(b"no number") == "bad-value"
    assert told == dict.fromkeys([b"utf-8", b"half", b"nothing", b"spelling", b"name"], "syntax")
    ends.close()


def test_the_broker_goes_and_comes_back(
    endpoint: Door, broker: Mosquitto, served: ServedObject, service: Service, stranger: Stranger
) -> None:
    with endpoint.listen("count?queue=9") as events:
        assert next(events).payload == "7"
        broker.stop()
        assert next(events).quality == "stale"
        assert endpoint.ask("count").error == "no-service"
        served.owned(lambda: service.update("count", 8))
        broker.start()
        back = next(events)
        assert (back.payload, back.quality) == ("8", "good")
        assert endpoint.ask("count").payload == "8"
    stranger.awaits(lambda: stranger.known.get("lab/robot/count") == b"8")


def test_the_owner_goes_and_comes_back(
    place: str, broker: Mosquitto, stranger: Stranger, ends: ExitStack
) -> None:
    served = serve(subject(), "robot", is_on_zenoh=False)
    ends.enter_context(bridge("robot", broker.address("lab")))
    stranger.awaits(lambda: stranger.known.get("lab/robot/count") == b"7")
    served.close()
    second = subject()
    second.update("count", 8)
    second.remove("mode")
    with serve(second, "robot", is_on_zenoh=False):
        stranger.awaits(lambda: stranger.known.get("lab/robot/count") == b"8")
        stranger.awaits(lambda: "lab/robot/mode" not in stranger.known)
        ends.close()


def test_what_is_refused(
    served: ServedObject, broker: Mosquitto, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(Malformed, match="not mqtt:USER@HOST"):
        bridge("robot", f"mqtt:localhost:{broker.port}/lab")
    with pytest.raises(Refused, match="on this host only"):
        bridge("robot", "mqtt:robot@example.org/lab")
    with pytest.raises(RtkitError, match="nothing is there"):
        bridge(broker.address("lab/nobody"), "tcp:0", timeout_s=0.5)
    monkeypatch.setenv("RTKIT_MQTT_PASSWORD", "guess")
    with pytest.raises(Refused, match="refuses robot"):
        bridge("robot", broker.address("lab"))
    monkeypatch.delenv("RTKIT_MQTT_PASSWORD")
    with pytest.raises(Refused, match="set RTKIT_MQTT_PASSWORD"):
        bridge("robot", broker.address("lab"))
    monkeypatch.setenv("RTKIT_MQTT_PASSWORD", PASSWORD)
    said: SimpleQueue[str] = SimpleQueue()
    broker.stop()
    with pytest.raises(Unreachable, match="cannot reach localhost"):
        bridge("robot", broker.address("lab"), on_status=said.put)


def test_behind_tls_certificates_say_who_it_is(
    place: str, served: ServedObject, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The broker asks for one of the CA; one of another CA, or none, is not let in."""
    broker = Mosquitto(Path(place), os.environ["RTKIT_KEYS"])
    try:
        address = broker.address("lab")
        authority.issue("helper", "component", [], 9, f"{tmp_path}/helper")
        with monkeypatch.context() as patch:
            patch.setenv("RTKIT_KEYS", f"{tmp_path}/helper")
            far = f"unix:{place}/far.sock"
            with bridge("robot", address) as near, bridge(near.address, far, timeout_s=BOUND_S), \
                    connect_unix(f"{place}/far.sock", BOUND_S) as client:  # fmt: skip
                assert client.ask("count").payload == "7"
        with monkeypatch.context() as patch:
            patch.setenv("RTKIT_KEYS", f"{tmp_path}/stranger")
            authority.init("stranger", ["localhost"])
            with pytest.raises(Refused, match="not trusted"):
                bridge("robot", address, timeout_s=BOUND_S)
            for name in (folder.CA_CERTIFICATE, folder.REVOKED):
                shutil.copy(f"{tmp_path}/helper/{name}", f"{tmp_path}/stranger")
            with pytest.raises(Refused, match="may not do"):
                bridge("robot", address, timeout_s=BOUND_S)
        with pytest.raises(Refused, match="no password"):
            bridge("robot", address.replace("mqtts", "mqtt"), timeout_s=BOUND_S)
    finally:
        broker.stop()
