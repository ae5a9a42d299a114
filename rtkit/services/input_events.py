"""Input events of Linux, as ``/dev/input/eventN`` sends them: reports, names, ranges.

A record is a ``struct input_event``: time (two longs), type, code, value. Records up to one of type
0 and code 0 (``SYN_REPORT``) belong together. See ``Documentation/input`` of the kernel.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

EVENT = struct.Struct("@llHHi")
SYN, KEY, REL, ABS = range(4)
_DROPPED = 3
_MOST_TYPE, _MOST_CODE = 0x1F, 0x2FF
_LONGEST_REPORT = 1024
_NAMES = {
    REL: {0: "x", 1: "y", 6: "hwheel", 8: "wheel"},
    ABS: {
        0: "x", 1: "y", 2: "z", 3: "rx", 4: "ry", 5: "rz", 6: "throttle", 7: "rudder", 8: "wheel",
        9: "gas", 10: "brake", 16: "hat_x", 17: "hat_y", 24: "pressure",
    },
    KEY: {
        0x110: "left", 0x111: "right", 0x112: "middle", 0x120: "trigger", 0x121: "thumb",
        0x130: "south", 0x131: "east", 0x133: "north", 0x134: "west", 0x136: "tl", 0x137: "tr",
        0x138: "tl2", 0x139: "tr2", 0x13A: "select", 0x13B: "start", 0x13C: "mode",
        0x13D: "thumb_l", 0x13E: "thumb_r", 0x14A: "touch", 0x220: "up", 0x221: "down",
    },
}  # fmt: skip
_OTHER = {KEY: "button", REL: "rel", ABS: "abs"}


class InputEvent(NamedTuple):
    """Event of an input device.

    Attributes:
        kind: `KEY`, `REL`, `ABS` or another type of the kernel.
        code: Key or axis.
        value: 1 for down and 0 for up of a key, a way of REL, a place of ABS.
    """

    kind: int
    code: int
    value: int

    @property
    def name(self) -> str:
        """Its name: that of the kernel in short, ``button_720`` where there is none."""
        known = _NAMES.get(self.kind, {}).get(self.code)
        return known or f"{_OTHER.get(self.kind, 'event')}_{self.code}"


class InputReader:
    """Reads reports from what an input device sends, in pieces of any length.

    Attributes:
        lost: How many times the kernel has told that events were lost.
    """

    def __init__(self) -> None:
        self._rest = b""
        self._report: list[InputEvent] = []
        self._is_skipping = False
        self.lost = 0

    def feed(self, data: bytes) -> list[list[InputEvent]]:
        """Return the reports that are whole now.

        Events behind a loss, up to the end of that report, say nothing and are left out.

        Raises:
            ValueError: These are no input events.
        """
        data = self._rest + data
        size = len(data) - len(data) % EVENT.size
        self._rest = data[size:]
        reports = []
        for _, _, kind, code, value in EVENT.iter_unpack(data[:size]):
            if kind > _MOST_TYPE or code > _MOST_CODE or len(self._report) > _LONGEST_REPORT:
                raise ValueError("these are no input events")
            if kind != SYN:
                self._report.append(InputEvent(kind, code, value))
            elif code == _DROPPED:
                self.lost += 1
                self._is_skipping = True
            elif code == 0:
                if self._report and not self._is_skipping:
                    reports.append(self._report)
                self._report, self._is_skipping = [], False
        return reports


def axis_range(descriptor: int, code: int) -> tuple[int, int, int] | None:
    """Return least and greatest value and flatness of an axis, None where a device cannot tell."""
    from fcntl import ioctl

    info = struct.Struct("@6i")
    request = 2 << 30 | info.size << 16 | ord("E") << 8 | 0x40 + code  # EVIOCGABS
    try:
        _, low, high, _, flat, _ = info.unpack(ioctl(descriptor, request, bytes(info.size)))
    except OSError:
        return None  # a pipe, a terminal, or no such axis
    return (low, high, max(0, flat)) if low < high else None
