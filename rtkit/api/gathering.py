"""Connects to the managers that a system profile is about, of this host and of others."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rtkit.errors import RtkitError, Unreachable
from rtkit.link.places import host_name
from rtkit.rtc.names import MANAGER_SUFFIX, is_local_host, manager_on, split_manager

NOWHERE: Mapping[str, str] = {}

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.profile.rts_model import ComponentInstance, RtsProfile
    from rtkit.tree.client import Tree


def names_another(profile: RtsProfile) -> bool:
    """Return whether a path leads below a manager, ``localhost/m1.mgr/…``, or to a known host."""
    paths = [each.path_uri or "" for each in profile.components]
    is_below = any(f"{MANAGER_SUFFIX}/" in path for path in paths)
    return is_below or any(map(_far_manager, dict.fromkeys(map(_host_in, paths))))


def is_movable(component: ComponentInstance) -> bool:
    """Return whether a component is to be made elsewhere when its host is lost."""
    from rtkit.deployment.extension import MOVABLE

    return any(each.name == MOVABLE for each in component.properties)


def _host_in(path: str) -> str:
    """Return the host that a path begins with, empty if it is this one or none."""
    host, slash, _ = path.strip().lstrip("/").partition("/")
    return host if slash and not is_local_host(host, host_name()) else ""


def _far_manager(host: str) -> str:
    """Return the manager of another host that is linked, or else in the inventory; or nothing."""
    if not host:
        return ""
    from rtkit.hosts import inventory
    from rtkit.link import host_links

    if host_links.is_linked(host):
        return host_links.read(host).far_manager
    known = inventory.read().get(host)
    return known.manager if known is not None else ""


class Managers:
    """The managers that the components of a profile belong to.

    Attributes:
        names: First the default manager, if any component belongs to it, or to another host, to
            which it has the link. Those of other hosts are called ``manager@robot1``.
        homes: The manager of each component.
        fixed: The same without components that are movable or moving: asked where they live.
        lost: Why those cannot be asked whose host is linked, but cut off; they may live.
    """

    def __init__(
        self,
        profile: RtsProfile,
        usual: str,
        mapped: Collection[str] = (),
        moving: Mapping[str, str] = NOWHERE,
    ) -> None:
        """Find them; `usual` is the manager of components whose path names none.

        Hosts that are `mapped` to another one are not asked. What is `moving` lives in another
        place, ``localhost/m1.mgr`` or ``robot1``, that it is to leave.
        """
        self.host = host_name()
        self._paths = {c.instance_name: c.path_uri or "" for c in profile.components}
        gone = [f"{place}/." for place in moving.values()]
        hosts = {_host_in(path) for path in (*self._paths.values(), *gone)}
        self._far = {host: _far_manager(host) for host in hosts.difference(mapped)}
        self.homes = {name: self._home(path) or usual for name, path in self._paths.items()}
        movable = {c.instance_name for c in profile.components if is_movable(c)} | {*moving}
        self.fixed = {name: home for name, home in self.homes.items() if name not in movable}
        found = dict.fromkeys([*self.homes.values(), *(self._home(each) or usual for each in gone)])
        self.lost: dict[str, str] = {}
        is_usual = usual in found or any(split_manager(name)[1] for name in found)
        self.names = [usual, *(n for n in found if n != usual)] if is_usual else [*found]

    def _home(self, path: str) -> str:
        """Return the manager that a path names; empty for the usual one."""
        from rtkit.deployment.place import Hosts, manager_in

        host = _host_in(path)
        if not self._far.get(host):
            return manager_in(path, Hosts(self.host, {}))
        stated = path.strip().lstrip("/").split("/")[1]
        is_stated = stated.endswith(MANAGER_SUFFIX)
        manager = stated.removesuffix(MANAGER_SUFFIX) if is_stated else self._far[host]
        return manager_on(manager, host)

    def connect(self, timeout_s: float) -> tuple[dict[str, Tree], dict[str, str]]:
        """Connect to each; return the connections, and the reasons for missing ones."""
        trees: dict[str, Tree] = {}
        absent: dict[str, str] = {}
        for name in self.names:
            try:
                trees[name] = connected(name, timeout_s)
            except Unreachable as error:
                absent[name] = f"{error}{self._paths_text(name)}"
                if _is_lost(name):
                    self.lost[name] = str(error)
            except BaseException:
                _close(trees)
                raise
        return trees, absent

    def take_for_empty(self, can_start: Callable[[str], bool]) -> None:
        """Take managers of linked hosts for empty that run no more, where they can be started."""
        from rtkit.link.host_links import is_cured_by_start

        ended = [name for name, why in self.lost.items() if is_cured_by_start(why)]
        for name in filter(can_start, ended):
            del self.lost[name]

    def _paths_text(self, manager: str) -> str:
        paths = [path for name, path in self._paths.items() if self.homes[name] == manager]
        if not paths:
            return f"; it is to hold the links to {', '.join(filter(None, self._far))}"
        more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
        return f"; it is to hold /{paths[0].lstrip('/')}{more}"

    def joined(self, reports: Iterable[Snapshot]) -> Snapshot:
        """Join the reports of these managers into one snapshot; one without a report is down."""
        from rtkit.deployment.multi_manager import down, joined

        known = {_name_of(each, self.host): each for each in reports}
        facts = [known.get(n) or down(self.host, n) for n in self.names]
        return joined(facts, self.fixed, self.lost)


def _name_of(report: Snapshot, host: str) -> str:
    is_here = is_local_host(report.host, host)
    return report.manager if is_here else manager_on(report.manager, report.host)


def connected(name: str, timeout_s: float) -> Tree:
    """Connect to a manager as plans call it.

    Raises:
        Unreachable: It does not run, or there is no link to its host.
    """
    from rtkit.tree.connect import connect, connect_far

    manager, host = split_manager(name)
    return connect_far(host, manager, timeout_s) if host else connect(name, timeout_s)


def gather(
    session: Session,
    document: SystemProfile,
    *,
    is_lenient: bool,
    starts: bool = False,
    would_start: bool = False,
    moving: Mapping[str, str] = NOWHERE,
) -> Snapshot | None:
    """Connect to the managers of a profile; return a snapshot if none of them runs.

    Args:
        session: Is given the connection, if the profile is about another manager or several.
        document: The system profile; hosts for which another one stands are not asked.
        is_lenient: A manager that does not run is told and counts as holding nothing.
        starts: One that does not run holds nothing, and can be started.
        would_start: It is only planned; also one of a linked host that runs no more holds nothing.
        moving: Places that components are to leave, by component.

    Raises:
        Unreachable: Tells which managers do not run, and what belongs there; or one is so like
            another one that runs that it is not started.
    """
    managers = Managers(document.profile, session.usual_manager, document.mapped, moving)
    trees, absent = managers.connect(session.timeout_s)
    if would_start:
        managers.take_for_empty(can_be_started)
    if starts and all(map(can_be_started, absent)):
        _check_meant(absent, trees)
        session.ask(_one(managers, trees, session))
        return None
    if absent and not is_lenient:
        _close(trees)
        raise Unreachable("; ".join(absent.values()))
    for name, why in absent.items():
        if name in managers.lost:
            session.miss(f"{why}; left out")
        else:
            session.fail(f"{why}; taken as if nothing lived there")
    if not trees:
        return managers.joined([])
    session.ask(_one(managers, trees))
    return None


def _is_lost(manager: str) -> bool:
    """Return whether a manager that does not answer may live: its host is linked, and cut off."""
    from rtkit.link import host_links

    return host_links.is_linked(split_manager(manager)[1])


def gather_named(session: Session, servers: Sequence[str]) -> tuple[str, ...]:
    """Connect to the managers among some servers; return the hosts that the servers stand for.

    The manager that is asked by default is among them when the host itself is named.

    Raises:
        Unreachable: One does not run.
    """
    from rtkit.deployment.place import Hosts, manager_in
    from rtkit.rtc.names import LOCAL
    from rtkit.tree.manager_set import ManagerSet

    hosts = Hosts(host_name(), {})
    usual = session.usual_manager
    named = {
        server: _far_named(server) or manager_in(f"{server.strip('/')}/.", hosts)
        for server in servers
    }
    trees: dict[str, Tree] = {}
    try:
        for name in dict.fromkeys(manager or usual for manager in named.values()):
            trees[name] = connected(name, session.timeout_s)
    except BaseException:
        _close(trees)
        raise
    session.ask(ManagerSet(list(dict.fromkeys([usual, *trees])), trees, {}))
    chosen = (split_manager(m)[1] or (LOCAL if m else host) for host, m in named.items())
    return tuple(dict.fromkeys(chosen))


def names_linked(servers: Iterable[str]) -> bool:
    """Return whether one of some servers is another host, or a manager, of its own."""
    return any(each.endswith(MANAGER_SUFFIX) or _far_named(each) for each in servers)


def _far_named(server: str) -> str:
    """Return the manager of a linked host that a server means; empty if it means none."""
    from rtkit.link import host_links

    host, _, manager = server.strip("/").partition("/")
    if is_local_host(host, host_name()) or not host_links.is_linked(host):
        return ""
    named = manager.removesuffix(MANAGER_SUFFIX) or host_links.read(host).far_manager
    return manager_on(named, host)


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
    """Return whether a manager that cannot be reached does not run, or its host is known."""
    from rtkit.link import places

    manager, host = split_manager(manager)
    if host:
        from rtkit.hosts import inventory
        from rtkit.link import host_links

        linked = host_links.read(host).far_manager if host_links.is_linked(host) else manager
        return linked == manager and host in inventory.read()
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


class _Starter:
    """Starts managers as ``rtmgr start NAME`` and ``--host HOST`` do, and ends them again."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._left: set[str] = set()

    def start(self, name: str) -> Tree:
        """Start a manager, unless it runs, and connect to it."""
        session = self._session
        manager, host = split_manager(name)
        if host:
            self._start_far(name)
        else:
            start_manager(manager, session.timeout_s, session.fail)
        return connected(name, session.timeout_s)

    def _start_far(self, name: str) -> None:
        from rtkit.fast_dataclass import replace
        from rtkit.hosts import bring_up, inventory
        from rtkit.hosts.progress import by_lines

        session = self._session
        manager, host = split_manager(name)
        far = replace(inventory.host(host), manager=manager)
        show, timeout_s = by_lines(session.verbose), session.timeout_s
        with connected(session.usual_manager, timeout_s) as near:
            try:
                done = bring_up.start(far, near, show, replaces=False, timeout_s=timeout_s)
            except Unreachable as error:
                raise Unreachable(f"host {host} cannot be reached: {error}") from error
        if done.was_running:
            self._left.add(name)

    def end(self, name: str, timeout_s: float) -> None:
        """End a manager that was started, but none that ran already and was only linked."""
        from rtkit.tree import managers

        manager, host = split_manager(name)
        if not host:
            managers.stop(name, timeout_s)
        elif name not in self._left:
            from rtkit.fast_dataclass import replace
            from rtkit.hosts import bring_up, inventory

            with connected(self._session.usual_manager, timeout_s) as near:
                bring_up.stop(replace(inventory.host(host), manager=manager), near, timeout_s)


