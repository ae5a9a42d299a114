"""The fork server: imports what slaves need, opens nothing, forks on request.

It is started by exec before the manager opens any session, has one thread, and tells the manager
what the kernel reports of its children: exit, stop, continue.
"""

from __future__ import annotations

import gc
import importlib
import os
import selectors
import signal
import socket
import sys
from typing import Any, NoReturn

from rtkit.manager import slave
from rtkit.manager.wire import Channel

_OPTIONS = os.WEXITED | os.WSTOPPED | os.WCONTINUED | os.WNOHANG
STOPS = (os.CLD_STOPPED, os.CLD_TRAPPED)
ENDS = (os.CLD_EXITED, os.CLD_KILLED, os.CLD_DUMPED)
_AT_LEISURE = ("rtkit.component.geometry",)
"""What most components import and what takes long: had in memory once nobody asks for a slave."""


def main() -> NoReturn:
    """Serve the socket whose descriptor is the first argument until the manager closes it."""
    channel = Channel(socket.socket(fileno=int(sys.argv[1])))
    wake_read, wake_write = os.pipe()
    for descriptor in (wake_read, wake_write):
        os.set_blocking(descriptor, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.set_wakeup_fd(wake_write, warn_on_full_buffer=False)
    gc.freeze()
    selector = selectors.DefaultSelector()
    selector.register(channel, selectors.EVENT_READ)
    selector.register(wake_read, selectors.EVENT_READ)
    later = list(_AT_LEISURE)
    while True:
        ready = selector.select(0 if later else None)
        if not ready and later:
            importlib.import_module(later.pop())
            gc.freeze()
        for key, _ in ready:
            if key.fd == wake_read:
                os.read(wake_read, 4096)
                _report(channel)
                continue
            messages = channel.receive()
            if messages is None:
                os._exit(0)
            for message in messages:
                _fork(channel, message, (selector.fileno(), wake_read, wake_write))


def _fork(channel: Channel, message: Any, inherited: tuple[int, ...]) -> None:
    key = message["key"]
    try:
        pid = os.fork()
    except OSError as error:
        channel.send({"failed": key, "reason": f"cannot fork: {error.strerror}"})
        return
    if pid:
        channel.send({"forked": key, "pid": pid})
        return
    try:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        os.setsid()
        channel.close()
        for descriptor in inherited:
            os.close(descriptor)
        slave.run(key, message["name"].replace("%p", str(os.getpid())), message)
    except BaseException:
        sys.excepthook(*sys.exc_info())  # the only place left to tell it: the log on stderr
        os._exit(1)
    os._exit(0)


def _report(channel: Channel) -> None:
    while True:
        try:
            report = os.waitid(os.P_ALL, 0, _OPTIONS)
        except ChildProcessError:
            return
        if report is None:
            return
        if report.si_code in ENDS:
            channel.send({"ended": report.si_pid, "reason": reason(report)})
        else:
            channel.send({"halted": report.si_pid, "is_halted": report.si_code in STOPS})


def reason(report: os.waitid_result) -> str:
    """Return how a process ended: ``signal 9`` or ``exit status 3``."""
    if report.si_code == os.CLD_EXITED:
        return f"exit status {report.si_status}"
    return f"signal {report.si_status}"


if __name__ == "__main__":
    main()
