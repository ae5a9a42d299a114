"""Lockstep: gives components a cycle each, one after the other, and waits until they are over."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Self

import rtkit
from rtkit.errors import Malformed, Partial, RtkitError, Unreachable

_PATIENCE_S = 3600.0
"""How long a cycle may take until it is given up for good; a tick is answered long before [s]."""

_BREATH_S = 0.1
"""Time between two tries with one that is lost [s]."""


class ParticipantLost(Unreachable):
    """Components of a lockstep had no cycle; simulated time stands still.

    Attributes:
        participants: Their paths.
        is_new: Whether it is another trouble than that of the call before.
    """

    def __init__(self, message: str, participants: tuple[str, ...], *, is_new: bool) -> None:
        super().__init__(message)
        self.participants = participants
        self.is_new = is_new


class Lockstep:
    """Drives components whose execution contexts are not periodic, in the order of their names.

    The components are of one manager, in any of its processes; the one that drives them may be in
    any of these, too. Nobody has a second cycle before all had the first: a tick that failed is
    gone on with by the next call, where it stood.

    Example, of a component that is a world::

        def on_activated(self, context):
            self.lockstep = Lockstep("Adaptor0", "Navigator0")

        def on_execute(self, context):
            if not self.lockstep.is_under_way:
                self.move_bodies_and_write_what_sensors_see()
            try:
                self.lockstep.tick()
            except ParticipantLost as lost:
                if lost.is_new:
                    self.report(str(lost))

        def on_deactivated(self, context):
            self.lockstep.close()

    Args:
        participants: Paths, or instance names of components below ``/localhost``.
        context: Number or id of their execution contexts.
        timeout_s: How long `tick` waits at most [s].
        manager: Its name; by default that of the component which makes this, else the usual one.

    Attributes:
        participants: Their paths.
        timeout_s: How long `tick` waits at most [s].
        is_under_way: Whether a tick failed that the next call goes on with: time stands still.

    Raises:
        Malformed: There are no participants, or one is named twice.
        Unreachable: The manager does not run.
    """

    def __init__(
        self,
        *participants: str,
        context: int | str = 0,
        timeout_s: float = 5.0,
        manager: str = "",
    ) -> None:
        self.participants = tuple(map(_path, participants))
        if not participants or len({*self.participants}) < len(participants):
            raise Malformed("a lockstep has participants, each of which is named once")
        self.timeout_s = timeout_s
        self.is_under_way = False
        self._context = context
        self._manager = manager
        self._tree: rtkit.Tree | None = rtkit.connect(manager, timeout_s)
        self._left = self.participants
        self._calls: SimpleQueue[Callable[[], RtkitError | None] | None] = SimpleQueue()
        self._answers: SimpleQueue[RtkitError | None] = SimpleQueue()
        self._is_pending = False
        self._trouble = ""
        threading.Thread(target=_serve, args=(self._calls, self._answers), daemon=True).start()

    def tick(self) -> None:
        """Give each participant one cycle; returns when the last one is over.

        Raises:
            ParticipantLost: One had none: it is gone, not active, fails, or is not ready in time.
                The next call goes on with it. A cycle that is only late is waited for, not
                asked for again.
        """
        self.is_under_way = True
        if not self._is_pending:
            if self._trouble:
                time.sleep(_BREATH_S)
            self._is_pending = True
            self._calls.put(self._give_cycles)
        try:
            error = self._answers.get(timeout=self.timeout_s)
        except Empty:
            raise self._late() from None
        self._is_pending = False
        if error is None:
            self._left, self.is_under_way, self._trouble = self.participants, False, ""
            return
        if isinstance(error, Partial):
            name, error = error.failures[0]
            self._left = self._left[self._left.index(name) :]
            raise self._lost(f"no cycle of {name}: {error}", (name,)) from None
        names = tuple(name for name in self._left if name in str(error)) or self._left
        raise self._lost(f"no cycle of {' '.join(names)}: {error}", names) from None

    def close(self) -> None:
        """End the connection; a cycle that is under way goes on."""
        self._calls.put(None)
        if self._tree is not None:
            self._tree.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.close()

    def _give_cycles(self) -> RtkitError | None:
        try:
            if self._tree is None:
                self._tree = rtkit.connect(self._manager, self.timeout_s)
            self._tree.tick(*self._left, context=self._context, timeout_s=_PATIENCE_S)
        except RtkitError as error:
            if isinstance(error, Unreachable) and self._tree is not None:
                self._tree.close()  # it may be the manager that has ended: another may follow
                self._tree = None
            return error
        return None

    def _late(self) -> ParticipantLost:
        """Return the error for a tick that is not over in time, with what the manager knows."""
        found = {}
        for path in self._left:
            try:
                trouble = "" if self._tree is None else self._tree.component(path).trouble
            except Unreachable:
                break
            except RtkitError as error:
                trouble = str(error)
            if trouble:
                found[path] = trouble
        names = tuple(found) or self._left
        reasons = "; ".join(f"{name}: {why}" for name, why in found.items())
        text = f"no end of a cycle within {self.timeout_s:g} s: {reasons or ' '.join(names)}"
        return self._lost(text, names)

    def _lost(self, text: str, names: tuple[str, ...]) -> ParticipantLost:
        is_new, self._trouble = text != self._trouble, text
        return ParticipantLost(text, names, is_new=is_new)


def _serve(
    calls: SimpleQueue[Callable[[], RtkitError | None] | None],
    answers: SimpleQueue[RtkitError | None],
) -> None:
    """Make calls on a thread of their own, so that the caller's wait has a bound."""
    while (call := calls.get()) is not None:
        answers.put(call())


def _path(name: str) -> str:
    return name if name.startswith("/") else f"/localhost/{name}.rtc"
