"""Far end of a link: splices its own input and output with the socket of a manager.

It runs on the other host, started over SSH: ``python -m rtkit.hosts.relay MANAGER``. Its first line
is `READY`, or why there is nothing to splice; from then on bytes pass as they are.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress

from rtkit.errors import RtkitError
from rtkit.link import places, running, unix
from rtkit.link.threads import start_thread

READY = "rtkit-relay 1"
_CHUNK = 1 << 16


def main() -> int:
    """Be the process."""
    name = sys.argv[1] if len(sys.argv) > 1 else places.DEFAULT_MANAGER
    places.keep_runtime_folder()
    try:
        if places.owner(name) is None:
            raise ConnectionError(running.why_absent(name, places.host_name()))
        near = unix.connect(places.manager_socket(name))
    except (OSError, RtkitError) as error:
        print(" ".join(str(error).split()), flush=True)
        return 1
    print(READY, flush=True)

    def inward() -> None:
        pump(lambda: os.read(0, _CHUNK), near.sendall)
        os._exit(0)  # its connection has ended: nobody is left to pass anything to

    start_thread(inward, "inward")
    pump(lambda: near.recv(_CHUNK), _write)
    return 0


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
