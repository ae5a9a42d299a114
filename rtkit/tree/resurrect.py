"""Brings a wanted system up: checks, creates, connects and configures; or rolls back."""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.deployment.creation import NOTHING_LACKS, bring_up_plans, checks
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.runner import PlanRunner, roll_back
from rtkit.deployment.system import WantedSystem
from rtkit.errors import RtkitError
from rtkit.tree.client import Tree


def resurrect(
    tree: Tree,
    system: WantedSystem,
    before: Snapshot,
    runner: PlanRunner,
    *,
    may_create: bool = True,
    lacks: Mapping[str, str] = NOTHING_LACKS,
) -> None:
    """Make what lives (`before`) the wanted system; `lacks` states why some cannot be made.

    Raises:
        Refused: Something required is missing or failed; new components are removed again.
        KeyboardInterrupt: Interrupted; new components are removed again. Its text names the rest.
    """

    def look() -> LiveIndex:
        live = LiveIndex(tree.snapshot(), system)
        runner.check(checks(system, live))
        return live

    plans = bring_up_plans(system, before, look, may_create=may_create, lacks=lacks)
    creation = next(plans)
    runner.check(creation.checks)
    try:
        runner.run(creation)
        runner.run(next(plans))
    except RtkitError as error:
        more = roll_back(runner, before, error)
        if not more:
            raise
        raise type(error)(f"{error}; {more}") from error
    except KeyboardInterrupt as error:
        raise KeyboardInterrupt(roll_back(runner, before, error)) from error
