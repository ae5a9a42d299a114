"""Delays replies until desired state is on the disk, and rolls back what cannot be stored.

While the store cannot be written nothing new is begun; what ends or rests something is done all
the same, since a robot must be stopped whatever its disk is like.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import NamedTuple

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.errors import Refused, RtkitError
from rtkit.manager.core.desired import module_path
from rtkit.manager.core.effects import Procedure
from rtkit.manager.core.events import Instruction, Row, RowsStored, StoreRows, WakeAt
from rtkit.manager.core.procedures import procedure_for
from rtkit.manager.core.state import ManagerState
from rtkit.manager.core.tasks import Tasks, failed
from rtkit.rtc.enums import Transition

SendResults = Callable[[list[Result]], object]
_log = logging.getLogger(__name__)
_UNDO_S = 10.0
"""How long it may take to take back what cannot be kept [s]."""
RETRY_S = 1.0
"""How long after a write that failed the next one is tried [s]."""


class _Done(NamedTuple):
    """Actions that were done; their results are sent once these are on the disk."""

    actions: Sequence[Action]
    results: list[Result]
    send: SendResults


class _Flight(NamedTuple):
    """Rows that are being written, and the replies that wait for them."""

    rows: tuple[Row, ...]
    done: list[_Done]
    waiting: list[Callable[[str], object]]


class DurableReplies:
    """Rows on their way to the store; `out` collects instructions for the shell."""

    def __init__(self, state: ManagerState, out: list[Instruction], tasks: Tasks) -> None:
        self._state = state
        self._out = out
        self._tasks = tasks
        self._number = 0
        self._flights: dict[int, _Flight] = {}
        self._retry_at: float | None = None
        self._is_stopping = False
        self._is_forgetting = False

    @property
    def is_idle(self) -> bool:
        """Return whether nothing is on its way."""
        return not self._flights

    def finish(self, actions: Sequence[Action], results: list[Result], send: SendResults) -> None:
        """Have results sent when the changes that they report are stored."""
        if self._is_forgetting or not any(result.ok for result in results):
            send(results)
        elif self._state.kept.has_changed:
            self._keep().done.append(_Done(actions, results, send))
        elif self._flights:  # perhaps with what another batch was waiting for
            self._flights[self._number].done.append(_Done(actions, results, send))
        else:
            send(results)

    def admit(self, actions: Sequence[Action], go_on: Callable[[str], object]) -> None:
        """Call `go_on` with why actions cannot be begun; with an empty text when they can."""
        if self._state.unkept and not all(map(_is_ending, actions)):
            self._keep().waiting.append(go_on)
        else:
            go_on("")

    def kept(self, stored: RowsStored) -> None:
        """Take the word of the store; if it is lost, have all kept in another one."""
        flight, why = self._flights.pop(stored.number), stored.why
        if stored.is_lost and not self._is_forgetting:
            self._keep_anew(flight, why)
            return
        self._state.unkept, self._retry_at = why, None
        if why:
            self._state.kept.not_kept(flight.rows)
        else:
            self._state.kept.is_kept(flight.rows)
        for go_on in flight.waiting:
            go_on(why)
        for done in flight.done:
            if why:
                self._take_back(done, why)
            else:
                done.send(done.results)

    def run(self, now: float) -> None:
        """Have kept what came of itself, once nothing is under way, and at once what is urgent.

        After a failure all that is left is tried again after a while, until it succeeds.
        """
        kept = self._state.kept
        if self._flights:
            return
        if self._state.unkept:
            self._retry(now)
        elif kept.has_changed and self._tasks.is_idle:
            self._keep()
        elif kept.is_urgent:
            self._keep(is_urgent=True)

    def _retry(self, now: float) -> None:
        if self._retry_at is None:
            self._retry_at = now + RETRY_S
        if now >= self._retry_at:
            self._keep()
        else:
            self._out.append(WakeAt(self._retry_at))

    def stop(self, *, is_kept: bool) -> None:
        """Roll nothing back any more; unless desired state is kept, clear it."""
        self._is_stopping = True
        if not is_kept:
            self._is_forgetting = True
            self._state.kept.clear()
        if self._state.kept.has_changed:
            self._keep()

    def _keep(self, *, is_urgent: bool = False) -> _Flight:
        self._number += 1
        rows = self._state.kept.changes(is_urgent=is_urgent)
        flight = self._flights[self._number] = _Flight(rows, [], [])
        self._out.append(StoreRows(self._number, flight.rows))
        return flight

    def _keep_anew(self, flight: _Flight, why: str) -> None:
        """Write all desired state into a new store; replies for the old one wait for that."""
        self._state.remark = f"{why}; all is written anew"
        _log.warning("%s", self._state.remark)
        self._state.kept.keep_all()
        again = self._keep()
        again.done.extend(flight.done)
        again.waiting.extend(flight.waiting)

    def _take_back(self, done: _Done, why: str) -> None:
        def send(_result: Result) -> None:
            done.send(done.results)

        self._tasks.begin(self._undo(done, why), _UNDO_S, send)

    def _undo(self, done: _Done, why: str) -> Procedure:
        """Roll back what was made and cannot be stored, the last first; report what stays."""
        for index in reversed(range(len(done.results))):
            result, action = done.results[index], done.actions[index]
            if not result.ok or isinstance(action, act.Tick):
                continue
            back = _opposite(self._state, action, result)
            stays = "done all the same, but "
            if back is not None and not self._is_stopping:
                try:
                    yield from procedure_for(back, self._state)
                    stays = ""
                except RtkitError as error:
                    stays = f"done, not taken back ({error}), and "
            done.results[index] = failed(Refused(stays + unkept(why)))
        return Result()


def unkept(why: str) -> str:
    """Return the reason to refuse a change that cannot be stored."""
    return f"what is wished cannot be recorded: {why}"


def _is_ending(action: Action) -> bool:
    """Return whether an action ends or rests something."""
    if isinstance(action, act.ChangeState):
        return action.transition is not Transition.ACTIVATE
    return isinstance(action, (act.Delete, act.EndSlave, act.Unregister, act.Disconnect, act.Tick))


def _opposite(state: ManagerState, action: Action, result: Result) -> Action | None:
    """Return what takes back something that was made just now; None for what stays."""
    is_stored = state.kept.is_stored
    match action:
        case act.Create() if not is_stored("component", result.value):
            return act.Delete(result.value)
        case act.Connect(connector) if not is_stored("wire", connector.connector_id):
            return act.Disconnect(connector.connector_id)
        case act.Load(path) if not any(is_stored("module", row) for row in _rows(state, path)):
            return act.Unload(path)
    return None


def _rows(state: ManagerState, path: str) -> list[str]:
    """Return the rows about a module, one for each init function."""
    return [row for row, init in state.kept.modules.items() if module_path(row, init) == path]
