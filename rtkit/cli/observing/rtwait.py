"""``rtwait``: wait for components, their states, and data of ports."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from rtkit.api.waiting import WORDS, Problem, WaitGoal, goal_of, reach
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import NumberChoice, arguments, json_flag, option
from rtkit.errors import Malformed, Partial, RtkitError
from rtkit.rtc.names import Path

_DEFAULT_S = 30.0


@command(
    "rtwait",
    examples=(
        ("rtwait -t 10 Robot0.rtc active", "Until it is active, or 10 s are over."),
        ("rtwait A.rtc B.rtc active Laser0.rtc:scan data", "A and B active, and a scan came."),
    ),
    json=("goal",),
    arguments=("waited-for",),
    words=WORDS,
    statuses={"1": "The time was up first, or it could not be done."},
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
    app.bound(timeout_s)
    goals = _goals(app, words)
    problems = reach(app, goals, begin + timeout_s)
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
            goals += [goal_of(path, state) for path in pending]
            pending = []
        else:
            _check_path(word)
            pending.append(app.path(word))
    goals += [goal_of(path) for path in pending]
    if not goals:
        raise WrongArguments("No component specified.")
    return goals


def _check_path(word: str) -> None:
    """Refuse a path that is probably a mistyped state: it would never exist."""
    from rtkit.rtc.nearest import did_you_mean

    if not set(word) & set("/.:") and (meant := did_you_mean(word, WORDS)):
        raise Malformed(f"neither a path nor a state: {word}{meant}")


def _failures(problems: Sequence[Problem], timeout_s: float) -> list[tuple[str, RtkitError]]:
    return [
        (goal.path.typed, RtkitError(f"{goal.path.typed} {problem} after {timeout_s:g} s"))
        for goal, problem in problems
    ]
