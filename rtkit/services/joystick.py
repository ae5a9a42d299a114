"""Joystick and pointer (mouse, touch pad), sensors behind an input device of Linux.

``rtserve rtkit.services.joystick:Joystick stick -a /dev/input/event5``. The user must be allowed to
read the device: the group ``input`` is, on most systems.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Final

import rtkit
from rtkit import init_of
from rtkit.services.frames import Frames
from rtkit.services.input_events import ABS, KEY, REL, InputEvent, InputReader, axis_range
from rtkit.services.sensor import MIDDLE, DeviceSensor, Pose6, numbers, within

_TRIGGERS = frozenset({"gas", "brake", "throttle", "pressure"})
_SLOT, _SLOT_X, _SLOT_Y, _SLOT_ID = 47, 53, 54, 57


class _InputSensor(DeviceSensor):
    """Base of sensors behind an input device."""

    def __init__(
        self,
        device: str,
        limits: tuple[float, float],
        location: Pose6,
        base: str,
        frames: Frames | None,
    ) -> None:
        super().__init__(device, 0, location, base, frames)
        self._limits = numbers("limits", limits, 2)
        if self._limits[0] >= self._limits[1]:
            raise ValueError(f"limits are the least and the greatest value, not {limits}")
        self._ranges: dict[int, tuple[float, ...]] = {}
        self._reader_of_events = InputReader()

    def _opened(self, descriptor: int) -> None:
        self._reader_of_events = InputReader()
        found = {code: axis_range(descriptor, code) for code in range(0x40)}
        self._ranges = {code: each for code, each in found.items() if each is not None}

    def _take(self, data: bytes) -> None:
        for report in self._reader_of_events.feed(data):
            self._report(report)

    @abstractmethod
    def _report(self, events: list[InputEvent]) -> None:
        """Take events that belong together."""

    def _fraction(self, code: int, value: float) -> float:
        """Return where a value is between the limits of its axis: 0 to 1."""
        low, high = self._ranges.get(code, self._limits)[:2]
        return min(1.0, max(0.0, (value - low) / (high - low)))


class Joystick(_InputSensor):
    """Joystick or gamepad. When it is unplugged, its axes go to 0 and its buttons are released.

    Args:
        device: ``/dev/input/eventN``.
        limits: Least and greatest value of axes of a device that does not tell them.
        dead: Deflection up to which an axis is at rest, 0 to 1; the device may tell more.
        location, base, frames: See `Sensor`.

    Attributes:
        data: Names and raw values of all axes and buttons that have been moved.
        axes: Deflections by name: -1 to 1, of pedals and triggers 0 to 1.
        buttons: Buttons that are down, by name.
    """

    type: Final[tuple[str, ...]] = ("joystick", "sensor")  # type: ignore[misc]
    range: Final[tuple[float, ...]] = (-1.0, 1.0)  # type: ignore[misc]
    data: Final[list[tuple[str, int]]] = []

    def __init__(
        self,
        device: str,
        limits: tuple[float, float] = (-32768, 32767),
        dead: float = 0.02,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
    ) -> None:
        super().__init__(device, limits, location, base, frames)
        self.dead: Annotated[float, rtkit.Range(0, 1)] = within("dead", dead, 0, 1)
        self.axes: Final[dict[str, float]] = {}
        self.buttons: Final[dict[str, bool]] = {}
        self._raw: dict[str, int] = {}

    def _report(self, events: list[InputEvent]) -> None:
        axes, buttons = dict(self.axes), dict(self.buttons)
        for each in events:
            if each.kind == ABS:
                axes[each.name] = self._deflection(each)
            elif each.kind == KEY:
                buttons[each.name] = each.value != 0
            else:
                continue
            self._raw[each.name] = each.value
        self._put(axes, buttons)

    def _deflection(self, event: InputEvent) -> float:
        limits = (-1.0, 1.0) if event.name.startswith("hat_") else self._limits
        self._ranges.setdefault(event.code, limits)
        fraction = self._fraction(event.code, event.value)
        found = fraction if event.name in _TRIGGERS else 2 * fraction - 1
        low, high, *flat = self._ranges[event.code]
        rest = max(self.dead, 2 * sum(flat) / (high - low))
        return 0.0 if abs(found) <= rest else round(found, 4)

    def _rest(self) -> None:
        self._raw = {}
        self._put(dict.fromkeys(self.axes, 0.0), dict.fromkeys(self.buttons, False))

    def _put(self, axes: dict[str, float], buttons: dict[str, bool]) -> None:
        setattr(self, "axes", axes)  # noqa: B010  it is final for all others
        setattr(self, "buttons", buttons)  # noqa: B010
        self._publish("data", list(self._raw.items()))


class Pointer(_InputSensor):
    """Mouse, touch pad or touch screen, as a plane whose lower left corner is at the sensor.

    Args:
        device: ``/dev/input/eventN``.
        limits: Least and greatest value of axes of a device that does not tell them; a mouse counts
            its ways within them.
        size: Width and height of the plane [m].
        location, base, frames: See `Sensor`.

    Attributes:
        data: Where each finger, or the mouse, is: parts of width and height from the lower left.
        wheel: Steps that the wheel was turned, away from the user.
        buttons: Buttons that are down, by name.
    """

    type: Final[tuple[str, ...]] = ("pointer", "sensor")  # type: ignore[misc]
    range: Final[tuple[float, ...]] = (0.0, 1.0)  # type: ignore[misc]
    data: Final[list[tuple[float, float]]] = []
    wheel: Final[int] = 0

    def __init__(
        self,
        device: str,
        limits: tuple[float, float] = (0, 1023),
        size: tuple[float, float] = (1.0, 1.0),
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
    ) -> None:
        super().__init__(device, limits, location, base, frames)
        self.size: Final[tuple[float, ...]] = numbers("size", size, 2)
        self.buttons: Final[dict[str, bool]] = {}
        middle = sum(self._limits) / 2
        self._mouse = [middle, middle]
        self._slots: dict[int, list[float]] = {}
        self._slot = 0
        self._has_slots = self._is_pad = False

    def _report(self, events: list[InputEvent]) -> None:
        buttons, wheel = dict(self.buttons), self.wheel
        for each in events:
            if each.kind == KEY:
                buttons[each.name] = each.value != 0
            elif each.kind == REL and each.name == "wheel":
                wheel += each.value
            elif each.kind == REL and each.code < 2:
                low, high = self._limits
                self._mouse[each.code] = min(high, max(low, self._mouse[each.code] + each.value))
            elif each.kind == ABS:
                self._touch(each)
        setattr(self, "buttons", buttons)  # noqa: B010  it is final for all others
        self._publish("wheel", wheel)
        self._publish("data", self._places())

    def _touch(self, event: InputEvent) -> None:
        """Take an event of a pad: of one finger, or of that in a slot."""
        self._is_pad = True
        if event.code == _SLOT:
            self._slot = event.value
        elif event.code == _SLOT_ID:
            self._has_slots = True
            if event.value < 0:
                self._slots.pop(self._slot, None)
            else:
                self._slots[self._slot] = [0.0, 0.0]
        elif event.code in (_SLOT_X, _SLOT_Y) and self._slot in self._slots:
            self._slots[self._slot][event.code - _SLOT_X] = self._fraction(event.code, event.value)
        elif event.code < 2:
            self._mouse[event.code] = event.value

    def _places(self) -> list[tuple[float, float]]:
        if self._has_slots:
            places = [tuple(each) for _, each in sorted(self._slots.items())]
        elif self._is_pad and not self.buttons.get("touch", True):
            places = []
        else:
            places = [tuple(self._fraction(axis, at) for axis, at in enumerate(self._mouse))]
        return [(round(x, 4), round(1 - y, 4)) for x, y in places]

    def _rest(self) -> None:
        self._slots, self._slot = {}, 0
        setattr(self, "buttons", dict.fromkeys(self.buttons, False))  # noqa: B010
        self._publish("data", [])

    def _found(self) -> list[rtkit.Marker]:
        """See `Sensor`: a marker for each finger, or for the mouse."""
        width, height = self.size
        places = [(0.0, -x * width, y * height) for x, y in self.data]
        return [rtkit.Marker(each, type="touch", id=str(at)) for at, each in enumerate(places)]


JoystickInit = init_of(Joystick)
PointerInit = init_of(Pointer)
