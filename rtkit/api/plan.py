"""Plans: the cheapest steps from what lives to a profile, looked at and carried out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.api.planning import Prepared
    from rtkit.api.session import Notify, Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.tree.client import Tree


class SystemPlan:
    """The cheapest plan from what lives to a profile; false when there is nothing to do.

    Made by `Tree.plan`. Nothing is changed before `apply`. As text it is what ``rtplan`` shows.

    Example::

        plan = tree.plan("robot.xml")
        print(plan)
        if plan.cost < 10:
            plan.apply(rollback=True)

    Attributes:
        profile: Where it leads.
        cost: What all steps cost together.
    """

    def __init__(
        self, tree: Tree, notify: Notify, profile: SystemProfile, prepared: Prepared
    ) -> None:
        """Keep a plan; `Tree.plan` makes it."""
        self._tree = tree
        self._notify = notify
        self._prepared = prepared
        self.profile = profile
        self.cost = prepared.plan.cost

    @property
    def steps(self) -> list[str]:
        """The steps, in an order in which they can be done."""
        return [move.text for move in self._prepared.plan.moves]

    def __bool__(self) -> bool:
        return bool(self._prepared.plan.moves)

    def __len__(self) -> int:
        return len(self._prepared.plan.moves)

    def __str__(self) -> str:
        from rtkit.deployment.planning.rendering import lines

        return "\n".join(lines(self._prepared.plan, self._prepared.goal.costs))

    def __repr__(self) -> str:
        return f"<SystemPlan: {len(self)} steps, cost {self.cost:g}, to {self.profile.source}>"

    def as_dict(self) -> Mapping[str, Any]:
        """Return it as the plain data that ``rtplan --json`` writes."""
        from rtkit.deployment.planning.rendering import as_plain

        return as_plain(self._prepared.plan, self._prepared.goal.costs)

    def dot(self) -> str:
        """Return it as a graph for Graphviz: what comes before what."""
        from rtkit.deployment.planning.rendering import to_dot

        return "\n".join(to_dot(self._prepared.plan))

    def apply(self, *, rollback: bool = False, exact: bool = False, wait_s: float = 0.0) -> None:
        """Carry it out. Where the world turns out otherwise, the rest is planned anew.

        Args:
            rollback: When a step fails, go back to what was before.
            exact: Stop where the world turns out otherwise, instead of planning anew.
            wait_s: How long to wait for another plan at work at the manager [s].

        Raises:
            Refused: A step failed, somebody else is at work, or a required component has not what
                the profile sets; the message tells what is left.
            Unreachable: A manager does not answer.
        """
        from rtkit.api import looking
        from rtkit.api.session import ScriptSession
        from rtkit.tree.plan_locks import PlanLocks

        name = f"script {self.profile.source}"
        is_strict = self._prepared.goal.is_strict
        with (
            ScriptSession(self._tree, self._notify, name, is_strict=is_strict) as session,
            PlanLocks(name, wait_s, self._notify) as lock,
        ):
            looking.look(session, self.profile, dry_run=False, starts=True, lock=lock)
            run(session, self._prepared, rollback=rollback, exact=exact)


def run(session: Session, prepared: Prepared, *, rollback: bool, exact: bool) -> None:
    """Carry a plan out whose locks are taken; see `SystemPlan.apply`."""
    is_back = rollback or session.is_strict
    unmet = carry_out(session, prepared, rolls_back=is_back, is_exact=exact)
    if unmet:
        raise Refused("; ".join(unmet))


def carry_out(
    session: Session,
    prepared: Prepared,
    *,
    rolls_back: bool = False,
    is_exact: bool = False,
    owns: bool = True,
) -> tuple[str, ...]:
    """Carry a plan out, and have the system followed if its profile wants that.

    Durations of steps are noted. One that is to be carried out exactly is not planned again where
    the world differs. Returns in what required components are not what is wanted.

    Raises:
        Refused: A step failed; the message states what is left, or that it went back.
        Unreachable: The manager does not answer.
        KeyboardInterrupt: Interrupted; its text states what is left.
    """
    from rtkit.api import displaced, owning, states, step_times
    from rtkit.deployment.applying import Applier
    from rtkit.tree.grace import uninterrupted

    document, goal, snapshot, plan, survey = prepared
    is_followed = states.is_follow_wanted(session, document)
    report = session.report
    older = owning.claim(session, document, goal) if owns else {}
    with step_times.noting(session, goal.system, snapshot) as taken:
        applier = Applier(
            session.tree, goal, report, report, taken, survey, uninterrupted, session.watch
        )
        applier.run(plan, snapshot, rolls_back=rolls_back, is_exact=is_exact)
    if owns:
        owning.note(session, document, goal, older)
        displaced.forget(session, document, owning.homes(session, goal))
    if is_followed:
        states.follow_from(session, document, goal)
    return tuple(applier.unmet)
