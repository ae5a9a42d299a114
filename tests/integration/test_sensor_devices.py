"""Sensors behind real pipes and pseudo terminals, unplugged and plugged again."""

from __future__ import annotations

import math
import os
import pty
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from waiting import until

from rtkit.property.messages import PropertyEvent
from rtkit.services.camera import Camera
from rtkit.services.device import SilenceLimit
from rtkit.services.gps import Gps
from rtkit.services.input_events import EVENT
from rtkit.services.joystick import Joystick, Pointer
from rtkit.services.microphone import Microphone
from rtkit.services.sensor import PropertySensor, Sensor
from rtkit.wires.line.client import LineClient, connect_unix
from rtkit.wires.serve import serve

BOUND_S = 10.0
GGA = b"$GPGGA,123519,6503.6000,N,02528.0000,E,1,08,0.9,15.4,M,46.9,M,,*7E\r\n"
Serve = Callable[[Sensor], LineClient]


@pytest.fixture
def serving(place: str) -> Iterator[Serve]:
    with ExitStack() as stack:

        def begin(sensor: Sensor) -> LineClient:
            served = stack.enter_context(serve(sensor, "sensor", is_on_zenoh=False))
            return stack.enter_context(connect_unix(served.socket, BOUND_S))

        yield begin


def report(*events: tuple[int, int, int]) -> bytes:
    return b"".join(EVENT.pack(0, 0, *each) for each in (*events, (0, 0, 0)))


def status(client: LineClient) -> str:
    return text(client, "status")


def text(client: LineClient, name: str) -> str:
    return str(client.ask(name).value()).strip('"')


def heard(client: LineClient) -> PropertyEvent:
    event = client.event(BOUND_S)
    assert event is not None
    return event


def test_a_joystick_is_unplugged_and_plugged_again(serving: Serve, place: str) -> None:
    path = f"{place}/event7"
    client = serving(Joystick(path, limits=(-100, 100)))
    until(lambda: "No such file or directory" in status(client), "it looks for the device")
    os.mkfifo(path)
    for turn in (100, -100):
        with open(path, "wb", buffering=0) as device:  # waits until it is read
            device.write(report((3, 0, turn), (1, 0x130, 1)))
            raw = f'(("x" {turn}) ("south" 1))'
            until(lambda raw=raw: client.ask("data").value() == raw, "it is read")  # type: ignore[misc]
            assert status(client) == "ready"
            assert client.ask("axes.x").value() == f"{turn / 100}"
            assert client.ask("buttons.south").value() == "true"
            marker = str(client.ask("markers").value())
            assert "<type>joystick</type>" in marker
        until(lambda: status(client) == f"waiting: {path}: unplugged", "it has gone")
        assert client.ask("axes.x").value() == "0.0"
        assert client.ask("buttons.south").value() == "false"


def test_each_report_is_an_event_in_order(serving: Serve, place: str) -> None:
    path = f"{place}/event7"
    os.mkfifo(path)
    client = serving(Pointer(path, limits=(0, 1000)))
    client.listen("data?queue=1000&mode=all")
    with open(path, "wb", buffering=0) as device:
        for each in range(0, 1000, 10):
            device.write(report((3, 0, each)))
        device.write(b"\x00")  # and the beginning of one more
        places: list[str] = []
        while not places or not places[-1].startswith("((0.99"):
            places.append(str(heard(client).payload))
    ways = [float(each.split()[0].strip("(")) for each in places if each != "()"]
    assert ways[-100:] == [each / 1000 for each in range(0, 1000, 10)]


def test_what_is_no_input_device_is_told(serving: Serve, place: str) -> None:
    Path(f"{place}/event7").write_bytes(b"this is no input device, as all may see" * 9)
    client = serving(Joystick(f"{place}/event7"))
    until(lambda: "these are no input events" in status(client), "it is refused")


def test_a_gps_on_a_terminal_is_unplugged_and_plugged_again(serving: Serve, place: str) -> None:
    path = f"{place}/ttyGPS"
    client = serving(Gps(path, baud=4800))
    for number, fix in enumerate((b",E,1,", b",E,0,"), 1):
        line = GGA.replace(b",E,1,", fix).replace(b"*7E", b"*7E" if fix == b",E,1," else b"*7F")
        master, slave = pty.openpty()
        os.symlink(os.ttyname(slave), path)
        until(lambda: status(client) == "no fix", "it is open")
        os.write(master, line[:30])
        os.write(master, line[30:] + GGA.replace(b"*7E", b"*00"))
        until(lambda: client.ask("refused").value() == f"{number}", "it is read")  # noqa: B023
        wanted = ("gps", "ready") if fix == b",E,1," else ("none", "no fix")
        assert (text(client, "fix"), status(client)) == wanted
        os.unlink(path)
        os.close(master)
        os.close(slave)
        until(lambda: status(client).startswith("waiting: "), "it has gone")
        assert client.ask("position").value() == "()"


