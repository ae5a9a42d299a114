"""Listeners to the connectors of a port, under the names and numbers of OpenRTM."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import RLock
from typing import Any

from rtkit.component.ports.connector_events import ConnectorEvent
from rtkit.component.values.codec import codec_for
from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.corba.twins import freezer_of, frozen_class_of, thawer_of
from rtkit.rtc.profiles import ConnectorProfile

_HEADER = b"\x00\x01\x00\x00"
"""Begins each value in CDR; OpenRTM hands values to listeners without it."""


class ConnectorListenerStatus:
    """Answers of a listener."""

    NO_CHANGE, INFO_CHANGED, DATA_CHANGED, BOTH_CHANGED = range(4)


class ConnectorDataListenerType:
    """Events that have a value."""

    (
        ON_BUFFER_WRITE, ON_BUFFER_FULL, ON_BUFFER_WRITE_TIMEOUT, ON_BUFFER_OVERWRITE,
        ON_BUFFER_READ, ON_SEND, ON_RECEIVED, ON_RECEIVER_FULL, ON_RECEIVER_TIMEOUT,
        ON_RECEIVER_ERROR, CONNECTOR_DATA_LISTENER_NUM,
    ) = range(11)  # fmt: skip


class ConnectorListenerType:
    """Events without a value."""

    (
        ON_BUFFER_EMPTY, ON_BUFFER_READ_TIMEOUT, ON_SENDER_EMPTY, ON_SENDER_TIMEOUT,
        ON_SENDER_ERROR, ON_CONNECT, ON_DISCONNECT, CONNECTOR_LISTENER_NUM,
    ) = range(8)  # fmt: skip


_E = ConnectorEvent
_DATA_EVENTS = (
    _E.WRITTEN, _E.FULL, _E.WRITE_TIMEOUT, _E.OVERWRITTEN, _E.READ, _E.SENT, _E.RECEIVED,
    _E.RECEIVER_FULL, _E.RECEIVER_TIMEOUT, _E.RECEIVER_ERROR,
)  # fmt: skip
_EVENTS = (
    _E.EMPTY, _E.READ_TIMEOUT, _E.SENDER_EMPTY, _E.SENDER_TIMEOUT, None, _E.CONNECTED,
    _E.DISCONNECTED,
)  # fmt: skip
"""Events by number; an end of a connector here does not learn of an error at the other one."""


class ConnectorListener:
    """Base of listeners to events without a value."""

    def __call__(self, info: ConnectorInfo) -> Any:
        """React; `info` describes the connector."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(ConnectorListenerType, status)


