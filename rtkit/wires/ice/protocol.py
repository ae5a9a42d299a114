"""Ice protocol: settings of both ends of a connection, and values as they travel.

The interface is in ``property_service.ice``. Ice itself (the package zeroc-ice, GPL-2) is imported
only here, by who needs it; it has no types.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping
from functools import cache
from logging import getLogger
from typing import Any, NamedTuple

from rtkit.errors import Refused
from rtkit.extras import how_to_get
from rtkit.property.messages import Payload, PropertyEvent, text_or_bytes
from rtkit.property.subscription import LEASE_S

DEADLINE = "deadline"
"""Key of the context of a request: when it is given up, as `rtkit.link.deadline` writes it."""
DOOR = "door"
"""The object that is asked who one is."""
LONGEST = 1 << 21
"""Bytes of a message to a service; a larger one ends the connection."""
_LONGEST_REPLY = 1 << 26
_PLACE = re.compile(r"\S+\.(?:cpp|h):\d+: ")
_COMMON = {
    "Ice.ThreadPool.Client.Size": 1,
    "Ice.ThreadPool.Server.Size": 1,
    "Ice.RetryIntervals": -1,  # a request is never sent twice: it may have acted
    "Ice.Override.CloseTimeout": 500,
    "Ice.Warn.Connections": 0,
    "Ice.Warn.Dispatch": 0,
}
_OF_CLIENT = {
    "Ice.MessageSizeMax": _LONGEST_REPLY >> 10,
    "Ice.ACM.Client.Timeout": LEASE_S,
    "Ice.ACM.Client.Close": 0,
    "Ice.ACM.Client.Heartbeat": 3,
}


class Runtime(NamedTuple):
    """Ice runtime: its module, and the module that it generates from the interface."""

    ice: Any
    slice: Any


@cache
def runtime() -> Runtime:
    """Return Ice.

    Raises:
        Refused: It is not there.
    """
    try:
        import Ice
    except ImportError:
        cure = f"{how_to_get('ice')}, or python3-zeroc-ice of Debian"
        raise Refused(f"Ice needs the package zeroc-ice: {cure}") from None
    from importlib.resources import as_file, files

    with as_file(files("rtkit.link") / "property_service.ice") as path:
        Ice.loadSlice("", [str(path)])
    return Runtime(Ice, sys.modules["PropertyService"])


def communicator(settings: Mapping[str, float] = _OF_CLIENT) -> Any:
    """Return a communicator of its own; nothing of the environment changes it."""
    ice = runtime().ice
    data = ice.InitializationData()
    data.logger = _logger()
    data.properties = ice.createProperties()
    for key, value in {**_COMMON, **settings}.items():
        data.properties.setProperty(key, f"{value:g}")
    return ice.initialize(data)


@cache
def _logger() -> Any:
    """Return a logger for Ice: one line per complaint in our log, without its source positions."""

    def complain(self: object, message: str) -> None:
        line = " ".join(_PLACE.sub("", message).split())
        getLogger("rtkit.properties").warning("Ice: %s", line)

    def remark(self: object, *message: str) -> None:
        """Ignore messages that are no complaint."""

    methods = {"error": complain, "warning": complain, "print": remark, "trace": remark}
    methods["getPrefix"] = lambda self: ""
    methods["cloneWithPrefix"] = lambda self, prefix: self
    return type("Log", (runtime().ice.Logger,), methods)()


def identity_of(service: str) -> Any:
    """Return the identity of a service."""
    category, _, name = service.rpartition("/")
    return runtime().ice.Identity(name, category)


def name_of(identity: Any) -> str:
    """Return the name of the service that an identity stands for."""
    return f"{identity.category}/{identity.name}" if identity.category else str(identity.name)


def write_payload(payload: Payload) -> Any:
    """Return a payload as it travels; characters that are none travel as bytes."""
    made = runtime().slice.Payload
    if isinstance(payload, str):
        try:
            payload.encode()
        except UnicodeEncodeError:
            payload = payload.encode("utf-8", "surrogateescape")
        else:
            return made(payload, b"", False)
    return made("", payload, True)


def read_payload(given: Any) -> Payload:
    """Return the payload that arrived."""
    return text_or_bytes(bytes(given.data)) if given.isBytes else str(given.text)


def write_event(event: PropertyEvent) -> Any:
    """Return an event as it travels."""
    value = write_payload(event.payload)
    return runtime().slice.Event(event.name, value, event.time, event.revision, event.quality,
                                 event.dropped, event.code)  # fmt: skip


def read_event(given: Any) -> PropertyEvent:
    """Return the event that arrived."""
    value = read_payload(given.value)
    return PropertyEvent(
        given.name, value, given.time, given.revision, given.quality, given.dropped, given.code
    )


def words_of(error: Any) -> str:
    """Return in a few words why a call failed."""
    ice = runtime().ice
    if isinstance(error, ice.DNSException):
        return f"no such host: {error.host}"
    if isinstance(error, ice.TimeoutException):
        return "no answer in time"
    ended = (
        ice.CloseConnectionException,
        ice.CommunicatorDestroyedException,
        ice.ConnectionLostException,
        ice.ConnectionManuallyClosedException,
    )
    if isinstance(error, ended):
        return "the connection has ended"
    if isinstance(error, ice.SocketException):
        return os.strerror(error.error)
    if isinstance(error, ice.ProtocolException):
        return "it speaks no Ice"
    return f"Ice: {type(error).__name__}"
