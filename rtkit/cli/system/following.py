"""Follows the events of a system, in the foreground: listens, and leads it from state to state."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rtkit.cli import _out
from rtkit.cli._app import App
from rtkit.cli._ears import write_now
from rtkit.cli._moments import clock
from rtkit.cli._records import line as json_line
from rtkit.cli._records import time_text
from rtkit.cli.system.leading import Leading
from rtkit.cli.system.states import States
from rtkit.errors import Unreachable

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.figures import ComponentFigures
    from rtkit.tree.lease import Leases
    from rtkit.tree.listening import Heard

SYSTEM_STATE = "SYSTEM_STATE"
BY_OTHERS = "by others"
AT_FIRST = "at first"


class Following:
    """Leads one system wherever its events lead."""

    def __init__(
        self, app: App, states: States, leases: Leases, *, is_json: bool, rolls_back: bool
    ) -> None:
        self._app = app
        self._states = states
        self._is_json = is_json
        self._leading = Leading(app, states, app.tell, leases, rolls_back=rolls_back)
        self._follower = self._leading.follower
        self._figures: dict[str, ComponentFigures] = {}
        self._left: int | None = None

    def run(self, number: int | None) -> None:
        """Go on until interrupted, or until `number` transitions were made.

        Raises:
            Unreachable: The manager ended.
            Refused: A transition failed, and no event leads on from there.
        """
        from rtkit.deployment.figures import FIGURES
        from rtkit.deployment.news import TREE
        from rtkit.tree.fleet import ear_at

        self._left = number
        conditions = self._states.machine.conditions.values()
        needs_figures = any(condition.needs_figures for condition in conditions)
        with ear_at(self._app.tree, (TREE, FIGURES) if needs_figures else (TREE,)) as ear:
            self._begin(ear.facts)
            while self._left != 0:
                if not self._step(ear.facts):
                    self._take(ear.wait())
                else:
                    self._take(ear.take())

    def _begin(self, facts: Snapshot) -> None:
        first = self._states.machine.first
        now = self._states.now(facts)
        self._follower.state = now or first
        if now:
            self._tell("", now, "is so")
        else:
            self._lead("", first, AT_FIRST)

    def _step(self, facts: Snapshot) -> bool:
        """Follow what is due; return whether something was."""
        passage = self._follower.look(facts, self._figures, time.monotonic())
        if passage is None:
            return False
        if passage.event:
            self._lead(passage.before, passage.state, passage.event)
        else:
            self._count(passage.before, passage.state, BY_OTHERS)
        return True

    def _lead(self, before: str, state: str, event: str) -> None:
        """Lead the system to a state; on from there if it cannot be reached."""
        before, event, state = self._leading.lead(before, state, event)
        self._count(before, state, event)

    def _take(self, heard: list[Heard]) -> None:
        from rtkit.deployment.figures import Figures
        from rtkit.tree.listening import Ended

        for each in heard:
            if isinstance(each, Ended):
                raise Unreachable(each.why)
            if isinstance(each, Figures):
                found = (c for process in each.processes for c in process.components)
                self._figures.update((figures.instance, figures) for figures in found)

    def _count(self, before: str, state: str, event: str) -> None:
        self._tell(before, state, event)
        if self._left is not None:
            self._left -= 1

    def _tell(self, before: str, state: str, event: str) -> None:
        moment = time.time()
        if self._is_json:
            record = {
                "time": time_text(int(moment * 1e9)),
                "system": self._states.name,
                "from": before,
                "to": state,
                "event": event,
            }
            write_now([json_line("transition", record)])
            return
        way = f"{before} -{event}-> {state}" if before else f"{state} ({event})"
        write_now([_out.printable(f"[{clock(moment)}] {way}")])
