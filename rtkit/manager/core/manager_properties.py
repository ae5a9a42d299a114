"""Shows and changes the properties of a manager, and passes them to its processes."""

from __future__ import annotations

import os.path

from rtkit.deployment.actions import Result
from rtkit.deployment.message import Message
from rtkit.errors import Refused, RtkitError
from rtkit.manager.core.effects import Call, Procedure, Send
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.state import ManagerState
from rtkit.settings.properties import INHERITED, canonical

_CONFIG_FILE = ".config_file"
_OF_PROCESSES = ("manager.modules.", "manager.cpu_affinity", "logger.")


def table(state: ManagerState) -> dict[str, str]:
    """Return all properties: what was given over the defaults, what the manager is over both."""
    return {**state.settings.table(), **_facts(state)}


def lookup(state: ManagerState, key: str) -> str | None:
    """Return the value of one property by its present or old name, None if there is none."""
    fact = _facts(state).get(canonical(key))
    return state.settings.lookup(key) if fact is None else fact


def _facts(state: ManagerState) -> dict[str, str]:
    return {"manager.modules.load_path": ",".join(load_paths(state)), **state.properties}


def load_paths(state: ManagerState) -> list[str]:
    """Return the folders of modules, those that were given before those that are always there."""
    given = state.settings.items("manager.modules.load_path") or (".",)
    more = state.settings.items("manager.modules.Python.load_paths")
    folders = [os.path.normpath(os.path.join(state.folder, each)) for each in (*given, *more)]
    return list(dict.fromkeys([*folders, *state.base_paths]))


def message(state: ManagerState) -> Message:
    """Return the message to a process with the properties that concern it."""
    settings = state.settings
    return {
        "op": "configure",
        "load_path": load_paths(state),
        "is_absolute_allowed": settings.flag("manager.modules.abs_path_allowed"),
        "is_search_allowed": settings.flag("manager.modules.search_auto"),
        "log_level": settings.text("logger.log_level") if settings.flag("logger.enable") else "",
        "processors": settings.text("manager.cpu_affinity"),
    }


def is_needed(state: ManagerState) -> bool:
    """Return whether a new process must be sent properties: without them it has the defaults."""
    return bool(state.settings.below(*_OF_PROCESSES))


def has_other(state: ManagerState, configured: object) -> bool:
    """Return whether a slave has other properties than these, by its report of them.

    One that was sent none reports the load path that it began with. To wake up each that an
    earlier manager left costs more than all else that is done to find it.
    """
    if not isinstance(configured, dict):
        return True
    wanted = message(state)
    if "op" not in configured:
        return is_needed(state) or configured.get("load_path") != wanted["load_path"]
    return any(configured.get(key) != value for key, value in wanted.items())


def change(state: ManagerState, argument: str) -> Procedure:
    """Change the property of ``KEY: VALUE``, and notify the processes that it concerns.

    Raises:
        NotFound: No such property.
        Refused: It cannot be changed while the manager runs.
        Malformed: The value is not of its kind.
    """
    key, _, value = argument.partition(":")
    key = key.strip()
    if canonical(key) in state.properties:
        raise Refused(f"read-only property: {key}")
    before = state.settings.copy()
    state.settings.change(key, value)
    if canonical(key).startswith(_OF_PROCESSES):
        sent = message(state)
        try:
            yield Call(state.processes[OWN_PROCESS], sent)
        except RtkitError:
            state.settings.put_back(key, before)
            raise
        for process in list(state.processes.values()):
            if process.is_slave and process.is_ready:
                yield Send(process, sent)
    state.kept.put("setting", key, value)
    return Result(value=lookup(state, key) or "")


def inherited(state: ManagerState) -> dict[str, str]:
    """Return the properties that components inherit."""
    return state.settings.below(*INHERITED)


def config_files(state: ManagerState) -> dict[str, str]:
    """Return the files of further properties, by ``CATEGORY.NAME`` of type or instance."""
    return {
        key.removesuffix(_CONFIG_FILE): os.path.join(state.folder, path)
        for key, path in state.settings.below("").items()
        if key.endswith(_CONFIG_FILE) and key.count(".") >= 2
    }
