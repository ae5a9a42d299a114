"""Computes the parameters of a composite component after members join or leave."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import NotFound

if TYPE_CHECKING:
    from rtkit.rtc.names import Path

MEMBERS = "members"
PORTS = "exported_ports"


class MemberChange(NamedTuple):
    """A member to be added or removed, or only ports of it."""

    path: Path
    instance: str
    ports: tuple[str, ...]

    @property
    def names(self) -> list[str]:
        """The names under which the composite shows these ports."""
        return [f"{self.instance}.{port}" for port in self.ports]

    def typed_port(self, port: str) -> str:
        """Return the path of one of these ports as the user typed it."""
        return f"{self.path.typed.rpartition(':')[0]}:{port}"


class Parts(NamedTuple):
    """Members and shown ports of a composite, by name."""

    members: tuple[str, ...]
    ports: tuple[str, ...]

    @property
    def values(self) -> dict[str, str]:
        """The parameters of a composite with these parts."""
        return {MEMBERS: ",".join(self.members), PORTS: ",".join(self.ports)}

    def with_added(self, changes: Iterable[MemberChange]) -> Parts:
        """Return these with members added, and ports of members shown."""
        members, ports = list(self.members), list(self.ports)
        for change in changes:
            members.append(change.instance)
            ports += change.names
        return Parts(tuple(dict.fromkeys(members)), tuple(dict.fromkeys(ports)))

    def without(self, changes: Iterable[MemberChange]) -> Parts:
        """Return these without some members, or without some ports of members.

        Raises:
            NotFound: It is no member, or its port is not shown.
        """
        members, ports = self
        for change in changes:
            if change.instance not in self.members:
                raise NotFound(f"Not a member: {change.path.typed}")
            if change.ports:
                self._check_shown(change)
                ports = tuple(name for name in ports if name not in change.names)
            else:
                prefix = f"{change.instance}."
                members = tuple(name for name in members if name != change.instance)
                ports = tuple(name for name in ports if not name.startswith(prefix))
        return Parts(members, ports)

    def _check_shown(self, change: MemberChange) -> None:
        for port, name in zip(change.ports, change.names, strict=True):
            if name not in self.ports:
                raise NotFound(f"Port not found: {change.typed_port(port)}")


def parts_of(values: Mapping[str, str]) -> Parts:
    """Return the parts that the parameters of a composite name."""
    return Parts(_split(values.get(MEMBERS, "")), _split(values.get(PORTS, "")))


def _split(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())
