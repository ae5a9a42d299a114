"""Site of plans for the manager itself, used on another thread: requests go to its loop."""

from __future__ import annotations

import json
import os
import time
import uuid
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from threading import Event

from rtkit.deployment.actions import Action, Result
from rtkit.deployment.batch import Batch, batch_to_text, results_from_text
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.lease import LeaseHolder, holder_from_text
from rtkit.deployment.multi_manager import sent
from rtkit.errors import Refused
from rtkit.link.ports import user_name
from rtkit.property.exchange import Reply, Request
from rtkit.rtc.serde import decode, encode

TIMEOUT_S = 10.0
"""How long each action may take [s]."""
_ASK_AGAIN_S = 0.2


class Ended(Exception):
    """Signals that nothing more is to be done here; it is no failure."""


class OwnSite:
    """Site (see `rtkit.deployment.site`) that is this manager; one thread uses it."""

    def __init__(self, post: Callable[[Request], object], manager: str, purpose: str) -> None:
        """Prepare to ask.

        Args:
            post: Hands a request to the loop.
            manager: Its name.
            purpose: Purpose of the lease, as shown to others.
        """
        self._post = post
        self._manager = manager
        self._answers: SimpleQueue[Reply | None] = SimpleQueue()
        self._is_over = Event()
        host = os.uname().nodename
        user, pid = user_name(os.getuid()), os.getpid()
        self._holder = LeaseHolder(uuid.uuid4().hex, purpose, user, host, pid)

    @property
    def is_over(self) -> bool:
        """Return whether nothing more is to be done."""
        return self._is_over.is_set()

    def end(self) -> None:
        """Have whatever is asked raise `Ended` from now on; from any thread."""
        self._is_over.set()
        self._answers.put(None)

    def snapshot(self) -> Snapshot:
        """Return everything that the manager knows."""
        return decode(Snapshot, json.loads(self._ask("snapshot", is_extension=True)))

    remains = snapshot

    def apply(self, actions: Sequence[Action], *, is_ordered: bool = True) -> tuple[Result, ...]:
        """Have a batch performed and return the result of each action."""
        words = tuple(sent(action, self._manager) for action in actions)
        batch = Batch(words, is_ordered, TIMEOUT_S, os.urandom(8).hex())
        return results_from_text(self._ask("batch", batch_to_text(batch)))

    def start(self, manager: str) -> None:
        """Start another manager; that is for commands to do.

        Raises:
            Refused: Always.
        """
        raise Refused(f"manager {manager} is not this one, and starts no other")

    def end_started(self) -> list[str]:
        """End the managers that were started: none."""
        return []

    def holder(self) -> LeaseHolder | None:
        """Return who carries a plan out; None for nobody."""
        return holder_from_text(self._ask("lease", is_extension=True))

    def pause(self, duration_s: float = _ASK_AGAIN_S) -> None:
        """Wait so long [s]; as it is, before it is asked again who carries a plan out."""
        if self._is_over.wait(duration_s):
            raise Ended

    def take_lease(self, waits: Callable[[str], object]) -> None:
        """Keep others from carrying plans out; `waits` receives whom it waits for."""
        told = ""
        while True:
            wanted = {**encode(self._holder), "since": time.time()}
            try:
                self._ask("lease", json.dumps({"take": wanted}), is_extension=True)
                return
            except Refused as error:
                if str(error) != told:
                    told = str(error)
                    waits(told)
            self.pause()

    def give_lease(self) -> None:
        """Keep nobody off any more; waits for nothing."""
        text = json.dumps({"give": self._holder.id})
        self._post(Request("lease", text, lambda _reply: None, is_extension=True))

    def _ask(self, name: str, payload: str | None = None, *, is_extension: bool = False) -> str:
        self._check()
        self._post(Request(name, payload, self._answers.put, is_extension))
        return self.awaited()

    def awaited(self) -> str:
        """Return the answer to what was asked last."""
        reply = self._answers.get()
        self._check()
        assert reply is not None
        return reply.value()

    @property
    def answer(self) -> Callable[[Reply], None]:
        """Return the receiver for the answer to another request, before `awaited`."""
        return self._answers.put

    def _check(self) -> None:
        if self.is_over:
            raise Ended
