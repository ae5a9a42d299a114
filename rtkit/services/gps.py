"""GPS, a sensor behind a device that sends NMEA 0183: a serial line, a pipe or a recorded file.

``rtserve rtkit.services.gps:Gps gps -a /dev/ttyUSB0 -a baud=4800``. Sentences are read by pynmea2,
``pip install 'rtkit[gps]'``.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, NamedTuple

import rtkit
from rtkit import init_of
from rtkit.errors import Refused
from rtkit.extras import how_to_get
from rtkit.services.frames import ORIGIN, Frames, plain, transform
from rtkit.services.sensor import MIDDLE, DeviceSensor, Pose6, numbers, within

_LONGEST = 256
_EARTH_M = 6_378_137.0
_FLATTENING = 1 / 298.257223563
_FIXES = ("none", "gps", "dgps", "pps", "rtk", "float", "estimated", "manual", "simulated")


class Sentence(NamedTuple):
    """Sentence whose check sum is right.

    Attributes:
        text: As it came.
        kind: ``GGA``, ``RMC`` …
        fields: As pynmea2 reads it.
    """

    text: str
    kind: str
    fields: Any


class NmeaReader:
    """Reads sentences from pieces of any length.

    Attributes:
        refused: How many lines were no sentence, or had no check sum or a wrong one.
    """

    def __init__(self, refused: int = 0) -> None:
        try:
            import pynmea2
        except ImportError as error:
            raise Refused(f"GPS needs pynmea2: {how_to_get('gps')}") from error
        self._library = pynmea2
        self._rest = b""
        self.refused = refused

    def feed(self, data: bytes) -> list[Sentence]:
        """Return the sentences that are whole now; a first line may lack its beginning."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > _LONGEST:
            self._rest = b""
            self.refused += 1
        return [each for each in map(self._sentence, lines) if each is not None]

    def _sentence(self, line: bytes) -> Sentence | None:
        text = line.decode("ascii", "replace").strip()
        if not text:
            return None
        try:
            fields = self._library.parse(text, check=True)
            return Sentence(text, str(fields.sentence_type), fields)
        except self._library.ParseError:
            self.refused += 1
        except AttributeError:
            pass  # a maker's own sentence: it is whole, but of no such type
        return None


