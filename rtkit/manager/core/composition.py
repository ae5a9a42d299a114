"""Finds the process for a composite: the one that holds all of its members."""

from __future__ import annotations

from rtkit.errors import Refused
from rtkit.manager.core.state import ManagerState, Process
from rtkit.manager.core.wiring import living
from rtkit.rtc.create import CreateString


def process_of_members(state: ManagerState, create: CreateString) -> Process | None:
    """Return the process of the members that a create string names, None if it names none.

    Raises:
        NotFound: There is no such component.
        Refused: They are in different processes, or it is to be made in another one.
    """
    names = [name.strip() for name in create.options.get("members", "").split(",")]
    processes = {name: living(state, name) for name in names if name}
    if not processes:
        return None
    first, home = next(iter(processes.items()))
    for name, process in processes.items():
        if process is not home:
            raise Refused(
                f"{first} is in {home.name}, {name} in {process.name}:"
                " members of a composite are in one process"
            )
    if create.place not in ("", home.name):
        raise Refused(f"{first} is in {home.name}: a composite of it cannot be in {create.place}")
    return home
