"""``rtwait``: wait for components, their states, and data of ports."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import NumberChoice, arguments, json_flag, option
from rtkit.errors import Malformed, Partial, RtkitError

if TYPE_CHECKING:
    from rtkit.api.observers import Observers
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

EXISTS, GONE, DATA = "exists", "gone", "data"
_STATES = {"created": "Created", "inactive": "Inactive", "active": "Active", "error": "Error"}
WORDS = (EXISTS, *_STATES, GONE, DATA)
_DEFAULT_S = 30.0


class WaitGoal(NamedTuple):
    """Desired state of one path."""

    path: Path
    wanted: str

    def problem(self, node: TreeNode | None) -> str:
        """Return the reason why the goal does not hold, "" when it does."""
        row = node.row if node is not None else None
        if row is None:
            return "" if self.wanted == GONE else "does not exist"
        if self.wanted == GONE:
            return "still exists"
        if row.zombie:
            return f"is a zombie ({row.zombie})"
        if self.wanted in (EXISTS, DATA) or row.state == _STATES[self.wanted]:
            return ""
        why = f" ({row.trouble or row.cause})" if row.trouble or row.cause else ""
        return f"is {row.state}{why}, not {_STATES[self.wanted]}"


Problem = tuple[WaitGoal, str]


@command(
    "rtwait",
    examples=(
        ("rtwait -t 10 Robot0.rtc active", "Until it is active, or 10 s are over."),
        ("rtwait A.rtc B.rtc active Laser0.rtc:scan data", "A and B active, and a scan came."),
    ),
    json=("goal",),
    arguments=("waited-for",),
    words=WORDS,
    statuses={
        "1": "The time was up first, or it could not be done.",
    },
)
def main(
    app: App,
    timeout_s: float = option(
        "--timeout -t SECONDS",
        "How long to wait at most (default 30).",
        NumberChoice(min=0.01),
        default=_DEFAULT_S,
    ),
    is_json: bool = json_flag("One JSON object a path, at the end."),
    words: tuple[str, ...] = arguments("PATH... [STATE]..."),
) -> int:
    r"""Wait for components, their states, and data of ports.

    A state holds for the paths before it: exists (what is meant when there is none), created,
    inactive, active, error, gone; data for ports, which is what is meant by PATH:PORT.

    \b
    rtwait Robot0.rtc                             until it exists
    rtwait Robot0.rtc Laser0.rtc active           until both are active
    rtwait Robot0.rtc active Laser0.rtc:scan      and until a scan comes

    The status is 0 when all of that holds at once, 1 when the time is up: then each path for
    which it does not is told with the reason. It waits for the manager, too.
    """
    begin = time.monotonic()
    until = begin + timeout_s
    app.bound(timeout_s)
    goals = _goals(app, words)
    problems = _reach(app, goals, until)
    carried = [goal for goal in goals if goal.wanted == DATA]
    if carried and not problems:
        problems = _await_values(app, carried, until)
    if is_json:
        terminal.write(
            json_records.lines("goal", _goal_records(goals, problems, time.monotonic() - begin))
        )
        return app.status(RtkitError()) if problems else 0
    if problems:
        raise Partial("", failures=_failures(problems, timeout_s))
    return 0


def _goal_records(
    goals: Sequence[WaitGoal], problems: Sequence[Problem], waited_s: float
) -> Iterator[dict[str, object]]:
    why = dict(problems)
    for goal in goals:
        yield {
            "path": str(goal.path),
            "wanted": goal.wanted,
            "reached": goal not in why,
            "problem": why.get(goal),
            "waited_s": round(waited_s, 6),
        }


def _goals(app: App, words: Sequence[str]) -> list[WaitGoal]:
    goals: list[WaitGoal] = []
    pending: list[Path] = []
    for word in words:
        state = word.casefold()
        if state in WORDS:
            if not pending:
                raise WrongArguments(f"No path before the state {word}.")
            goals += [_goal(path, state) for path in pending]
            pending = []
        else:
            _check_path(word)
            pending.append(app.path(word))
    goals += [_goal(path, DATA if path.port else EXISTS) for path in pending]
    if not goals:
        raise WrongArguments("No component specified.")
    return goals


def _check_path(word: str) -> None:
    """Refuse a path that is probably a mistyped state: it would never exist."""
    from rtkit.rtc.nearest import did_you_mean

    if not set(word) & set("/.:") and (meant := did_you_mean(word, WORDS)):
        raise Malformed(f"neither a path nor a state: {word}{meant}")


def _goal(path: Path, wanted: str) -> WaitGoal:
    if (path.port is not None) is not (wanted == DATA):
        what = "a state is one of a component" if path.port else "data come from a port"
        raise Malformed(f"{path.typed} {wanted}: {what}")
    if path.is_directory or not path.elements:
        raise Malformed(f"Not a component: {path.typed}")
    return WaitGoal(path, wanted)


def _reach(app: App, goals: Sequence[WaitGoal], until: float) -> Sequence[Problem]:
    """Wait until all goals hold, looking again only when something has changed.

    When the time is up it returns what is missing; no manager answers may be why.
    """
    from rtkit.api.observers import Observers
    from rtkit.deployment.delta import TREE

    with Observers(app, (TREE,), is_patient=True) as subscriptions:
        if subscriptions.why is not None:
            app.verbose(str(subscriptions.why))
        problems = _problems(goals, subscriptions)
        for _ in subscriptions.listen(until) if problems else ():
            problems = _problems(goals, subscriptions)
            if not problems:
                return []
        if not subscriptions.subscriptions and subscriptions.why is not None:
            return [(goal, f"is not known: {subscriptions.why}") for goal in goals]
        return problems


def _problems(goals: Sequence[WaitGoal], subscriptions: Observers) -> list[Problem]:
    """Return the unmet condition of each goal, as far as is known."""
    from rtkit.deployment.listing import listing_of
    from rtkit.tree.resolve import find
    from rtkit.tree.view import build

    subscription = subscriptions.subscriptions.get("")
    if subscription is None:
        return [(goal, "is at a manager that does not answer") for goal in goals]
    root = build(listing_of(subscription.facts))
    pairs = ((goal, goal.problem(find(root, goal.path, subscription.facts.host))) for goal in goals)
    return [(goal, problem) for goal, problem in pairs if problem]


def _failures(problems: Sequence[Problem], timeout_s: float) -> list[tuple[str, RtkitError]]:
    return [
        (goal.path.typed, RtkitError(f"{goal.path.typed} {problem} after {timeout_s:g} s"))
        for goal, problem in problems
    ]


def _await_values(app: App, goals: Sequence[WaitGoal], until: float) -> Sequence[Problem]:
    """Wait until each of these ports has carried a value; return those that did not in time."""
    from rtkit.probe.port_spec import PortSpec, find_streams
    from rtkit.probe.probe import Probe, tap_ports
    from rtkit.rtc.enums import PortType

    specs = [PortSpec(goal.path.typed, goal.path) for goal in goals]
    streams = find_streams(app.tree, specs, PortType.OUT)
    silent = dict(zip((stream.name for stream in streams), goals, strict=True))
    with Probe(app.tree, "rtwait", streams, tap_ports(streams)) as probe:
        probe.connect({})
        for piece in probe.arrivals(until):
            for arrival in piece:
                silent.pop(arrival.stream, None)
            if not silent:
                return []
    return [(goal, "carried no data") for goal in silent.values()]
