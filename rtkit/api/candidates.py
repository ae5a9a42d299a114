"""Looks at the places where components of a system profile may be made: at managers, and hosts."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, NamedTuple

from rtkit.deployment.placement.choice import PlaceCandidate
from rtkit.errors import NotFound, RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.link.places import host_name
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX, is_local_host

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.hosts.host import Host
    from rtkit.link.devices import HostFacts
    from rtkit.profile.rts_model import ComponentInstance
    from rtkit.tree.client import Tree


class LookedAt(NamedTuple):
    """A place, and what was found there.

    Attributes:
        candidate: The place, and what its host has.
        tree: Connection to its manager; None where that does not run.
        snapshot: What lives there.
        is_lost: It cannot be reached, and may hold components.
    """

    candidate: PlaceCandidate
    tree: Tree | None = None
    snapshot: Snapshot | None = None
    is_lost: bool = False


def stated_place(component: ComponentInstance, hosts: Collection[str]) -> str:
    """Return the place that a path names; this host for what is on none of the known hosts."""
    host, _, rest = (component.path_uri or "").strip().lstrip("/").partition("/")
    below, slash, _ = rest.partition("/")
    if slash and is_local_host(host, host_name()) and below.endswith(MANAGER_SUFFIX):
        return f"{LOCAL}/{below}"
    return host if host in hosts else LOCAL


class Places(ExitStack):
    """The places that are known; each is looked at once, connections are closed at the end.

    Attributes:
        hosts: The other hosts by name, with what the inventory tells of them.
        seen: What was found, by place.
    """

    def __init__(self, session: Session, devices: Sequence[str], mapped: Collection[str]) -> None:
        """Find them; hosts that are `mapped` to others are none."""
        super().__init__()
        self._session = session
        self._devices = devices
        self.hosts = _hosts(mapped) if session.finds_managers else {}
        self.seen: dict[str, LookedAt] = {}

    def look(self, places: Iterable[str], *, is_remote: bool) -> None:
        """Look at places; at hosts without a link, over SSH, only if that is asked for."""
        unlinked = []
        for place in places:
            if place in self.seen:
                continue
            if place.partition("/")[0] == LOCAL:
                self.seen[place] = self._near(place)
            elif (linked := self._linked(place)) is not None:
                self.seen[place] = linked
            elif is_remote:
                unlinked.append(place)
        if unlinked:
            from concurrent.futures import ThreadPoolExecutor

            with ThreadPoolExecutor(max_workers=len(unlinked)) as pool:
                self.seen.update(zip(unlinked, pool.map(self._over_ssh, unlinked), strict=True))

    def _near(self, place: str) -> LookedAt:
        """Look at a manager of this host, or at the host where that one does not run."""
        _, _, below = place.partition("/")
        name = below.removesuffix(MANAGER_SUFFIX) or self._session.usual_manager
        try:
            return self._at(place, self._connected(name))
        except Unreachable:
            from rtkit.manager.host_facts import facts_of_host
            from rtkit.settings.configuration import CommandLineSettings, read

            tags = read(CommandLineSettings()).settings.text("rtkit.tags")
            return LookedAt(_found(place, facts_of_host(self._devices, tags)))

    def _connected(self, manager: str) -> Tree:
        if not self._session.finds_managers:
            return self._session.tree
        from rtkit.tree.connect import connect

        return self.enter_context(connect(manager, self._session.timeout_s))

    def _linked(self, host: str) -> LookedAt | None:
        """Look at the manager of a host that is linked; None where none is."""
        from rtkit.link import host_links
        from rtkit.tree.connect import connect_far

        if not host_links.is_linked(host):
            return None
        try:
            tree = self.enter_context(connect_far(host, "", self._session.timeout_s))
            found = self._at(host, tree)
        except RtkitError as error:
            return LookedAt(PlaceCandidate(host, why_not=str(error)), is_lost=True)
        if (known := self.hosts.get(host)) is None:
            return found
        tags = found.candidate.tags | {*known.tags}
        return found._replace(candidate=replace(found.candidate, tags=tags))

    def _at(self, place: str, tree: Tree) -> LookedAt:
        try:
            candidate = _found(place, tree.host_facts(self._devices))
        except NotFound as error:
            why = f"its rtkit tells nothing of its host: {error}"
            candidate = PlaceCandidate(place, why_not=why)
        return LookedAt(candidate, tree, tree.snapshot())

    def _over_ssh(self, name: str) -> LookedAt:
        from rtkit.hosts import far_side
        from rtkit.hosts.connection import connect

        host = self.hosts[name]
        assert host is not None
        try:
            with connect(host, self._session.timeout_s) as connection:
                far = far_side.look(connection, self._devices)
        except RtkitError as error:
            return LookedAt(PlaceCandidate(name, why_not=str(error)))
        why = "; ".join(far.obstacles(needs_room=not far.current))
        devices, tags = frozenset(far.devices), frozenset(host.tags)
        return LookedAt(PlaceCandidate(name, tags, far.memory_bytes, devices, why))


def _hosts(mapped: Collection[str]) -> dict[str, Host | None]:
    from rtkit.hosts import inventory
    from rtkit.link import host_links

    found: dict[str, Host | None] = {**dict.fromkeys(host_links.hosts()), **inventory.read()}
    return {host: each for host, each in sorted(found.items()) if host not in mapped}


def _found(place: str, facts: HostFacts) -> PlaceCandidate:
    return PlaceCandidate(place, frozenset(facts.tags), facts.memory, frozenset(facts.devices))


def lacking(
    session: Session, looked_at: LookedAt, makings: Mapping[str, tuple[str, str]]
) -> dict[str, str]:
    """Return why components cannot be made at a place, as far as its manager can tell."""
    if looked_at.tree is None or not makings:
        return {}
    distinct = sorted({*makings.values()})
    try:
        whys = dict(zip(distinct, looked_at.tree.lacking(distinct), strict=True))
    except RtkitError as error:
        session.verbose(f"what {looked_at.candidate.place} can make is not known: {error}")
        return {}
    return {name: whys[making] for name, making in makings.items() if whys[making]}
