"""A network link that loses and delays packets, as kernels without netem cannot.

Both its ends are devices of the kernel, and a thread of the test passes packets between them: what
is lost is lost below TCP, which sends it again.
"""

from __future__ import annotations

import fcntl
import heapq
import itertools
import os
import random
import select
import struct
import threading
from contextlib import suppress
from time import monotonic

_TUN, _NO_HEADER, _SET = 0x0001, 0x1000, 0x400454CA
_LONGEST = 1 << 16
_QUEUE = 1000
"""Packets on the way, above which more are lost, as in any router."""


class LossyLink:
    """Two devices, and what passes between them.

    Args:
        names: Of the devices.
        seed: The same seed loses the same packets, one after the other.

    Attributes:
        loss: How many of all packets are lost, in each direction.
        delay_s: How long each takes, in each direction [s].
        is_cut: Whether all are lost.
        mute_until: Until when all are lost that carry data from the far end [s, monotonic]; what
            acknowledges data passes.
        lost: How many have been.
    """

    def __init__(self, names: tuple[str, str], seed: int = 1) -> None:
        self.loss, self.delay_s, self.is_cut, self.lost = 0.0, 0.0, False, 0
        self.mute_until = 0.0
        self._random = random.Random(seed)
        self._ends = [_device(name) for name in names]
        self._ended, self._wakes = os.pipe()
        self._thread = threading.Thread(target=self._run, name="lossy link", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Have neither device any longer."""
        os.close(self._wakes)
        self._thread.join()
        for each in (*self._ends, self._ended):
            os.close(each)

    def _run(self) -> None:
        waiting: list[tuple[float, int, int, bytes]] = []
        count = itertools.count()
        poll = select.poll()
        for end in (*self._ends, self._ended):
            poll.register(end, select.POLLIN)
        while True:
            wait_s = max(0.0, waiting[0][0] - monotonic()) if waiting else None
            for ready, _ in poll.poll(None if wait_s is None else wait_s * 1000):
                if ready == self._ended:
                    return
                with suppress(OSError):  # a device that is down
                    packet = os.read(ready, _LONGEST)
                    is_mute = ready == self._ends[1] and monotonic() < self.mute_until
                    is_muted = is_mute and _has_data(packet)
                    if self._passes(len(waiting), is_muted=is_muted):
                        (other,) = (each for each in self._ends if each != ready)
                        at = monotonic() + self.delay_s
                        heapq.heappush(waiting, (at, next(count), other, packet))
            while waiting and waiting[0][0] <= monotonic():
                with suppress(OSError):
                    os.write(waiting[0][2], waiting[0][3])
                heapq.heappop(waiting)

    def _passes(self, waiting: int, *, is_muted: bool) -> bool:
        is_lost = self.is_cut or self._random.random() < self.loss or waiting >= _QUEUE or is_muted
        self.lost += is_lost
        return not is_lost


def _has_data(packet: bytes) -> bool:
    """Return whether there is more in a packet of TCP, over IPv4, than its heads."""
    head = 4 * (packet[0] & 0xF)
    return len(packet) > head + 4 * (packet[head + 12] >> 4)


def _device(name: str) -> int:
    """Make a device whose packets this process reads and writes."""
    end = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(end, _SET, struct.pack("16sH", name.encode(), _TUN | _NO_HEADER))
    return end
