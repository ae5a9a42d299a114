"""Takes the locks of the managers at which a plan is carried out, and gives them back."""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Callable
from contextlib import suppress

from rtkit.closing import Closing
from rtkit.deployment.plan_lock import LockHolder, holder_from_text
from rtkit.errors import Denied, Malformed, NotFound, Refused, RtkitError
from rtkit.link import stopping
from rtkit.link.places import host_name
from rtkit.link.port_holders import user_name
from rtkit.rtc.serde import encode
from rtkit.tree.client import Tree

_ASK_AGAIN_S = 0.2
"""After how long is asked again, in case a lock was given back by who goes on living [s]."""


class PlanLocks(Closing):
    """The locks of this process; managers end them by themselves when it ends."""

    def __init__(self, command: str, wait_s: float, notify: Callable[[str], object]) -> None:
        """Prepare to take locks.

        Args:
            command: Command that takes them, as others see it.
            wait_s: How long to wait for those who have them [s].
            notify: Receives for whom it waits, and who gives none.
        """
        pid, user = os.getpid(), user_name(os.getuid())
        self._holder = LockHolder(uuid.uuid4().hex, command, user, host_name(), pid)
        self._wait_s = wait_s
        self._notify = notify
        self._taken: list[Tree] = []

    def take(self, *trees: Tree) -> None:
        """Take the locks of managers, all or none.

        Raises:
            Refused: Somebody has one, and had it all the time that there was to wait.
            Unreachable: A manager does not answer.
        """
        until = time.monotonic() + self._wait_s
        notified = ""
        while True:
            stopping.check()
            busy = self._try([*trees])
            left_s = until - time.monotonic()
            if busy is None:
                return
            tree, why = busy
            if left_s <= 0:
                waited = f" (waited {self._wait_s:g} s)" if self._wait_s else ""
                hint = "" if self._wait_s else "; --wait SECONDS waits for its end"
                raise Refused(f"{why}{waited}{hint}")
            if why != notified:
                self._notify(f"waits: {why}")
                notified = why
            self._await(tree, min(_ASK_AGAIN_S, left_s))

    def close(self) -> None:
        """Give all of them back; a manager that does not answer any more has none."""
        self._give([*self._taken])

    def _try(self, trees: list[Tree]) -> tuple[Tree, str] | None:
        """Take locks, all or none; return a manager whose lock somebody has, and who."""
        known = len(self._taken)
        for tree in trees:
            since = time.time()
            try:
                tree.plan_lock({"take": {**encode(self._holder), "since": since}})
                self._taken.append(tree)
            except Denied:  # by the role of this user, not by a holder
                self._give(self._taken[known:])
                raise
            except Refused as error:
                self._give(self._taken[known:])
                return tree, f"manager {tree.manager!r} is in use by {error}"
            except (NotFound, Malformed) as error:
                self._notify(f"manager {tree.manager!r} keeps no others off meanwhile: {error}")
            except BaseException:
                self._give(self._taken[known:])
                raise
        return None

    @staticmethod
    def _await(tree: Tree, timeout_s: float) -> None:
        """Wait until the process ends that has the lock of a manager, but not for long."""
        holder = holder_from_text(tree.plan_lock())
        if holder is None:
            return  # it has just been given back
        if holder.host != host_name():
            time.sleep(timeout_s)  # its end cannot be seen from here
            return
        from rtkit.link.processes import ProcessWatch

        try:
            life = ProcessWatch(holder.pid)
        except ProcessLookupError:
            return  # it has just ended
        try:
            life.await_end(timeout_s)
        finally:
            life.close()

    def _give(self, trees: list[Tree]) -> None:
        for tree in trees:
            self._taken.remove(tree)
            with suppress(RtkitError):
                tree.plan_lock({"give": self._holder.id})
