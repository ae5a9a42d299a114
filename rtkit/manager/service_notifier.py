"""Notifies the service manager (systemd) that started a manager: ready, alive, what it does.

The protocol of ``sd_notify``: datagrams of lines ``KEY=VALUE`` to the socket that the environment
names (decision 58). Ready is said when the manager has answered a question at its own socket, as
a client's; the watchdog hears from the loop alone, so one that is stuck is ended and restarted.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Mapping, MutableMapping

from rtkit.errors import RtkitError
from rtkit.link import unix, zenoh_keys
from rtkit.manager.core.state import ManagerState

SOCKET = "NOTIFY_SOCKET"
_USEC = "WATCHDOG_USEC"
_PID = "WATCHDOG_PID"
_STATUS_S = 5.0
"""Period of the status where nobody watches over heartbeats [s]."""
_ASK_S = 5.0
_SEND_S = 5.0
"""How long the manager may take to answer itself, and its service manager to take READY [s]."""

_log = logging.getLogger(__name__)


class ServiceNotifier:
    """Sends the status of a manager to its service manager; without one it does nothing.

    Args:
        state: Of the manager.
        environment: Its variables are taken out: no other process may send in this one's name.

    Attributes:
        due_at: When `beat` is due, monotonic [s]; None where nobody listens.
        variables: Variables taken out of the environment, for this program when it starts anew.
    """

    def __init__(self, state: ManagerState, environment: MutableMapping[str, str]) -> None:
        names = (SOCKET, _USEC, _PID)
        self.variables = {name: environment.pop(name) for name in names if name in environment}
        self._state = state
        self._address = self.variables.get(SOCKET, "")
        self._period_s, self._has_watchdog = _period(self.variables)
        self.due_at = time.monotonic() if self._address else None
        self._last_status = ""
        self._is_warned = False
        self._closing = threading.Event()

    def ready(self) -> None:
        """Have READY sent as soon as the manager answers at its own socket."""
        if self._address:
            threading.Thread(target=self._ask, name="readiness", daemon=True).start()

    def beat(self) -> None:
        """Send a heartbeat, with the status where it has changed; call it from the loop only."""
        self.due_at = time.monotonic() + self._period_s
        status = status_text(self._state)
        lines = ["WATCHDOG=1"] if self._has_watchdog else []
        if status != self._last_status and not self._closing.is_set():
            lines.append(f"STATUS={status}")
        if lines and self._send(lines):
            self._last_status = status

    def end(self, *, is_restart: bool) -> None:
        """Send that the manager ends, or that it starts anew in the same process."""
        if not self._address or self._closing.is_set():
            return
        self._closing.set()
        if is_restart:
            now_us = time.clock_gettime_ns(time.CLOCK_MONOTONIC) // 1000
            self._send(["RELOADING=1", f"MONOTONIC_USEC={now_us}", "STATUS=starts anew"])
        else:
            self._send(["STOPPING=1", "STATUS=ends its components and slaves"])

    def _ask(self) -> None:
        while not self._closing.is_set():
            try:
                _ask_itself(self._state)
            except RtkitError as error:
                _log.warning("the manager does not answer at its own socket: %s", error)
                self._closing.wait(1.0)
                continue
            if not self._closing.is_set():
                lines = ["READY=1", f"STATUS={status_text(self._state)}"]
                self._send([*lines, f"MAINPID={os.getpid()}"], _SEND_S)
            return

    def _send(self, lines: list[str], wait_s: float = 0.0) -> bool:
        """Send a datagram; return whether it was taken. The loop never waits for that."""
        try:
            unix.send_datagram(self._address, "\n".join(lines).encode(), wait_s)
        except OSError as error:
            if not self._is_warned:
                _log.warning("the service manager cannot be told %s: %s", lines[0], error)
            self._is_warned = True
            return False
        self._is_warned = False
        return True


def status_text(state: ManagerState) -> str:
    """Return what a manager holds in one line: ``3 components (1 zombie), 2 slaves``."""
    from rtkit.report.finding import counted

    facts = list(state.components.values())
    zombies = sum(bool(each.zombie) for each in facts)
    alive = [each for each in list(state.processes.values()) if each.is_slave and each.is_alive]
    slaves = sum(not state.is_leaving(each) for each in alive)
    lost = f" ({counted(zombies, 'zombie')})" if zombies else ""
    return f"{counted(len(facts), 'component')}{lost}, {counted(slaves, 'slave')}"


def _period(variables: Mapping[str, str]) -> tuple[float, bool]:
    """Return the period of what is sent [s], and whether heartbeats are awaited from here.

    They are sent three times as often, so that a late one does no harm.
    """
    usec = variables.get(_USEC, "")
    is_mine = variables.get(_PID, "") in ("", str(os.getpid()))
    if not usec.isdecimal() or not int(usec) or not is_mine:
        return _STATUS_S, False
    return int(usec) / 3e6, True


def _ask_itself(state: ManagerState) -> None:
    """Ask the manager for its pid, as a client does.

    Raises:
        RtkitError: It does not answer in time.
    """
    from rtkit.link.requests.manager_link import open_link

    link = open_link(state.name, state.host, _ASK_S)
    try:
        key = zenoh_keys.property_key(zenoh_keys.service(state.host, state.name), "manager.pid")
        link.call(key, None, _ASK_S).value()
    finally:
        link.close()
