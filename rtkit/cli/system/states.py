"""Presents the states that a system's profile defines, for people and as records."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtkit.cli.shared.json_records import picked, time_text

if TYPE_CHECKING:
    from rtkit.api.states import StatesReport
    from rtkit.deployment.facts import Followed
    from rtkit.deployment.states.machine import SystemStates
    from rtkit.deployment.states.states import Way


def as_lines(report: StatesReport) -> list[str]:
    """Return for people: each state with the way there, the events of the present one, who follows.

    Args:
        report: Of a look at the system.
    """
    now, ways, followed = report.now, report.ways(), report.followed
    width = max(len(way.state) for way in ways)
    lines = [
        f"{'*' if way.state == now else ' '} {way.state:<{width}}  {_way_text(way, now)}".rstrip()
        for way in ways
    ]
    if not now:
        lines.append("state not known" if report.live.unreachable else "between states")
    events = _events(report.states.machine, now)
    width = max((len(each["event"]) for each in events), default=0)
    to = max((len(each["to"]) for each in events), default=0)
    for each in events:
        when = each["when"] or "on command"
        lines.append(
            f"  -{each['event']}->{' ' * (width - len(each['event']))} {each['to']:<{to}}  {when}"
        )
    return lines + (_followed_lines(followed) if followed is not None else [])


def as_record(report: StatesReport) -> dict[str, Any]:
    """Return the same as a record."""
    now, followed = report.now, report.followed
    return {
        "system": report.states.name,
        "state": now,
        "states": [
            {
                "name": way.state,
                "steps": None if way.plan is None else len(way.plan.moves),
                "cost": None if way.plan is None else round(way.plan.cost, 6),
                "impossible": way.why,
            }
            for way in report.ways()
        ],
        "events": _events(report.states.machine, now),
        "followed": None if followed is None else _followed(followed),
    }


def _followed(followed: Followed) -> dict[str, Any]:
    return {
        **picked(followed, "state from=before event transitions=count"),
        "time": time_text(int(followed.time * 1e9)) if followed.time else "",
        **picked(followed, "is_led waits_for=waits error=why is_over"),
    }


def _followed_lines(followed: Followed) -> list[str]:
    word = "not followed any more" if followed.is_over else "followed by its manager"
    lines = [f"{word}: {'being led: ' * followed.is_led}{followed}"]
    if followed.waits:
        lines.append(f"  waits for {followed.waits}")
    if followed.why:
        lines.append(f"  failed: {followed.why}")
    return lines


def _way_text(way: Way, now: str) -> str:
    if way.state == now:
        return "is so"
    if way.plan is None:
        return way.why
    from rtkit.report.finding import counted

    return f"{counted(len(way.plan.moves), 'step')}, cost {way.plan.cost:g}"


def _events(machine: SystemStates, now: str) -> list[dict[str, str]]:
    from rtkit.deployment.states.machine import FAILED

    return [
        {
            "event": event,
            "to": to,
            "when": "a transition to it fails"
            if event == FAILED
            else str(machine.conditions.get(event, "")),
        }
        for event, to in machine.table.get(now, {}).items()
    ]
