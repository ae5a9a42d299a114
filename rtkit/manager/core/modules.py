"""Loaded modules, whatever path led to them: one entry for each init function of a file.

A module may hang, exit or crash when it is imported: that costs a process that is there for nothing
else. Only what was imported well so is imported by the manager itself, and only when a component
is to live in it.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Generator
from functools import partial
from typing import Any, NamedTuple

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.message import Message
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.manager.core import effects as fx
from rtkit.manager.core.deletion import end_slaves
from rtkit.manager.core.desired import module_row
from rtkit.manager.core.effects import Call, Procedure, Send
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.state import ManagerState, Process
from rtkit.rtc.profiles import ModuleProfile
from rtkit.rtc.serde import decode


def known(state: ManagerState, path: str, init: str) -> ModuleProfile | None:
    """Return the module that a path means, loaded by an init function; by any if none is named."""
    return next(
        (each for each in state.modules.values() if each.is_at(path) and init in ("", each.init)),
        None,
    )


def load(state: ManagerState, action: act.Load) -> Procedure:
    """Load a module, or call another init function of it."""
    path = action.path
    module = known(state, path, action.init)
    if module is None:
        tried = yield from try_module(state, path, action.init)
        return _loaded(action, "; ".join(tried.remarks), partial(take, state, tried.module, path))
    message = {"op": "fingerprint", "path": module.file or module.path}
    present: Any = yield Call(state.processes[OWN_PROCESS], message)
    is_changed = present and present != state.tried.get(module.path, present)
    note = f"{path} has changed since it was loaded (rtmgr -u forgets what it was)"
    return _loaded(action, note if is_changed else "")


def _loaded(action: act.Load, note: str, take_in: Callable[[], object] = bool) -> Result:
    """Take a module in, unless there is a note on it and that is too much.

    Raises:
        Refused: It is.
    """
    if action.is_strict and note:
        raise Refused(note)
    take_in()
    return Result(value=action.path, note=note)


def take(state: ManagerState, module: ModuleProfile, path: str = "") -> None:
    """Take in that a module was loaded, by a path that perhaps is another one for the same file."""
    for key, each in state.modules.items():
        if (each.file or each.path, each.init) == (module.file or module.path, module.init):
            if path and not each.is_at(path):
                state.modules[key] = replace(each, aliases=(*each.aliases, path))
            return
    is_second = module.path in state.modules
    state.modules[f"{module.path}:{module.init}" if is_second else module.path] = module


def take_all(state: ManagerState, process: Process, reported: object) -> None:
    """Take in the report of a process about what it has loaded by itself.

    Raises:
        Malformed: It cannot be read.
    """
    for each in reported if isinstance(reported, list) else ():
        tried, before = read(each), set(state.modules)
        take(state, tried.module)
        process.found += state.modules.keys() - before
        for path in (tried.module.path, *tried.module.aliases):
            state.tried.setdefault(path, tried.fingerprint)
        state.ahead.update(filter(None, [tried.ahead]))


def forget_found(state: ManagerState, process: Process) -> None:
    """Forget what a process had loaded for a component, when it ended before that was made."""
    for key in process.found if not process.is_alive else ():
        state.modules.pop(key, None)
    process.found.clear()


def unload(state: ManagerState, action: act.Unload) -> Procedure:
    """Forget a module, all its init functions; components already made stay."""
    message: Message = {"op": "unload", "path": action.path}
    file: Any = yield Call(state.processes[OWN_PROCESS], message)
    gone = {
        key: each
        for key, each in state.modules.items()
        if each.is_at(action.path) or (file and each.file == file)
    }
    if not gone:
        raise NotFound(f"module is not loaded: {action.path}")
    for key, module in gone.items():
        del state.modules[key]
        for path in (module.path, module.file, *module.aliases):
            for row in (path, module_row(path, module.init)):
                state.kept.drop("module", row)
    for process in list(state.processes.values()):
        if process.is_slave and process.is_ready:
            yield Send(process, message)
    return Result()


TRIAL = "@modules"
"""Name of the process that imports; no slave can have it."""

_PATIENCE_S = 10.0
"""How long a trial that somebody else began is waited for [s]."""


class CheckedModule(NamedTuple):
    """A module that a process has imported, with the fingerprint of its content and findings.

    Attributes:
        ahead: Module that slaves have best imported before; mostly empty.
    """

    module: ModuleProfile
    fingerprint: int
    remarks: tuple[str, ...]
    ahead: str


def try_module(
    state: ManagerState, path: str, init: str
) -> Generator[fx.Effect, Any, CheckedModule]:
    """Have another process import a module; return what it offers, and what is odd in it.

    Raises:
        RtkitError: It cannot be imported; gives the reason, and the line if there is one.
    """
    process: Process = yield fx.AcquireSlave(TRIAL, trial_of=path)
    try:
        report = yield fx.Call(process, {"op": "load", "path": path, "init": init})
        tried = read(report)
    except RtkitError as error:
        yield fx.Spawn(_kill(process))
        failure = _explained(path, process, error) if isinstance(error, Unreachable) else error
        process.failure = failure
        raise failure from error
    yield fx.Spawn(end_slaves([process]))
    state.tried.update(dict.fromkeys((path, tried.module.path), tried.fingerprint))
    state.ahead.update(filter(None, [tried.ahead]))
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


def read(given: Any) -> CheckedModule:
    """Read the report of a process about a module that it has loaded.

    Raises:
        Malformed: It cannot be read.
    """
    if not isinstance(given, dict) or not isinstance(given.get("fingerprint"), int):
        raise Malformed("what was told of the module cannot be read")
    remarks = tuple(map(str, given.get("remarks") or ()))
    module, ahead = decode(ModuleProfile, given.get("module")), str(given.get("ahead", ""))
    return CheckedModule(module, given["fingerprint"], remarks, ahead)


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
