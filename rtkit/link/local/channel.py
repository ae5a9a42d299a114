"""One connection between two processes of a host: whole packets, in order, either way.

======= ======================================= ================================================
kind    follows                                 meaning
======= ======================================= ================================================
VALUE   octets                                  a small value
COUNTED number, octets                          the same, of a stream that counts its values
USES    none                                    a page for uses of memory of the sender, whose
                                                descriptor comes along (see `leases`)
SLOT    slot, use, size, number or NONE         a large value, in shared memory of the sender;
                                                its descriptor comes along the first time
LOST    number                                  that value will not come
MARK    number                                  asks that it is sent back, once all before it has
                                                been dealt with
FREE    none                                    a use has ended, and the sender waits for that
FORGET  slot                                    no value will come in that slot any more
PASS    none                                    a packet with a descriptor follows, though not at
                                                once where several threads send
======= ======================================= ================================================
"""

from __future__ import annotations

import os
import select
import socket
import struct
import time
from array import array
from contextlib import suppress
from functools import lru_cache, partial
from threading import Lock
from typing import TypeAlias

from rtkit.link.ends import Octets, Payload, joined
from rtkit.link.local.leases import MOST, BorrowedUses, LentSlots
from rtkit.link.local.slots import SeenSlots, Slot, SlotPool

VALUE, COUNTED, USES, SLOT, LOST, MARK, FREE, FORGET, PASS = (bytes([kind]) for kind in range(9))
NONE = (1 << 64) - 1
MOST_INLINE = 32 << 10
"""How large a value may be that is copied through the socket [bytes]."""

_NUMBER = struct.Struct("<Q")
_SLOT = struct.Struct("<IIQQ")
_INDEX = struct.Struct("<I")
_TIMEVAL = struct.Struct("@ll")
_LONGEST_S = 1e6
_MOST = MOST_INLINE + 64
_ROOM = socket.CMSG_SPACE(4)
# As numbers: the members of an enumeration take longer to join than a packet to send.
_FLAGS = int(socket.MSG_NOSIGNAL | socket.MSG_DONTWAIT)
_CLOEXEC = int(socket.MSG_CMSG_CLOEXEC)
NOW = int(socket.MSG_DONTWAIT)
"""Flag by which `Channel.receive` does not wait."""
_MOST_HELD = 16
_MOST_HELD_BYTES = 32 << 20
_LEAST_HELD = 2
Ancillary: TypeAlias = "list[tuple[int, int, bytes]]"
_GLANCE_S = 0.02
_IN_TRANSIT = 2
"""How many more values than a reader keeps may be on their way."""


@lru_cache(maxsize=16)
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


