"""Watches the files of a folder with inotify(7)."""

from __future__ import annotations

import ctypes
import os
import struct

from rtkit.errors import Refused

_MODIFY, _MOVED, _CREATE, _DELETE = 0x2, 0xC0, 0x100, 0x200
_EVENT = struct.Struct("iIII")
_ROOM = 65_536


class FolderWatch:
    """Watch on one folder: reports files that are made, written, moved or removed in it."""

    def __init__(self, path: str) -> None:
        """Begin to watch.

        Raises:
            Refused: The folder is not there, or the kernel has no more inotify watches.
        """
        libc = ctypes.CDLL(None, use_errno=True)
        self._descriptor: int = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        mask = _MODIFY | _MOVED | _CREATE | _DELETE
        if (
            self._descriptor < 0
            or libc.inotify_add_watch(self._descriptor, os.fsencode(path), mask) < 0
        ):
            why = os.strerror(ctypes.get_errno())
            self.close()
            raise Refused(f"cannot listen to folder {path}: {why}")

    def fileno(self) -> int:
        """Return the descriptor that turns readable, for selectors."""
        return self._descriptor

    def take(self) -> set[str]:
        """Return the names of files to which something happened since the last time."""
        names: set[str] = set()
        while True:
            try:
                data = os.read(self._descriptor, _ROOM)
            except BlockingIOError:
                return names
            start = 0
            while start < len(data):
                *_, length = _EVENT.unpack_from(data, start)
                start += _EVENT.size
                names.add(os.fsdecode(data[start : start + length].rstrip(b"\0")))
                start += length

    def close(self) -> None:
        """End the watch."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
