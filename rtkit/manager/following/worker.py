"""Follows the events of one system on a thread, from its last state on.

Its site is the manager itself: requests go to the manager's loop.
"""

from __future__ import annotations

import json
import logging
import os
import time
import uuid
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from rtkit.deployment.actions import Action, Result
from rtkit.deployment.batch import Batch, batch_to_text, results_from_text
from rtkit.deployment.delta import TREE
from rtkit.deployment.facts import Followed, Snapshot
from rtkit.deployment.metrics import METRICS
from rtkit.deployment.multi_manager import sent
from rtkit.deployment.plan_lock import LockHolder, holder_from_text
from rtkit.deployment.states.states_text import spec_from_text
from rtkit.errors import Refused, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.link.places import host_name
from rtkit.link.port_holders import user_name
from rtkit.property.exchange import Reply, Request
from rtkit.rtc.serde import decode_text, encode

if TYPE_CHECKING:
    from rtkit.deployment.metrics import ComponentMetrics
    from rtkit.deployment.states.leading import Leader, SystemTransition

_log = logging.getLogger(__name__)
_PAUSE_S, _LONGEST_PAUSE_S = 0.05, 1.0
"""The shortest and the longest time between two looks [s]: conditions are levels."""
_PAUSES = 4
"""So many times as long as a look took is the pause behind it: others want the manager too."""


