"""Publishes deltas of the state to subscribers after each event; idle while there are none.

See decision 20.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.deployment.delta import TREE, Delta, FullSnapshot, delta_between
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.fast_dataclass import replace
from rtkit.manager.core.events import AnswerClient, Instruction, Publish
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import encode, encode_text


class ChangeFeed:
    """State as the subscribers know it; `out` collects instructions for the shell."""

    DERIVED = ("_components", "_connectors", "_processes", "_claims")

    def __init__(self, state: ManagerState, out: list[Instruction]) -> None:
        self._state = state
        self._out = out
        self._number = 0
        self._known: Snapshot | None = None
        self._components: dict[str, ComponentFacts] = {}
        self._connectors: dict[str, ConnectorProfile] = {}
        self._processes: list[tuple[object, ...]] = []
        self._claims: list[str] = []
        self._held: list[int] | None = None

    @property
    def run_id(self) -> str:
        """Return the id of this run of the manager."""
        return f"{self._state.pid}@{self._state.properties.get('manager.started', '')}"

    def resume(self) -> None:
        """Derive again what was known of the state, which is the same now."""
        self._is_other()

    def listen(self, has_listeners: bool) -> None:
        """Note that somebody listens now, or that nobody does any more."""
        if not has_listeners:
            self._known = None
        elif self._known is None:
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
        if self._known is None:
            self._begin()
        self.run()
        assert self._known is not None
        self._publish(Delta(self.run_id, self._number + 1))
        whole = FullSnapshot(self.run_id, self._number, self._known)
        self._out.append(AnswerClient(request, Reply(encode_text(whole))))

    def run(self) -> None:
        """Publish what has changed since the last time, if there are subscribers."""
        if self._known is None or not self._is_other():
            return
        now = self._facts()
        delta = delta_between(self._known, now, self.run_id, self._number + 1)
        self._known = now
        if delta != Delta(delta.run, delta.number):
            self._publish(delta)

    def end(self) -> None:
        """Publish that the manager ends."""
        if self._known is not None:
            self._publish(Delta(self.run_id, self._number + 1, is_last=True))

    def _begin(self) -> None:
        """Begin to publish; a skipped number makes an older subscriber take a new snapshot."""
        self._is_other()
        self._known = self._facts()
        self._number += 1
        self._publish(Delta(self.run_id, self._number + 1))

    def _publish(self, delta: Delta) -> None:
        self._number = delta.number
        self._out.append(Publish(TREE, encode(delta)))

    def _facts(self) -> Snapshot:
        """Return what is published: not what is still being made, which has no names yet."""
        facts = self._state.snapshot()
        known = tuple(process for process in facts.processes if process.pid)
        made = tuple(each for each in facts.components if each.instance not in self._state.claims)
        return replace(facts, components=made, processes=known, modules=(), properties={})

    def _is_other(self) -> bool:
        """Return whether anything may have changed: facts are replaced, never changed in place."""
        state = self._state
        processes = [
            (p.pid, p.name, p.state, p.reason, *p.stuck.items()) for p in state.processes.values()
        ]
        claims = list(state.claims)
        is_same = (
            processes == self._processes
            and claims == self._claims
            and _same(state.components, self._components)
            and _same(state.connectors, self._connectors)
            and (self._known is None or self._known.names == state.names)
            and (self._known is None or self._known.systems == tuple(state.kept.reached.values()))
        )
        if is_same:
            return False
        self._processes, self._claims = processes, claims
        self._components = dict(state.components)
        self._connectors = dict(state.connectors)
        return True


def _same(one: Mapping[str, object], other: Mapping[str, object]) -> bool:
    return len(one) == len(other) and all(other.get(key) is each for key, each in one.items())
