"""Addresses of Ice endpoints, ``ice://HOST:PORT/SERVICE``."""

from __future__ import annotations

import re
from typing import NamedTuple

from rtkit.errors import Malformed

_ADDRESS = re.compile(r"ice://([A-Za-z0-9_.\-]+):(\d{1,5})(?:/(.*))?")


class IceAddress(NamedTuple):
    """Address of an Ice endpoint, and of a service behind it."""

    host: str
    port: int
    service: str = ""

    def __str__(self) -> str:
        return f"ice://{self.host}:{self.port}" + (f"/{self.service}" if self.service else "")


def read_address(text: str) -> IceAddress:
    """Read ``ice://HOST:PORT[/SERVICE]``.

    Raises:
        Malformed: It is something else.
    """
    found = _ADDRESS.fullmatch(text)
    if found is None or int(found[2]) > 65535:
        raise Malformed(f"not ice://HOST:PORT: {text}")
    return IceAddress(found[1], int(found[2]), (found[3] or "").rstrip("/"))
