"""Waits for components, their states, and data of ports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.api.observers import Observers
    from rtkit.api.session import Session
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

EXISTS, GONE, DATA = "exists", "gone", "data"
_STATES = {"created": "Created", "inactive": "Inactive", "active": "Active", "error": "Error"}
WORDS = (EXISTS, *_STATES, GONE, DATA)


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
        known = row.trouble or row.cause or row.again
        why = f" ({known})" if known else ""
        return f"is {row.state}{why}, not {_STATES[self.wanted]}"


def check_word(state: str) -> str:
    """Return a word for a state as goals have it; empty for the usual one.

    Raises:
        Malformed: There is no such state.
    """
    from rtkit.rtc.nearest import did_you_mean

    word = state.casefold()
    if word and word not in WORDS:
        hint = did_you_mean(state, WORDS)
        raise Malformed(f"no such state: {state}{hint}; known: {', '.join(WORDS)}")
    return word


Problem = tuple[WaitGoal, str]


def goal_of(path: Path, wanted: str = "") -> WaitGoal:
    """Return a goal; without a word data of a port, or that a component exists.

    Raises:
        Malformed: The path cannot be in that state.
    """
    wanted = wanted or (DATA if path.port else EXISTS)
    if (path.port is not None) is not (wanted == DATA):
        what = "a state is one of a component" if path.port else "data come from a port"
        raise Malformed(f"{path.typed} {wanted}: {what}")
    if path.is_directory or not path.elements:
        raise Malformed(f"Not a component: {path.typed}")
    return WaitGoal(path, wanted)


def reach(session: Session, goals: Sequence[WaitGoal], until: float) -> Sequence[Problem]:
    """Wait until all goals hold at once; return what does not when the time [monotonic s] is up."""
    problems = _reach(session, goals, until)
    carried = [goal for goal in goals if goal.wanted == DATA]
    return _await_values(session, carried, until) if carried and not problems else problems


def _reach(session: Session, goals: Sequence[WaitGoal], until: float) -> Sequence[Problem]:
    """Wait until all goals hold, looking again only when something has changed.

    When the time is up it returns what is missing; no manager answers may be why.
    """
    from rtkit.api.observers import Observers
    from rtkit.deployment.delta import TREE

    with Observers(session, (TREE,), is_patient=True) as subscriptions:
        if subscriptions.why is not None:
            session.verbose(str(subscriptions.why))
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


def _await_values(session: Session, goals: Sequence[WaitGoal], until: float) -> Sequence[Problem]:
    """Wait until each of these ports has carried a value; return those that did not in time."""
    from rtkit.api.ports import reading
    from rtkit.probe.port_spec import PortSpec, find_streams
    from rtkit.rtc.enums import PortType

    specs = [PortSpec(goal.path.typed, goal.path) for goal in goals]
    streams = find_streams(session.tree, specs, PortType.OUT)
    silent = dict(zip((stream.name for stream in streams), goals, strict=True))
    with reading(session.tree, "rtwait", streams) as probe:
        for piece in probe.arrivals(until):
            for arrival in piece:
                silent.pop(arrival.stream, None)
            if not silent:
                return []
    return [(goal, "carried no data") for goal in silent.values()]