def local(
    position: tuple[float, float, float], origin: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return a place as metres east, north and above an origin, some kilometres around it.

    Args:
        position: Latitude and longitude [degrees north, east] and altitude [m].
        origin: Likewise.
    """
    latitude = math.radians(origin[0])
    squared = _FLATTENING * (2 - _FLATTENING)
    curve = 1 - squared * math.sin(latitude) ** 2
    meridian = _EARTH_M * (1 - squared) / curve**1.5 + origin[2]
    parallel = (_EARTH_M / math.sqrt(curve) + origin[2]) * math.cos(latitude)
    east = math.radians(math.remainder(position[1] - origin[1], 360))
    return (
        parallel * east,
        meridian * math.radians(position[0] - origin[0]),
        position[2] - origin[2],
    )


class Gps(DeviceSensor):
    """Receiver of satellite navigation. Sentences with a wrong check sum are refused and counted.

    Args:
        device: Path of a serial line, a pipe or a recorded file.
        origin: Latitude, longitude and altitude of the world's origin [degrees, degrees, m]; the
            first fix where it is empty.
        accuracy: Standard deviation at a dilution of precision of 1 [m].
        baud, location, base, frames: See `DeviceSensor`.
        silence: How long no whole sentence may come before `status` calls it silent, and there is
            no position any more [s]; 0: for ever.

    Attributes:
        status: ``ready``, ``no fix``, ``silent since TIME``, or ``waiting: why``.
        data: The last sentence.
        position: Latitude, longitude, altitude [degrees, degrees, m]; empty without a fix.
        fix: ``none``, ``gps``, ``dgps``, ``rtk`` …
        satellites: How many are used.
        hdop: Horizontal dilution of precision.
        velocity: Over ground, to the east and to the north [m/s].
        time: Of the last fix, UTC.
        refused: How many lines were no sentence, or had no check sum or a wrong one.
    """

    type: Final[tuple[str, ...]] = ("gps", "sensor")  # type: ignore[misc]
    unit: Final[str] = "deg"  # type: ignore[misc]
    data: Final[str] = ""
    position: Final[tuple[float, ...]] = ()
    fix: Final[str] = "none"
    satellites: Final[int] = 0
    hdop: Final[float] = 0.0
    velocity: Final[Annotated[tuple[float, float], rtkit.Unit("m/s")]] = (0.0, 0.0)
    time: Final[str] = ""
    refused: Final[int] = 0

    def __init__(
        self,
        device: str,
        origin: tuple[float, ...] = (),
        accuracy: Annotated[float, rtkit.Unit("m")] = 5.0,
        baud: int = 0,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
        silence: Annotated[float, rtkit.Unit("s")] = 5.0,
    ) -> None:
        super().__init__(device, baud, location, base, frames, silence)
        self.origin: tuple[float, ...] = numbers("origin", origin, 0, 3)
        self.accuracy = within("accuracy", accuracy, 0)
        self._nmea = NmeaReader()

    def _opened(self, descriptor: int) -> None:
        self._nmea = NmeaReader(self.refused)

    def _take(self, data: bytes) -> bool:
        sentences = self._nmea.feed(data)
        for sentence in sentences:
            try:
                self._read(sentence)
            except (ValueError, TypeError, AttributeError):
                self._nmea.refused += 1  # its check sum is right, its numbers are none
        if self._nmea.refused != self.refused:
            self._publish("refused", self._nmea.refused)
        return bool(sentences)

    def _read(self, sentence: Sentence) -> None:
        fields = sentence.fields
        if sentence.kind == "GGA":
            quality = int(fields.gps_qual or 0)
            is_fixed = quality > 0 and bool(fields.lat and fields.lon)
            position = (fields.latitude, fields.longitude, float(fields.altitude or 0))
            is_on_earth = abs(position[0]) <= 90 and abs(position[1]) <= 180
            is_whole = fields.lat_dir in ("N", "S") and fields.lon_dir in ("E", "W")
            if is_fixed and not (is_on_earth and is_whole):
                raise ValueError("no place on the earth")
            self._fixed(*((position, _FIXES[min(quality, 8)]) if is_fixed else ((), "none")))
            self._publish("satellites", int(fields.num_sats or 0))
            self._publish("hdop", float(fields.horizontal_dil or 0))
            self._publish("time", str(fields.timestamp or ""))
        elif sentence.kind == "RMC" and fields.status == "A":
            speed, course = float(fields.spd_over_grnd or 0), float(fields.true_course or 0)
            east, north = math.sin(math.radians(course)), math.cos(math.radians(course))
            knot = 1852 / 3600
            self._publish("velocity", plain((speed * knot * east, speed * knot * north)))
        elif sentence.kind == "RMC":
            self._fixed((), "none")
        self._publish("data", sentence.text)

    def _fixed(self, position: tuple[float, ...], fix: str) -> None:
        if position and not self.origin:
            self.origin = position
        self._publish("position", position)
        self._publish("fix", fix)
        self._publish("status", "ready" if position else "no fix")
        if not position:
            self._publish("velocity", (0.0, 0.0))

    def _changed(self, state: str) -> None:
        super()._changed("no fix" if state == "ready" and not self.position else state)

    def _rest(self) -> None:
        self._publish("position", ())
        self._publish("fix", "none")
        self._publish("velocity", (0.0, 0.0))

    def get_markers(self, frame: str = "world") -> list[rtkit.Marker]:
        """The place of the receiver [m], x to the east and y to the north of the origin."""
        pose = ORIGIN if frame == "world" else self._frames.between("world", frame)
        if len(self.position) < 3 or len(self.origin) < 3:
            return []
        x, y, z = self.position
        place = local((x, y, z), (self.origin[0], self.origin[1], self.origin[2]))
        found = rtkit.Marker(
            plain(transform(pose, place)), type="gps", frame="" if frame == "base" else frame,
            variance=(self.accuracy * max(self.hdop, 1.0)) ** 2, fix=self.fix,
        )  # fmt: skip
        return [found]


GpsInit = init_of(Gps)
