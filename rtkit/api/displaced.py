"""Components that are not where their profile says: made elsewhere by their owner, or moved.

A plan leads them back; checks, starts, stops and teardowns take them where they live.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api import move_records, owning
from rtkit.errors import RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.rtc.names import LOCAL, split_manager

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile


class Displaced(NamedTuple):
    """Place of a component that was moved by request: it lives there, or may live there.

    Attributes:
        manager: The manager there, as plans call it.
        path: Its path there.
        why: Why nobody can look; empty where one can.
        is_lost: Its host is linked, and cannot be reached.
    """

    manager: str
    path: str
    why: str = ""
    is_lost: bool = False


def homes_of(session: Session, document: SystemProfile) -> dict[str, str]:
    """Return the managers to which a profile has its components belong, by component."""
    from rtkit.api.gathering import Managers

    return Managers(document.profile, session.usual_manager, document.mapped).homes


def _by_request(
    session: Session, document: SystemProfile, homes: Mapping[str, str]
) -> dict[str, Displaced]:
    """Return the components that ``rtmove`` led away from their managers, by name.

    Movable ones whose owner knows where they are are left out, and what is not there any more.
    Those whose owner was stopped meanwhile count as moved by request.
    """
    if not session.finds_managers:
        return {}
    moves: dict[str, tuple[str, str]] = {}
    if move_records.has_moved():
        for name, home in homes.items():
            if (last := move_records.last_move(home, name)) is not None:
                moves[name] = last.manager, last.shown_at(last.manager)[0]
    for name, manager in owning.homes_as_known_there(session, document).items():
        if manager != homes[name]:
            moves[name] = manager, f"{split_manager(manager)[1] or LOCAL}/{name}.rtc"
    owned = owning.read(session.usual_manager, document.profile.id)
    for name in owned.components if owned is not None else ():
        moves.pop(name, None)
    found = {}
    for name, (manager, path) in moves.items():
        there = _place_of(manager, path)
        if there is not None and _may_live(session, name, there, homes[name]):
            found[name] = there
    return found


def _may_live(session: Session, name: str, there: Displaced, home: str) -> bool:
    """Return whether a component lives where it was moved to, or may, if it is not at home."""
    if there.why:
        return _state(session, home, name) != ""
    return _state(session, there.manager, name) is not None


def forget(session: Session, document: SystemProfile, homes: Mapping[str, str]) -> None:
    """Forget where components were moved by request that are where they belong, or nowhere."""
    if session.finds_managers and move_records.has_moved():
        left = _by_request(session, document, homes)
        for name in homes.keys() - left.keys():
            move_records.forget_moves(homes[name], name)


def _place_of(manager: str, path: str) -> Displaced | None:
    """Return what is known of where a component was moved to; None if that has ended."""
    from rtkit.hosts import inventory
    from rtkit.link import host_links, places

    own, host = split_manager(manager)
    if not host:
        if places.owner(own) is not None:
            return Displaced(manager, path)
        why = f"manager {own} does not run, but may go on with it (rtmgr start {own})"
        return Displaced(manager, path, why) if os.path.exists(places.store_file(own)) else None
    gives_up = f"rtmgr stop --host {host} gives it up"
    if not host_links.is_linked(host):
        why = f"{host} is not linked (rtmgr start --host {host} links it, {gives_up})"
        return Displaced(manager, path, why) if host in inventory.read() else None
    link = host_links.read(host)
    if link.far_manager != own:
        why = f"the link to {host} leads to {link.far_manager} (rtmgr start {own} --host {host})"
        return Displaced(manager, path, why)
    if link.why and host_links.is_cured_by_start(link.why):
        return None
    why = f"host {host} cannot be reached: {link.why} ({gives_up})" if link.why else ""
    return Displaced(manager, path, why, bool(link.why))


def _state(session: Session, manager: str, name: str) -> str | None:
    """Return why a component of a manager is a zombie, empty if not; None if it is not seen."""
    from rtkit.api.gathering import connected

    try:
        with connected(manager, session.timeout_s) as tree:
            facts = tree.snapshot().component(name)
    except RtkitError:
        return None
    return None if facts is None else facts.zombie


def places_to_leave(session: Session, document: SystemProfile) -> dict[str, str]:
    """Return the places to which components were moved by request, for a plan that leads them back.

    Raises:
        Unreachable: One may live where nobody can look: a second one would be made.
    """
    found = _by_request(session, document, homes_of(session, document))
    _check_seen(found)
    return {name: owning.place(each.manager) for name, each in found.items()}


def _check_seen(found: Mapping[str, Displaced]) -> None:
    for name, each in found.items():
        if each.why:
            raise Unreachable(f"{name} was moved, and may live at /{each.path}: {each.why}")


def where_they_live(
    session: Session, document: SystemProfile, *, makes: bool = False
) -> SystemProfile:
    """Return a profile with its components where they live, or may live on lost hosts.

    What may live where nobody can look is told; for who `makes` components it is an error.

    Raises:
        Unreachable: That.
    """
    from rtkit.api.placing import settled

    document = settled(session, document)
    found = _by_request(session, document, homes_of(session, document))
    if makes:
        _check_seen(found)
    for name, each in found.items():
        if each.why and not each.is_lost:
            session.miss(f"/{each.path}: {name} was moved there: {each.why}")
    paths = {name: each.path for name, each in found.items()}
    paths |= owning.paths(session, document)
    if not paths:
        return document
    from rtkit.deployment.placement.profiles import with_paths

    return replace(document, profile=with_paths(document.profile, paths))


def remarks(document: SystemProfile, there: SystemProfile) -> dict[str, str]:
    """Return what is to be said of components that live elsewhere than their profile has them."""
    before = {each.instance_name: each.path_uri or "" for each in document.profile.components}
    return {
        each.instance_name: f"the profile has it at /{before[each.instance_name].lstrip('/')}"
        for each in there.profile.components
        if each.path_uri != before[each.instance_name]
    }
