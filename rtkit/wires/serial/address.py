"""Addresses of serial lines, ``serial:/dev/ttyACM0?baud=115200``; opens the line behind one.

``?address=7``, ``?address=1-20,base`` name devices that share the line.
"""

from __future__ import annotations

import errno
import os
import re
import stat
from typing import NamedTuple

from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.extras import how_to_get

SCHEME = "serial:"
HELLO_TARGET = "door/hello"
"""First request of a client, to find out which form of the protocol the service speaks."""
KNOWS_DEADLINES = "deadline"
"""The answer of a far side that knows the parameter of `rtkit.link.deadline`; others refuse."""
_BAUD = 115200
_SETTINGS = re.compile(r"([^?]*\?(?:baud|check|address)=[^/?]*)(?:/|$)")
_CHECK = {"auto": None, "1": True, "0": False}


class SerialAddress(NamedTuple):
    """Address of a serial line.

    Attributes:
        baud: Speed [bit/s].
        has_checks: Whether lines carry a check; None: if the far side knows how to.
        devices: Addresses of the devices that share the line; none where one is alone there.
    """

    device: str
    baud: int = _BAUD
    has_checks: bool | None = None
    devices: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.device


def read_address(text: str) -> SerialAddress:
    """Read ``[serial:]DEVICE[?baud=N][&check=auto|1|0][&address=LIST]``.

    Raises:
        Malformed: It is something else.
    """
    device, mark, tail = text.removeprefix(SCHEME).partition("?")
    given = dict(each.partition("=")[::2] for each in tail.split("&")) if mark else {}
    baud, check = given.pop("baud", str(_BAUD)), given.pop("check", "auto")
    is_number = baud.isascii() and baud.isdigit() and int(baud[:9]) > 0 and len(baud) < 9
    listed = given.pop("address", None)
    if not device or given or check not in _CHECK or not is_number:
        raise Malformed(f"not serial:DEVICE[?baud=N&check=auto|1|0&address=LIST]: {text}")
    settings = SerialAddress(device, int(baud), _CHECK[check])
    if listed is None:
        return settings
    from rtkit.property.addressed import read_addresses

    try:
        return settings._replace(devices=read_addresses(listed))
    except ValueError as error:
        raise Malformed(f"{error} in {text}") from None


def split_target(text: str) -> tuple[str, str]:
    """Return the address in ``serial:DEVICE[?baud=…][/NAME]``, and the name behind it.

    Where no settings show where it ends, the device is the first on the path that is no folder.
    """
    found = _SETTINGS.match(text)
    if found is not None:
        return found[1], text[found.end() :]
    ends = [found.start() for found in re.finditer("/", text) if found.start() > len(SCHEME)]
    for end in ends:
        path = text[len(SCHEME) : end]
        if os.path.exists(path) and not os.path.isdir(path):
            return text[:end], text[end + 1 :]
    return text, ""


class SerialEnd:
    """Open serial line; reads and writes what there is, as a socket that does not wait.

    Raises:
        Unreachable: There is no such device, or it cannot be opened (now).
        Refused: It is no serial line, or pyserial is missing.
    """

    def __init__(self, address: SerialAddress) -> None:
        import termios

        try:
            from serial import Serial, SerialException
        except ImportError as error:
            raise Refused(f"serial lines need pyserial: {how_to_get('serial')}") from error
        device = address.device
        try:
            if not stat.S_ISCHR(os.stat(device).st_mode):
                raise Refused(f"not a serial line: {device}")
            self._port = Serial(device, address.baud, timeout=0, write_timeout=0, exclusive=True)
            self._fd = self._port.fileno()
            # Nothing there and nobody there differ only so.
            settings = termios.tcgetattr(self._fd)
            settings[6][termios.VMIN], settings[6][termios.VTIME] = 1, 0
            termios.tcsetattr(self._fd, termios.TCSANOW, settings)
        except SerialException as error:
            if f"({errno.ENOTTY}," in str(error):
                raise Refused(f"not a serial line: {device}") from error
            if "exclusively" in str(error):
                raise Unreachable(
                    f"cannot open {device}: it is in use (rtproxy shares it)"
                ) from error
            why = os.strerror(error.errno) if error.errno else str(error)
            raise Unreachable(f"cannot open {device}: {why}") from error
        except (OSError, termios.error, ValueError) as error:
            why = getattr(error, "strerror", None) or str(error)
            raise Unreachable(f"cannot open {device}: {why}") from error

    def fileno(self) -> int:
        """Return its descriptor."""
        return self._fd

    def setblocking(self, flag: bool, /) -> None:
        """Do nothing: it never waits."""

    def recv(self, size: int, /) -> bytes:
        """Return what has come, nothing when the device is gone.

        Raises:
            BlockingIOError: Nothing has come.
            OSError: The device is gone.
        """
        return os.read(self._fd, size)

    def send(self, data: bytes | bytearray | memoryview, /) -> int:
        """Send as much as the receiver takes; return how many bytes.

        Raises:
            BlockingIOError: There is none.
            OSError: The device is gone.
        """
        return os.write(self._fd, data)

    def close(self) -> None:
        """Give the device back."""
        self._port.close()