class FollowingWorker(Thread):
    """One thread that follows one system.

    Attributes:
        reached: Its reports so far.
        needs_figures: Whether a condition is on what components do; known once it runs.
    """

    def __init__(
        self,
        text: str,
        reached: Followed,
        site: OwnSite,
        report: Callable[[Followed], object],
        listen: Callable[[Sequence[str]], object],
        failed: Callable[[str, BaseException], object] = lambda _work, _error: None,
    ) -> None:
        """Prepare to follow.

        Args:
            text: Specification by which a system is followed (`rtkit.deployment.facts`).
            reached: Its last state and transition.
            site: Where it lives.
            report: Stores and reports its outcome; returns when that is stored.
            listen: Has `changed` called with what is published on these topics, and no others.
            failed: Takes note of a fault of its own.
        """
        super().__init__(name="follower", daemon=True)
        self._text = text
        self._site = site
        self._report = report
        self._listen = listen
        self._failed_at = failed
        self._changed = Event()
        self._rolls_back = False
        self._metrics: dict[str, ComponentMetrics] = {}
        self.reached = reached
        self.needs_metrics = False

    def end(self) -> None:
        """Follow no more: what is under way is finished, and nothing else begun."""
        self._site.end()
        self._changed.set()

    def changed(self, metrics: Any = None) -> None:
        """Note that something has changed, perhaps with new metrics; from any thread."""
        if metrics is not None:
            self._metrics = {
                each.instance: each for process in metrics.processes for each in process.components
            }
        self._changed.set()

    def run(self) -> None:
        """Follow until its end is requested, or until a transition fails and nothing leads on."""
        try:
            self._follow()
        except Ended:
            return
        except Exception as error:
            kind = error.kind if isinstance(error, RtkitError) else "error"
            why = str(error) if isinstance(error, RtkitError) else f"a bug in rtkit: {error!r}"
            _log.error("%s is followed no more: %s", self.reached.system, why)
            if not isinstance(error, RtkitError):
                self._failed_at("following", error)
            self._give_up(why, kind)
        finally:
            self._listen(())

    def _give_up(self, why: str, kind: str) -> None:
        try:
            self._update(why=why, kind=kind, is_over=True, is_led=False, waits="")
        except (Ended, RtkitError) as error:
            _log.error("that could not be kept: %s", error)

    def _follow(self) -> None:
        from rtkit.deployment.states.leading import Leader, SystemTransition

        self._states, self._rolls_back = spec_from_text(self._text)
        leader = Leader(self._states, self._reach, self._failed, time.monotonic)
        conditions = self._states.machine.conditions.values()
        self.needs_metrics = any(condition.needs_metrics for condition in conditions)
        self._listen((TREE, METRICS) if self.needs_metrics else (TREE,))
        last = self.reached
        if last.is_led:
            self._came(leader.lead(SystemTransition(last.before, last.event, last.state)))
        elif last.state:
            leader.state = last.state
        else:
            while self._site.holder() is not None:
                self._site.pause()
            self._came(leader.begin(self._site.snapshot()))
        while not self._site.is_over:
            self._changed.clear()
            if self._is_kept_off(leader):
                continue
            began_s = time.monotonic()
            passage = leader.step(self._site.snapshot(), self._metrics)
            if passage is not None:
                self._came(passage)
                continue
            if self.reached.waits:
                self._update(waits="")
            took_s = time.monotonic() - began_s
            self._changed.wait()
            self._site.pause(min(max(_PAUSE_S, _PAUSES * took_s), _LONGEST_PAUSE_S))

    def _is_kept_off(self, leader: Leader) -> bool:
        """Return whether a plan is being carried out: states on its way are no events to follow."""
        holder = self._site.holder()
        if holder is None:
            return False
        if str(holder) != self.reached.waits and leader.due(self._site.snapshot(), self._metrics):
            self._update(waits=str(holder))
        self._site.pause()
        return True

    def _reach(self, passage: SystemTransition) -> None:
        from rtkit.deployment.applying import Applier

        goal = self._states.goal(passage.state)
        self._site.take_lock(lambda whom: self._update(waits=whom))
        try:
            before, event, state = passage
            now = time.time()
            self._update(before=before, event=event, state=state, is_led=True, waits="", time=now)
            snapshot = self._site.snapshot()
            applier = Applier(self._site, goal, _log.warning, _log.info)
            applier.run(goal.plan(snapshot), snapshot, rolls_back=self._rolls_back)
        finally:
            self._site.give_lock()

    def _failed(self, why: str) -> None:
        _log.warning("%s", why)
        self._update(why=why)

    def _came(self, passage: SystemTransition) -> None:
        from rtkit.deployment.states.machine import FAILED

        before, event, state = passage
        self._update(
            before=before,
            event=event,
            state=state,
            count=self.reached.count + 1,
            time=time.time(),
            is_led=False,
            waits="",
            why=self.reached.why if event == FAILED else "",
        )
        _log.info("%s: %s", self.reached.system, self.reached)

    def _update(self, **changes: Any) -> None:
        self.reached = replace(self.reached, **changes)
        self._report(self.reached)


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
            purpose: Purpose of the lock, as shown to others.
        """
        self._post = post
        self._manager = manager
        self._answers: SimpleQueue[Reply | None] = SimpleQueue()
        self._is_over = Event()
        host = host_name()
        user, pid = user_name(os.getuid()), os.getpid()
        self._holder = LockHolder(uuid.uuid4().hex, purpose, user, host, pid)

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
        return decode_text(Snapshot, self._ask("snapshot", is_extension=True))

    remains = snapshot

    def apply(self, actions: Sequence[Action], *, is_ordered: bool = True) -> tuple[Result, ...]:
        """Have a batch performed and return the result of each action."""
        words = tuple(sent(action, self._manager) for action in actions)
        batch = Batch(words, is_ordered, TIMEOUT_S, os.urandom(8).hex())
        return results_from_text(self._ask("batch", batch_to_text(batch)))

    def start_manager(self, manager: str) -> None:
        """Start another manager; that is for commands to do.

        Raises:
            Refused: Always.
        """
        raise Refused(f"manager {manager} is not this one, and starts no other")

    def end_started(self) -> list[str]:
        """End the managers that were started: none."""
        return []

    def holder(self) -> LockHolder | None:
        """Return who carries a plan out; None for nobody."""
        return holder_from_text(self._ask("lease", is_extension=True))

    def pause(self, duration_s: float = _ASK_AGAIN_S) -> None:
        """Wait so long [s]; as it is, before it is asked again who carries a plan out."""
        if self._is_over.wait(duration_s):
            raise Ended

    def take_lock(self, waits: Callable[[str], object]) -> None:
        """Keep others from carrying plans out; `waits` receives whom it waits for."""
        before = ""
        while True:
            wanted = {**encode(self._holder), "since": time.time()}
            try:
                self._ask("lease", json.dumps({"take": wanted}), is_extension=True)
                return
            except Refused as error:
                if str(error) != before:
                    before = str(error)
                    waits(before)
            self.pause()

    def give_lock(self) -> None:
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
