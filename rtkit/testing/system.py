"""Brings the system of a profile up for a test, with components of its own or stand-ins."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtkit.api.system_profiles import SystemProfile
from rtkit.deployment.extension import STAND_IN
from rtkit.fast_dataclass import replace
from rtkit.profile_tools.stating import Statement, stated

if TYPE_CHECKING:
    from rtkit.api.tree import Tree

Values = Mapping[str, Sequence[Any]]
StandIns = bool | Sequence[str] | Mapping[str, Values]
_LOAD_PATH = "manager.modules.load_path"


def bring_up(
    tree: Tree, system: SystemProfile, stand_in: StandIns, notes: list[str], **options: Any
) -> None:
    """Apply a profile; `notes` receives the plan, and what is reported while it is carried out.

    Raises:
        NotFound: There is no such component to be a stand-in.
        RtkitError: As `Tree.plan` and `Plan.apply` say.
    """
    system = replaced(system, {} if isinstance(stand_in, bool) else stand_in)
    folder = str(Path(system.source).resolve().parent)
    if folder not in (known := tree.get(_LOAD_PATH).split(",")):
        tree.set(_LOAD_PATH, ",".join([*known, folder]))
    tree.notify = notes.append
    plan = tree.plan(system, stand_in=stand_in is True, **options)
    notes.append(str(plan))
    plan.apply()


def replaced(
    system: SystemProfile, stand_in: Sequence[str] | Mapping[str, Values]
) -> SystemProfile:
    """Return a profile with stand-ins for components, which may transmit values.

    Raises:
        NotFound: There is no such component; names those that there are.
    """
    scripts = stand_in if isinstance(stand_in, Mapping) else {name: {} for name in stand_in}
    statements = [Statement(name, STAND_IN, "yes") for name in scripts]
    statements += [
        Statement(name, f"{STAND_IN}.{port}", json.dumps(list(values)))
        for name, script in scripts.items()
        for port, values in script.items()
    ]
    return replace(system, profile=stated(system.profile, statements))
