"""A slave: one process of components, told what to do by its manager over a private socket.

It outlives its manager (see `rtkit.manager.processes.contact`) and ends when one tells it to.
"""

from __future__ import annotations

import _thread
import contextlib
import faulthandler
import os
import signal
from collections.abc import Callable
from typing import Any

from rtkit import fault
from rtkit.link.streams import Streams
from rtkit.manager.core.message import Message
from rtkit.manager.holding.beats import Beats, beats_path
from rtkit.manager.holding.connect import Wires
from rtkit.manager.holding.estate import Will, estate_path
from rtkit.manager.holding.holder import Holder
from rtkit.manager.holding.maker import Maker
from rtkit.manager.logs.logs import Log, hand_over
from rtkit.manager.modules.loader import Loader
from rtkit.manager.processes.contact import Contact
from rtkit.manager.processes.leftovers import MARK, Adopted, end_children
from rtkit.manager.processes.stacks import ASK, STACK_SIGNAL, open_stacks, write_stacks
from rtkit.manager.processes.subreaper import become_subreaper
from rtkit.manager.processes.term import Term

LAST_S = 5
"""Grace that components have to finalise after a TERM, if nobody sends a KILL before [s]."""


class Slave:
    """A slave that is not born yet: what does not depend on which one it is to be.

    The zygote has one, and every fork is a copy of it: what is made here costs time once, and
    memory once for all of them.

    Args:
        settings: ``manager``, ``control`` and ``data`` (socket paths), ``host``, ``load_path``.
        log: Of the zygote, which becomes that of the slave.
    """

    def __init__(self, settings: Any, log: Log) -> None:
        self._settings = settings
        self._log = log
        self._contact: Contact
        self._stacks: int
        wires = Wires(settings["host"], Streams(settings["data"]))
        self._holder = Holder(self._send, wires, Maker(Loader(list(settings["load_path"]))))

    def live(self, key: int, name: str) -> None:
        """Hold components until a TERM arrives; called once, after the fork.

        Args:
            key: Under which the manager knows this process.
            name: Name of the slave.
        """
        with hand_over(self._log, self._settings["manager"], name):
            self._hold(key, name)

    def _hold(self, key: int, name: str) -> None:
        pid, data = os.getpid(), self._settings["data"]
        os.environ[MARK] = str(pid)
        fault.point("slave.begun")
        _name_process(f"rtkit {name}")
        self._contact = contact = Contact(
            self._settings["control"], name, Term(), at_leisure=Adopted().look
        )
        self._holder.show_beats(Beats(beats_path(data, pid)))
        self._holder.write_down(Will(estate_path(data, pid), name))
        self._stacks = open_stacks(data, pid)
        faulthandler.register(STACK_SIGNAL, self._stacks, all_threads=True)
        fault.point("slave.greeting")
        contact.greet(key, self._settings["born_of"])
        os.setsid()  # until now it was to end with its zygote
        become_subreaper()
        fault.point("slave.greeted")
        # One of `threading` touches 50 kB more, and waits until the other thread had its turn.
        _thread.start_new_thread(self._listen, ())
        self._holder.run()
        fault.point("slave.holds_nothing")
        end_children()

    def put(self, message: Message) -> None:
        """Take a message of the manager, on the thread that hears it."""
        if message.get("op") == ASK:
            with contextlib.suppress(OSError):  # a component has closed the file
                write_stacks(self._stacks)
        else:
            self._holder.put(message)

    def tell_all(self, tell: Callable[[Message], object]) -> None:
        """Call `tell` with everything that is held."""
        self._holder.tell_all(tell)

    def _send(self, message: Message) -> None:
        self._contact.send(message)

    def _listen(self) -> None:
        try:
            self._contact.listen(self)
        finally:
            fault.point("slave.told_to_end")
            self._holder.close()
            signal.alarm(LAST_S)  # ends the process, also one in which a component hangs


def _name_process(name: str) -> None:
    descriptor = os.open("/proc/self/comm", os.O_WRONLY)
    try:
        os.write(descriptor, name.encode("utf-8", "replace"))
    finally:
        os.close(descriptor)
