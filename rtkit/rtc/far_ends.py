"""Names ends of connectors that are in another manager: ``m2.mgr/Motor0`` instead of ``Motor0``.

No component of a manager's own bears such a name, so an end tells by itself whose it is. Between
managers both ends are written so; each takes its own name off. A manager of another host is named
with that: ``robot1/manager.mgr/Motor0``.
"""

from __future__ import annotations

from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.rtc.names import MANAGER_SUFFIX
from rtkit.rtc.profiles import ConnectorProfile, PortRef

_MARK = MANAGER_SUFFIX + "/"


def far_name(instance: str, manager: str) -> str:
    """Return how another manager names a component of `manager`."""
    return f"{manager}{_MARK}{instance}"


def on_host(manager: str, host: str) -> str:
    """Return how managers of other hosts name a manager."""
    return f"{host}/{manager}"


def host_of(peer: str) -> str:
    """Return the host of a manager that is named by others; empty for the own one."""
    return peer.rpartition("/")[0]


def split_far(instance: str) -> tuple[str, str]:
    """Return the manager in a name, empty for the own one, and the component's name there."""
    manager, mark, rest = instance.partition(_MARK)
    return (manager, rest) if mark else ("", instance)


def peer_of(connector: ConnectorProfile) -> str:
    """Return the other manager that a connector leads to; empty when both ends are the own."""
    managers = (split_far(end.instance)[0] for end in connector.ports)
    return next(filter(None, managers), "")


def own_end(connector: ConnectorProfile) -> tuple[int, PortRef]:
    """Return which end of half a connector is the own one, and that end.

    Raises:
        Malformed: It is none, as both ends are elsewhere.
    """
    for number, end in enumerate(connector.ports):
        if not split_far(end.instance)[0]:
            return number, end
    raise Malformed(f"connection {connector.connector_id} has no end here")


def named_by(connector: ConnectorProfile, manager: str) -> ConnectorProfile:
    """Return a connector of one manager as it is named between managers."""
    return replace(connector, ports=tuple(_named(end, manager) for end in connector.ports))


def named_for(connector: ConnectorProfile, manager: str) -> ConnectorProfile:
    """Return a connector that is named between managers as one of them names it."""
    below = far_name("", manager)
    ends = (PortRef(e.instance.removeprefix(below), e.port) for e in connector.ports)
    return replace(connector, ports=tuple(ends))


def _named(end: PortRef, manager: str) -> PortRef:
    is_far = bool(split_far(end.instance)[0])
    return end if is_far else PortRef(far_name(end.instance, manager), end.port)
