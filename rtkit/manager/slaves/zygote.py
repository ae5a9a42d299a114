"""The fork server: imports what slaves need, opens nothing, forks on request.

It is started by exec before the manager opens any session, has one thread, and sends the manager
what the kernel reports of its children: exit, stop, continue. It outlives the manager as long as
it has children, so that the next one receives their end too.

See decisions 2 and 49.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import contextlib
import gc
import importlib
import json
import logging
import os
import selectors
import signal
import socket
import sys
import threading
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn

from rtkit import fault
from rtkit.container.control_channel import ControlChannel
from rtkit.container.orphans import become_subreaper, end_orphans
from rtkit.container.slave import Slave
from rtkit.deployment.message import Message
from rtkit.link import unix
from rtkit.link.places import of_pid
from rtkit.logs.logs import Log, share_log
from rtkit.manager.child_process import ENDS, STOPS, exit_reason
from rtkit.manager.slaves.code_together import put_together
from rtkit.manager.slaves.warm_up import fill_gaps, warm_up

_OPTIONS = os.WEXITED | os.WSTOPPED | os.WCONTINUED | os.WNOHANG
AHEAD = (
    "rtkit.component.collisions", "rtkit.component.composite", "rtkit.component.fsm",
    "rtkit.component.timed", "rtkit.deployment.listing", "rtkit.link.running",
    "rtkit.container.metrics", "rtkit.component.values.fields", "rtkit.component.values.value_text",
    "rtkit.settings.values", "rtkit.container.terminals", "rtkit.link.requests.manager_link",
    "encodings.ascii",
)  # fmt: skip
"""Lazy imports of a container, which attached processes need not have: loaded before any fork,
so that slaves share it."""

_AT_LEISURE = ("rtkit.component.geometry", "rtkit.component.timed")
"""Data types of most components, made while nobody asks for a slave, so that slaves share them."""

_REHEARSALS = 8
"""Python fits byte code to what it met when it has run eight times."""

_log = logging.getLogger(__name__)


class Zygote:
    """Serves one manager after the other; ends when it has neither a manager nor children.

    Between two managers it keeps the reports of its children. It listens at a path of its own from
    the start, so that the next manager finds it however slowly it notices the end of the last one.

    Args:
        channel: To the first manager.
        settings: Of slaves (see `rtkit.container.slave`), and ``zygote``, the path.
        log: Its log.
    """

    def __init__(self, channel: ControlChannel, settings: Any, log: Log) -> None:
        self._channel: ControlChannel | None = channel
        self._settings = settings
        self._log = log
        self._slave = Slave(settings, log)
        self._path = of_pid(settings["zygote"], os.getpid())
        self._listener = unix.listen(self._path)
        self._children: dict[int, str] = {}
        self._reports: list[Message] = []
        self._filling: list[bytes] = []
        self._selector = selectors.DefaultSelector()
        self._wake, self._wake_write = os.pipe()
        for descriptor in (self._wake, self._wake_write):
            os.set_blocking(descriptor, False)
        self._selector.register(channel, selectors.EVENT_READ, self._receive)
        self._selector.register(self._wake, selectors.EVENT_READ, self._reap)

    def run(self) -> None:
        """Work until there is nothing left to do."""
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.set_wakeup_fd(self._wake_write, warn_on_full_buffer=False)
        for name in AHEAD:
            importlib.import_module(name)
        gc.freeze()  # decision 49: a slave's collector would copy each page that it looks through
        self._report({"ready": os.getpid()})
        later: list[Callable[[], object]] = [self._warm_up] * _REHEARSALS
        # Code that runs only the first time need not lie with what each slave runs.
        later += [partial(put_together, self._warm_up), self._warm_up]
        later += [partial(_make_types, name) for name in _AT_LEISURE]
        later.insert(0, self._pack)  # last of all
        later.append(become_subreaper)  # first
        while self._channel is not None or self._children:
            ready = self._selector.select(0 if later else None)
            if not ready and later:
                later.pop()()
                gc.freeze()
            for key, _ in ready:
                key.data()
        self._listener.close()
        with contextlib.suppress(FileNotFoundError):  # a manager found nobody behind it
            os.unlink(self._path)

    def _pack(self) -> None:
        self._filling = fill_gaps()

    def _warm_up(self) -> None:
        try:
            with fault.unheeded():
                warm_up(self._log, self._settings)
        except Exception:  # slaves are forked all the same
            _log.exception("cannot rehearse")
        gc.collect()

    def _receive(self) -> None:
        channel = self._channel
        messages = channel.receive() if channel is not None else None
        if channel is not None and messages is None:
            self._selector.unregister(channel)
            channel.close()
            self._channel = None
            fault.point("zygote.alone")
            self._selector.register(self._listener, selectors.EVENT_READ, self._accept)
            fault.point("zygote.listening")
        for message in messages or ():
            self._fork(message)

    def _accept(self) -> None:
        connection, _ = self._listener.accept()
        self._selector.unregister(self._listener)
        self._channel = ControlChannel(connection)
        self._selector.register(self._channel, selectors.EVENT_READ, self._receive)
        kept, self._reports = self._reports, []
        for report in kept:
            self._report(report)
        fault.point("zygote.accepted")
        # Last: who is no child any more has been reported, so the manager waits for no more.
        children = sorted(self._children)
        self._report({"children": children, "names": self._children, "zygote": os.getpid()})

    def _report(self, message: Message) -> None:
        """Report to the manager; keep an end for the next one where there is none any more.

        Only ends: keys of the last manager mean others to the next.
        """
        if self._channel is not None:
            with contextlib.suppress(OSError):  # `_receive` notices that it is gone
                self._channel.send(message)
                return
        if "ended" in message:
            self._reports.append(message)

    def _import_ahead(self, names: list[str]) -> None:
        """Import what slaves from now on have in common, so that none does it by itself."""
        for name in names:
            try:
                importlib.import_module(name)
            except Exception:  # slaves are forked all the same
                _log.exception("cannot import %s", name)
        gc.collect()
        gc.freeze()

    def _fork(self, message: Message) -> None:
        key = message["key"]
        fault.point("zygote.asked")
        new = [name for name in message["ahead"] if name not in sys.modules]
        if new:
            self._import_ahead(new)
        try:
            pid = _forked()
        except OSError as error:
            self._report({"failed": key, "reason": f"cannot fork: {error.strerror}"})
            return
        if pid:
            self._children[pid] = message["name"].replace("%p", str(pid))
            fault.point("zygote.forked")
            self._report({"forked": key, "pid": pid})
            fault.point("zygote.told")
        else:
            self._become_slave(key, message)

    def _become_slave(self, key: int, message: Message) -> NoReturn:
        try:
            signal.set_wakeup_fd(-1)
            _signal.signal(signal.SIGCHLD, _signal.SIG_DFL)  # as in `rtkit.container.slave`
            if self._channel is not None:
                self._channel.close()
            self._listener.close()
            for descriptor in (self._selector.fileno(), self._wake, self._wake_write):
                os.close(descriptor)
            self._slave.live(key, message["name"].replace("%p", str(os.getpid())))
        except BaseException:
            sys.excepthook(*sys.exc_info())  # the only place left to report it: the log on stderr
            os._exit(1)
        os._exit(0)

    def _reap(self) -> None:
        os.read(self._wake, 4096)
        while True:
            try:
                report = os.waitid(os.P_ALL, 0, _OPTIONS)
            except ChildProcessError:
                return
            if report is None:
                return
            fault.point("zygote.reaped")
            if report.si_code in ENDS:
                name = self._children.pop(report.si_pid, None)
                self._end_orphans(name)
                if name is not None:
                    self._report({"ended": report.si_pid, "reason": exit_reason(report)})
            elif report.si_pid in self._children:
                self._report({"halted": report.si_pid, "is_halted": report.si_code in STOPS})

    def _end_orphans(self, name: str | None) -> None:
        """End what a slave that ended left behind, and then what that left: it has come to us."""
        for pid, what in end_orphans(self._children):
            whose = f"slave {name}" if name is not None else "it"
            _log.warning("%s (pid %d) is ended: %s had left it behind", what, pid, whose)


def _make_types(module: str) -> None:
    family = importlib.import_module(module)
    for name in family.__all__:
        getattr(family, name)


def _forked() -> int:
    """Fork, in a process with one thread.

    After a fork `threading` looks for ended threads in a set of weak references, which touches
    180 kB of the child's memory (decision 49); there is none here.
    """
    module: Any = threading
    ended, module._dangling = module._dangling, set()  # noqa: SLF001
    try:
        return os.fork()
    finally:
        module._dangling = ended  # noqa: SLF001


def main() -> None:
    """Serve the socket of that descriptor; later managers find it at the path of its pid."""
    os.setsid()
    settings = json.loads(sys.argv[2])
    log = share_log(settings["manager"], "zygote", is_shown=settings["is_shown"])
    Zygote(ControlChannel(socket.socket(fileno=int(sys.argv[1]))), settings, log).run()
    os._exit(0)


if __name__ == "__main__":
    main()
