"""Publishes deltas of the state to subscribers after each event; idle while there are none.

What has changed, tables of the state note by themselves: a delta costs the same beside 10,000
components as beside ten. See decision 20.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from rtkit.deployment.delta import TREE, Delta, FullSnapshot, changed
from rtkit.deployment.facts import ComponentFacts, Followed, ProcessFacts, Snapshot
from rtkit.fast_dataclass import replace
from rtkit.manager.core.events import AnswerClient, Instruction, Publish
from rtkit.manager.core.indexed_table import IndexedTable, Journal
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import encode, encode_text

T = TypeVar("T")


class ChangeFeed:
    """State as the subscribers know it; `out` collects instructions for the shell."""

    DERIVED = (
        "_components", "_connectors", "_processes", "_signs", "_names", "_systems", "_journals",
    )  # fmt: skip

    def __init__(self, state: ManagerState, out: list[Instruction]) -> None:
        self._state = state
        self._out = out
        self._number = 0
        self._is_published = False
        self._components: dict[str, ComponentFacts] = {}
        self._connectors: dict[str, ConnectorProfile] = {}
        self._processes: tuple[ProcessFacts, ...] = ()
        self._signs: list[object] = []
        self._names: tuple[str, ...] = ()
        self._systems: tuple[Followed, ...] = ()
        self._journals: tuple[Journal[str], ...] = ()
        self._held: list[int] | None = None

    @property
    def run_id(self) -> str:
        """Return the id of this run of the manager."""
        return f"{self._state.pid}@{self._state.properties.get('manager.started', '')}"

    def resume(self) -> None:
        """Derive again what was known of the state, which is the same now."""
        if self._is_published:
            self._take_in()

    def listen(self, has_listeners: bool) -> None:
        """Note that somebody listens now, or that nobody does any more."""
        if not has_listeners:
            self._is_published = False
            self._end_journals()
        elif not self._is_published:
            self._begin()

    def hold(self) -> None:
        """Send no snapshot yet: what earlier managers left is not back, and would seem to end."""
        self._held = []

    def release(self) -> None:
        """Send snapshots from now on, first to the clients that have waited."""
        held, self._held = self._held, None
        for request in held or ():
            self.send_picture(request)

    def send_picture(self, request: int) -> None:
        """Answer with a snapshot, after an empty delta, which shows that deltas arrive."""
        if self._held is not None:
            self._held.append(request)
            return
        if not self._is_published:
            self._begin()
        self.run()
        self._publish(Delta(self.run_id, self._number + 1))
        whole = FullSnapshot(self.run_id, self._number, self._facts())
        self._out.append(AnswerClient(request, Reply(encode_text(whole))))

    def run(self) -> None:
        """Publish what has changed since the last time, if there are subscribers."""
        if not self._is_published:
            return
        delta = self._delta()
        if delta != Delta(delta.run, delta.number):
            self._publish(delta)

    def end(self) -> None:
        """Publish that the manager ends."""
        if self._is_published:
            self._publish(Delta(self.run_id, self._number + 1, is_last=True))

    def _begin(self) -> None:
        """Begin to publish; a skipped number makes an older subscriber take a new snapshot."""
        self._take_in()
        self._is_published = True
        self._number += 1
        self._publish(Delta(self.run_id, self._number + 1))

    def _publish(self, delta: Delta) -> None:
        self._number = delta.number
        self._out.append(Publish(TREE, encode(delta)))

    @property
    def _tables(self) -> tuple[IndexedTable[str, Any], ...]:
        """The tables of which changes are published."""
        return self._state.components, self._state.claims, self._state.connectors

    def _end_journals(self) -> None:
        for table, journal in zip(self._tables, self._journals, strict=False):
            table.end_journal(journal)
        self._journals = ()

    def _take_in(self) -> None:
        """Take the present facts for known."""
        self._end_journals()
        self._journals = tuple(table.begin_journal() for table in self._tables)
        facts = self._facts()
        self._components = {each.instance: each for each in facts.components}
        self._connectors = {each.connector_id: each for each in facts.connectors}
        self._processes, self._signs = facts.processes, self._process_signs()
        self._names, self._systems = facts.names, facts.systems

    def _facts(self) -> Snapshot:
        """Return what is published: not what is still being made, which has no names yet."""
        facts = self._state.snapshot()
        made = tuple(filter(self._is_made, facts.components))
        processes = _born(facts.processes)
        return replace(facts, components=made, processes=processes, modules=(), properties={})

    def _is_made(self, facts: ComponentFacts) -> bool:
        return facts.instance not in self._state.claims

    def _delta(self) -> Delta:
        """Return what has changed since the last time, which is known from now on."""
        state = self._state
        names = state.names if state.names != self._names else None
        reached = tuple(state.kept.reached.values())
        systems = reached if reached != self._systems else None
        self._names, self._systems = state.names, reached
        entered, claimed, joined = (journal.take() for journal in self._journals)
        touched = {**entered, **claimed}
        found = {each: state.components.get(each) for each in touched if each not in state.claims}
        components, gone = _renewed(self._components, touched, found.get)
        connectors, cut = _renewed(self._connectors, joined, state.connectors.get)
        processes, ended = self._changed_processes()
        number = self._number + 1
        return Delta(
            self.run_id, number, 0.0, components, gone, connectors, cut, processes, ended,
            names, systems,
        )  # fmt: skip

    def _changed_processes(self) -> tuple[tuple[ProcessFacts, ...], tuple[int, ...]]:
        signs = self._process_signs()
        if signs == self._signs:
            return (), ()
        before, self._processes = self._processes, _born(self._state.process_facts())
        self._signs = signs
        return changed(before, self._processes, "pid")

    def _process_signs(self) -> list[object]:
        """Return all that facts about processes follow from."""
        state = self._state
        signs: list[object] = [state.remark, state.unkept, state.barred]
        for p in state.processes.values():
            signs.append((p.pid, p.name, p.state, p.reason, p.silence))
            if p.stuck or not p.is_wanted:
                signs += [p.is_overdue, {**p.stuck}, state.held_by(p.key)]
        return signs


def _born(processes: Iterable[ProcessFacts]) -> tuple[ProcessFacts, ...]:
    return tuple(process for process in processes if process.pid)


def _renewed(
    known: dict[str, T], touched: Iterable[str], present: Callable[[str], T | None]
) -> tuple[tuple[T, ...], tuple[str, ...]]:
    """Bring rows up to date; return those that are new or other, and the keys of those gone."""
    fresh: list[T] = []
    gone: list[str] = []
    for key in touched:
        row, before = present(key), known.get(key)
        if row is None:
            if known.pop(key, None) is not None:
                gone.append(key)
        elif row is not before:
            if row != before:
                fresh.append(row)
            known[key] = row
    return tuple(fresh), tuple(gone)
