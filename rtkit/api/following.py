"""Makes the manager of a system follow its events, or ends that."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from rtkit.deployment.extension import FOLLOW
from rtkit.errors import InvalidDocument, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.api.document import SystemDocument
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Followed, Snapshot
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.states.states import States
    from rtkit.tree.client import Tree

_YES, _NO = ("true", "yes", "on", "1"), ("false", "no", "off", "0", "")


def is_wanted(session: Session, document: SystemDocument) -> bool:
    """Return whether the profile wants its system followed as soon as it is brought up.

    Raises:
        InvalidDocument: It does, and its states make no sense; or the value is not a boolean.
        Refused: It does, and its components are in several managers.
    """
    values = [item.value or "" for item in document.profile.properties if item.name == FOLLOW]
    word = values[-1].strip().lower() if values else ""
    if word not in _YES + _NO:
        raise InvalidDocument(f"{document.source}: {FOLLOW}: neither true nor false: {values[-1]}")
    if word in _NO:
        return False
    from rtkit.api.states import read_machine

    read_machine(document)
    check_one_manager(session, document)
    return True


def check_one_manager(session: Session, document: SystemDocument) -> None:
    """Refuse a system that no manager knows as a whole.

    Raises:
        Refused: Its components are in several.
    """
    from rtkit.api.gathering import Managers

    names = Managers(document.profile, session.usual_manager).names
    if len(names) > 1:
        raise Refused(
            f"{document.source}: no manager can follow {document.profile.id}: its components are"
            f" in several ({', '.join(names)}), and each knows only its own"
        )


def owner(session: Session) -> Tree:
    """Return the connection to the one manager of a system."""
    (tree,) = session.tree.trees.values()
    return tree


def begin(
    session: Session, document: SystemDocument, states: States, *, rolls_back: bool = False
) -> None:
    """Have the manager of a system follow its events, from now on and after its restart.

    Raises:
        Refused: It is followed as another profile tells it.
    """
    from hashlib import sha256  # loads OpenSSL: some 3 ms that a dry run does not need

    from rtkit.deployment.states.states_text import spec_to_text

    flags = bytes([rolls_back, states.base.replaces, states.base.is_strict])
    digest = sha256(document.data + flags).hexdigest()
    text = spec_to_text(states, [document.source, digest], rolls_back=rolls_back)
    session.verbose(owner(session).set(FOLLOW, f'{{"start": {text}}}'))


def begin_from(session: Session, document: SystemDocument, goal: DeploymentGoal) -> None:
    """Have the system of a profile followed that was led to a goal.

    Raises:
        Refused: It is followed as another profile tells it.
    """
    from dataclasses import replace

    from rtkit.api.states import read_machine
    from rtkit.deployment.states.states import States
    from rtkit.rtc.enums import LifeCycleState

    base = replace(goal, state=LifeCycleState.ACTIVE, prunes=False, parallel=0)
    begin(session, document, States(document.profile.id, read_machine(document), base))


def begin_as_stated(
    session: Session,
    document: SystemDocument,
    mapped: tuple[str, ...],
    *,
    stand_in: bool = False,
    transmit: bool = False,
) -> None:
    """Have the system of a profile followed from what lives now, perhaps with stand-ins.

    Raises:
        Refused: It is followed as another profile tells it.
    """
    from rtkit.api import planning
    from rtkit.api.states import states_of

    way = planning.WayOptions((), planning.MEASURED, stand_in, transmit, False)
    begin(
        session, document, states_of(planning.begin(session, document, mapped, way, is_dry=False))
    )


def end(tree: Tree, name: str) -> str:
    """Stop following a system, after the transition under way has ended; return a message.

    Raises:
        NotFound: It is not followed.
    """
    return tree.set(FOLLOW, json.dumps({"stop": name}))


def end_if_followed(session: Session, document: SystemDocument, facts: Snapshot) -> bool:
    """Stop following a system; return whether it was followed."""
    name = document.profile.id
    managers = [m.manager for m in (facts, *facts.others) if followed_in(m, name) is not None]
    for manager in managers:
        session.verbose(end(session.tree.at(manager), name))
    return bool(managers)


def followed_in(facts: Snapshot, name: str) -> Followed | None:
    """Return the report on a followed system; None for one that is not followed."""
    return next((each for each in facts.systems if each.system == name), None)


def named(facts: Snapshot, name: str) -> str:
    """Return the identity of a followed system by that, or by the name in it.

    Raises:
        NotFound: None is followed of that name.
        Refused: Several are.
    """
    known = [each.system for each in facts.systems]
    fits = [each for each in known if name == each or name in each.split(":")[2:3]]
    if len(fits) > 1:
        raise Refused(f"several systems have that name: {', '.join(fits)}")
    if not fits:
        there = f"; it follows {', '.join(known)}" if known else ""
        raise NotFound(f"manager {facts.manager!r} does not follow {name}{there}")
    return fits[0]
