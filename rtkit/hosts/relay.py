"""Far end of a link: splices its own input and output with the socket of a manager.

It runs on the other host, started over SSH: ``python -m rtkit.hosts.relay MANAGER [PID]``. Its
first lines are its own id and `READY`, or why there is nothing to splice; from then on bytes pass
as they are.

With the id of the relay of the same link before, it ends that first. Where a network was away for
seconds, the router here may take that one for alive while the next one joins; once it noticed, it
has forgotten for good who answers at the other end (decision 98).
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress

from rtkit.errors import RtkitError
from rtkit.link import places, running, unix
from rtkit.link.host_links import SETTLE_S
from rtkit.link.processes import ProcessWatch
from rtkit.link.threads import start_thread

READY = "rtkit-relay 1"
_CHUNK = 1 << 16
_END_S = 1.0
"""How long the relay before may take to end [s]."""
_MODULE = b"rtkit.hosts.relay"


def main() -> int:
    """Be the process."""
    name = sys.argv[1] if len(sys.argv) > 1 else places.DEFAULT_MANAGER
    places.keep_runtime_folder()
    if len(sys.argv) > 2 and sys.argv[2].isdecimal() and end_relay(int(sys.argv[2])):
        time.sleep(SETTLE_S)
    try:
        if places.owner(name) is None:
            raise ConnectionError(running.why_absent(name, places.host_name()))
        near = unix.connect(places.manager_socket(name))
    except (OSError, RtkitError) as error:
        print(" ".join(str(error).split()), flush=True)
        return 1
    print("", os.getpid(), READY, sep="\n", flush=True)

    def inward() -> None:
        pump(lambda: os.read(0, _CHUNK), near.sendall)
        os._exit(0)  # its connection has ended: nobody is left to pass anything to

    start_thread(inward, "inward")
    pump(lambda: near.recv(_CHUNK), _write)
    return 0


def end_relay(pid: int) -> bool:
    """End a relay, wait for that, and return whether it was one.

    Any other process that has its id by now is left alone.
    """
    with suppress(OSError), ProcessWatch(pid) as relay:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            is_relay = _MODULE in file.read().split(b"\0")
        if is_relay:
            relay.send(signal.SIGTERM)
            relay.await_end(_END_S)
        return is_relay
    return False


def pump(read: Callable[[], bytes], write: Callable[[bytes], object]) -> None:
    """Pass bytes until their source ends, or their sink."""
    with suppress(OSError):
        while data := read():
            write(data)


def _write(data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(1, view) :]


if __name__ == "__main__":
    os._exit(main())  # the other thread waits for input that may never come
