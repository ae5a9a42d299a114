"""One connection between two processes of a host: whole packets, in order, either way.

======= ======================================= ================================================
kind    follows                                 meaning
======= ======================================= ================================================
VALUE   octets                                  a small value
COUNTED number, octets                          the same, of a stream that counts its values
SLOT    slot, size, number or NONE              a large value, in shared memory of the sender;
                                                its descriptor comes along the first time
LOST    number                                  that value will not come
MARK    number                                  asks that it is sent back, once all before it has
                                                been dealt with
FREE    slot                                    the receiver has no use for that value any more
FORGET  slot                                    no value will come in that slot any more
======= ======================================= ================================================
"""

from __future__ import annotations

import os
import select
import socket
import struct
import time
from array import array
from collections import deque
from contextlib import suppress
from threading import Lock
from typing import NamedTuple, TypeAlias

from rtkit.link.ends import Octets, Payload
from rtkit.link.local.slots import SeenSlots, Slot, SlotPool

VALUE, COUNTED, SLOT, LOST, MARK, FREE, FORGET = (bytes([kind]) for kind in range(7))
NONE = (1 << 64) - 1
MOST_INLINE = 32 << 10
"""How large a value may be that is copied through the socket [bytes]."""

_NUMBER = struct.Struct("<Q")
_SLOT = struct.Struct("<IQQ")
_INDEX = struct.Struct("<I")
_TIMEVAL = struct.Struct("@ll")
_LONGEST_S = 1e6
_MOST = MOST_INLINE + 64
_SMALL = 64
_ROOM = socket.CMSG_SPACE(4)
# As numbers: the members of an enumeration take longer to join than a packet to send.
_FLAGS = int(socket.MSG_NOSIGNAL | socket.MSG_DONTWAIT)
_CLOEXEC = int(socket.MSG_CMSG_CLOEXEC)
_CUT = int(socket.MSG_TRUNC | socket.MSG_CTRUNC)
NOW = int(socket.MSG_DONTWAIT)
"""Flag by which `Channel.receive` does not wait."""
_MOST_HELD = 16
_MOST_HELD_BYTES = 32 << 20
_LEAST_HELD = 2
Ancillary: TypeAlias = "list[tuple[int, int, bytes]]"
_GLANCE_S = 0.02
_IN_TRANSIT = 2
"""How many more values than a reader keeps may be on their way."""