def test_a_recorded_file_is_read_to_its_end(serving: Serve, place: str) -> None:
    Path(f"{place}/track.nmea").write_bytes(GGA * 50 + GGA[:20])
    client = serving(Gps(f"{place}/track.nmea"))
    until(lambda: status(client) == "ended", "the end is told")
    assert client.ask("satellites").value() == "8"


def test_a_sensor_is_closed_while_its_device_says_nothing(serving: Serve, place: str) -> None:
    os.mkfifo(f"{place}/quiet")
    keeps = os.open(f"{place}/quiet", os.O_RDWR)
    sensor = Joystick(f"{place}/quiet")
    with sensor:
        until(lambda: sensor.status == "ready", "it is open")
    with sensor:  # and may be opened again
        until(lambda: sensor.status == "ready", "it is open")
    os.close(keeps)


SILENCE_S = 0.25


def test_a_gps_that_falls_silent_says_since_when_and_has_no_position(
    serving: Serve, place: str
) -> None:
    """What is no sentence ends no silence; a sentence without a place ends it, too."""
    master, slave = pty.openpty()
    client = serving(Gps(os.ttyname(slave), silence=SILENCE_S))
    until(lambda: status(client) == "no fix", "it is open")
    os.write(master, GGA)
    until(lambda: status(client) == "ready", "it has a place")
    client.listen("status")
    assert str(heard(client).payload) == '"ready"'
    for ends, then in ((GGA, ["ready"]), (b"$GPGSV,0,0,00*79\r\n", ["no fix"]), (b"", [])):
        since = str(heard(client).payload).strip('"')
        assert re.fullmatch(r"silent since \d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", since)
        assert client.ask("position").value() == "()"
        assert text(client, "fix") == "none"
        refused = int(str(client.ask("refused").value()))
        os.write(master, b"rubbish\r\n")
        until(lambda: client.ask("refused").value() == f"{refused + 1}", "it is read")  # noqa: B023
        assert status(client) == since
        os.write(master, ends)
        while then and then[-1:] != [(event := str(heard(client).payload).strip('"'))]:
            assert event == "no fix", "it is there again, and its place not yet known"
    os.close(master)
    os.close(slave)


def test_rubbish_for_ever_is_a_silence_too(serving: Serve, place: str) -> None:
    os.mkfifo(f"{place}/gps")
    client = serving(Gps(f"{place}/gps", silence=SILENCE_S))
    with open(f"{place}/gps", "wb", buffering=0) as pipe:
        pipe.write(GGA)
        until(lambda: status(client) == "ready", "it has a place")
        until(lambda: pipe.write(b"x\n" * 50) and "silent" in status(client), "it says so")


def test_a_microphone_that_falls_silent_says_so_until_it_is_heard(
    serving: Serve, place: str
) -> None:
    os.mkfifo(f"{place}/sound")
    client = serving(Microphone(f"{place}/sound", rate=100, block=0.1, silence=SILENCE_S))
    with open(f"{place}/sound", "wb", buffering=0) as pipe:
        for _ in range(2):
            pipe.write(b"ab" * 10)
            until(lambda: client.ask("data").value() == "ab" * 10, "it is heard")
            assert status(client) == "ready"
            until(lambda: status(client).startswith("silent since 2"), "it says so")
            assert client.ask("data").value() == ""
            assert client.ask("level").value() == "0.0"


def test_a_joystick_that_nobody_moves_is_ready(serving: Serve, place: str) -> None:
    silence = SilenceLimit(0)
    assert (silence.left_s(), silence.state()) == (None, "ready")
    os.mkfifo(f"{place}/event7")
    assert Joystick(f"{place}/event7")._silence_s == 0
    assert Pointer(f"{place}/event7")._silence_s == 0


@pytest.mark.parametrize("wrong", [-1, math.inf, math.nan])
def test_a_silence_is_a_time(wrong: float) -> None:
    for kind in (Gps, Microphone, Camera):
        with pytest.raises(ValueError, match="silence is 0 to"):
            kind("/nowhere", silence=wrong)


def test_a_wrong_speed_of_a_line_is_told(serving: Serve, place: str) -> None:
    master, slave = pty.openpty()
    client = serving(Gps(os.ttyname(slave), baud=4801))
    until(lambda: "no such speed of a line: 4801" in status(client), "it is refused")
    os.close(master)
    os.close(slave)


class Panel:
    speed: float = 0.25


def test_a_widget_is_a_sensor_also_before_and_after_it_was_away(serving: Serve, place: str) -> None:
    client = serving(PropertySensor("panel.speed", location=(1, 0, 0, 0, 0, 0)))
    until(lambda: status(client) == "waiting: panel.speed: no-service", "it is waited for")
    for speed in (0.5, 0.75):
        panel = Panel()
        with serve(panel, "panel", is_on_zenoh=False):
            panel.speed = speed
            until(lambda: status(client) == "ready", "it is found")
            until(lambda: client.ask("data").value() == str(speed), "it is read")  # noqa: B023
            assert f"<data>{speed}</data>" in text(client, "markers")
        until(lambda: status(client) == "waiting: panel.speed: no-service", "it has gone")
