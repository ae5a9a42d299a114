"""Names the paths of components and ports, as users find them in the tree."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.rtc.far_ends import host_of, split_far
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, Snapshot


def component_path(snapshot: Snapshot, facts: ComponentFacts) -> str:
    """Return where a component is found: its first name, else the place below its manager."""
    if facts.names:
        return "/" + facts.names[0]
    usual = f"localhost/{snapshot.manager}{MANAGER_SUFFIX}"
    manager = snapshot.names[0] if snapshot.names else usual
    return f"/{manager}/{facts.instance}{COMPONENT_SUFFIX}"


def port_path(snapshot: Snapshot, instance: str, port: str) -> str:
    """Return the path of a port; empty when nobody knows its component."""
    manager, name = split_far(instance)
    if host_of(manager):
        host, _, manager = manager.partition("/")
        return f"/{host}/{manager}{MANAGER_SUFFIX}/{name}{COMPONENT_SUFFIX}:{port}"
    if manager:
        return f"/{LOCAL}/{manager}{MANAGER_SUFFIX}/{name}{COMPONENT_SUFFIX}:{port}"
    facts = snapshot.component(instance)
    return "" if facts is None else f"{component_path(snapshot, facts)}:{port}"