def most_held(size: int) -> int:
    """Return how many values of a size [bytes] a reader keeps in memory of their writer."""
    return max(_LEAST_HELD, min(_MOST_HELD, _MOST_HELD_BYTES // size))


def size_of(value: Payload) -> int:
    """Return the size of what is sent [bytes]."""
    return sum(map(len, value)) if isinstance(value, list) else len(value)


def take_passed(passed: Ancillary, most: int) -> list[int]:
    """Return the descriptors that came with a packet; close those that nobody asked for."""
    found = [
        descriptor
        for level, kind, octets in passed
        if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS)
        for descriptor in array("i", octets[: len(octets) // 4 * 4])
    ]
    for descriptor in found[most:]:
        os.close(descriptor)
    return found[:most]


class Packet(NamedTuple):
    """A value, a loss, or a mark that is to be sent back.

    Attributes:
        kind: VALUE, LOST or MARK.
        number: Of the value, or mark; NONE where values are not counted.
        value: Empty where there is none.
    """

    kind: bytes
    number: int
    value: Octets = b""


class Full(Exception):
    """Nothing more can be sent now.

    Attributes:
        is_memory: Because too many large values have not been given back, not for the socket.
    """

    def __init__(self, *, is_memory: bool) -> None:
        super().__init__()
        self.is_memory = is_memory


class _Socket(socket.socket):
    """A socket that is closed with the last reference to it."""

    def __del__(self) -> None:
        self.close()


class Channel:
    """One end of a connection.

    One thread may send while another receives. Each may be told that the other end is gone by an
    OSError, or the end of all packets.

    Args:
        connection: A socket that keeps the bounds of packets; it is taken over.
        pool: Where large values that are sent are put.

    Attributes:
        returned: The mark that the other end has sent back last.
        is_closed: Whether it was closed here.
    """

    def __init__(self, connection: socket.socket, pool: SlotPool) -> None:
        self.connection = _Socket(fileno=connection.detach())
        self._send = self.connection.send
        self._receive = self.connection.recvmsg
        self._pool = pool
        self._lock = Lock()
        self.returned = NONE
        self.is_closed = False
        self._seen = SeenSlots()
        # These two are changed where garbage is collected, which may be inside any lock.
        self._in_use: set[object] = set()
        self._freed: deque[int] = deque()
        self._given: dict[int, list[Slot]] = {}
        self._known: dict[int, Slot] = {}
        self._given_count = 0
        self._is_over = False
        self._bound_s = 0.0

    def fileno(self) -> int:
        """Return the descriptor of its socket."""
        return self.connection.fileno()

    # sending

    def send(self, value: Payload, number: int = NONE) -> None:
        """Send a value without waiting.

        Raises:
            Full: It cannot be taken now.
            OSError: The other end is gone, or there is no memory.
        """
        if self._is_over:
            raise BrokenPipeError
        size = size_of(value)
        if size > MOST_INLINE:
            self._send_large(value, size, number)
            return
        if isinstance(value, list):
            value = b"".join(value)
        head = VALUE if number == NONE else COUNTED + _NUMBER.pack(number)
        try:
            self._send(head + value, _FLAGS)
        except BlockingIOError:
            raise Full(is_memory=False) from None

    def _send_large(self, value: Payload, size: int, number: int) -> None:
        if self._given_count >= most_held(size) + _IN_TRANSIT:
            self.take_back()
            if self._given_count >= most_held(size) + _IN_TRANSIT:
                raise Full(is_memory=True)
        elif self._given_count:
            self.take_back(is_for_memory=True)  # so that the memory used last is used again
        slot = self._pool.fill(value, size)
        try:
            self._send_slot(slot, size, number)
        except BaseException:
            self._pool.release(slot)
            raise
        with self._lock:
            self._given.setdefault(slot.number, []).append(slot)
            self._given_count += 1

    def _send_slot(self, slot: Slot, size: int, number: int) -> None:
        packet = SLOT + _SLOT.pack(slot.number, size, number)
        try:
            if slot.number in self._known:
                self._send(packet, _FLAGS)
                return
            for old in [each for each in self._known.values() if each.memory.closed]:
                self._send(FORGET + _INDEX.pack(old.number), _FLAGS)
                del self._known[old.number]
            passed = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array("i", [slot.descriptor]))]
            self.connection.sendmsg([packet], passed, _FLAGS)
            self._known[slot.number] = slot
        except BlockingIOError:
            raise Full(is_memory=False) from None

    def send_notice(self, kind: bytes, number: int) -> None:
        """Send a mark, or send one back, or tell of a loss.

        Raises:
            Full: It cannot be taken now.
            OSError: The other end is gone.
        """
        try:
            self._send(kind + _NUMBER.pack(number), _FLAGS)
        except BlockingIOError:
            raise Full(is_memory=False) from None

    def await_room(self, full: Full, until: float) -> bool:
        """Wait until more may fit, at most until then (monotonic) [s]; False when time is up."""
        return self._await(0 if full.is_memory else select.POLLOUT, until)

    def await_mark(self, number: int, until: float) -> bool:
        """Wait until a mark was sent back, at most until then (monotonic) [s]."""
        while self.returned != number:
            # Another thread that sends may be the one that takes it.
            if time.monotonic() >= until or self._is_over:
                return False
            self._await(0, min(until, time.monotonic() + _GLANCE_S))
        return True

    def _await(self, events: int, until: float) -> bool:
        poll = select.poll()
        poll.register(self.fileno(), events | select.POLLIN)
        left_s = until - time.monotonic()
        if self._is_over or left_s <= 0 or not poll.poll(left_s * 1e3):
            return False
        self.take_back()
        return not self._is_over

    def take_back(self, *, is_for_memory: bool = False) -> None:
        """Take back memory, and marks, that the other end has sent back.

        It is for ends that receive nothing else. What is done for memory ends with the last value
        that had not been given back.
        """
        try:
            while self._given_count or not is_for_memory:
                data, passed, _, _ = self._receive(_SMALL, _ROOM, NOW | _CLOEXEC)
                if not data:
                    break
                packet = self._read(data[:1], data, passed)
                if packet is not None:
                    self.returned = packet.number
            else:
                return
        except BlockingIOError:
            return
        except (OSError, ValueError, LookupError, struct.error):
            pass
        self._is_over = True

    # receiving

    def bound(self, timeout_s: float) -> None:
        """Have each wait in `receive` end after so long at most [s]."""
        if timeout_s != self._bound_s:
            self._bound_s = timeout_s
            bound_us = max(1, int(min(timeout_s, _LONGEST_S) * 1e6))  # none would be for ever
            bound = _TIMEVAL.pack(*divmod(bound_us, 1_000_000))
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, bound)

    def receive(self, flags: int = 0) -> Packet | None:
        """Return what comes next; None when the other end is gone.

        Raises:
            BlockingIOError: Nothing has come in the time that flags and socket allow.
            OSError: This end is closed.
            ValueError: It is no packet.
        """
        while True:
            data, passed, state, _ = self._receive(_MOST, _ROOM, flags | _CLOEXEC)
            if not data:
                return None
            if state & _CUT:
                raise ValueError("a packet that is too large")
            kind = data[:1]
            if passed and kind != SLOT:
                take_passed(passed, most=0)
            if kind == VALUE:
                return Packet(VALUE, NONE, data[1:])
            try:
                packet = self._read(kind, data, passed)
            except (struct.error, LookupError, OverflowError) as error:
                raise ValueError(f"no packet: {error}") from error
            if packet is not None:
                return packet

    def _read(self, kind: bytes, data: bytes, passed: Ancillary) -> Packet | None:
        if kind == COUNTED:
            (number,) = _NUMBER.unpack_from(data, 1)
            return Packet(VALUE, number, data[1 + _NUMBER.size :])
        if kind == SLOT:
            slot, size, number = _SLOT.unpack_from(data, 1)
            for descriptor in take_passed(passed, most=1):
                self._seen.learn(slot, descriptor)
            return Packet(VALUE, number, self._value_in(slot, size))
        if kind in (LOST, MARK):
            return Packet(kind, *_NUMBER.unpack_from(data, 1))
        (slot,) = _INDEX.unpack_from(data, 1)
        if kind == FREE:
            self._take_back(slot)
        elif kind == FORGET:
            self._seen.forget(slot)
        return None

    def _value_in(self, slot: int, size: int) -> Octets:
        if size <= MOST_INLINE:
            raise ValueError("a small value in shared memory")
        is_kept, use = len(self._in_use) < most_held(size), object()
        self._in_use.add(use)
        view = self._seen.view(slot, size, lambda: self._give_back(slot, use))
        return view if is_kept else bytes(view)

    def _give_back(self, slot: int, use: object) -> None:
        """Tell the other end that a value is not used any more; by whichever thread."""
        self._in_use.discard(use)
        self._freed.append(slot)
        try:
            while self._freed:
                next_slot = self._freed.pop()
                try:
                    self._send(FREE + _INDEX.pack(next_slot), _FLAGS)
                except BlockingIOError:
                    self._freed.append(next_slot)  # with the next one
                    return
        except (IndexError, OSError):
            return  # another thread has sent it, or the other end is gone

    def _take_back(self, slot: int) -> None:
        with self._lock:
            given = self._given.get(slot)
            if not given:
                raise ValueError("memory that was not given is given back")
            taken = given.pop()
            self._given_count -= 1
        self._pool.release(taken)

    def close(self) -> None:
        """End the connection; a thread that waits at it finds its end.

        Its descriptor is closed when no thread and no value refers to it any more: a number that
        were used anew meanwhile would be that of something else.
        """
        self.is_closed = True
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)
        with self._lock:
            self._is_over = True
            given = [slot for slots in self._given.values() for slot in slots]
            self._given.clear()
        for slot in given:
            self._pool.release(slot, is_spent=True)
