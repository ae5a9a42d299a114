"""``rtwatch``: print what happens to components, as it happens."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rtkit.api.events import Record, Watch, kinds_of, topics
from rtkit.api.observers import Observers, scopes_of
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.json_records import line as json_line
from rtkit.cli.shared.json_records import time_text
from rtkit.cli.shared.options import (
    COUNT,
    WordChoice,
    arguments,
    json_flag,
    lasting,
    option,
    several,
)
from rtkit.cli.shared.system_values import PARAMETERS
from rtkit.cli.shared.terminal import clock
from rtkit.deployment.user_events import KINDS, SYSTEM_STATE

if TYPE_CHECKING:
    from rtkit.api.gathering import Managers
    from rtkit.deployment.states.states import States

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
    statuses={"1": "The time was up before N events, or it could not be done."},
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
    parameters: None = PARAMETERS,
    is_json: bool = json_flag(),
    paths: tuple[str, ...] = arguments("PATH..."),
) -> int:
    r"""Print what happens to components, as it happens.

    PATH is a component; or a directory or manager, for all that is, or comes, below it; / for
    everything, on linked hosts, too. Each line has the time, the path, what it happened to, and
    what happened.

    \b
    TREE_EVENT         it appeared, vanished, became a zombie; a process began or ended
    RTC_STATUS         its state in an execution context: ACTIVE INACTIVE ERROR
    COMPONENT_PROFILE  what changed of its names, members, options
    EC_EVENT           an execution context: attached, detached, started, shut down, its rate
    PORT_EVENT         a port: added, removed, connected, disconnected
    CONFIG_EVENT       a configuration set or parameter: changed, added, removed, activated
    FSM_EVENT          its state machine: state, structure, events
    SUPERVISION        its policy and rules of health: RETURNING MADE_AGAIN GIVEN_UP DEGRADED
                       WELL STOPPED CRITICAL_STOP DEVICE_GONE DEVICE_APPEARED, with the reason
    SYSTEM_STATE       a system that is followed (rtstate): to which state it came, or FOLLOWED
                       TRANSITION_FAILED WAITS NOT_FOLLOWED; with --system it is seen in what
                       lives: all conditions of the state hold
    HEARTBEAT          once a second, of the component and each execution context that runs

    A manager that ends is waited for, one that begins is listened to. A state that is left
    again at once may not be told. The status is 1 when the time is up before N events, or any at
    all, have come.
    """
    if not paths:
        raise WrongArguments("No component specified.")
    wanted = kinds_of(kinds)
    states, managers = _states(app, system) if system is not None else (None, None)
    app.bound(duration_s)
    until = None if duration_s is None else time.monotonic() + duration_s
    scopes = scopes_of(app, paths)
    is_wide = managers is not None or not all(scope.is_one_manager for scope in scopes)
    left = number
    has_hosts = managers is not None or not all(scope.is_one_host for scope in scopes)
    with Observers(app, topics(wanted), is_wide=is_wide, has_hosts=has_hosts) as subscriptions:
        watch = Watch(app, subscriptions, scopes, wanted, states, managers)
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
    from rtkit.cli.system.document import read_as_is
    from rtkit.deployment.goal import DeploymentGoal

    document = read_as_is(app, (file,))
    is_wide = names_another(document.profile)
    managers = Managers(document.profile, app.usual_manager) if is_wide else None
    snapshot = looking.snapshot(app)
    if managers is not None:
        snapshot = managers.joined([snapshot])
    system = looking.wanted_system(app, document, snapshot)
    return states_of(DeploymentInputs(document, DeploymentGoal(system), snapshot)), managers


def _json(record: Record) -> str:
    return json_line("event", {**record, "time": time_text(int(record["time"] * 1e9))})


def _line(record: Record) -> str:
    words = [record["path"], record["subject"], record["event"]]
    if record["detail"]:
        words.append(f"({record['detail']})")
    return terminal.printable(f"[{clock(record['time'])}] {' '.join(filter(None, words))}")
