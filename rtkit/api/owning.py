"""Ownership of systems with movable components: recorded when applied, moved with, given up.

The record is a file of the manager on which the system was applied, whose process
`rtkit.api.owner_process` acts on it. Epochs are told to all managers of the system before a
component is made elsewhere; see decision 79.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from collections.abc import Set as AbstractSet
from contextlib import ExitStack, contextmanager
from time import time
from typing import TYPE_CHECKING

from rtkit.deployment.extension import MOVABLE
from rtkit.errors import RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX, manager_on, split_manager

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.owned import OwnedSystem
    from rtkit.tree.client import Tree

Older = Mapping[str, AbstractSet[str]]
"""Managers in which an older one of a component may live, by its name."""


def claim(session: Session, document: SystemProfile, goal: DeploymentGoal) -> Older:
    """Raise the epochs of components that a plan leads elsewhere than their owner has them.

    What managers were told of some by an ownership that has ended is taken back. Returns in which
    managers there may be one of each that is to live in another one.
    """
    if not _is_here(session):
        return {}
    there = homes(session, goal)
    _take_back(session, session.tree.trees, there)
    known = _own(session, document)
    if known is None:
        return {}
    older = {name: {each.home, *each.stale} for name, each in known.components.items()}
    for name, each in known.components.items():
        if there.get(name, each.home) != each.home:
            is_stale = each.home not in session.tree.trees
            known = _moved(session, known, name, there[name], is_stale=is_stale)
    return {name: found - {there.get(name, "")} for name, found in older.items()}


def claim_one(session: Session, name: str, home: str) -> None:
    """Raise the epoch of one component, which is moved by request, if its owner is here."""
    for known in records(session.usual_manager) if _is_here(session) else ():
        if name in known.components:
            _moved(session, known, name, home)


def _is_here(session: Session) -> bool:
    """Return whether the manager that would own a system is of this host, where its files are."""
    from rtkit.link.places import host_name
    from rtkit.rtc.names import is_local_host

    return is_local_host(session.tree.host, host_name())


def _own(session: Session, document: SystemProfile) -> OwnedSystem | None:
    """Return the record of a system, if its owner is here."""
    return read(session.usual_manager, document.profile.id) if _is_here(session) else None


def elsewhere(session: Session, document: SystemProfile) -> dict[str, str]:
    """Return the places of movable components that are not where the profile says.

    Those on hosts that are lost are left out: their owner ends them once these are back.
    """
    known = read(session.usual_manager, document.profile.id) if session.finds_managers else None
    rows = known.components if known is not None else {}
    return {
        name: place(each.home)
        for name, each in rows.items()
        if each.home != each.origin and not is_lost(each.home)
    }


def paths(session: Session, document: SystemProfile) -> dict[str, str]:
    """Return the paths of movable components that their owner has elsewhere, by name."""
    from rtkit.deployment.owned import moved_paths

    known = read(session.usual_manager, document.profile.id) if session.finds_managers else None
    return moved_paths(known) if known is not None else {}


def place(manager: str) -> str:
    """Return the place of a manager that is called as in plans: ``robot1/manager.mgr``."""
    own, host = split_manager(manager)
    return f"{host or LOCAL}/{own}{MANAGER_SUFFIX}"


def homes_as_known_there(session: Session, document: SystemProfile) -> dict[str, str]:
    """Return where movable components were had by an ownership that ended with the manager here.

    Managers of linked hosts have been told, and know it still: the manager of each, by component.
    """
    from rtkit.api.gathering import is_movable
    from rtkit.link import host_links
    from rtkit.link.places import host_name

    movable = {each.instance_name for each in document.profile.components if is_movable(each)}
    if not movable or not host_links.hosts() or read(session.usual_manager, document.profile.id):
        return {}
    found: dict[str, tuple[int, str]] = {}
    here = f"{host_name()}/{session.usual_manager}"
    with ExitStack() as stack:
        for tree in _linked(session, stack, ()).values():
            for line in tree.get("get_fences").splitlines():
                name, epoch, home, owner = line.split()
                if owner == here and name in movable:
                    found[name] = max(found.get(name, (0, "")), (int(epoch), home))
    return {name: _in_plans(home) for name, (_, home) in found.items()}


def _in_plans(home: str) -> str:
    """Return how plans call a manager that is told with its host."""
    from rtkit.link.places import host_name

    host, _, manager = home.rpartition("/")
    return manager if host == host_name() else manager_on(manager, host)


def absent_hosts(document: SystemProfile) -> Iterator[str]:
    """Yield a remark for each host that a movable component is to go to, and that is not linked.

    One on which the profile has components is linked by its plan.
    """
    from rtkit.deployment.owned import rules_of
    from rtkit.link import host_links, places
    from rtkit.rtc.names import is_local_host

    with document.naming():
        rules = rules_of(document.profile)
    paths = (each.path_uri or "" for each in document.profile.components)
    used = {path.strip().lstrip("/").partition("/")[0] for path in paths}
    for name, rule in rules.items():
        for host in rule.hosts:
            if is_local_host(host, places.host_name()) or host_links.is_linked(host):
                continue
            from rtkit.hosts import inventory

            why = f"is not known, and is left out (rthost add {host} USER@ADDRESS)"
            if host in inventory.read():
                if host in used:
                    continue
                why = f"is not linked, and is left out (rtmgr start --host {host})"
            yield f"{name}: {MOVABLE}: host {host} {why}"


def is_lost(manager: str) -> bool:
    """Return whether the host of a manager is linked and cannot be reached."""
    from rtkit.link import host_links

    return bool(host_links.why_lost(split_manager(manager)[1]))


def _moved(
    session: Session, known: OwnedSystem, name: str, home: str, *, is_stale: bool = False
) -> OwnedSystem:
    moved = known.moved(name, home, time(), is_stale=is_stale)
    known = replace(moved, is_pending=known.is_pending and is_stale)
    write(session.usual_manager, known)
    send_epoch(session.tree.trees, session.usual_manager, name, known, session.verbose)
    return known


def note(session: Session, document: SystemProfile, goal: DeploymentGoal, older: Older) -> None:
    """Own a system that was applied, if components of it are movable and on other hosts.

    What is left of an `older` one in a manager that was asked, as its host was just back, ends.
    """
    from rtkit.api.gathering import is_movable
    from rtkit.deployment.owned import OwnedComponent, OwnedSystem

    if not _is_here(session):
        return
    name = document.profile.id
    known = read(session.usual_manager, name)
    there = homes(session, goal)
    named = {each.instance_name for each in document.profile.components if is_movable(each)}
    movable = {name: home for name, home in there.items() if name in named}
    rows = dict(known.components) if known is not None else {}
    if not any(split_manager(home)[1] for home in movable.values()) and not rows:
        return
    fresh = {each: OwnedComponent(home, home, int(time())) for each, home in movable.items()}
    components = {
        each: replace(rows[each], origin=row.origin) if each in rows else row
        for each, row in fresh.items()
    }
    for each, managers in older.items():
        for manager in managers & session.tree.trees.keys():
            end(session.tree.at(manager), each)
    made = OwnedSystem(name, document.source, document.text(), components)
    write(session.usual_manager, made)
    for each in components:
        send_epoch(session.tree.trees, session.usual_manager, each, made, session.verbose)
    _awake(session)


@contextmanager
def given_up(session: Session, document: SystemProfile, *, ends: bool) -> Iterator[None]:
    """Own a system no more: its components may be anywhere again.

    With `ends` older ones of them end, too, once the body is through; what it leaves undone when
    it fails is owned still, so that it can be undone where it is.
    """
    from rtkit.link import owned_files

    if not _is_here(session):
        yield
        return
    known = _own(session, document)
    names = {each.instance_name for each in document.profile.components}
    if known is None:
        _take_back(session, session.tree.trees, names)
        yield
        return
    owned_files.remove(owned_files.path_of(session.usual_manager, known.system))
    try:
        _awake(session)
        with ExitStack() as stack:
            _take_back(
                session, session.tree.trees | _linked(session, stack, session.tree.trees), names
            )
        yield
    except BaseException:
        write(session.usual_manager, known)
        raise
    if ends:
        _end_older(session, known)


def _linked(session: Session, stack: ExitStack, but: Collection[str]) -> dict[str, Tree]:
    """Return connections to the managers of linked hosts, without some."""
    from rtkit.api.gathering import connected
    from rtkit.link import host_links

    found = {}
    for host in host_links.hosts():
        name = manager_on(host_links.read(host).far_manager, host)
        if name not in but and not is_lost(name):
            try:
                found[name] = stack.enter_context(connected(name, session.timeout_s))
            except Unreachable as error:
                session.verbose(str(error))
    return found


def _take_back(session: Session, trees: Mapping[str, Tree], names: Collection[str]) -> None:
    """Take back what managers were told of components that the manager here owns no more."""
    from rtkit.link import host_links
    from rtkit.link.places import host_name

    if not host_links.hosts():
        return
    owned = {name for each in records(session.usual_manager) for name in each.components}
    here = f"{host_name()}/{session.usual_manager}"
    for tree in trees.values():
        for line in tree.get("get_fences").splitlines():
            name, epoch, _, owner = line.split()
            if owner == here and name in names and name not in owned:
                row = {"component": name, "epoch": int(epoch) + 1, "home": "", "owner": here}
                tree.set("fence", json.dumps(row))


def _end_older(session: Session, known: OwnedSystem) -> None:
    """End older ones of components of a system that has been torn down, or tell where they are."""
    from rtkit.api.gathering import connected

    for name, each in known.components.items():
        for manager in each.stale:
            path = f"/{split_manager(manager)[1] or LOCAL}/{name}.rtc"
            try:
                with connected(manager, session.timeout_s) as tree:
                    end(tree, name)
            except RtkitError as error:
                session.miss(f"{path}: an older one may live there: {error}")


def end(tree: Tree, name: str) -> bool:
    """End a component in a manager, which is older than one elsewhere; return whether it lived."""
    from rtkit.deployment.actions import Delete

    if tree.snapshot().component(name) is None:
        return False
    for result in tree.apply([Delete(name, is_forced=True)]):
        result.raise_for_error()
    return True


def send_epoch(
    trees: Mapping[str, Tree],
    owner: str,
    name: str,
    owned: OwnedSystem,
    notify: Callable[[str], object],
) -> None:
    """Tell managers in which one a component is to be, and since which epoch its owner says so."""
    from rtkit.link.places import host_name

    each = owned.components[name]
    manager, host = split_manager(each.home)
    home = f"{host or host_name()}/{manager}" if manager else ""
    row = {"component": name, "epoch": each.epoch, "home": home}
    row["owner"] = f"{host_name()}/{owner}"
    text = json.dumps(row)
    for tree in trees.values():
        try:
            tree.set("fence", text)
        except Unreachable as error:
            notify(f"{error}: it is told of {name} when it is back")


def read(manager: str, system: str) -> OwnedSystem | None:
    """Return the record of a system that a manager owns, if it does."""
    from rtkit.link import owned_files

    return _decoded(owned_files.read(owned_files.path_of(manager, system)))


def records(manager: str) -> Iterator[OwnedSystem]:
    """Yield the records of all systems that a manager owns; damaged ones are left out."""
    from rtkit.link import owned_files

    texts = map(owned_files.read, owned_files.of_manager(manager))
    return filter(None, map(_decoded, texts))


def _decoded(text: str) -> OwnedSystem | None:
    """Return a record from its text; None for an empty or damaged one."""
    from rtkit.deployment.owned import OwnedSystem
    from rtkit.rtc.serde import decode_text

    try:
        return decode_text(OwnedSystem, text) if text else None
    except (RtkitError, ValueError, LookupError, TypeError):
        return None


def troubles(manager: str) -> dict[str, str]:
    """Return what is wrong with movable components that a manager owns, by their names."""
    found = {}
    for owned in records(manager):
        for name, each in owned.components.items():
            left = [f"an older one may live in {manager}" for manager in each.stale]
            failed = [owned.why or "not all is connected yet"] if owned.is_pending else []
            whys = [*filter(None, [each.why]), *failed, *left]
            if whys:
                found[name] = "; ".join(whys)
    return found


def write(manager: str, owned: OwnedSystem) -> None:
    """Keep the record of a system."""
    from rtkit.link import owned_files
    from rtkit.rtc.serde import encode_text

    owned_files.write(owned_files.path_of(manager, owned.system), encode_text(owned))


def exchange(manager: str, known: OwnedSystem, made: OwnedSystem) -> bool:
    """Keep another record of a system if it is still the known one; return whether it was."""
    from rtkit.link import owned_files
    from rtkit.rtc.serde import encode_text

    path = owned_files.path_of(manager, known.system)
    return owned_files.exchange(path, lambda text: _decoded(text) == known, encode_text(made))


def homes(session: Session, goal: DeploymentGoal) -> dict[str, str]:
    """Return the managers of the components of a goal, as plans call them."""
    first = session.tree.manager
    return {each.instance: each.manager or first for each in goal.system.components}


def _awake(session: Session) -> None:
    """Have the manager begin, wake up or end the process that acts on its records."""
    session.tree.at(session.usual_manager).set("own", "")
