"""Checks the import of a module in a process of its own before the manager accepts the module.

A module may hang, exit or crash when it is imported: that costs a process that is there for nothing
else. Only what was imported well so is imported by the manager itself, and only when a component
is to live in it.
"""

from __future__ import annotations

import signal
from collections.abc import Generator
from typing import Any, NamedTuple

from rtkit.deployment.actions import Result
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.manager.core import effects as fx
from rtkit.manager.core.state import ManagerState, Process
from rtkit.manager.core.stopping import end_slaves
from rtkit.rtc.profiles import ModuleProfile
from rtkit.rtc.serde import decode

TRIAL = "@modules"
"""Name of the process that imports; no slave can have it."""

_PATIENCE_S = 10.0
"""How long a trial that somebody else began is waited for [s]."""


class CheckedModule(NamedTuple):
    """A module that a process has imported, with the fingerprint of its content and findings."""

    module: ModuleProfile
    fingerprint: int
    remarks: tuple[str, ...]


def try_module(
    state: ManagerState, path: str, init: str
) -> Generator[fx.Effect, Any, CheckedModule]:
    """Have another process import a module; return what it offers, and what is odd in it.

    Raises:
        RtkitError: It cannot be imported; gives the reason, and the line if there is one.
    """
    process: Process = yield fx.AcquireSlave(TRIAL, trial_of=path)
    try:
        told = yield fx.Call(process, {"op": "load", "path": path, "init": init})
        tried = read(told)
    except RtkitError as error:
        yield fx.Spawn(_kill(process))
        failure = _explained(path, process, error) if isinstance(error, Unreachable) else error
        process.failure = failure
        raise failure from error
    yield fx.Spawn(end_slaves([process]))
    state.tried[path] = tried.fingerprint
    return tried


def share_trial(state: ManagerState, path: str, init: str) -> Generator[fx.Effect, Any, None]:
    """Have a module tried once for all that want it at a time.

    Raises:
        RtkitError: It cannot be imported; gives the reason, and the line if there is one.
    """
    trials = (each for each in state.processes.values() if each.trial_of == path)
    trial = next((each for each in trials if each.is_alive and each.is_wanted), None)
    if trial is None:
        yield from try_module(state, path, init)
        return
    yield fx.WaitForEnds((trial,), _PATIENCE_S)
    if trial.failure is not None:
        raise trial.failure


def read(told: Any) -> CheckedModule:
    """Read the report of a process about a module that it has loaded.

    Raises:
        Malformed: It cannot be read.
    """
    if not isinstance(told, dict) or not isinstance(told.get("fingerprint"), int):
        raise Malformed("what was told of the module cannot be read")
    remarks = tuple(map(str, told.get("remarks") or ()))
    return CheckedModule(decode(ModuleProfile, told.get("module")), told["fingerprint"], remarks)


def _kill(process: Process) -> fx.Procedure:
    process.is_wanted = False
    if process.is_alive:
        yield fx.SendSignal(process, signal.SIGKILL)
    return Result()


def _explained(path: str, process: Process, error: Unreachable) -> RtkitError:
    if not process.is_alive and process.pid:
        words = f"; its last words: {process.last}" if process.last else ""
        why = f"{process.reason}{words}"
        return Refused(f"module {path} ended the process that imported it: {why}")
    stuck = "; ".join(process.stuck.values())
    if stuck:
        return Unreachable(f"module {path} was not imported in time: it is {stuck}")
    return error
