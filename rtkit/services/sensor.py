"""Sensor, a standard service: where it is, what it reads, and its readings as markers.

A sensor's own frame has x ahead, y to the left and z up; its `location` is the pose of that frame
in the base that carries it. Other frames are those of `rtkit.services.frames`.
"""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from functools import partial
from typing import Annotated, Any, Final, Self

import rtkit
from rtkit import init_of
from rtkit.services.asking import Asking
from rtkit.services.device import LOOK_S, Device
from rtkit.services.frames import (
    ORIGIN,
    Frames,
    Pose,
    is_number,
    plain,
    pose_of,
    transform,
    transform_covariance,
)

Pose6 = tuple[float, float, float, float, float, float]
MIDDLE: Pose6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Sensor(Asking):
    """Base of all sensors.

    Args:
        location: Pose in the base that carries it [m, rad].
        base: Service whose `location` is that of the base in the world, ``robots/r1``; without one
            only the base itself is a frame.
        frames: The frames of who has them at hand, in place of `base`.

    Attributes:
        status: ``ready``, ``waiting: why`` while a device or another service is away, or ``silent
            since TIME`` of one that is there and should send, but does not.
        unit: Of the numbers in `data`.
        rate: Readings in a second, 0 where they come when something happens [Hz].
        range: Least and greatest value of a reading.
    """

    type: Final[tuple[str, ...]] = ("sensor",)
    version: Final = "1.0"
    # A Final property cannot be SET from outside; a sensor itself changes it by `_publish`.
    status: Final[str] = "ready"
    unit: Final[str] = ""
    rate: Final[Annotated[float, rtkit.Unit("Hz")]] = 0.0
    range: Final[tuple[float, ...]] = ()

    def __init__(
        self, location: Pose6 = MIDDLE, base: str = "", frames: Frames | None = None
    ) -> None:
        super().__init__()
        self._location: Pose = numbers("location", location, 6)
        self._base = base
        self._frames = frames or Frames(self._pose_of, self._base_pose)
        self._publish: Callable[[str, object], None] = partial(setattr, self)
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def __served__(self, publish: Callable[[str, object], None]) -> None:
        self._publish = publish

    def __exit__(self, *raised: object) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        super().__exit__(*raised)

    def _work(self, run: Callable[[], None]) -> None:
        """Have a thread read something; it is to return soon after `_ended` is set."""
        self._ended.clear()
        self._thread = threading.Thread(target=run, name=f"{self.type[0]} reading")
        self._thread.start()

    def get_location(self, frame: str = "base") -> Annotated[Pose6, rtkit.Concurrent()]:
        """Pose of the sensor [m, rad]; in its base, or in another frame."""
        return self._frames.convert(self._location, "base", frame)  # type: ignore[return-value]

    def set_location(self, pose: Pose6) -> None:
        """Put the sensor elsewhere in its base [m, rad]."""
        self._location = pose_of(pose)

    def get_markers(self, frame: str = "base") -> list[rtkit.Marker]:
        """All that the sensor sees now, as markers in a frame."""
        pose = self.get_location(frame)
        name = "" if frame == "base" else frame
        return [moved(each, pose, name) for each in self._found()]

    def _found(self) -> Iterable[rtkit.Marker]:
        """Return what is seen, in the frame of the sensor: itself with its reading, by default."""
        return [rtkit.Marker(ORIGIN, type=self.type[0], data=self.data)]  # type: ignore[attr-defined]

    def _base_pose(self) -> Pose:
        if not self._base:
            raise rtkit.PropertyError("bad-parameter", "no frame but base: no `base` is configured")
        return self._pose_of(self._base)


def moved(marker: rtkit.Marker, pose: Pose, frame: str) -> rtkit.Marker:
    """Return a marker of the frame that has a pose in another one, as a marker of that one."""
    changes: dict[str, Any] = {"frame": frame}
    if marker.location is not None:
        changes["location"] = plain(transform(pose, marker.location))
        if marker.covariance is not None:
            changes["covariance"] = transform_covariance(pose, marker.location, marker.covariance)
    return marker.with_(**changes)


def numbers(name: str, given: object, *counts: int) -> tuple[float, ...]:
    """Return a setting that is so many finite numbers.

    Raises:
        ValueError: It is not.
    """
    found = tuple(given) if isinstance(given, list | tuple) else ()
    if len(found) in counts and all(is_number(each) and math.isfinite(each) for each in found):
        return tuple(map(float, found))
    raise ValueError(f"{name} is {' or '.join(map(str, counts))} numbers in brackets, not {given}")


def within(name: str, given: float, low: float, high: float = 1e9) -> float:
    """Return a setting that is a number within bounds.

    Raises:
        ValueError: It is not.
    """
    if not low <= given <= high:
        raise ValueError(f"{name} is {low:g} to {high:g}, not {given}")
    return given


class DeviceSensor(Sensor, ABC):
    """Base of sensors behind a device file, which comes and goes.

    Args:
        device: Path of the device; a pipe or an ordinary file will do.
        baud: Speed of a serial line [baud]; 0 leaves it as it is.
        location, base, frames: See `Sensor`.
        silence: How long it may send nothing before `status` calls it silent [s]; 0: for ever.
    """

    def __init__(
        self,
        device: str,
        baud: int = 0,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
        silence: float = 0.0,
    ) -> None:
        super().__init__(location, base, frames)
        self._silence_s = within("silence", silence, 0)
        self.device: Final[str] = str(device)
        self._publish("status", f"waiting: {device}: not opened")
        self._baud = baud
        self._reader: Device | None = None

    def __enter__(self) -> Self:
        self._reader = Device(
            self.device, self._take, self._changed, self._baud, self._opened, self._silence_s
        )
        return self

    def __exit__(self, *raised: object) -> None:
        if self._reader is not None:
            self._reader.close()
            self._reader = None
        super().__exit__(*raised)

    def _changed(self, state: str) -> None:
        if state.startswith(("waiting", "silent")):
            self._rest()
        self._publish("status", state)

    def _opened(self, descriptor: int) -> None:
        """Look at the device that was opened."""

    @abstractmethod
    def _take(self, data: bytes) -> bool | None:
        """Take what came; ValueError: it makes no sense; False: it is nothing worth the name."""

    def _rest(self) -> None:
        """Put what is read to rest: the device has gone or is silent, nobody holds it any more."""


class PropertySensor(Sensor):
    """Sensor whose reading is a property of any service: a widget of a user interface, say.

    Args:
        source: The property, ``panel.speed``; waited for, and found again after it was away.
        location, base, frames: See `Sensor`.

    Attributes:
        data: Its value; the last one while its service is away, which `status` tells.
    """

    data: Final[Any] = ()

    def __init__(
        self,
        source: str,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
    ) -> None:
        super().__init__(location, base, frames)
        self.source: Final[str] = source
        self._publish("status", f"waiting: {source}: not asked yet")

    def __enter__(self) -> Self:
        self._work(self._begin)
        return self

    def _begin(self) -> None:
        """Ask until somebody answers; from then on the client keeps track of the property."""
        while not self._ended.is_set():
            try:
                self._asked().listen(self.source, self._take)
                return
            except rtkit.PropertyError as error:
                self._publish("status", f"waiting: {self.source}: {error.code}")
            self._ended.wait(LOOK_S)

    def _take(self, change: Any) -> None:
        if not change.code:
            self._publish("data", change.value)
        self._publish(
            "status", f"waiting: {self.source}: {change.code}" if change.code else "ready"
        )


PropertySensorInit = init_of(PropertySensor)
