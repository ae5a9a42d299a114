"""Places of registration: map the ``pathUri`` of a profile's component to a name, host by host."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rtkit.errors import InvalidDocument, Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.profile.rts_model import (
    ComponentInstance,
    DataPortConnector,
    RtsProfile,
    ServicePortConnector,
)
from rtkit.profile.words import PATH_ID, property_value
from rtkit.rtc.names import (
    COMPONENT_SUFFIX,
    LOCAL,
    MANAGER_SUFFIX,
    is_local_host,
    split_manager,
)


@dataclass(frozen=True, slots=True)
class Hosts:
    """Knowledge about hosts.

    Attributes:
        hostname: Name of this machine.
        same: Hosts that stand for another one (``--map``).
        any_is_local: Unknown hosts stand for this machine (``--stand-in``).
        managers: Managers beside the first one; those of other hosts as ``manager@robot1``.
    """

    hostname: str
    same: Mapping[str, str]
    any_is_local: bool = False
    managers: Collection[str] = ()

    def is_local(self, host: str) -> bool:
        """Return whether components of this host are made here."""
        return is_local_host(self.same.get(host, host), self.hostname)

    def far_manager(self, host: str) -> str:
        """Return the manager that a plan has on another host, as ``manager@robot1``; or nothing."""
        return next((each for each in self.managers if split_manager(each)[1] == host), "")


@dataclass(frozen=True, slots=True)
class RegisteredName:
    """A registered name, the path that users know, and the host when nobody knows it.

    Attributes:
        manager: Other manager that it belongs to; empty for the first.
    """

    name: str
    path: str
    unknown_host: str = ""
    note: str = ""
    manager: str = ""


def check_map(hosts: Hosts) -> None:
    """Refuse a mapping to a host where nothing can be made.

    Raises:
        Malformed: Names the host.
    """
    for host, other in hosts.same.items():
        if not is_local_host(other, hosts.hostname):
            raise Malformed(f"cannot map {host} to {other}: no manager is known on {other}")


def place(component: ComponentInstance, hosts: Hosts, taken: Collection[str]) -> RegisteredName:
    """Return where `component` belongs; names in `taken` are in use by the same profile."""
    uri = (component.path_uri or "").strip().lstrip("/")
    elements = uri.split("/")
    if not _is_name(elements):
        return _default(component, f"path {uri!r} is no name of a component")
    host, *rest = elements
    local = is_local_host(host, hosts.hostname)
    far = "" if hosts.is_local(host) else hosts.far_manager(host)
    if far and rest[0] == f"{split_manager(far)[0]}{MANAGER_SUFFIX}":
        del rest[0]
    name = "/".join([LOCAL if local else host, *rest])
    if name in taken:
        return _default(component, f"path {uri} is used twice")
    is_known = local or far or hosts.any_is_local or hosts.is_local(host)
    below = manager_in(uri, hosts) if local else ""
    manager = below if below in hosts.managers else far
    return RegisteredName(name, f"/{uri}", "" if is_known else host, manager=manager)


def manager_in(uri: str, hosts: Hosts) -> str:
    """Return the manager of this host that a path is below, ``localhost/m1.mgr/…``; or nothing."""
    host, *rest = uri.strip().lstrip("/").split("/")
    is_below = len(rest) > 1 and rest[0].endswith(MANAGER_SUFFIX)
    if not is_below or not is_local_host(host, hosts.hostname):
        return ""
    return rest[0].removesuffix(MANAGER_SUFFIX)


def _is_name(elements: list[str]) -> bool:
    if len(elements) < 2 or not elements[-1].endswith(COMPONENT_SUFFIX):
        return False
    if elements[-1] == COMPONENT_SUFFIX or elements[0].endswith(":"):
        return False
    return all(e not in ("", ".", "..") and e.isprintable() for e in elements)


def _default(component: ComponentInstance, why: str) -> RegisteredName:
    name = f"{LOCAL}/{component.instance_name}{COMPONENT_SUFFIX}"
    return RegisteredName(
        name, f"/{name}", note=f"{component.instance_name}: {why}: taken as /{name}"
    )


def check_paths(profile: RtsProfile) -> None:
    """Refuse connectors whose ends state another path than that of their component.

    Raises:
        InvalidDocument: Names connector, component and both paths.
    """
    paths = {each.instance_name: _bare(each.path_uri) for each in profile.components}
    connectors: list[DataPortConnector | ServicePortConnector] = [*profile.data_port_connectors]
    connectors += profile.service_port_connectors
    for connector in connectors:
        for end in (connector.source, connector.target):
            stated = property_value(end.properties, PATH_ID)
            own = paths.get(end.instance_name, "")
            if stated and _bare(stated) != own:
                raise InvalidDocument(
                    f"connector {connector.connector_id}: {PATH_ID} of {end.instance_name}"
                    f" is {stated}, but its path is {own}"
                )


def _bare(path: str) -> str:
    return path.strip("/")
