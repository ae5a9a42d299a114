"""A slave: one process of components, told what to do by its manager over a private socket.

It outlives its manager (see `rtkit.manager.processes.contact`) and ends when one tells it to.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import threading
from typing import Any

from rtkit.link.streams import Streams
from rtkit.manager.holding.beats import Beats
from rtkit.manager.holding.connect import Wires
from rtkit.manager.holding.holder import Holder
from rtkit.manager.logs.logs import open_log
from rtkit.manager.modules.loader import Loader
from rtkit.manager.processes.contact import Contact, Term
from rtkit.manager.processes.leftovers import MARK, end_sessions
from rtkit.manager.processes.watchman import STACK_SIGNAL, beats_path, stack_path

LAST_S = 5
"""Grace that components have to finalise after a TERM, if nobody sends a KILL before [s]."""


def run(key: int, name: str, settings: Any) -> None:
    """Hold components until a TERM arrives.

    Args:
        key: Under which the manager knows this process.
        name: Name of the slave.
        settings: ``manager``, ``control`` and ``data`` (socket paths), ``host``, ``load_path``,
            ``is_shown`` (the log goes to the terminal too).
    """
    with open_log(settings["manager"], name, is_shown=settings["is_shown"]):
        _hold(key, name, settings)


def _hold(key: int, name: str, settings: Any) -> None:
    os.environ[MARK] = str(os.getpid())
    with open("/proc/self/comm", "w", encoding="utf-8") as comm:
        comm.write(f"rtkit {name}")
    contact = Contact(settings["control"], name, Term())
    data = settings["data"].replace("%p", str(os.getpid()))
    beats = Beats(beats_path(settings["data"], os.getpid()))
    stack = open(stack_path(settings["data"], os.getpid()), "a")  # noqa: SIM115 - open for life
    faulthandler.register(STACK_SIGNAL, stack, all_threads=True)
    holder = Holder(
        contact.send,
        Wires(settings["host"], Streams(data)),
        Loader(list(settings["load_path"])),
        beats,
    )
    contact.greet(key)
    threading.Thread(target=_listen, args=(contact, holder), name="control", daemon=True).start()
    holder.run()
    if contact.is_alone:
        end_sessions({os.getpid()})  # a manager would do it


def _listen(contact: Contact, holder: Holder) -> None:
    try:
        contact.listen(holder)
    finally:
        holder.close()
        signal.alarm(LAST_S)  # ends the process, also one in which a component hangs
