"""The serial door, over real terminal devices: it answers as all doors do, also where lines are
damaged, and when devices come and go."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue

import pytest
from conformance import ROWS, check_answers, check_events, subject
from oneline import BOUND_S, OneLine
from property_endpoints import listening
from serialkit import Cable, noise

from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serial.address import read_address, split_target
from rtkit.wires.serial.client import connect_serial
from rtkit.wires.serve import ServedObject, serve


@contextmanager
def serving(cable: Cable, service: Service, *settable: str) -> Iterator[ServedObject]:
    given = {"serial": cable.far, "settable": settable, "is_on_zenoh": False}
    with serve(service, "robot", **given) as served:  # type: ignore[arg-type]
        yield served


@pytest.mark.parametrize("check", ["1", "0"])
def test_it_answers_as_all_doors(cable: Cable, check: str) -> None:
    with (
        serving(cable, subject(), "*"),
        connect_serial(f"serial:{cable.near}?check={check}", BOUND_S) as client,
    ):
        check_answers(OneLine(client))


@pytest.mark.parametrize("check", ["1", "0"])
def test_it_tells_events_as_all_doors(cable: Cable, check: str) -> None:
    with (
        serving(cable, subject(), "*") as served,
        connect_serial(f"serial:{cable.near}?check={check}", BOUND_S) as client,
    ):
        check_events(OneLine(client), served.service, served.owned)


def test_it_answers_alike_where_lines_are_damaged(cable: Cable) -> None:
    cable.noise = noise(0, one_in=6)
    short = tuple(row for row in ROWS if len(row[1] or "") < 1000)
    with (
        serving(cable, subject(), "*"),
        connect_serial(f"serial:{cable.near}?check=1", BOUND_S) as client,
    ):
        check_answers(OneLine(client), short)


def test_what_is_asked_again_acts_once(cable: Cable) -> None:
    calls: list[float] = []

    class Robot:
        def move(self, way: float) -> int:
            calls.append(way)
            return len(calls)

    cable.noise = noise(7, one_in=4)
    with (
        serve(Robot(), "robot", serial=cable.far, settable=["move"], is_on_zenoh=False),
        connect_serial(f"serial:{cable.near}?check=1", BOUND_S) as client,
    ):
        for way in range(30):
            answer = client.ask("move?echo", str(way)).value()
            assert answer == f'<call state="done"><result>{way + 1}</result></call>'
    assert calls == list(range(30))


def test_the_last_value_arrives_where_lines_are_damaged(
    cable: Cable, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.wires.serial.client.LEASE_S", 0.6)
    cable.noise = noise(3, one_in=3)
    with (
        serving(cable, subject()) as served,
        connect_serial(f"serial:{cable.near}?check=1", BOUND_S) as client,
    ):
        client.listen("count")
        for value in range(100):
            served.owned(lambda value=value: served.service.update("count", value))  # type: ignore[misc]
        while (event := client.event(BOUND_S)) is not None and event.payload != "99":
            pass
        assert event is not None


def test_only_what_is_named_can_be_set(cable: Cable) -> None:
    with serving(cable, subject(), "arm.*") as _, connect_serial(cable.near, BOUND_S) as client:
        assert client.has_checks
        assert client.ask("arm.angle", "4").error == ""
        assert client.ask("count", "4").error == "denied"
        assert client.ask("properties", "((arm.angle 5) (count 4))").error == "denied"
        assert client.ask("properties?names=(arm.angle%20count)&values").payload == (
            "((arm.angle 4) (count 7))"
        )
        assert client.ask("properties", "((arm.angle 5))").error == ""
        client.listen("count")
        event = client.event(BOUND_S)
        assert event is not None
        assert event.payload == "7"


def test_a_device_that_is_unplugged_is_missed_and_taken_up_again(
    cable: Cable, caplog: pytest.LogCaptureFixture
) -> None:
    cable.unplug(cable.far)
    with serving(cable, subject(), "*"):
        assert "waiting for it" in caplog.text
        cable.plug(cable.far)
        with connect_serial(cable.near, BOUND_S) as client:
            assert client.ask("count", "8").error == ""
            cable.unplug(cable.near)
            with pytest.raises(Unreachable, match="unplugged"):
                client.ask("count")
            with pytest.raises(Unreachable, match="unplugged"):
                client.event(BOUND_S)
        with pytest.raises(Unreachable, match="No such file"):
            connect_serial(cable.near, BOUND_S)
        cable.plug(cable.near)
        cable.unplug(cable.far)
        cable.plug(cable.far)
        with connect_serial(cable.near, BOUND_S) as client:
            assert client.ask("count").payload == "8"
        assert "is back" in caplog.text


def test_nobody_at_the_other_end_is_said(cable: Cable) -> None:
    with pytest.raises(Unreachable, match="no answer within"):
        connect_serial(cable.near, 0.2)


@pytest.mark.parametrize("check", ["1", "0"])
@pytest.mark.parametrize(
    "rubbish",
    [
        bytes(range(256)) * 8,
        b"x" * (3 << 20),
        b"\n" * 10_000,
        b"SET any {999999999999}\n" + b"SET count 1\n" * 1000,
        b"SET any {5}\n" + b"SET count 1\n" * 1000,
        b"#1 SET any {12} ~0000\nSET count 12\n",
        b"GET ~29B1\n" * 100,
    ],
)
def test_rubbish_is_lived_through(cable: Cable, check: str, rubbish: bytes) -> None:
    address = f"{cable.near}?check={check}"
    if check == "0":
        rubbish = rubbish.replace(b" ~0000", b"")
    with serving(cable, subject(), "*"):
        with connect_serial(address, BOUND_S) as client:
            assert client.ask("count").payload == "7"
        end = os.open(cable.near, os.O_RDWR | os.O_NOCTTY)
        rest = memoryview(rubbish)
        while rest:
            rest = rest[os.write(end, rest) :]
        os.close(end)
        with connect_serial(address, BOUND_S) as client:
            assert client.ask("count").payload == "7"


def test_two_do_not_share_a_device(cable: Cable) -> None:
    with (
        serving(cable, subject()),
        connect_serial(cable.near, BOUND_S),
        pytest.raises(Unreachable, match="in use"),
    ):
        connect_serial(cable.near, BOUND_S)


def test_addresses(tmp_path: Path) -> None:
    assert read_address("serial:/dev/ttyS0?baud=9600&check=1") == ("/dev/ttyS0", 9600, True, ())
    assert read_address("/dev/ttyS0") == ("/dev/ttyS0", 115200, None, ())
    assert read_address("/dev/ttyS0?address=1-3,base").devices == ("1", "2", "3", "base")
    for wrong in (
        "serial:", "x?baud=fast", "x?baud=0", "x?check=2", "x?y=1", "x?baud=999999999",
        "x?address=", "x?address=1,1", "x?address=é",
    ):  # fmt: skip
        with pytest.raises(Malformed):
            read_address(wrong)
    (tmp_path / "tty").touch()
    device = f"serial:{tmp_path}/tty"
    for text, parts in (
        (device, (device, "")),
        (f"{device}/", (device, "")),
        (f"{device}/arm/angle?x=1", (device, "arm/angle?x=1")),
        ("serial:/none/speed", ("serial:/none/speed", "")),
        ("serial:COM?baud=9600/a?frame=x", ("serial:COM?baud=9600", "a?frame=x")),
        ("serial:COM?check=1&baud=9600", ("serial:COM?check=1&baud=9600", "")),
        ("serial:COM?address=7/a.b", ("serial:COM?address=7", "a.b")),
    ):
        assert split_target(text) == parts
    for wrong in (__file__, "/dev/null"):
        with pytest.raises(Refused, match="not a serial line"):
            connect_serial(wrong, 1.0)


def test_while_the_device_is_gone_a_proxy_says_so(place: str, cable: Cable) -> None:
    said: SimpleQueue[str] = SimpleQueue()
    path = f"{place}/p.sock"
    with (
        serving(cable, subject(), "*") as served,
        bridge(f"serial:{cable.near}?check=1", f"unix:{path}", allow_set=["*"], on_status=said.put),
        connect_unix(path, BOUND_S) as client,
        listening(connect_unix(path, BOUND_S), "count") as events,
    ):
        assert next(events).payload == "7"
        cable.unplug(cable.near)
        assert "unplugged" in said.get(timeout=BOUND_S)
        assert client.ask("count").error == "no-service"
        assert next(events).quality == "stale"
        served.owned(lambda: served.service.update("count", 8))
        cable.plug(cable.near)
        while said.get(timeout=BOUND_S):
            pass
        while (event := next(events)).payload != "8":
            pass
        assert event.quality == "good"
        assert client.ask("count").payload == "8"
