"""``rtwatch``: print what happens to components, as it happens."""

from __future__ import annotations

import time
from collections.abc import Container, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from rtkit.api.observers import (
    ManagerSeen,
    Observers,
    is_covered,
    place_of,
    scopes_of,
)
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.json_records import line as json_line
from rtkit.cli.shared.json_records import picked, time_text
from rtkit.cli.shared.options import (
    COUNT,
    WordChoice,
    arguments,
    json_flag,
    lasting,
    option,
    several,
)
from rtkit.cli.shared.terminal import clock
from rtkit.deployment.user_events import HEARTBEAT, KINDS, SYSTEM_STATE, UserEvent, heartbeats

if TYPE_CHECKING:
    from rtkit.api.gathering import Managers
    from rtkit.api.observers import ObservedEvent
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.metrics import Metrics
    from rtkit.deployment.states.states import States
    from rtkit.tree.scope import Scope

Record = dict[str, Any]
ALL = "ALL"


@command(
    "rtwatch",
    examples=(
        ("rtwatch /", "Everything that happens on this host."),
        ("rtwatch -f rtc_status Robot0.rtc Arm0.rtc", "Only states of two components."),
        ("rtwatch -n 1 -t 60 -f tree_event Robot0.rtc", "Until it goes; status 1 if it does not."),
        ("rtwatch --json / > events.jsonl", "For another program."),
    ),
    json=("event",),
    arguments=("anything",),
    statuses={
        "1": "The time was up before N events, or it could not be done.",
    },
)
def main(
    app: App,
    kinds: tuple[str, ...] = several(
        "-f --filter KIND",
        "Print only events of this kind (default: all but HEARTBEAT).",
        type=WordChoice("kind of event", (ALL, *KINDS, SYSTEM_STATE)),
    ),
    number: int | None = option("-n --number N", "Stop after N events.", COUNT),
    duration_s: float | None = lasting(),
    system: str | None = option(
        "-S --system FILE",
        "Tell also to which of its states the system of this profile comes (rtstate).",
    ),
    is_json: bool = json_flag(),
    paths: tuple[str, ...] = arguments("PATH..."),
) -> int:
    r"""Print what happens to components, as it happens.

    PATH is a component; or a directory or manager, for all that is, or comes, below it; / for
    everything. Each line has the time, the path, what it happened to, and what happened.

    \b
    TREE_EVENT         it appeared, vanished, became a zombie; a process began or ended
    RTC_STATUS         its state in an execution context: ACTIVE INACTIVE ERROR
    COMPONENT_PROFILE  what changed of its names, members, options
    EC_EVENT           an execution context: attached, detached, started, shut down, its rate
    PORT_EVENT         a port: added, removed, connected, disconnected
    CONFIG_EVENT       a configuration set or parameter: changed, added, removed, activated
    FSM_EVENT          its state machine: state, structure, events
    SUPERVISION        its policy and rules of health: RETURNING MADE_AGAIN GIVEN_UP DEGRADED
                       WELL STOPPED CRITICAL_STOP, with the reason
    SYSTEM_STATE       a system that is followed (rtstate): to which state it came, or FOLLOWED
                       TRANSITION_FAILED WAITS NOT_FOLLOWED; with --system it is seen in what
                       lives: all conditions of the state hold
    HEARTBEAT          once a second, of the component and each execution context that runs

    A manager that ends is waited for, one that begins is listened to. A state that is left
    again at once may not be told. The status is 1 when the time is up before N events, or any at
    all, have come.
    """
    from rtkit.deployment.delta import TREE
    from rtkit.deployment.metrics import METRICS

    if not paths:
        raise WrongArguments("No component specified.")
    all_kinds = {*KINDS, SYSTEM_STATE}
    wanted = all_kinds if ALL in kinds else set(kinds) or all_kinds - {HEARTBEAT}
    states, managers = _states(app, system) if system is not None else (None, None)
    app.bound(duration_s)
    until = None if duration_s is None else time.monotonic() + duration_s
    scopes = scopes_of(app, paths)
    is_wide = managers is not None or not all(scope.is_one_manager for scope in scopes)
    lines = (TREE, METRICS) if HEARTBEAT in wanted else (TREE,)
    left = number
    with Observers(app, lines, is_wide=is_wide) as subscriptions:
        watch = _Watch(app, subscriptions, scopes, wanted, states, managers)
        watch.begin()
        app.verbose("listening")
        for events in subscriptions.listen(until):
            records = list(watch.records(events))[:left]
            terminal.write_now([_json(each) if is_json else _line(each) for each in records])
            left = None if left is None else left - len(records)
            if left == 0:
                return 0
    return 0 if number is None and watch.count else 1


