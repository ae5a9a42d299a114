"""Small classes and constants that components name."""

from __future__ import annotations

from typing import Any


class DataPortStatus:
    """Outcomes of a write or a read, as numbers."""

    (
        PORT_OK, PORT_ERROR, BUFFER_ERROR, BUFFER_FULL, BUFFER_EMPTY, BUFFER_TIMEOUT, SEND_FULL,
        SEND_TIMEOUT, RECV_EMPTY, RECV_TIMEOUT, INVALID_ARGS, PRECONDITION_NOT_MET,
        CONNECTION_LOST, UNKNOWN_ERROR,
    ) = range(14)  # fmt: skip

    @classmethod
    def toString(cls, status: int) -> str:
        """Return the name of an outcome."""
        names = {value: name for name, value in vars(cls).items() if isinstance(value, int)}
        return names.get(status, "")


class PortType:
    """Kinds of data ports."""

    OutPortType, InPortType, PortTypeNum = range(3)


class ScopedLock:
    """Holds a lock until it is deleted, or until the end of a `with` block."""

    def __init__(self, mutex: Any) -> None:
        self._mutex = mutex
        mutex.acquire()

    def __del__(self) -> None:
        if self._mutex is not None:
            self._mutex.release()

    def __enter__(self) -> ScopedLock:
        return self

    def __exit__(self, *_: object) -> None:
        mutex, self._mutex = self._mutex, None
        mutex.release()


def toTypename(value: Any) -> str:
    """Return the name of the type of a value, as ports have it."""
    return str(value._NP_RepositoryId)  # noqa: SLF001 - as omniORB calls it
