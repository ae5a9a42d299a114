"""Connects to the managers of this host that a system profile is about."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rtkit.errors import RtkitError, Unreachable
from rtkit.link.places import host_name
from rtkit.rtc.names import MANAGER_SUFFIX

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.tree.client import Tree
    from rtkit.tree.manager_set import Start


def names_another(profile: RtsProfile) -> bool:
    """Return whether a component's path may lead below a manager: ``localhost/m1.mgr/…``."""
    return any(f"{MANAGER_SUFFIX}/" in (each.path_uri or "") for each in profile.components)


class Managers:
    """The managers that the components of a profile belong to.

    Attributes:
        names: First the default manager, if any component belongs to it.
    """

    def __init__(self, profile: RtsProfile, usual: str) -> None:
        """Find them; `usual` is the manager of components whose path names none."""
        from rtkit.deployment.place import Hosts, manager_in

        self.host = host_name()
        self._hosts = Hosts(self.host, {})
        self._paths = {c.instance_name: c.path_uri or "" for c in profile.components}
        self.homes = {
            name: manager_in(path, self._hosts) or usual for name, path in self._paths.items()
        }
        found = dict.fromkeys(self.homes.values())
        self.names = [usual, *(n for n in found if n != usual)] if usual in found else [*found]

    def connect(self, timeout_s: float) -> tuple[dict[str, Tree], dict[str, str]]:
        """Connect to each; return the connections, and the reasons for missing ones."""
        from rtkit.tree.connect import connect

        trees: dict[str, Tree] = {}
        absent: dict[str, str] = {}
        for name in self.names:
            try:
                trees[name] = connect(name, timeout_s)
            except Unreachable as error:
                absent[name] = f"{error}; it is to hold {self._paths_text(name)}"
            except BaseException:
                _close(trees)
                raise
        return trees, absent

    def _paths_text(self, manager: str) -> str:
        first, *more = [path for name, path in self._paths.items() if self.homes[name] == manager]
        return f"/{first.lstrip('/')}" + (f" and {len(more)} more" if more else "")

    def joined(self, reports: Iterable[Snapshot]) -> Snapshot:
        """Join the reports of these managers into one snapshot; one without a report is down."""
        from rtkit.deployment.multi_manager import down, joined

        known = {each.manager: each for each in reports}
        return joined([known.get(n) or down(self.host, n) for n in self.names], self.homes)


def gather(
    session: Session, profile: RtsProfile, *, is_lenient: bool, starts: bool = False
) -> Snapshot | None:
    """Connect to the managers of a profile; return a snapshot if none of them runs.

    Args:
        session: Is given the connection, if the profile is about another manager or several.
        profile: The system profile.
        is_lenient: A manager that does not run is told and counts as holding nothing.
        starts: One that does not run holds nothing, and can be started.

    Raises:
        Unreachable: Tells which managers do not run, and what belongs there; or one is so like
            another one that runs that it is not started.
    """
    managers = Managers(profile, session.usual_manager)
    trees, absent = managers.connect(session.timeout_s)
    if starts and all(map(can_be_started, absent)):
        _check_meant(absent, trees)
        session.ask(_one(managers, trees, session))
        return None
    if absent and not is_lenient:
        _close(trees)
        raise Unreachable("; ".join(absent.values()))
    for why in absent.values():
        session.fail(f"{why}; taken as if nothing lived there")
    if not trees:
        return managers.joined([])
    session.ask(_one(managers, trees))
    return None


