"""Keeps a manager that is no master registered with its master, on a thread of its own."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from rtkit.errors import RtkitError, Unreachable
from rtkit.link import secret, tcp_endpoint, zenoh_keys
from rtkit.link.zenoh import ZenohLink
from rtkit.rtc.manager_address import Address

_TIMEOUT_S = 2.0
_log = logging.getLogger(__name__)


class Registrar:
    """Registers `name` with the master at an address: at once, then each interval [s].

    `found` is called once it worked for the first time.
    """

    def __init__(
        self, master: Address, name: str, interval_s: float, found: Callable[[], object]
    ) -> None:
        self._master = master
        self._name = name
        self._interval_s = interval_s
        self._found = found
        self._is_registered = False
        self._is_warned = False
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="registrar", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Take the manager off its master again."""
        self._closed.set()
        self._thread.join()
        if self._is_registered:
            self._try("remove_slave_manager")

    def _run(self) -> None:
        while True:
            if self._try("add_slave_manager") and not self._is_registered:
                self._is_registered = True
                self._found()
            if not self._interval_s or self._closed.wait(self._interval_s):
                return

    def _try(self, operation: str) -> bool:
        try:
            self._ask(operation)
        except RtkitError as error:
            if not self._is_warned:
                _log.warning("cannot reach the master at %s: %s", self._master, error)
                self._is_warned = True
            return False
        self._is_warned = False
        return True

    def _ask(self, operation: str) -> None:
        try:
            session = tcp_endpoint.log_in(self._master.port, secret.read(), _TIMEOUT_S)
        except Unreachable as error:
            raise Unreachable(f"no manager of this user listens at {self._master}") from error
        link = ZenohLink(session)
        try:
            master = tcp_endpoint.ask_identity(session, _TIMEOUT_S)
            service = zenoh_keys.service(master.host, master.manager)
            link.call(zenoh_keys.property_key(service, operation), self._name, _TIMEOUT_S).value()
        finally:
            link.close()
