"""Solves the problems of this folder and prints what comes of each: ``python -m manipulation``."""

from __future__ import annotations

from manipulation import explore, line, spar, take
from rtkit.planner import Evaluator, Problem, execute, optimal_plans, plan


def main() -> None:
    """Print every case."""
    _show("jaws, every command costs 1", line.jaws((4, 1), (1, 1)))
    _show("jaws, open moves cost 2", line.jaws((4, 1), (1, 1), line.OPEN_MOVES_COST_2))
    _show("grasp", line.jaws((4, 1), (2, 1), line.OPEN_MOVES_COST_2))
    _show("carry", line.carrying((5, 0, 2), {"y": 4}))
    _show("push", line.carrying((5, 1, 4), {"y": 2}))
    _show("the same without pushing", line.carrying((5, 1, 4), {"y": 2}, may_push=False))
    _show("spar, turning is dear", spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=3))
    _show("spar, turning is cheap", spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=1))
    across = spar.handled((2, 2, 1, 1, 2, 2, 0), {"sx": 3, "sy": 3, "sa": 0})
    _show("spar held across, to be grasped otherwise before a doorway", across)
    _switch()
    _doorway()
    _explore()


def _show(title: str, problem: Problem) -> None:
    found = optimal_plans(problem)
    print(f"{title}: cost {found.cost:g}, plans: {found.count}")
    for each in found:
        print(f"    {', '.join(each.commands)}")


def _switch() -> None:
    site = take.switch_site()
    print("switch of two objects, by where the first waits (rows) and the hand (columns):")
    for x in ((4, 5), (5, 5), (6, 5)):
        paths = [take.switch(site, x, y)(site.state) for y in ((4, 4), (6, 4))]
        print("   ", *(f"{path.cost:g}" if path is not None else "-" for path in paths))


def _doorway() -> None:
    for told, is_caching, bounded in (
        ("as it comes", False, False),
        ("equal cross-sections once", True, False),
        ("the most promising first, too", True, True),
    ):
        evaluator = Evaluator(is_caching=is_caching)
        site = take.doorway_site(evaluator)
        path = take.pass_doorway(site, bounded=bounded)(site.state)
        assert path is not None
        print(f"blocked doorway, {told}: cost {path.cost:g}, {evaluator.evaluations} evaluations")


def _explore() -> None:
    done = execute(explore.route, explore.TouchWorld([(6, 2)]), plan)
    costs = ", then ".join(f"{each.cost:g}" for each in done.plans)
    print(f"unknown object: planned {costs}; travelled {done.cost:g}; found {set(done.facts)}")


if __name__ == "__main__":
    main()
