"""Tells which ports a port may be connected to, and what a manager can make."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rtkit.api.live_records import KnownManager, Record
from rtkit.component.ports.port_matching import refusal
from rtkit.errors import NotFound
from rtkit.profile_tools.system_summary import short_type
from rtkit.rtc.profiles import PortProfile
from rtkit.tree.wiring import DATA_DEFAULTS


def fitting(port: str, managers: Iterable[KnownManager], hostname: str) -> list[Record]:
    """Return all other ports, each with the reason why it does not fit; empty where it does.

    Raises:
        NotFound: There is no such port.
    """
    ports = {
        f"{manager.path(facts, hostname)}:{each.name}": each
        for manager in managers
        if not manager.why
        for facts in manager.facts.components
        if not facts.zombie
        for each in facts.ports
    }
    asked = ports.pop(port, None)
    if asked is None:
        raise NotFound(f"No such port: {port}")
    return [
        {"path": path, "type": short_type(each.data_type), "why": _why(asked, each)}
        for path, each in ports.items()
    ]


def offers_of(rows: Iterable[Record], loaded: Sequence[Record]) -> Record:
    """Return the types that can be created, and the modules that can be loaded and forgotten.

    Args:
        rows: What ``rtmgr --json -m`` tells.
        loaded: Modules that are loaded already, as ``rtcat --json`` has them.
    """
    modules_in = [{"path": each["path"], "init": each["init"]} for each in loaded]
    files = frozenset(each["file"] for each in loaded)
    types, modules = [], {}
    for each in rows:
        id, module, problem = each["type"] or "", each["module"] or "", each["problem"] or ""
        if id:
            types.append({"name": id.split(":")[3], "id": id, "module": module})
        if module and module not in files:
            modules[module] = {"path": module, "problem": problem}
    return {"types": types, "modules": list(modules.values()), "loaded": modules_in}


def _why(one: PortProfile, other: PortProfile) -> str:
    data_type = one.data_type or other.data_type
    properties = {**DATA_DEFAULTS, "dataport.data_type": data_type} if data_type else {}
    return refusal((one, other), properties)
