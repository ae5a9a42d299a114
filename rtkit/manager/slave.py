"""A slave: one process of components, told what to do by its manager over a private socket."""

from __future__ import annotations

import logging
import os
import select
import signal
import socket
import sys
import threading
from typing import Any

from rtkit.link.streams import Streams
from rtkit.manager.connect import Wires
from rtkit.manager.holder import Holder
from rtkit.manager.leftovers import MARK, end_session
from rtkit.manager.loader import Loader
from rtkit.manager.wire import Channel

PROTOCOL = 1
"""Version of the messages between manager and slaves."""

LAST_S = 5
"""Grace that components have to finalise when no manager is left that would end them [s]."""


def run(key: int, name: str, settings: Any) -> None:
    """Hold components until the manager says stop, goes away, or a TERM arrives.

    Args:
        key: Under which the manager knows this process.
        name: Name of the slave.
        settings: ``control`` and ``data`` (socket paths), ``host``, ``load_path``.
    """
    logging.basicConfig(
        stream=sys.stderr,
        level=logging.INFO,
        format=f"%(asctime)s {name} %(levelname)s %(name)s: %(message)s",
    )
    os.environ[MARK] = str(os.getpid())
    with open("/proc/self/comm", "w", encoding="utf-8") as comm:
        comm.write(f"rtkit {name}")
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(settings["control"])
    channel = Channel(connection)
    data = settings["data"].replace("%p", str(os.getpid()))
    holder = Holder(
        _Voice(channel).send,
        Wires(settings["host"], Streams(data)),
        Loader(list(settings["load_path"])),
    )
    wake = _catch_term()
    channel.send({"hello": key, "pid": os.getpid(), "protocol": PROTOCOL})
    threading.Thread(
        target=_listen, args=(channel, wake, holder), name="control", daemon=True
    ).start()
    holder.run()
    end_session(os.getpid())
    logging.shutdown()
    sys.stdout.flush()


class _Voice:
    """Sends to the manager; when it is gone there is nobody to tell, and the slave ends."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel

    def send(self, message: Any) -> None:
        try:
            self._channel.send(message)
        except OSError as error:
            logging.getLogger(__name__).warning("cannot reach the manager: %s", error)


def _catch_term() -> int:
    """Return a descriptor that turns readable at a TERM, whichever thread the kernel gives it to.

    A handler alone would run only when the main thread next leaves a wait of its own.
    """
    read, write = os.pipe()
    for descriptor in (read, write):
        os.set_blocking(descriptor, False)
    signal.signal(signal.SIGTERM, lambda *_: None)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    return read


def _listen(channel: Channel, wake: int, holder: Holder) -> None:
    try:
        while _pass_on(channel, wake, holder):
            pass
    finally:
        holder.close()
        signal.alarm(LAST_S)  # ends the process, also one in which a component hangs


def _pass_on(channel: Channel, wake: int, holder: Holder) -> bool:
    """Hand the next messages to the holder; False when it is time to end."""
    sources: list[Any] = [channel, wake]
    ready: list[object] = select.select(sources, [], [])[0]
    if wake in ready and signal.SIGTERM in os.read(wake, 4096):
        return False
    if channel in ready:
        messages = channel.receive()
        if messages is None:
            return False
        for message in messages:
            holder.put(message)
    return True
