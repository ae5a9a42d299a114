"""Events of components, processes and systems, each with its place in the tree."""

from __future__ import annotations

from collections.abc import Container, Generator, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.api.observers import ManagerSeen, Observers, is_covered, place_of, scopes_of
from rtkit.deployment.user_events import HEARTBEAT, KINDS, SYSTEM_STATE, UserEvent, heartbeats

if TYPE_CHECKING:
    from rtkit.api.gathering import Managers
    from rtkit.api.observers import ObservedEvent
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.metrics import Metrics
    from rtkit.deployment.states.states import States
    from rtkit.tree.scope import Scope

Record = dict[str, Any]


class SystemEvent(NamedTuple):
    """Something that happened to a component, a process or a system.

    Attributes:
        time: When the manager sent it [s since 1970].
        kind: ``TREE_EVENT``, ``RTC_STATUS``, ``PORT_EVENT`` …: those of ``rtwatch -h``.
        path: What it happened to.
        subject: Which execution context, port, configuration set; empty for the whole.
        event: What happened: ``ACTIVE``, ``VANISHED``, ``PORT_CONNECT`` …
        detail: More about it.
    """

    time: float
    kind: str
    path: str
    subject: str
    event: str
    detail: str


def kinds_of(names: Iterable[str]) -> set[str]:
    """Return the kinds of events that are meant: ``ALL``, or none for all but heartbeats."""
    every = {*KINDS, SYSTEM_STATE}
    given = set(names)
    return every if "ALL" in given else given or every - {HEARTBEAT}


def watched(
    session: Session, paths: Sequence[str], kinds: Iterable[str], until: float | None
) -> Generator[SystemEvent | None, None, None]:
    """Yield None when ready, then what happens below some paths until a moment [s, monotonic].

    Raises:
        NotFound: A path leads nowhere.
        Unreachable: The manager does not answer.
    """
    wanted = kinds_of(kinds)
    scopes = scopes_of(session, paths)
    is_wide = not all(scope.is_one_manager for scope in scopes)
    has_hosts = not all(scope.is_one_host for scope in scopes)
    with Observers(session, topics(wanted), is_wide=is_wide, has_hosts=has_hosts) as subscriptions:
        watch = Watch(session, subscriptions, scopes, wanted)
        yield None
        for events in subscriptions.listen(until):
            for each in watch.records(events):
                yield SystemEvent(*(each[name] for name in SystemEvent._fields))


def topics(wanted: Container[str]) -> tuple[str, ...]:
    """Return the topics of managers on which events of these kinds come."""
    from rtkit.deployment.delta import TREE
    from rtkit.deployment.metrics import METRICS

    return (TREE, METRICS) if HEARTBEAT in wanted else (TREE,)


class Watch:
    """Makes records of the wanted events.

    Attributes:
        count: Number of records made.
    """

    def __init__(
        self,
        session: Session,
        subscriptions: Observers,
        scopes: Sequence[Scope],
        wanted: Container[str],
        states: States | None = None,
        managers: Managers | None = None,
    ) -> None:
        """Prepare to make records.

        Args:
            session: Of whoever watches.
            subscriptions: To the managers.
            scopes: What is watched.
            wanted: Kinds of events.
            states: States of a system to which it comes are events, too.
            managers: Of that system if it is not in one.
        """
        self._states = states
        self._managers = managers
        self._state = ""
        self._session = session
        self._subscriptions = subscriptions
        self._scopes = scopes
        self._wanted = wanted
        self._host = session.tree.host
        self.count = 0

    def records(self, events: Sequence[ObservedEvent]) -> Iterator[Record]:
        """Yield a record for each event."""
        from rtkit.deployment.metrics import Metrics
        from rtkit.tree.subscription import TreeChange

        for manager, event in events:
            if isinstance(event, TreeChange):
                if event.lost:
                    self._session.fail(f"{event.lost} news were missed; what they led to is told")
                yield from self._chosen(manager, event.time, event.user_events)
                yield from self._came_to(manager, event.time)
            elif isinstance(event, Metrics):
                yield from self._chosen(manager, event.time, self._heartbeats(manager, event))
            elif isinstance(event, ManagerSeen):
                self._session.fail(str(event))
            else:
                self._session.fail(f"{event.why}; waiting for it to come back")

    def _chosen(
        self, manager: str, moment: float, happened: Iterable[UserEvent]
    ) -> Iterator[Record]:
        for each in happened:
            if self._is_seen(each):
                continue
            if each.kind in self._wanted and is_covered(self._scopes, manager, each, self._host):
                self.count += 1
                yield self._record(manager, moment, each)

    def _is_seen(self, user_event: UserEvent) -> bool:
        """Return whether the arrival of a system in a state is reported all the same."""
        system = user_event.system
        is_own = (
            self._states is not None and system is not None and system.system == self._states.name
        )
        return is_own and system is not None and user_event.event == system.state

    def begin(self) -> None:
        """Record the state of the system before anything happens."""
        facts = self._facts("")
        if self._states is not None and facts is not None:
            self._state = self._states.now(facts)

    def _facts(self, manager: str) -> Snapshot | None:
        """Return the facts of the system, if this manager has a part in it."""
        if self._managers is not None:
            return self._managers.joined(
                [subscription.facts for subscription in self._subscriptions.subscriptions.values()]
            )
        subscription = self._subscriptions.subscriptions.get(manager)
        return subscription.facts if subscription is not None and not manager else None

    def _came_to(self, manager: str, moment: float) -> Iterator[Record]:
        """Yield a record when the system is in another state than before."""
        facts = self._facts(manager)
        if self._states is None or facts is None or SYSTEM_STATE not in self._wanted:
            return
        now = self._states.now(facts, self._state)
        if now in ("", self._state):
            return
        before, self._state = self._state, now
        self.count += 1
        user_event = UserEvent(
            SYSTEM_STATE, "", "", "state", now, f"was {before}" if before else ""
        )
        yield {**self._record(manager, moment, user_event), "path": self._states.name}

    def _heartbeats(self, manager: str, metrics: Metrics) -> Iterator[UserEvent]:
        subscription = self._subscriptions.subscriptions.get(manager)
        known = (
            {facts.instance: facts for facts in subscription.facts.components}
            if subscription
            else {}
        )
        for process in metrics.processes:
            for component in process.components:
                facts = known.get(component.instance)
                if facts is not None and not facts.trouble:
                    yield from heartbeats(facts, [c.id for c in component.contexts if c.is_running])

    def _record(self, manager: str, moment: float, user_event: UserEvent) -> Record:
        name, places = self._subscriptions.names[manager], self._subscriptions.places
        return {
            "time": moment,
            "kind": user_event.kind,
            "path": place_of(
                name, user_event, self._host, is_usual=not manager, local=places[manager]
            ),
            "manager": name,
            "process": user_event.process,
            "instance": user_event.instance,
            "subject": user_event.subject,
            "event": user_event.event,
            "detail": user_event.detail,
            **_restart(user_event),
        }


def _restart(user_event: UserEvent) -> Record:
    """Return which restart it was, in numbers; nothing for other events."""
    restart = user_event.restart
    if restart is None:
        return {}
    facts = {"count": restart.restarts, "why": restart.why, "took_s": restart.took_s}
    return {"restart": facts}
