"""Feasibility of components to create: whether a manager can create them, and their ports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.system import WantedSystem
from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.create import FRESH_SLAVE, parse_create
from rtkit.rtc.names import split_manager
from rtkit.rtc.profiles import PortProfile

if TYPE_CHECKING:
    from rtkit.component.configuration.constraint_check import Declared

Making = tuple[str, str]
"""Module, ``PATH:INIT`` or nothing, and create string."""


@dataclass(frozen=True, slots=True)
class Feasibility:
    """Knowledge about components before they are created.

    Attributes:
        lacks: By instance name, why it cannot be made: its module or its type is not found.
        ports: By instance name the ports that it will have, where its type has a profile.
        parameters: By instance name the parameters that it will have, where its type has a profile.
        code: CRC-32 of files of modules, as they are.
        described: Of which all ports and parameters are known so.
    """

    lacks: Mapping[str, str] = field(default_factory=dict)
    ports: Mapping[str, tuple[PortProfile, ...]] = field(default_factory=dict)
    parameters: Mapping[str, Mapping[str, Declared]] = field(default_factory=dict)
    described: frozenset[str] = frozenset()
    code: Mapping[str, str] = field(default_factory=dict)


NOTHING_KNOWN = Feasibility()


def place_name(manager: str, process: str) -> str:
    """Return a place as the model calls it; empty and the manager's own name are the manager."""
    if process in ("", split_manager(manager)[0]):
        return f"{manager}:inproc"
    return f"{manager}:slave" if process == FRESH_SLAVE else f"{manager}:slave/{process}"


def makings(system: WantedSystem, live: LiveIndex) -> dict[str, Making]:
    """Return what those components are made of that are not there, or not where they are wanted.

    Stand-ins, which need nothing but what is in their profile, are left out.
    """
    found = {}
    for component in system.components:
        text = live.create_of(component)
        if component.pattern is not None or not text:
            continue
        create = parse_create(text)
        name = component.instance
        facts = live.at(name)
        is_there = facts is not None and (
            create.is_place_open
            or place_name(live.home(name), facts.process)
            == place_name(live.destination(name), create.place)
        )
        if not is_there:
            bare = str(create).partition("?")[0]
            found[component.instance] = (component.module, bare)
    return found