def _states(app: App, file: str) -> tuple[States, Managers | None]:
    """Return the states of the system of a profile, and its managers if it is not in one.

    Raises:
        InvalidDocument: It tells none, or they make no sense.
    """
    from rtkit.api import looking
    from rtkit.api.gathering import Managers, names_another
    from rtkit.api.planning import DeploymentInputs
    from rtkit.api.states import states_of
    from rtkit.cli.system.document import read_document
    from rtkit.deployment.goal import DeploymentGoal

    document = read_document(app, (file,))
    is_wide = names_another(document.profile)
    managers = Managers(document.profile, app.usual_manager) if is_wide else None
    snapshot = looking.snapshot(app)
    if managers is not None:
        snapshot = managers.joined([snapshot])
    system = looking.wanted_system(app, document, snapshot)
    return states_of(DeploymentInputs(document, DeploymentGoal(system), snapshot)), managers


class _Watch:
    """Makes records of the wanted events.

    Attributes:
        count: Number of records made.
    """

    def __init__(
        self,
        app: App,
        subscriptions: Observers,
        scopes: Sequence[Scope],
        wanted: Container[str],
        states: States | None,
        managers: Managers | None,
    ) -> None:
        self._states = states
        self._managers = managers
        self._state = ""
        self._app = app
        self._subscriptions = subscriptions
        self._scopes = scopes
        self._wanted = wanted
        self._host = app.tree.host
        self.count = 0

    def records(self, events: Sequence[ObservedEvent]) -> Iterator[Record]:
        """Yield a record for each event."""
        from rtkit.deployment.metrics import Metrics
        from rtkit.tree.subscription import TreeChange

        for manager, event in events:
            if isinstance(event, TreeChange):
                if event.lost:
                    self._app.fail(f"{event.lost} news were missed; what they led to is told")
                yield from self._chosen(manager, event.time, event.user_events)
                yield from self._came_to(manager, event.time)
            elif isinstance(event, Metrics):
                yield from self._chosen(manager, event.time, self._heartbeats(manager, event))
            elif isinstance(event, ManagerSeen):
                self._app.fail(str(event))
            else:
                self._app.fail(f"{event.why}; waiting for it to come back")

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
        name = self._subscriptions.names[manager]
        return {
            "time": moment,
            "kind": user_event.kind,
            "path": place_of(name, user_event, self._host, is_usual=not manager),
            "manager": name,
            **picked(user_event, "process instance subject event detail"),
            **_restart(user_event),
        }


def _restart(user_event: UserEvent) -> Record:
    """Return which restart it was, in numbers; nothing for other events."""
    restart = user_event.restart
    if restart is None:
        return {}
    return {"restart": picked(restart, "count=restarts why took_s")}


def _json(record: Record) -> str:
    return json_line("event", {**record, "time": time_text(int(record["time"] * 1e9))})


def _line(record: Record) -> str:
    words = [record["path"], record["subject"], record["event"]]
    if record["detail"]:
        words.append(f"({record['detail']})")
    return terminal.printable(f"[{clock(record['time'])}] {' '.join(filter(None, words))}")