class ConnectorDataListener:
    """Base of listeners to events that are given values in CDR."""

    def __call__(self, info: ConnectorInfo, data: Any) -> Any:
        """React; may return `DATA_CHANGED` and the value to go on with."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(ConnectorDataListenerType, status)


class ConnectorDataListenerT(ConnectorDataListener):
    """Base of listeners to events that are given values as objects."""

    def __call__(  # type: ignore[override]  # authors pass on more than they are given
        self, info: ConnectorInfo, cdrdata: Any, data: Any = None, *_: Any
    ) -> Any:
        """Return a value as an object of the type of `data`; one that is an object already is."""
        if isinstance(cdrdata, bytes | bytearray) and data is not None:
            return decoded(frozen_class_of(data), cdrdata)
        return cdrdata


class ConnectorInfo:
    """A connector: name, id, ends as texts, and its properties without ``dataport.`` before."""

    def __init__(self, name: str, id: str, ports: list[str], properties: Properties) -> None:
        self.name = name
        self.id = id
        self.ports = ports
        self.properties = properties


class ListenedPort:
    """Base of ports whose connectors can be listened to."""

    port: Any

    def addConnectorDataListener(
        self,
        listener_type: int,
        listener: Any,
        autoclean: bool = True,
    ) -> None:
        """Have a listener called with info and value at each event of a kind."""
        self._add_notice(_DATA_EVENTS, listener_type, _DataNotice(listener))

    def removeConnectorDataListener(self, listener_type: int, listener: Any) -> None:
        """Call a listener no more."""
        self._remove_notice(_DATA_EVENTS, listener_type, listener)

    def addConnectorListener(
        self,
        callback_type: int,
        listener: Any,
        autoclean: bool = True,
    ) -> None:
        """Have a listener called with info at each event of a kind."""
        self._add_notice(_EVENTS, callback_type, _Notice(listener))

    def removeConnectorListener(self, callback_type: int, listener: Any) -> None:
        """Call a listener no more."""
        self._remove_notice(_EVENTS, callback_type, listener)

    @property
    def _notices(self) -> list[tuple[ConnectorEvent, _Notice]]:
        found: list[tuple[ConnectorEvent, _Notice]] = vars(self).setdefault("_notice_list", [])
        return found

    def _add_notice(
        self, events: Sequence[ConnectorEvent | None], number: int, notice: _Notice
    ) -> None:
        event = events[number]
        if event is not None:
            self._notices.append((event, notice))
            self.port.add_listener(event, notice)

    def _remove_notice(
        self, events: Sequence[ConnectorEvent | None], number: int, listener: Any
    ) -> None:
        for each in self._notices:
            event, notice = each
            if event is events[number] and notice.listener == listener:
                self._notices.remove(each)
                self.port.remove_listener(event, notice)
                return


class _Notice:
    """Calls an author's listener; by one thread at a time, as OpenRTM does."""

    def __init__(self, listener: Any) -> None:
        self.listener = listener
        self._lock = RLock()
        self._infos: dict[str, ConnectorInfo] = {}

    def __call__(self, connector: ConnectorProfile, value: Any) -> Any:
        with self._lock:
            self.listener(self.info(connector))

    def info(self, connector: ConnectorProfile) -> ConnectorInfo:
        """Return a connector as listeners see it: the same object each time."""
        id = connector.connector_id
        known = self._infos.get(id)
        if known is None:
            known = self._infos[id] = info_of(connector)
        return known


class _DataNotice(_Notice):
    """Does so with a value, and returns the one to go on with; None for the same."""

    def __init__(self, listener: Any) -> None:
        super().__init__(listener)
        self._takes_object = isinstance(listener, ConnectorDataListenerT)

    def __call__(self, connector: ConnectorProfile, value: Any) -> Any:
        cls = type(value)
        there, back = _objects(cls) if self._takes_object else _octets(cls)
        with self._lock:
            given = there(value)
            answer = self.listener(self.info(connector), given)
        status, data = answer if isinstance(answer, tuple) else (answer, given)
        is_changed = isinstance(status, int) and status & ConnectorListenerStatus.DATA_CHANGED
        return back(data) if is_changed else None


def _objects(cls: type) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    return (_same, _same) if cls is bytes else (thawer_of(cls), freezer_of(cls))


def _octets(cls: type) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    encode, decode = codec_for(cls)
    size = len(_HEADER)
    return (lambda value: encode(value)[size:], lambda data: decode(_HEADER + bytes(data)))


def _same(value: Any) -> Any:
    return value


def decoded(cls: type, octets: bytes | bytearray) -> Any:
    """Return the mutable value of octets in CDR.

    Raises:
        Malformed: They are none of that type.
    """
    return thawer_of(cls)(codec_for(cls).decode(_HEADER + bytes(octets)))


def info_of(connector: ConnectorProfile) -> ConnectorInfo:
    """Describe a connector to listeners."""
    properties = Properties()
    for key, text in connector.properties.items():
        properties.setProperty(key.removeprefix("dataport."), text)
    ports = [str(each) for each in connector.ports]
    return ConnectorInfo(connector.name, connector.connector_id, ports, properties)


def name_of(numbers: type, number: int) -> str:
    """Return the name of a number; empty of one that has none."""
    named = {value: name for name, value in vars(numbers).items() if isinstance(value, int)}
    name = named.get(number, "")
    return "" if name.endswith("_NUM") else name
