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
    tell: Callable[[System, Live], str],
) -> None:
    """Carry out a plan for the system of `profile`; `tell` says how far one got that broke off.

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
        raise type(error)(f"{error}; {_progress(app, system, tell)}") from error
    except KeyboardInterrupt as error:
        raise KeyboardInterrupt(_progress(app, system, tell)) from error


def _progress(app: App, system: System, tell: Callable[[System, Live], str]) -> str:
    from rtkit.deployment.live import Live

    try:
        return tell(system, Live(_system.snapshot(app), system))
    except (RtkitError, KeyboardInterrupt) as trouble:
        return f"how far it got is not known ({str(trouble) or 'interrupted again'})"
