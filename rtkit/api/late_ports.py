"""Connects who reads patterns of ports to those that come meanwhile and match."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api.observers import Observers
from rtkit.closing import Closing
from rtkit.deployment.delta import TREE
from rtkit.deployment.listing import Listing, listing_of
from rtkit.errors import RtkitError
from rtkit.link.wakeup import Wakeup
from rtkit.probe.port_pattern import expanded
from rtkit.probe.port_spec import PortSpec, Stream, find_streams
from rtkit.probe.probe import Probe, Refusal, tap_ports
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import PortRef
from rtkit.tree.subscription import TreeChange

if TYPE_CHECKING:
    from rtkit.api.observers import ObservedEvent
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.probe.tap import Arrival
    from rtkit.rtc.names import Path

_SETTLE_S = 0.05
"""Time that others have to come, too, before the ports that came are looked at [s]."""

_RESTORED_S = 1.0
"""Time in which a manager connects a component again that it has restarted [s]."""

Namer = Callable[[int, PortRef], str]


class LatePorts(Closing):
    """Takes the arrivals of a probe, and gives it the ports that come; leave it when it is over.

    Args:
        session: Of whoever reads.
        probe: What reads; it is connected already.
        specs: The patterns, and ports named.
        streams: The streams that it is connected to.
        name: Names streams that the user did not name.
        refused: Is told why a port is not connected.
        add: Is called with a stream before its first value comes.
    """

    def __init__(
        self,
        session: Session,
        probe: Probe,
        specs: Sequence[PortSpec],
        streams: Sequence[Stream],
        name: Namer,
        refused: Refusal,
        add: Callable[[Stream], object],
    ) -> None:
        self._session = session
        self._probe = probe
        self._specs = specs
        self._name = name
        self._refused = refused
        self._add = add
        self._kinds = {each.name: self._kind(each) for each in streams}
        self._alive = {end.ref for each in streams for end in each.ends}
        self._restarts: dict[PortRef, int] = {}
        self._due: dict[PortRef, float] = {}
        self._waiting: list[Stream] = []
        self._until: float | None = None
        self._look_at: float | None = None
        self._wakeup = Wakeup()
        probe.component.notify = self._wakeup.ring
        self._observers = Observers(session, (TREE,))
        self._events = self._observers.listen(None, [self._wakeup.fileno()], self._next)
        self._look()

    def close(self) -> None:
        """Look for no more ports."""
        self._probe.component.notify = lambda: None
        self._observers.close()
        self._wakeup.close()

    def take(self, until: float | None) -> list[Arrival] | None:
        """Wait for arrivals until a monotonic time [s]; see `Probe.take`."""
        self._until = until
        while True:
            self._wakeup.hush()
            piece = self._probe.take(0.0)
            if piece is None or piece or (until is not None and monotonic() >= until):
                return piece
            if events := next(self._events):
                self._forget_gone(events)
                soon = monotonic() + _SETTLE_S
                self._look_at = soon if self._look_at is None else min(soon, self._look_at)
            if self._look_at is not None and monotonic() >= self._look_at:
                self._look()
                self._look_at = min(self._due.values(), default=None)

    def _forget_gone(self, events: Iterable[ObservedEvent]) -> None:
        """Forget ports of components that have gone, though they may be back at the next look."""
        changes = (change for _, change in events if isinstance(change, TreeChange))
        gone = {
            each.instance
            for change in changes
            for each in change.user_events
            if each.event in ("VANISHED", "ZOMBIE")
        }
        self._alive = {ref for ref in self._alive if ref.instance not in gone}
        self._waiting = [each for each in self._waiting if each.ends[0].ref.instance not in gone]

    def _next(self) -> float | None:
        return min((t for t in (self._until, self._look_at) if t is not None), default=None)

    def _look(self) -> None:
        """Take what has come; first the component gets ports, and they are connected when seen."""
        subscription = self._observers.subscriptions.get("")
        facts = subscription.facts if subscription is not None else None
        own = facts.component(self._probe.component.instance) if facts is not None else None
        if facts is None or own is None:
            return  # the manager is away, or does not know the recorder yet
        for stream in self._new(facts):
            if stream.name not in self._kinds:
                self._kinds[stream.name] = self._kind(stream)
                self._add(stream)
                self._probe.extend(tap_ports([stream]))
            self._waiting.append(stream)
        ready = [each for each in self._waiting if own.port(each.name) is not None]
        self._waiting = [each for each in self._waiting if each not in ready]
        if ready:
            self._probe.join(self._session.tree, ready, self._refused)
        for each in ready:
            self._session.verbose(f"{each.ends[0].path.typed} is recorded as {each.name}")

    def _new(self, facts: Snapshot) -> list[Stream]:
        """Return the streams of ports that have come, and that nobody has connected yet."""
        known = _Known(facts, listing_of(facts))
        was_alive, self._alive = self._alive, set()
        found = []
        for spec, ref in expanded(facts, self._specs, PortType.OUT, is_patient=True):
            if ref is None:
                continue  # a port that was named, and has gone
            restarts = known.restarts(ref)
            if ref not in was_alive and self._is_restored_later(ref, restarts):
                continue
            self._restarts[ref] = restarts
            self._alive.add(ref)
            if ref not in was_alive and not known.joins(ref, self._probe.component.instance):
                try:
                    (stream,) = find_streams(known, [spec], PortType.OUT, self._name)
                except RtkitError as error:
                    self._refused(str(error))  # it came back as another kind of port
                else:
                    found.append(self._with_name(stream))
        return found

    def _is_restored_later(self, ref: PortRef, restarts: int) -> bool:
        """Return whether to wait for the manager, which restores connections at a restart."""
        if restarts <= self._restarts.get(ref, restarts):
            return False
        due = self._due.setdefault(ref, monotonic() + _RESTORED_S)
        if monotonic() < due:
            return True
        del self._due[ref]
        return False

    def _with_name(self, stream: Stream) -> Stream:
        """Return a stream under a name that no stream of another kind has."""
        name, kind = stream.name, self._kind(stream)
        while self._kinds.get(name, kind) != kind:
            name += "_"
        return stream._replace(name=name)

    def _kind(self, stream: Stream) -> tuple[str, str, str]:
        """Return what streams of one name have in common: type, and port if that names them."""
        end = stream.ends[0]
        is_own = stream.name.rstrip("_") == self._name(0, end.ref).rstrip("_")
        return stream.data_type, stream.definition, str(end.ref) if is_own else ""


class _Known(NamedTuple):
    """Facts that need no request."""

    snapshot: Snapshot
    short: Listing

    def restarts(self, ref: PortRef) -> int:
        """Return how often a component was restarted."""
        component = self.snapshot.component(ref.instance)
        return component.restart_status.restarts if component is not None else 0

    def joins(self, ref: PortRef, instance: str) -> bool:
        """Return whether a port is connected to a component."""
        ends = (each.ports for each in self.snapshot.connectors if ref in each.ports)
        return any(end.instance == instance for each in ends for end in each)

    def listing(self) -> Listing:
        """Return the short list of components."""
        return self.short

    def listing_at(self, paths: Sequence[Path]) -> Listing:
        """Return the short list of components."""
        return self.short

    def part(self, instances: Sequence[str]) -> Snapshot:
        """Return everything."""
        return self.snapshot
