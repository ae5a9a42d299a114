"""Links of a machine to the services that it reads and sets, each with a thread of its own.

A service that is dead or slow holds up nothing but what is sent to itself.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import rtkit
from rtkit.services.statemachine.expressions import VARIABLES
from rtkit.services.statemachine.interpreter import MachineEvent, OutgoingSet

_MOST_WAITING = 100
_RETRY_S = 0.5
_AFTER_NAME = ("", ".", "/", "?")
_QUEUE = 1000
"""Changes of a property that may wait; enough for what comes while the machine is edited."""


class ServiceNames:
    """Short names that a machine has for services, or for what several of them begin with.

    Args:
        text: ``NAME=SERVICE`` each, with blanks between.

    Raises:
        PropertyError: ``bad-value``: a word is no such pair, or a name stands there twice.
    """

    def __init__(self, text: str) -> None:
        self._services: dict[str, str] = {}
        for word in text.split():
            name, _, service = word.partition("=")
            if not (name and service):
                raise rtkit.PropertyError("bad-value", f"names: expected NAME=SERVICE: {word}")
            if self._services.setdefault(name, service) != service:
                raise rtkit.PropertyError("bad-value", f"names: {name} stands for two services")

    def resolved(self, target: str) -> str:
        """Return a target with the service that its name stands for; the longest name counts."""
        fits = [
            name
            for name in self._services
            if target.startswith(name) and target[len(name) : len(name) + 1] in _AFTER_NAME
        ]
        name = max(fits, key=len, default="")
        return self._services.get(name, "") + target.removeprefix(name)


class ServiceLink:
    """Link to one service: sends SETs in their order, listens to what is wanted of it.

    Args:
        client: Asks the service.
        names: Names of services in the machine.
        received: Called with each change of what is listened to.
        got: Called with the variable and the value that were to be got.
        failed: Called with the target and the reason of what failed, and whether it is a repetition
            that fails as it did before.
    """

    def __init__(
        self,
        client: rtkit.Client,
        names: ServiceNames,
        received: Callable[[MachineEvent], object],
        got: Callable[[str, Any], object],
        failed: Callable[[str, str, bool], object],
    ) -> None:
        self._client, self._resolved = client, names.resolved
        self._report, self._got, self._failed = received, got, failed
        self._sends: deque[OutgoingSet] = deque()
        self._failing: dict[str, str] = {}
        self._wanted: frozenset[str] = frozenset()
        self._listening: dict[str, Any] = {}
        self._gone: set[str] = set()
        self._is_closed = self._is_retrying = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="service link", daemon=True)
        self._thread.start()

    def send(self, send: OutgoingSet) -> bool:
        """Have a SET sent; return whether there is room; a repetition of what waits is left out."""
        with self._changed:
            if send.is_repeated and send.target in [each.target for each in self._sends]:
                return True
            if len(self._sends) >= _MOST_WAITING:
                return False
            self._sends.append(send)
            self._changed.notify()
        return True

    def want(self, targets: frozenset[str]) -> None:
        """Listen to these properties from now on."""
        with self._changed:
            self._wanted, self._is_retrying = targets, False
            self._changed.notify()

    def close(self, timeout_s: float) -> None:
        """End when what waits has been sent, or after some time [s]."""
        with self._changed:
            self._is_closed, self._wanted = True, frozenset()
            self._changed.notify()
        self._thread.join(timeout_s)

    def _work(self) -> None:
        while True:
            with self._changed:
                if not self._is_due():
                    self._changed.wait(_RETRY_S if self._is_retrying else None)
                    self._is_retrying = False
                send = self._sends.popleft() if self._sends else None
                wanted, is_over = self._wanted, self._is_closed and not send
            if send:
                self._carry_out(send)
            self._listen(wanted)
            if is_over:
                return

    def _is_due(self) -> bool:
        is_new = self._wanted != self._listening.keys() and not self._is_retrying
        return bool(self._sends or self._gone) or is_new or self._is_closed

    def _carry_out(self, send: OutgoingSet) -> None:
        try:
            self._do(send)
        except rtkit.PropertyError as error:
            why = f"{error.code}: {error}"
            # Most errors begin with the property and the code by themselves.
            self._note_failure(send, why.removeprefix(f"{error.code}: {send.target}: "))
        except ValueError as error:
            self._note_failure(send, f"bad-value: {error}")
        else:
            self._failing.pop(send.target, None)

    def _do(self, send: OutgoingSet) -> None:
        if send.target.startswith(VARIABLES):
            value = self._client.get(self._resolved(send.get))
            self._got(send.target.removeprefix(VARIABLES), value)
            return
        target = self._resolved(send.target)
        if send.get:
            self._copy(self._resolved(send.get), target)
        else:
            self._client.set(target, send.value)

    def _note_failure(self, send: OutgoingSet, why: str) -> None:
        """Tell that a SET has failed."""
        is_known = send.is_repeated and self._failing.get(send.target) == why
        self._failing[send.target] = why
        self._failed(send.target, why, is_known)

    def _copy(self, source: str, target: str) -> None:
        """Set a property to what another one is, bytes as bytes; many of them in blocks."""
        try:
            value = self._client.payload(rtkit.Ask(source), self._client.timeout_s)
        except rtkit.PropertyError as error:
            if error.code != "too-large":
                raise
            value = self._client.get_bytes(source)
        if isinstance(value, bytes):
            self._client.set_bytes(target, value)
        else:
            self._client.set(target, value)

    def _listen(self, wanted: frozenset[str]) -> None:
        gone, self._gone = self._gone, set()
        for target in (self._listening.keys() - wanted) | (gone & self._listening.keys()):
            self._listening.pop(target).close()
        for target in wanted - self._listening.keys():
            try:
                received = partial(self._received, target)
                handle = self._client.listen(self._resolved(target), received, queue=_QUEUE)
            except rtkit.PropertyError:
                self._is_retrying = True  # the value stays unknown until the owner is there
            else:
                self._listening[target] = handle

    def _received(self, target: str, change: Any) -> None:
        self._report(MachineEvent(target, None if change.code else change.value, True))
        if change.code == "no-service":
            self._failed(target, "no-service: it has gone", False)
        elif change.code:
            with self._changed:
                self._gone.add(target)  # nothing further will come of this listening
                self._changed.notify()


def service_of(target: str) -> str:
    """Return the service of a property, as far as its name tells."""
    path = target.partition("?")[0]
    end = path.rfind("/") + 1
    return path[:end] + path[end:].partition(".")[0]