def gather_named(session: Session, servers: Sequence[str]) -> tuple[str, ...]:
    """Connect to the managers among some servers; return the hosts that the servers stand for.

    The manager that is asked by default is among them when the host itself is named.

    Raises:
        Unreachable: One does not run.
    """
    from rtkit.deployment.place import Hosts, manager_in
    from rtkit.rtc.names import LOCAL
    from rtkit.tree.connect import connect
    from rtkit.tree.manager_set import ManagerSet

    hosts = Hosts(host_name(), {})
    usual = session.usual_manager
    named = {server: manager_in(f"{server.strip('/')}/.", hosts) for server in servers}
    trees: dict[str, Tree] = {}
    try:
        for name in dict.fromkeys(manager or usual for manager in named.values()):
            trees[name] = connect(name, session.timeout_s)
    except BaseException:
        _close(trees)
        raise
    session.ask(ManagerSet(list(dict.fromkeys([usual, *trees])), trees, {}))
    return tuple(dict.fromkeys(LOCAL if manager else host for host, manager in named.items()))


def snapshots(
    session: Session, but: Collection[str] = ()
) -> Iterator[tuple[str, Snapshot | RtkitError]]:
    """Yield each running manager of this host with its snapshot, or the reason for none."""
    from rtkit.link.running import managers
    from rtkit.tree.connect import connect

    for name in managers():
        if name in but:
            continue
        found: Snapshot | RtkitError
        try:
            with connect(name, session.timeout_s) as tree:
                found = tree.snapshot()
        except RtkitError as error:
            found = error
        yield name, found


def can_be_started(manager: str) -> bool:
    """Return whether a manager that cannot be reached is one of this host that does not run."""
    from rtkit.link import places

    return ":" not in manager and places.owner(manager) is None


def start_manager(name: str, timeout_s: float, notify: Callable[[str], object]) -> None:
    """Start a manager as ``rtmgr start NAME`` does; no error if somebody else has just done so.

    Raises:
        Refused: It cannot be started, or not all of its start was done.
    """
    from rtkit.errors import Partial, Refused
    from rtkit.link import places
    from rtkit.manager import launch
    from rtkit.rtc.names import check_instance_name
    from rtkit.settings.configuration import CommandLineSettings

    check_instance_name(name)
    try:
        started = launch.start(name, CommandLineSettings(), timeout_s)
        for text in (*started.warnings, *started.failures):
            notify(f"manager {name}: {text}")
    except Partial as error:
        whys = (str(failure) for _, failure in error.failures)
        raise Refused("; ".join([str(error), *whys])) from error
    except Refused:
        if places.owner(name) is None:  # else somebody else has just started it
            raise


def starter(session: Session) -> Start:
    """Return a function that starts a manager as ``rtmgr start NAME`` does, and connects to it."""

    def start(name: str) -> Tree:
        from rtkit.tree.connect import connect

        start_manager(name, session.timeout_s, session.fail)
        return connect(name, session.timeout_s)

    return start


def unstarted(session: Session) -> Tree:
    """Return the usual manager, which does not run, as one that can be started."""
    from rtkit.tree.manager_set import ManagerSet

    return ManagerSet([session.usual_manager], {}, {}, starter(session))


def _check_meant(absent: Mapping[str, str], trees: Mapping[str, Tree]) -> None:
    """Refuse to start a manager whose name looks like a misspelt one of a running manager.

    Raises:
        Unreachable: It does; tells how it is started if it is meant.
    """
    from rtkit.link.running import managers
    from rtkit.rtc.nearest import is_slip

    for name, why in absent.items():
        meant = next((each for each in managers() if is_slip(name, each)), "")
        if meant:
            _close(trees)
            reason = f"not started, as its name is so like {meant}, which runs"
            raise Unreachable(f"{why}; {reason} (if it is meant: rtmgr start {name})")


def _one(managers: Managers, trees: Mapping[str, Tree], session: Session | None = None) -> Tree:
    """Return connections as one; with `session` those that are missing can be started."""
    if len(managers.names) == 1 and trees:
        return trees[managers.names[0]]
    from rtkit.tree.manager_set import ManagerSet

    start = starter(session) if session is not None else None
    return ManagerSet(managers.names, trees, managers.homes, start)


def _close(trees: Mapping[str, Tree]) -> None:
    for tree in trees.values():
        tree.close()