Packet: TypeAlias = "tuple[bytes, int, Octets]"
"""VALUE, LOST or MARK, its number, and the value, which is empty where there is none.

The number is NONE where values are not counted. It is a bare tuple: one that has names takes as
long to make as a small value to decode.
"""


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
        bound_s: How long a wait in `receive` takes at most [s]; 0: for ever.
    """

    def __init__(self, connection: socket.socket, pool: SlotPool) -> None:
        self.connection = _Socket(fileno=connection.detach())
        self._send = self.connection.send
        self._receive = self.connection.recv
        self._pool = pool
        self._lock = Lock()
        self.returned = NONE
        self.is_closed = False
        self._seen = SeenSlots()
        # It is changed where garbage is collected, which may be inside any lock.
        self._in_use: dict[int, object] = {}
        self._lent: LentSlots | None = None
        self._borrowed: BorrowedUses | None = None
        self._known: dict[int, Slot] = {}
        self._is_passed = False
        self._is_over = False
        self.bound_s = 0.0

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
        if value.__class__ is not bytes or len(value) > MOST_INLINE:
            size = size_of(value)
            if size > MOST_INLINE:
                self._send_large(value, size, number)
                return
            value = joined(value)
        head = VALUE if number == NONE else COUNTED + _NUMBER.pack(number)
        try:
            self._send(head + value, _FLAGS)
        except BlockingIOError:
            raise Full(is_memory=False) from None

    def _send_large(self, value: Payload, size: int, number: int) -> None:
        lent = self._lent
        if lent is None:
            lent = self._begin_lending()
        with self._lock:
            ended = lent.ended()
            if len(lent.uses) >= most_held(size) + _IN_TRANSIT:
                self._pool.release(ended)
                raise Full(is_memory=True)
            slot = self._pool.fill(value, size, ended)
            use = lent.lend(slot)
        try:
            self._send_slot(slot, _SLOT.pack(slot.number, use, size, number))
        except BaseException:
            with self._lock:
                is_ours = lent.take_back(use)
            if is_ours:
                self._pool.release([slot])
            raise

    def _begin_lending(self) -> LentSlots:
        with self._lock:
            if self._lent is not None:  # another thread sends, too
                return self._lent
            lent = LentSlots()
            try:
                self._pass(USES, lent.descriptor)
            except BaseException as error:
                lent.close()
                if isinstance(error, BlockingIOError):
                    raise Full(is_memory=False) from None
                raise
            self._lent = lent
            return lent

    def _collect(self, lent: LentSlots) -> None:
        """Take back memory whose uses have ended."""
        with self._lock:
            ended = lent.ended()
        self._pool.release(ended)

    def _send_slot(self, slot: Slot, where: bytes) -> None:
        packet = SLOT + where
        try:
            if slot.number in self._known:
                self._send(packet, _FLAGS)
                return
            for old in [each for each in self._known.values() if each.memory.closed]:
                self._send(FORGET + _INDEX.pack(old.number), _FLAGS)
                del self._known[old.number]
            self._pass(packet, slot.descriptor)
            self._known[slot.number] = slot
        except BlockingIOError:
            raise Full(is_memory=False) from None

    def _pass(self, packet: bytes, descriptor: int) -> None:
        # Told before, so that the other end need not look for descriptors at each packet.
        self._send(PASS, _FLAGS)
        passed = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array("i", [descriptor]))]
        self.connection.sendmsg([packet], passed, _FLAGS)

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
        if not full.is_memory:
            return self._await(select.POLLOUT, until)
        lent = self._lent
        if lent is None:
            return not self._is_over
        before = len(lent.uses)
        lent.await_end(is_awaited=True)
        try:
            while True:
                # The end of a use and this look may just miss each other: no wait is long.
                self._collect(lent)
                if self._is_over or len(lent.uses) < before:
                    return not self._is_over
                if time.monotonic() >= until:
                    return False
                self._await(0, min(until, time.monotonic() + _GLANCE_S))
        finally:
            lent.await_end(is_awaited=False)

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

    def take_back(self) -> None:
        """Take marks that the other end has sent back, and answers that come too late.

        It is for ends that wait for nothing else.
        """
        try:
            while (packet := self.receive(NOW)) is not None:
                _, self.returned, _ = packet
        except BlockingIOError:
            return
        except (OSError, ValueError):
            pass
        self._is_over = True

    # receiving

    def bound(self, timeout_s: float) -> None:
        """Have each wait in `receive` end after so long at most [s]."""
        self.bound_s = timeout_s
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
            if self._is_passed:
                data, passed = self._receive_passed(flags)
            else:
                data, passed = self._receive(_MOST + 1, flags), []
            if not data:
                return None
            if len(data) > _MOST:
                raise ValueError("a packet that is too large")
            kind = data[:1]
            if kind == VALUE:
                return VALUE, NONE, data[1:]
            try:
                packet = self._read(kind, data, passed)
            except (struct.error, LookupError, OverflowError) as error:
                raise ValueError(f"no packet: {error}") from error
            if packet is not None:
                return packet

    def _receive_passed(self, flags: int) -> tuple[bytes, list[int]]:
        """Return the next packet, and the descriptor of a kind that has one."""
        data, passed, *_ = self.connection.recvmsg(_MOST + 1, _ROOM, flags | _CLOEXEC)
        descriptors = take_passed(passed, most=int(data[:1] in (SLOT, USES)))
        self._is_passed = not descriptors
        return data, descriptors

    def _read(self, kind: bytes, data: bytes, passed: list[int]) -> Packet | None:
        if kind == COUNTED:
            (number,) = _NUMBER.unpack_from(data, 1)
            return VALUE, number, data[1 + _NUMBER.size :]
        if kind == SLOT:
            slot, use, size, number = _SLOT.unpack_from(data, 1)
            for descriptor in passed:
                self._seen.learn(slot, descriptor)
            is_new = 0 < use <= MOST and use not in self._in_use
            if size <= MOST_INLINE or self._borrowed is None or not is_new:
                raise ValueError("no value in shared memory")
            is_kept = len(self._in_use) < most_held(size)
            end = partial(self._end_use, self._borrowed, use)
            view, self._in_use[use] = self._seen.view(slot, size, end)
            return VALUE, number, view if is_kept else bytes(view)
        if kind in (LOST, MARK):
            return kind, _NUMBER.unpack_from(data, 1)[0], b""
        if kind == USES:
            (descriptor,) = passed
            self._borrowed = BorrowedUses(descriptor)
        elif kind == PASS:
            self._is_passed = True
        elif kind == FORGET:
            self._seen.forget(*_INDEX.unpack_from(data, 1))
        elif kind != FREE:
            raise ValueError("a packet of no kind")
        return None

    def _end_use(self, borrowed: BorrowedUses, use: int, _: object) -> None:
        """Tell the other end that a value is not used any more; by whichever thread."""
        self._in_use.pop(use, None)
        if borrowed.end(use):
            with suppress(OSError):  # the other end is gone, or looks for itself
                self._send(FREE, _FLAGS)

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
            lent, self._lent = self._lent, None
            left = lent.close() if lent is not None else []
        for slot in left:
            slot.is_spent = True
        self._pool.release(left)
