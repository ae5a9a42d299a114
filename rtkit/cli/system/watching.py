"""Prints the transitions of a system that its manager follows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from rtkit.api.observers import Observers
from rtkit.api.states import followed_in
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.json_records import line as json_line
from rtkit.cli.shared.json_records import picked, time_text
from rtkit.cli.shared.terminal import clock
from rtkit.deployment.delta import TREE
from rtkit.deployment.facts import IS_SO
from rtkit.errors import Refused, from_kind

if TYPE_CHECKING:
    from rtkit.api.observers import ObservedEvent
    from rtkit.deployment.facts import Followed
    from rtkit.deployment.user_events import UserEvent


class Watching:
    """Watches one system; following goes on when this ends."""

    def __init__(self, app: App, system: str, *, is_json: bool) -> None:
        """Prepare to watch a system by the identity of its profile."""
        self._app = app
        self._system = system
        self._is_json = is_json

    def run(self, begin: Callable[[], object], number: int | None) -> None:
        """Go on until interrupted, or until `number` transitions were made.

        Args:
            begin: Makes the manager follow the system, once the subscription stands.
            number: Of transitions from now on; None for no bound.

        Raises:
            Refused: It cannot be followed, or somebody ended that.
            RtkitError: A transition failed, and no event leads on from there.
        """
        left = number
        with Observers(self._app, (TREE,)) as subscriptions:
            known = followed_in(subscriptions.subscriptions[""].facts, self._system)
            begin()
            if known is not None and not known.is_over and known.count:
                self._show(known)
            for events in subscriptions.listen(None):
                for each in self._happened(events):
                    left = self._take(each, left)
                    if left == 0:
                        return

    def _happened(self, events: Sequence[ObservedEvent]) -> list[UserEvent]:
        from rtkit.tree.subscription import SubscriptionEnded, TreeChange

        found: list[UserEvent] = []
        for _, event in events:
            if isinstance(event, SubscriptionEnded):
                self._app.fail(f"{event.why}; waiting for it to come back")
            elif isinstance(event, TreeChange):
                found += event.user_events
        return [each for each in found if each.system and each.system.system == self._system]

    def _take(self, user_event: UserEvent, left: int | None) -> int | None:
        """Report an event; return the number of transitions still to report."""
        system = user_event.system
        assert system is not None
        if user_event.event == "WAITS":
            self._app.verbose(f"waits: manager is in use by {user_event.detail}")
        elif user_event.event == "TRANSITION_FAILED":
            if not system.is_over:
                self._app.fail(user_event.detail)
        elif user_event.event == "NOT_FOLLOWED":
            if system.is_over:
                raise from_kind(system.kind, system.why)
            raise Refused(f"{self._system} is followed no more")
        elif user_event.event == system.state:
            self._show(system)
            if left is not None and system.event != IS_SO:
                return left - 1
        return left

    def _show(self, followed: Followed) -> None:
        if self._is_json:
            fields = picked(followed, "system from=before to=state event")
            record = {"time": time_text(int(followed.time * 1e9)), **fields}
            terminal.write_now([json_line("transition", record)])
            return
        terminal.write_now([terminal.printable(f"[{clock(followed.time)}] {followed}")])
