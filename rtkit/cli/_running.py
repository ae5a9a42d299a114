"""What rtstart, rtstop and rtteardown share: a plan shown or carried out, and never undone."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rtkit.cli import _system
from rtkit.cli._app import App
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.deployment.live import Live
    from rtkit.deployment.plan import Plan
    from rtkit.deployment.system import System
    from rtkit.profile.rts_model import RtsProfile


def run(
    app: App,
    profile: RtsProfile,
    plan_for: Callable[[System, Live], Plan],
    *,
    dry_run: bool,
    mapped: tuple[str, ...],
    remains: str,
) -> None:
    """Carry out a plan for the system of `profile`; `remains` is the word for what was done.

    Raises:
        Refused: Something required failed; the message tells how far it went.
        KeyboardInterrupt: Interrupted; its text tells how far it went.
    """
    from rtkit.deployment.live import Live

    snapshot = _system.look(app, dry_run=dry_run)
    system = _system.wanted_system(app, profile, snapshot, mapped=mapped)
    plan = plan_for(system, Live(snapshot, system))
    if dry_run:
        _system.show(plan)
        return
    runner = _system.runner(app)
    runner.check(plan.checks)
    try:
        runner.run(plan)
    except RtkitError as error:
        progress = _progress(len(runner.done), plan, remains)
        raise type(error)(f"{error} ({progress})") from error
    except KeyboardInterrupt as error:
        raise KeyboardInterrupt(_progress(len(runner.done), plan, remains)) from error


def _progress(done: int, plan: Plan, remains: str) -> str:
    return f"{done} of {len(plan.steps)} {remains} before"
