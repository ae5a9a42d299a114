"""Runs the live page on a terminal: keeps it up to date and handles its keys."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING

from rtkit.api.rates import RateRow
from rtkit.cli.observing.top.page import COLUMNS, Look, cut, ordered, table
from rtkit.cli.observing.top.screen import Screen
from rtkit.cli.shared import terminal
from rtkit.errors import RtkitError
from rtkit.rtc.enums import Transition

if TYPE_CHECKING:
    from rtkit.api.observers import ObservedEvent
    from rtkit.cli.observing.top.activity import Top
    from rtkit.deployment.actions import ChangeState
    from rtkit.tree.client import Tree

_LEAST_S = 0.05
"""Least time between two drawings of the page [s]."""

_LATE_S = 3.5
"""Time after the last metrics at which the page is drawn without new ones [s]."""

_MESSAGE_S = 5.0
"""Time for which the outcome of a key is shown [s]."""

_KEYS = "q quit, h help, arrows select and sort, a activate, d deactivate, r reset"
_HELP = (
    "up down      select a component (also k j, page up, page down)",
    "left right   sort by another column (also < >)",
    "i            sort the other way round",
    "a            activate the selected component",
    "d            deactivate it",
    "r            reset it: from Error to Inactive",
    "h ?          this help",
    "q            quit (also Ctrl-C)",
    "",
    "RATE/Hz      cycles a second: reached / asked for; - where no cycle calls it",
    "MEAN MAX/ms  time of a cycle, and of the longest in the last second",
    "MISS/s       periods at which nothing was done",
    "CPU% MEM     of its whole process; IN/s OUT/s values of its data ports",
    "RST          how often its policy made it again after it was lost",
)
_TRANSITIONS = {
    "a": (Transition.ACTIVATE, "activated"),
    "d": (Transition.DEACTIVATE, "deactivated"),
    "r": (Transition.RESET, "reset"),
}
_MOVES = {
    "up": -1,
    "k": -1,
    "down": 1,
    "j": 1,
    "page up": -10,
    "page down": 10,
    "home": -1_000_000,
    "end": 1_000_000,
}


def run(top: Top, look: Look) -> None:
    """Show the page until it is left by a key."""
    with Screen() as screen:
        _Live(top, look, screen).run()


class _Live:
    def __init__(self, top: Top, look: Look, screen: Screen) -> None:
        self._top = top
        self._look = look
        self._screen = screen
        self._rows: list[RateRow] = []
        self._has_help = False
        self._is_over = False
        self._message = ""
        self._message_until = 0.0
        self._outcomes: deque[str] = deque()
        self._draw_at = 0.0
        self._is_stale = False

    def run(self) -> None:
        self._draw()
        for events in self._top.subscriptions.listen(None, self._screen.sources, self._wake_at):
            self._screen.hush()
            self._receive(events)
            self._press(self._screen.keys())
            if self._is_over:
                return
            if monotonic() >= self._draw_at:
                self._draw()

    def _wake_at(self) -> float | None:
        """Return when to draw changes, or that metrics do not come any more."""
        if self._is_stale:
            return self._draw_at
        return max(self._top.received_at + _LATE_S, self._draw_at + 1.0)

    def _receive(self, events: Sequence[ObservedEvent]) -> None:
        from rtkit.api.observers import ManagerSeen
        from rtkit.tree.subscription import SubscriptionEnded

        self._top.take(events)
        for _, event in events:
            if isinstance(event, SubscriptionEnded):
                self._notify(f"{event.why}; waiting for it to come back")
            elif isinstance(event, ManagerSeen):
                self._notify(str(event))
        while self._outcomes:
            self._notify(self._outcomes.popleft())
        self._is_stale = True

    def _notify(self, text: str) -> None:
        self._message, self._message_until = text, monotonic() + _MESSAGE_S

    # keys

    def _press(self, keys: Sequence[str]) -> None:
        for key in keys:
            if key in ("q", "Q", "end of input"):
                self._is_over = True
            elif key in ("h", "?"):
                self._has_help = not self._has_help
            elif key in _TRANSITIONS:
                self._change(key)
            elif key == "i":
                self._look = self._look._replace(is_reversed=not self._look.is_reversed)
            elif key in ("left", "<", "right", ">"):
                self._sort(-1 if key in ("left", "<") else 1)
            elif key in _MOVES:
                self._move(_MOVES[key])
            if key not in ("h", "?"):
                self._has_help = False

    def _sort(self, step: int) -> None:
        sort = (self._look.sort + step) % len(COLUMNS)
        self._look = self._look._replace(sort=sort, is_reversed=False)

    def _move(self, step: int) -> None:
        paths = [row.path for row in self._rows]
        if not paths:
            return
        at = paths.index(self._look.selected) if self._look.selected in paths else 0
        at = max(0, min(len(paths) - 1, at + step))
        self._look = self._look._replace(selected=paths[at])

    def _change(self, key: str) -> None:
        """Ask for a transition of the selected component; its outcome is told when it comes."""
        from rtkit.deployment.actions import ChangeState

        row = next((row for row in self._rows if row.path == self._look.selected), None)
        subscriptions = self._top.subscriptions
        asked = next(
            (
                name
                for name, subscription in subscriptions.subscriptions.items()
                if row and subscription.facts.manager == row.manager
            ),
            None,
        )
        if row is None or asked is None:
            self._notify("no component is selected")
            return
        transition, done = _TRANSITIONS[key]
        if not row.context:
            self._notify(f"{row.path} has no execution context")
            return
        tree = subscriptions.subscriptions[asked].tree
        action = ChangeState(row.instance, row.context, transition)
        self._notify(f"{row.path}: {transition.value} ...")
        Thread(target=self._await, args=(tree, action, row.path, done), daemon=True).start()

    def _await(self, tree: Tree, action: ChangeState, path: str, done: str) -> None:
        try:
            tree.perform(action)
        except RtkitError as error:
            self._outcomes.append(f"{path}: {error}")
        else:
            self._outcomes.append(f"{path} is {done}")
        self._screen.wakeup.ring()

    # the page

    def _draw(self) -> None:
        width, height = self._screen.size
        self._rows = ordered(self._top.rows(), self._look)
        paths = [row.path for row in self._rows]
        if self._look.selected not in paths:
            self._look = self._look._replace(selected=paths[0] if paths else "")
        head = cut(terminal.printable(self._top.summary(self._rows)), width)
        room = max(2, height - 2)
        if self._has_help:
            body = [cut(line, width) for line in _HELP[:room]]
        else:
            look = self._look._replace(width=width, height=room)
            body = table(self._rows, look)
        message = self._message if monotonic() < self._message_until else _KEYS
        blank = [""] * (room - len(body))
        self._screen.show([head, *body, *blank, cut(terminal.printable(message), width)][:height])
        self._draw_at, self._is_stale = monotonic() + _LEAST_S, False
