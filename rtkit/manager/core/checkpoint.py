"""Copies of a core at rest, from which another core continues in the same state.

While a procedure is under way there is no copy: it is a generator, whose place nobody can write
down. So a checkpoint is taken only between events, when the core is idle.

See decision 48.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from rtkit.errors import Malformed
from rtkit.fast_dataclass import fields, is_record
from rtkit.manager.core.core import Core
from rtkit.manager.core.desired import DesiredState
from rtkit.manager.core.indexed_table import IndexedTable
from rtkit.manager.core.state import ManagerState, NameReservation, Opening, Process
from rtkit.settings.properties import Settings

_CHANGEABLE = (Process, NameReservation, Opening, ManagerState)
"""Records that change in place; all others are replaced."""

Checkpoint = Mapping[str, Mapping[str, Any]]
"""Attributes of the parts of a core, by the name of the part; the core's own under ``core``."""


def take(core: Core) -> Checkpoint:
    """Return a copy of a core that is idle, not sharing anything that changes in place."""
    return {
        "core": {"state": copied(core.state), **_own(core, core)},
        **{name: _own(core, part) for name, part in _parts(core).items()},
    }


def restored(checkpoint: Checkpoint) -> Core:
    """Return a core that goes on from there.

    Raises:
        Malformed: It is no checkpoint, or one of another version of rtkit.
    """
    checkpoint = copied(checkpoint)
    own = dict(_table(checkpoint, "core"))
    state = own.pop("state", None)
    if not isinstance(state, ManagerState):
        raise Malformed("the checkpoint has no state")
    core = Core(state)
    parts = {"core": core, **_parts(core)}
    if parts.keys() != checkpoint.keys():
        raise Malformed(f"the checkpoint has other parts than here: {', '.join(checkpoint)}")
    for name, part in parts.items():
        content = own if part is core else _table(checkpoint, name)
        if _own(core, part).keys() != content.keys():
            raise Malformed(f"part {name} of the checkpoint has other attributes than here")
        for key, value in content.items():
            wanted = type(getattr(part, key))
            if wanted in (dict, set, bool, int) and type(value) is not wanted:
                raise Malformed(f"{name}.{key} in the checkpoint is not a {wanted.__name__}")
            setattr(part, key, deque(value) if wanted is deque else value)
    core.resume()
    return core


def copied(value: Any) -> Any:
    """Return a copy that shares only what never changes."""
    kind = type(value)
    if kind is dict:
        return {key: copied(item) for key, item in value.items()}
    if kind is IndexedTable:
        return value.like({key: copied(item) for key, item in value.items()})
    if kind is list or kind is set or kind is deque:
        return kind(map(copied, value))
    if kind in _CHANGEABLE:
        return kind(**{f.name: copied(getattr(value, f.name)) for f in fields(value)})
    if kind is DesiredState or kind is Settings:
        other = kind()
        for key, item in vars(value).items():
            setattr(other, key, copied(item))
        return other
    return value


def _parts(core: Core) -> dict[str, Any]:
    """Return the parts of a core by their name in it."""
    return {
        name: part
        for name, part in vars(core).items()
        if type(part).__module__.startswith(_CORE) and not is_record(type(part))
    }


_CORE = __name__.rpartition(".")[0]


def _own(core: Core, part: Any) -> dict[str, Any]:
    """Return what a part holds itself, without what it shares with others or derives."""
    shared = [core, core.state, vars(core)["_out"], *_parts(core).values()]
    derived = getattr(part, "DERIVED", ())
    return {
        name: copied(value)
        for name, value in vars(part).items()
        if name not in derived and not any(value is each for each in shared)
    }


def _table(checkpoint: Any, name: str) -> Mapping[str, Any]:
    table = checkpoint.get(name) if isinstance(checkpoint, dict) else None
    if not isinstance(table, dict):
        raise Malformed(f"the checkpoint has no part {name}")
    return table
