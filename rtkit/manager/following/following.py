"""Supervises the systems that a manager follows: starts and ends threads, passes changes on.

See decision 46.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING, Any

from rtkit.deployment.delta import TREE
from rtkit.deployment.facts import Followed
from rtkit.deployment.metrics import METRICS
from rtkit.deployment.states.states_text import spec_from_text
from rtkit.errors import Malformed
from rtkit.manager.core.events import Event, FollowAsked, FollowSaid, ListenersChanged
from rtkit.manager.core.requests import PendingRequests
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Request, failure

if TYPE_CHECKING:
    from rtkit.manager.following.worker import FollowingWorker

_END_S = 5.0
"""How long a transition under way is waited for when a system is to be followed no more [s]."""
_CLOSE_S = 1.0

Post = Callable[["Event | Request"], object]
Failed = Callable[[str, BaseException], object]
"""Takes note of a fault of its own, with the name of the work."""


class Following:
    """Followers of a manager; called on its loop except where stated."""

    def __init__(
        self, post: Post, state: ManagerState, requests: PendingRequests, failed: Failed
    ) -> None:
        self._post = post
        self._state = state
        self._requests = requests
        self._failed = failed
        self._workers: dict[str, FollowingWorker] = {}
        self._numbers = itertools.count()
        self._has_begun = self._is_over = False

    def begin(self) -> None:
        """Follow from now on: all live processes have reported, and desired state is recovered."""
        self._has_begun = True
        self.sync()

    def sync(self) -> None:
        """Follow what is to be followed, and nothing else."""
        if not self._has_begun or self._is_over:
            return
        kept = self._state.kept
        for name in [name for name in self._workers if name not in kept.followed]:
            self._workers.pop(name).end()
        for name, text in kept.followed.items():
            reached = kept.reached.get(name, Followed(name))
            known = self._workers.get(name)
            if reached.is_over:
                self._workers.pop(name, None)
            elif known is None or not known.is_alive():
                self._workers[name] = self._attendant(name, text, reached)

    def _attendant(self, name: str, text: str, reached: Followed) -> FollowingWorker:
        from rtkit.manager.following.worker import FollowingWorker, OwnSite

        purpose = f"the manager itself, which follows {name}"
        site = OwnSite(self._post, self._state.name, purpose)

        def report(outcome: Followed) -> None:
            self._post(FollowSaid(outcome, self._requests.add(site.answer)))
            site.awaited()

        listen = partial(self._listen, f"{name} {next(self._numbers)}")
        worker = FollowingWorker(text, reached, site, report, listen, self._failed)
        worker.start()
        return worker

    def _listen(self, who: str, lines: Sequence[str]) -> None:
        """Subscribe a follower to these topics, and no others; called on its thread."""
        for line in (TREE, METRICS):
            self._post(ListenersChanged(line, line in lines, who))

    def on_published(self, line: str, message: Mapping[str, Any]) -> None:
        """Pass what the manager publishes on its topics to the followers."""
        attendants = [*self._workers.values()]
        if line == TREE:
            for worker in attendants:
                worker.changed()
        elif any(each.needs_metrics for each in attendants):
            from rtkit.deployment.metrics import Metrics
            from rtkit.rtc.serde import decode

            metrics = decode(Metrics, message)
            for worker in attendants:
                worker.changed(metrics)

    def end(self) -> None:
        """Begin nothing any more."""
        self._is_over = True
        for worker in self._workers.values():
            worker.end()

    def close(self) -> None:
        """Wait a little for the threads to end."""
        self.end()
        for worker in self._workers.values():
            worker.join(_CLOSE_S)

    def ask(self, request: Request) -> None:
        """Begin to follow a system, ``{"start": …}``, or end it, ``{"stop": NAME}``.

        It is read on a thread of its own, and a transition under way waited for there.
        """
        Thread(target=self._asked, args=(request,), name="follow", daemon=True).start()

    def _asked(self, request: Request) -> None:
        try:
            self._post(self._read(request))
        except Exception as error:
            request.answer(failure(error))

    def _read(self, request: Request) -> FollowAsked:
        try:
            asked = json.loads(request.payload or "")
            wanted, name = asked.get("start"), asked.get("stop")
        except (ValueError, AttributeError, RecursionError) as error:
            raise Malformed(f"neither {{start: …}} nor {{stop: NAME}}: {error}") from error
        if wanted is not None:
            text = json.dumps(wanted, separators=(",", ":"))
            states, _ = spec_from_text(text)
            return FollowAsked(states.name, text, self._requests.add(request.answer))
        if not isinstance(name, str):
            raise Malformed("neither {start: …} nor {stop: NAME}")
        worker = self._workers.get(name)
        if worker is not None:
            worker.end()
            worker.join(_END_S)
        return FollowAsked(name, None, self._requests.add(request.answer))
