"""Sensors tell the same reading in any frame, and are at rest when their device has gone."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import Any, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rtkit
from rtkit.services.camera import Camera
from rtkit.services.environment import Environment
from rtkit.services.frames import Frames, compose, inverse, transform
from rtkit.services.gps import Gps, NmeaReader, local
from rtkit.services.input_events import EVENT
from rtkit.services.joystick import Joystick, Pointer, _InputSensor
from rtkit.services.microphone import Microphone
from rtkit.services.sensor import DeviceSensor, Sensor
from rtkit.services.vision import CameraView, PictureStore, Vision

coordinate = st.floats(-50, 50)
angle = st.floats(-math.pi, math.pi)
poses = st.tuples(coordinate, coordinate, coordinate, angle, st.floats(-1.4, 1.4), angle)


class Feeler(Sensor):
    """A sensor that feels one thing at a place."""

    data: Final = 7

    def __init__(self, marker: rtkit.Marker, **more: object) -> None:
        super().__init__(**more)  # type: ignore[arg-type]
        self.marker = marker

    def _found(self) -> Iterable[rtkit.Marker]:
        return [self.marker]


@given(poses, poses, poses, st.tuples(coordinate, coordinate, coordinate))
def test_one_reading_in_two_frames_agrees_with_the_location(
    mount: tuple[float, ...],
    base: tuple[float, ...],
    other: tuple[float, ...],
    seen: tuple[float, ...],
) -> None:
    frames = Frames({"robots/r2": other}.__getitem__, lambda: base)
    rows = ((1.0, 0.5, 0.0), (0.5, 2.0, 0.0), (0.0, 0.0, 3.0))
    sensor = Feeler(
        rtkit.Marker(seen, covariance=rows, type="ball"), location=mount, frames=frames
    )  # fmt: skip
    for frame in ("base", "world", "robots/r2"):
        (found,) = sensor.get_markers(frame)
        own = transform(inverse(sensor.get_location(frame)), found.location or ())
        assert own == pytest.approx(seen, abs=1e-6)
        assert found.frame == ("" if frame == "base" else frame)
        covariance = found.covariance or ()
        assert sum(covariance[each][each] for each in range(3)) == pytest.approx(6.0)
    in_world = compose(base, mount)
    assert sensor.get_location("world")[:3] == pytest.approx(in_world[:3], abs=1e-6)


@pytest.mark.parametrize("frame", ["kitchen", "world"])
def test_a_frame_that_is_not_there_is_a_bad_parameter(frame: str) -> None:
    sensor = Feeler(rtkit.Marker((1.0, 2.0)), frames=Frames())
    for ask in (sensor.get_location, sensor.get_markers):
        with pytest.raises(rtkit.PropertyError, match="no frame") as refused:
            ask(frame)
        assert refused.value.code == "bad-parameter"


def test_a_sensor_that_sees_no_things_is_a_marker_with_its_reading() -> None:
    sensor = Sensor((1, 2, 0, 0, 0, 0))
    sensor.data = 3.5  # type: ignore[attr-defined]
    (marker,) = sensor.get_markers()
    assert (marker.location, marker.type) == ((1.0, 2.0, 0.0, 0.0, 0.0, 0.0), "sensor")
    assert marker.features == {"data": 3.5}


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_place_that_is_no_number_is_refused_and_the_old_one_kept(number: float) -> None:
    sensor, place = Sensor((1, 2, 0, 0, 0, 0)), (number, 0.0, 0.0, 0.0, 0.0, 0.0)
    camera = CameraView(PictureStore(lambda source: b"", "", 1.0), 1.2)
    with pytest.raises(rtkit.PropertyError, match="finite"):
        sensor.set_location(place)
    with pytest.raises(rtkit.PropertyError, match="finite"):
        camera.location = place
    assert (sensor.get_location(), camera.location) == ((1, 2, 0, 0, 0, 0), (0,) * 6)
    with pytest.raises(ValueError, match="6 numbers"):
        Sensor(place)


# input devices


def report(*events: tuple[int, int, int]) -> bytes:
    return b"".join(EVENT.pack(0, 0, *each) for each in (*events, (0, 0, 0)))


def test_a_joystick_tells_deflections_and_buttons_and_goes_to_rest() -> None:
    stick = Joystick("/nowhere", limits=(0, 255), dead=0.05)
    stick._take(report((3, 0, 255), (3, 1, 128), (3, 9, 51), (3, 17, -1), (1, 0x130, 1)))
    assert stick.axes == {"x": 1.0, "y": 0.0, "gas": 0.2, "hat_y": -1.0}
    assert stick.buttons == {"south": True}
    assert stick.data == [("x", 255), ("y", 128), ("gas", 51), ("hat_y", -1), ("south", 1)]
    stick._changed("waiting: unplugged")
    assert set(stick.axes.values()) == {0.0}
    assert stick.buttons == {"south": False}
    assert stick.data == []
    assert stick.status == "waiting: unplugged"


@pytest.mark.parametrize(
    ("low", "high", "flat", "at", "deflection"),
    [
        (-32768, 32767, 0, -32768, -1.0), (-32768, 32767, 0, 32767, 1.0),
        (0, 255, 15, 142, 0.0), (0, 255, 15, 143, 0.1216), (0, 255, 15, 113, 0.0),
        (-100, 300, 0, 100, 0.0), (-100, 300, 0, 0, -0.5), (-100, 300, 0, 900, 1.0),
    ],
)  # fmt: skip
def test_an_axis_is_scaled_as_its_device_tells(
    monkeypatch: pytest.MonkeyPatch, low: int, high: int, flat: int, at: int, deflection: float
) -> None:
    def told(descriptor: int, request: int, info: bytes) -> bytes:
        if request & 0x3F:
            raise OSError(22, "no such axis")
        return struct.pack("@6i", 7, low, high, 3, flat, 12)

    monkeypatch.setattr("fcntl.ioctl", told)
    stick = Joystick("/nowhere")
    stick._opened(0)
    stick._take(report((3, 0, at)))
    assert stick.axes == {"x": deflection}


def test_a_mouse_moves_within_its_plane() -> None:
    mouse = Pointer("/nowhere", limits=(0, 100), size=(2.0, 1.0))
    mouse._take(report((2, 0, 25), (2, 1, -50), (2, 8, -2)))
    assert (mouse.data, mouse.wheel) == ([(0.75, 1.0)], -2)
    assert mouse.get_markers()[0].location == (0.0, -1.5, 1.0)
    mouse._take(report((2, 0, 900), (1, 0x110, 1)))
    assert (mouse.data, mouse.buttons) == ([(1.0, 1.0)], {"left": True})


def test_fingers_on_a_pad_come_and_go() -> None:
    pad = Pointer("/nowhere", limits=(0, 100))
    down = [(3, 57, 5), (3, 53, 10), (3, 54, 20), (3, 47, 1), (3, 57, 6), (3, 53, 50), (3, 54, 50)]
    pad._take(report(*down, (1, 0x14A, 1)))
    assert pad.data == [(0.1, 0.8), (0.5, 0.5)]
    assert [each.id for each in pad.get_markers()] == ["0", "1"]
    pad._take(report((3, 47, 0), (3, 57, -1)))
    assert pad.data == [(0.5, 0.5)]
    single = Pointer("/nowhere", limits=(0, 100))
    single._take(report((3, 0, 10), (3, 1, 90), (1, 0x14A, 1)))
    assert single.data == [(0.1, 0.1)]
    single._take(report((1, 0x14A, 0)))
    assert single.data == []


# GPS


def sentence(text: str) -> bytes:
    total = 0
    for each in text.encode():
        total ^= each
    return f"${text}*{total:02X}\r\n".encode()


GGA = "GPGGA,123519,6503.6000,N,02528.0000,E,1,08,0.9,15.4,M,46.9,M,,"
RMC = "GPRMC,123519,A,6503.6000,N,02528.0000,E,010.0,090.0,230394,003.1,W"


def test_a_fix_is_read_in_pieces_and_a_line_without_its_beginning_is_refused() -> None:
    data = sentence(GGA)[20:] + sentence(GGA) + sentence(RMC)
    for size in (1, 7, 500):
        gps = Gps("/nowhere")
        for at in range(0, len(data), size):
            gps._take(data[at : at + size])
        assert gps.position == pytest.approx((65.06, 25 + 28 / 60, 15.4))
        assert (gps.status, gps.fix, gps.satellites, gps.hdop) == ("ready", "gps", 8, 0.9)
        assert gps.velocity == pytest.approx((5.144444, 0.0), abs=1e-6)
        assert gps.refused == 1
        assert gps.data.startswith("$GPRMC")
        (marker,) = gps.get_markers()
        assert (marker.location, marker.variance) == (pytest.approx((0, 0, 0)), 25.0)


@pytest.mark.parametrize(
    "bad",
    [
        sentence(GGA)[:-4] + b"00\r\n", sentence(GGA).split(b"*")[0] + b"\r\n",
        b"\xff\x00 rubbish\n", b"x" * 5000,
        sentence("GPGGA,123519,north,N,02528.0,E,1,08,0.9,high,M,46.9,M,,"),
        sentence(GGA.replace("6503", "9903")), sentence(GGA.replace(",N,", ",,")),
        sentence(GGA.replace(",E,", ",e,")), sentence("GPXYZ,1,2"), b"$\n", b"$PGRM*11\n",
    ],
)  # fmt: skip
def test_a_wrong_line_is_refused_and_the_fix_stays(bad: bytes) -> None:
    gps = Gps("/nowhere")
    gps._take(sentence(GGA))
    before = gps.position
    gps._take(bad)
    assert (gps.position, gps.refused, gps.status) == (before, 1, "ready")
    gps._take(b"\n" + sentence(GGA.replace("6503", "6504")))
    assert gps.position[0] == pytest.approx(65.0766666)


@pytest.mark.parametrize(
    "lost",
    [GGA.replace(",E,1,", ",E,0,"), "GPGGA,123519,,,,,0,00,,,M,,M,,", RMC.replace(",A,", ",V,")],
)
def test_no_fix_is_reported_and_leaves_no_position(lost: str) -> None:
    gps = Gps("/nowhere", origin=(65.0, 25.0, 0.0))
    gps._take(sentence(GGA) + sentence(RMC) + sentence(lost))
    assert (gps.status, gps.fix, gps.position) == ("no fix", "none", ())
    assert gps.velocity == (0.0, 0.0)
    assert gps.get_markers() == []
    gps._take(sentence(GGA.replace(",E,1,", ",E,4,")))
    assert (gps.status, gps.fix) == ("ready", "rtk")
    gps._changed("waiting: unplugged")
    assert (gps.status, gps.fix, gps.position) == ("waiting: unplugged", "none", ())


def test_talkers_of_all_constellations_are_read_and_sentences_of_makers_are_no_fault() -> None:
    gps = Gps("/nowhere")
    for talker, latitude in (("GP", 48.0), ("GL", 48.1), ("GN", -48.2), ("GA", 48.3), ("BD", 48.4)):
        degrees, minutes = divmod(abs(latitude) * 60, 60)
        place = f"{degrees:02.0f}{minutes:07.4f},{'N' if latitude > 0 else 'S'}"
        gps._take(sentence(f"{talker}GGA,123519,{place},01130.0000,W,1,14,0.6,15.4,M,46.9,M,,"))
        assert gps.position[:2] == pytest.approx((latitude, -11.5))
    for other in ("GLGSV,1,1,02,65,40,083,46,66,17,308,41", "PUBX,00,1", "PMTK010,001"):
        gps._take(sentence(other))
    assert (gps.status, gps.satellites, gps.refused) == ("ready", 14, 0)


def test_a_degree_is_as_long_as_on_the_ellipsoid() -> None:
    x, y, z = local((61.0, 180.5, 10.0), (60.0, -179.5, 0.0))
    assert x == pytest.approx(-0.0 + 55_800, rel=1e-3) or x == pytest.approx(-0.0)
    x, y, z = local((60.5, 25.5, 10.0), (60.0, 25.0, 0.0))
    assert (x, y, z) == (
        pytest.approx(55_800 / 2, rel=1e-3),
        pytest.approx(111_412 / 2, rel=1e-3),
        10,
    )


@pytest.mark.parametrize(
    ("wrong", "why"),
    [({"limits": 5}, "limits is 2 numbers"), ({"limits": (5, 1)}, "least and the greatest"),
     ({"location": (1, 2)}, "location is 6 numbers"), ({"location": "x"}, "location is 6 numbers")],
)  # fmt: skip
def test_wrong_settings_are_refused_at_once(wrong: dict[str, Any], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        Joystick("/nowhere", **wrong)
    assert Joystick(5).device == "5"  # type: ignore[arg-type]  as a shell may give it


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        (Camera, {"rate": math.inf}), (Camera, {"field": -1}), (Camera, {"silence": math.nan}),
        (Vision, {"rate": 0}), (Vision, {"field": math.nan}), (Environment, {"most": 0}),
        (Environment, {"maxage": math.nan}), (Environment, {"side": math.inf}),
        (Environment, {"gate": 0}), (Environment, {"drift": -1}),
    ],
)  # fmt: skip
def test_a_setting_out_of_its_bounds_is_refused_by_its_name(kind: Any, given: Any) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(given))} is"):
        kind(**given)


@pytest.mark.parametrize("wrong", [-1.0, math.nan])
def test_settings_of_devices_are_within_bounds(wrong: float) -> None:
    for kind, name in ((Gps, "accuracy"), (Joystick, "dead"), (Microphone, "block")):
        with pytest.raises(ValueError, match=f"{name} is"):
            kind("/nowhere", **{name: wrong})


def test_an_origin_has_three_numbers() -> None:
    with pytest.raises(ValueError, match="origin is 0 or 3 numbers in brackets, not"):
        Gps("/nowhere", origin=(1.0, 2.0))


def test_rubbish_costs_bounded_memory() -> None:
    reader = NmeaReader()
    for _ in range(100):
        reader.feed(b"y" * 1000)
    assert len(reader._rest) <= 256
    assert reader.refused == 100


@pytest.mark.parametrize("base", [DeviceSensor, _InputSensor])
def test_a_base_that_reads_nothing_cannot_be_made(base: Any) -> None:
    with pytest.raises(TypeError, match="abstract method"):
        base("/dev/none")
