"""Meets the managers at the other ends of connectors: when one is found, or something has changed.

Nothing is sent while nothing changes; a meeting that fails is tried again as long as the peer runs.
"""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.message import message_from
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.manager.core import events as ev
from rtkit.manager.core import fences
from rtkit.manager.core.durable_replies import DurableReplies, SendResults, unkept
from rtkit.manager.core.effects import Procedure
from rtkit.manager.core.fences import check_fence
from rtkit.manager.core.halves import be_met, check_expected, connector_in, make_half, meet, show
from rtkit.manager.core.state import ManagerState
from rtkit.manager.core.tasks import Tasks, failed
from rtkit.manager.core.wiring import check_same, own_port
from rtkit.property.exchange import Reply, failure
from rtkit.rtc.far_ends import host_of
from rtkit.rtc.profiles import ConnectorProfile

_MEETING_S = 10.0
"""How long a meeting may take [s]."""
AGAIN_S = 1.0
"""Pause after a meeting that failed, or left a half that could not be joined [s]."""


class Meetings:
    """Meetings with peers; `out` collects instructions for the shell.

    Attributes:
        is_open: Peers may ask: all live processes have reported, and the manager does not end.
    """

    def __init__(
        self,
        state: ManagerState,
        out: list[ev.Instruction],
        tasks: Tasks,
        keeping: DurableReplies,
    ) -> None:
        self._state = state
        self._out = out
        self._tasks = tasks
        self._keeping = keeping
        self._watched: tuple[str, ...] = ()
        self._busy: set[str] = set()
        self._away: set[str] = set()
        self._pauses: dict[str, float] = {}
        self._retries: dict[str, float] = {}
        self.is_open = False
        self._now = 0.0

    def run(self, now: float) -> None:
        """Begin the meetings that are due at monotonic time `now` [s]."""
        kept, self._now = self._state.kept, now
        self._forget_expected()
        expected = {each.peer for each in self._state.expected.values()}
        if not (kept.far or kept.untold or expected or self._watched) or not self.is_open:
            return
        for peer in self._away - kept.far.keys():
            if not host_of(peer):
                kept.untold.pop(peer, None)  # it asks itself when it is back
        # A peer that is just asked is let go only when that is over.
        wanted = tuple(sorted({*kept.far, *kept.untold, *expected, *self._tasks.peers_asked()}))
        if wanted != self._watched:
            self._out.append(ev.WatchPeers(wanted))
            self._watched = wanted
            self._state.peers.intersection_update(wanted)
            self._away.intersection_update(wanted)
        for peer in self._due():
            ids = kept.untold.pop(peer)
            self._busy.add(peer)
            self._tasks.begin(self._meet(peer, ids), _MEETING_S, lambda _result: None)
        moments = [*self._pauses.values(), *self._retries.values()]
        moments += [each.until for each in self._state.expected.values()]
        if moments:
            self._out.append(ev.WakeAt(min(moments)))

    def _forget_expected(self) -> None:
        expected = self._state.expected
        for connector_id in [key for key, each in expected.items() if each.until <= self._now]:
            del expected[connector_id]

    def _due(self) -> Iterator[str]:
        """Yield the peers to be met now; a half that could not be joined is told, then retried."""
        kept, failing = self._state.kept, self._state.failing
        self._pauses = {peer: at for peer, at in self._pauses.items() if at > self._now}
        for peer in kept.far if failing else ():
            ids = [each for each in kept.far[peer] if each in failing]
            if ids and self._retries.setdefault(peer, self._now + AGAIN_S) <= self._now:
                for connector_id in ids:
                    del failing[connector_id]
                    kept.untell(peer, connector_id)
        self._retries = {peer: at for peer, at in self._retries.items() if at > self._now}
        for peer in list(kept.untold):
            is_free = peer not in self._busy and peer not in self._pauses
            if is_free and peer in self._state.peers:
                yield peer

    def _meet(self, peer: str, ids: dict[str, str]) -> Procedure:
        try:
            yield from meet(self._state, peer, ids)
        except RtkitError as error:
            for connector_id, making in ids.items():
                self._state.kept.untell(peer, connector_id, making)
                if connector_id in self._state.kept.far.get(peer, ()):  # else another peer has it
                    show(self._state, connector_id, str(error))
            self._pauses[peer] = self._now + AGAIN_S
        finally:
            self._busy.discard(peer)
        return Result()

    def found(self, event: ev.PeerFound) -> None:
        """Have all halves met whose other ones a peer has that can be asked now."""
        self._state.peers.add(event.peer)
        self._away.discard(event.peer)
        self._pauses.pop(event.peer, None)
        for connector_id in self._state.kept.far.get(event.peer, ()):
            self._state.kept.untell(event.peer, connector_id)

    def lost(self, event: ev.PeerLost) -> None:
        """Note that a peer has ended: what its slaves hold goes on, nobody answers for it."""
        self._state.peers.discard(event.peer)
        self._away.add(event.peer)
        self._tasks.peer_lost(event.peer, Unreachable(event.why))
        fences.note_lost(self._state, event.peer, event.why)
        for connector_id in self._state.kept.far.get(event.peer, ()):
            show(self._state, connector_id, event.why)

    def asked(self, event: ev.PeerAsked) -> None:
        """Do what a peer asks, and answer once that is recorded."""

        def answer(results: list[Result]) -> None:
            (result,) = results
            text, kind = (result.value, "") if result.ok else (result.why, result.kind)
            self._out.append(ev.AnswerClient(event.request, Reply(text, kind)))

        try:
            if not self.is_open:
                raise Unreachable(f"manager {self._state.name} is just starting, or ending")
            message = message_from(event.text)
            op = message.get("op")
            if event.peer and message.get("manager") != event.peer:
                raise Refused(f"{event.peer} poses as {message.get('manager')}")
            if op == "meet":
                steps = be_met(self._state, message)
                self._tasks.begin(steps, _MEETING_S, lambda result: answer([result]))
                return
            if op != "make":
                raise Malformed(f"no such request of a manager: {op!r}")
            connector = connector_in(self._state, message)
            check_fence(self._state, connector)
            if event.peer:
                check_expected(self._state, connector)
            check_same(self._state, connector)
        except RtkitError as error:
            self._out.append(ev.AnswerClient(event.request, failure(error)))
            return
        making = make_half(self._state, message, connector, own_port)
        self._make(connector, making, answer)

    def _make(self, connector: ConnectorProfile, making: Procedure, answer: SendResults) -> None:
        actions = [act.Connect(connector)]

        def done(result: Result) -> None:
            self._keeping.finish(actions, [result], answer)

        def go_on(why: str) -> None:
            if why:
                answer([failed(Refused(unkept(why)))])
            else:
                self._tasks.begin(making, _MEETING_S, done)

        self._keeping.admit(actions, go_on)