def unstarted(session: Session) -> Tree:
    """Return the usual manager, which does not run, as one that can be started."""
    from rtkit.tree.manager_set import ManagerSet

    starter = _Starter(session)
    return ManagerSet([session.usual_manager], {}, {}, starter.start, starter.end)


def _check_meant(absent: Mapping[str, str], trees: Mapping[str, Tree]) -> None:
    """Refuse to start a manager whose name looks like a misspelt one of a running manager.

    Raises:
        Unreachable: It does; tells how it is started if it is meant.
    """
    from rtkit.link.running import managers
    from rtkit.rtc.nearest import is_slip

    for name, why in absent.items():
        meant = next((each for each in managers() if is_slip(name, each)), "")
        meant = "" if split_manager(name)[1] else meant
        if meant:
            _close(trees)
            reason = f"not started, as its name is so like {meant}, which runs"
            raise Unreachable(f"{why}; {reason} (if it is meant: rtmgr start {name})")


def _one(managers: Managers, trees: Mapping[str, Tree], session: Session | None = None) -> Tree:
    """Return connections as one; with `session` those that are missing can be started."""
    if len(managers.names) == 1 and trees:
        return trees[managers.names[0]]
    from rtkit.tree.manager_set import ManagerSet

    if session is None:
        return ManagerSet(managers.names, trees, managers.fixed, unreachable=managers.lost)
    starter = _Starter(session)
    return ManagerSet(managers.names, trees, managers.fixed, starter.start, starter.end)


def _close(trees: Mapping[str, Tree]) -> None:
    for tree in trees.values():
        tree.close()
