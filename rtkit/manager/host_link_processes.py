"""Supervises the processes of links to other hosts: one a link, another one when it ends."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress

from rtkit.errors import RtkitError, Unreachable
from rtkit.link import host_links
from rtkit.link.host_links import HostLink
from rtkit.link.processes import ProcessWatch
from rtkit.manager.child_process import Backoff, exit_reason
from rtkit.manager.core.state import ManagerState

_log = logging.getLogger(__name__)
_MODULE = "rtkit.hosts.link_process"
_END_S = 2.0


class HostLinkProcesses:
    """Processes of links; called on the loop, except the threads of its own.

    Args:
        state: Of the manager whose links they are.
    """

    def __init__(self, state: ManagerState) -> None:
        self._state = state
        self._links: dict[str, _LinkProcess] = {}

    def sync(self) -> None:
        """Have the links to the hosts that are desired, and no others."""
        self._have(self._state.kept.hosts)

    def _have(self, wanted: Mapping[str, str]) -> None:
        for name, link in [*self._links.items()]:
            if wanted.get(name) != link.text:
                self._links.pop(name).close()
        for name, text in wanted.items():
            if name not in self._links:
                self._links[name] = _LinkProcess(self._state.name, name, text)
            else:
                self._links[name].hasten()
        for name in host_links.hosts():
            with suppress(Unreachable):  # of one whose manager and process were killed
                if name not in wanted and host_links.read(name).manager == self._state.name:
                    host_links.remove(name)

    def close(self) -> None:
        """End all."""
        self._have({})


class _LinkProcess:
    """Process of one link."""

    def __init__(self, manager: str, name: str, text: str) -> None:
        self.text = text
        self._state = HostLink(name, manager, "", "not linked yet")
        self._closing = threading.Event()
        self._watch: ProcessWatch | None = None
        host_links.write(self._state)
        self._thread = threading.Thread(target=self._run, args=(manager, text), daemon=True)
        self._thread.start()

    def _run(self, manager: str, text: str) -> None:
        backoff = Backoff()
        name = self._state.host
        while not self._closing.is_set():
            backoff.begin(time.monotonic())
            arguments = [sys.executable, "-P", "-m", _MODULE, manager, text]
            pid = os.posix_spawn(sys.executable, arguments, os.environ)
            self._watch = ProcessWatch(pid)
            if self._closing.is_set():
                self._watch.send(signal.SIGKILL)
            how = _reap(pid)
            if not self._closing.is_set():
                why = f"the process of the link ended: {how}"
                _log.error("host %s: %s", name, why)
                with suppress(RtkitError):
                    host_links.write(self._state._replace(why=why))
                self._closing.wait(backoff.end(time.monotonic()))
        host_links.remove(name)

    def hasten(self) -> None:
        """Have it try at once, if it waits."""
        if self._watch is not None:
            self._watch.send(signal.SIGCONT)

    def close(self) -> None:
        """End it."""
        self._closing.set()
        if self._watch is not None:
            self._watch.send(signal.SIGKILL)
        self._thread.join(_END_S)


def _reap(pid: int) -> str:
    try:
        report = os.waitid(os.P_PID, pid, os.WEXITED)
    except ChildProcessError:  # another thread has waited for all children
        report = None
    return exit_reason(report) if report is not None else "exit status unknown"
