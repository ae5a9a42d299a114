"""Heartbeats: which callback each execution context of a process is in, and since when.

The thread that drives a context writes its own slot, in memory that the manager reads: a callback
that holds the interpreter lock, or loops for ever, is seen from outside all the same. Behind that
memory, in the same file, is room for stacks (see `rtkit.container.stacks`): one file a
process is created sooner than two.
"""

from __future__ import annotations

import mmap
import os
import struct
import threading
import time
from typing import NamedTuple

from rtkit.link.places import of_pid

CALLBACKS = (
    "", "on_initialize", "on_finalize", "on_startup", "on_shutdown", "on_activated",
    "on_deactivated", "on_aborting", "on_error", "on_reset", "on_execute", "on_state_update",
    "on_rate_changed", "on_action", "import", "creation", "listener",
)  # fmt: skip
_CODES = {name: code for code, name in enumerate(CALLBACKS)}
_HEADER = struct.Struct("<I")
_START = struct.Struct("<Q")
_SLOT = struct.Struct("<QQBB")
_NAME_BYTES = 110
_STRIDE = 128
_FIRST = 128
_SLOTS = 1024
_SIZE = _FIRST + _SLOTS * _STRIDE
STACKS_AT = _SIZE
"""Where in the file stacks begin [byte]."""


def heartbeats_path(pattern: str, pid: int) -> str:
    """Return where a process keeps its heartbeats; `pattern` is that of its data socket."""
    return of_pid(pattern, pid).removesuffix(".data") + ".beats"


def guest_pattern(pattern: str) -> str:
    """Return the pattern for attached processes: by another name nothing takes them for slaves."""
    return pattern.removesuffix(".data") + ".guest.data"


class Activity(NamedTuple):
    """A callback, a listener, the import of a module, or a creation that is under way.

    Attributes:
        instance: Name of the component, or of the module.
        since_ns: When it was entered, monotonic [ns].
        thread: Identity of the thread that runs it.
    """

    instance: str
    callback: str
    since_ns: int
    thread: int


class Heartbeats:
    """Heartbeat slots of this process."""

    def __init__(self, path: str) -> None:
        flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW
        descriptor = os.open(path, flags, 0o600)
        try:
            os.ftruncate(descriptor, _SIZE)
            self._memory = mmap.mmap(descriptor, _SIZE)
        finally:
            os.close(descriptor)
        self._free: list[int] = []
        self._used = 0
        self._lock = threading.Lock()

    def slot(self) -> HeartbeatSlot | None:
        """Return a slot for one execution context; None when all are taken."""
        with self._lock:
            if self._free:
                return HeartbeatSlot(self._memory, self._free.pop())
            if self._used == _SLOTS:
                return None
            self._used += 1
            _HEADER.pack_into(self._memory, 0, self._used)
            return HeartbeatSlot(self._memory, self._used - 1)

    def release(self, slot: HeartbeatSlot) -> None:
        """Take a slot back."""
        slot.watch("", "")
        with self._lock:
            self._free.append(slot.index)


class HeartbeatSlot:
    """Slot in which one execution context reports its activity."""

    def __init__(self, memory: mmap.mmap, index: int) -> None:
        self.index = index
        self._memory = memory
        self._offset = _FIRST + index * _STRIDE
        self._names: dict[str, bytes] = {}

    def watch(self, instance: str, callback: str) -> None:
        """Note that a callback was entered, or with empty texts that it was left."""
        if not callback:
            _START.pack_into(self._memory, self._offset, 0)
            return
        name = self._names.get(instance)
        if name is None:
            name = self._names[instance] = instance.encode()[:_NAME_BYTES]
        offset = self._offset + _SLOT.size
        self._memory[offset : offset + len(name)] = name
        # The start is what makes the rest valid, so a reader compares it before and after.
        code = _CODES.get(callback, 0)
        thread = threading.get_ident()
        _SLOT.pack_into(self._memory, self._offset, time.monotonic_ns(), thread, code, len(name))

    def grant(self, time_ns: int) -> None:
        """Have the present callback count as entered that much later [ns]."""
        (start,) = _START.unpack_from(self._memory, self._offset)
        if start:
            _START.pack_into(self._memory, self._offset, start + time_ns)


class HeartbeatReader:
    """Reads the slots of another process.

    Raises:
        OSError: It has none.
    """

    def __init__(self, path: str) -> None:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
        try:
            self._memory = mmap.mmap(descriptor, _SIZE, prot=mmap.PROT_READ)
        finally:
            os.close(descriptor)

    def close(self) -> None:
        """Let go of the memory."""
        self._memory.close()

    def inside(self) -> list[Activity]:
        """Return every callback that is under way."""
        used = min(_HEADER.unpack_from(self._memory, 0)[0], _SLOTS)
        heartbeats = []
        for offset in range(_FIRST, _FIRST + used * _STRIDE, _STRIDE):
            start, thread, code, length = _SLOT.unpack_from(self._memory, offset)
            if not start:
                continue
            at = offset + _SLOT.size
            name = self._memory[at : at + min(length, _NAME_BYTES)]
            if _START.unpack_from(self._memory, offset)[0] == start and code < len(CALLBACKS):
                instance = name.decode("utf-8", "replace")
                heartbeats.append(Activity(instance, CALLBACKS[code], start, thread))
        return heartbeats
