"""States of a system: read from its profile, seen, led to, and followed by its manager."""

from __future__ import annotations

import json
import os
import time
from typing import TYPE_CHECKING

from rtkit.deployment.extension import FOLLOW
from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused
from rtkit.fast_dataclass import dataclass, replace

if TYPE_CHECKING:
    from rtkit.api.planning import DeploymentInputs, WayOptions
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Followed, Snapshot
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.states.leading import SystemTransition
    from rtkit.deployment.states.machine import SystemStates, Table
    from rtkit.deployment.states.states import States, Way
    from rtkit.tree.client import Tree
    from rtkit.tree.plan_locks import PlanLocks

_YES, _NO = ("true", "yes", "on", "1"), ("false", "no", "off", "0", "")


def states_of(begun: DeploymentInputs) -> States:
    """Return the states of a system.

    Raises:
        InvalidDocument: Its profile tells none, or they make no sense.
    """
    from rtkit.deployment.states.states import States

    return States(begun.document.profile.id, read_machine(begun.document), begun.goal)


def read_machine(document: SystemProfile) -> SystemStates:
    """Return the states of a system profile, checked.

    Raises:
        InvalidDocument: It tells none, or they make no sense.
    """
    from rtkit.deployment.described import properties_of
    from rtkit.deployment.extension import STATE_CHART, STATES
    from rtkit.deployment.states.machine import machine_of

    profile = document.profile
    properties = properties_of(profile.properties)
    sets = {c.instance_name: [s.id for s in c.configuration_sets] for c in profile.components}
    chart = properties.get(STATE_CHART)
    try:
        table = _chart(chart, document.source) if chart is not None else None
        machine = machine_of(properties, sets, table)
    except Malformed as error:
        raise InvalidDocument(f"{document.source}: {error}") from error
    if machine is None:
        raise InvalidDocument(f"{document.source}: it tells no states ({STATES} of the system)")
    return machine


def _chart(text: str, source: str) -> Table:
    """Return states and transitions of SCXML: the text, or a file beside the profile."""
    from rtkit.profile.read import STDIN, read_bytes
    from rtkit.profile.scxml import read_scxml

    if text.lstrip().startswith("<"):
        return read_scxml(text.encode(), source).states
    folder = os.path.dirname(source) if source != STDIN else ""
    path = os.path.join(folder, text.strip())
    try:
        return read_scxml(read_bytes(path), path).states
    except NotFound as error:
        raise InvalidDocument(f"{source}: the state chart: {error}") from error


def with_chart(document: SystemProfile) -> SystemProfile:
    """Return a profile that holds the text of its state chart, where it names a file of it.

    Raises:
        InvalidDocument: The file cannot be read.
    """
    from rtkit.deployment.extension import STATE_CHART
    from rtkit.profile.common import ExtensionProperty
    from rtkit.profile.read import STDIN, read_bytes
    from rtkit.profile.tree_read import decoded

    folder = os.path.dirname(document.source) if document.source != STDIN else ""

    def whole(item: ExtensionProperty) -> ExtensionProperty:
        text = item.value or ""
        if item.name != STATE_CHART or text.lstrip().startswith("<"):
            return item
        path = os.path.join(folder, text.strip())
        return ExtensionProperty(item.name, decoded(read_bytes(path), path))

    read = tuple(whole(item) for item in document.profile.properties)
    return replace(document, profile=replace(document.profile, properties=read))


@dataclass(frozen=True, slots=True)
class StatesReport:
    """The states of a system, and what it was like when it was looked at.

    Attributes:
        states: The states of its profile, over its goal.
        live: What lived.
        source: Names the profile in messages.
    """

    states: States
    live: Snapshot
    source: str

    def __repr__(self) -> str:
        return f"<StatesReport: {self}>"

    def __str__(self) -> str:
        return self.now or "between states"

    @property
    def now(self) -> str:
        """The state that it was in; empty for none of them, and where not all can be seen."""
        return "" if self.live.unreachable else self.states.now(self.live)

    @property
    def names(self) -> list[str]:
        """The names of all its states."""
        return list(self.states.machine.table)

    @property
    def events(self) -> dict[str, str]:
        """The events of the present state, and where each leads."""
        return dict(self.states.machine.table.get(self.now, {}))

    @property
    def followed(self) -> Followed | None:
        """The report of its manager; None where it is not followed."""
        return followed_in(self.live, self.states.name)

    def ways(self) -> list[Way]:
        """Return the cheapest way to each state, or why there is none."""
        from rtkit.deployment.states.states import Way

        why = "; ".join(self.live.unreachable.values())
        if why:
            return [Way(state, None, f"not known: {why}") for state in self.names]
        return [self.states.way(state, self.live) for state in self.names]

    def target(self, state: str, event: str = "") -> str:
        """Return the state that is meant by name, or by an event of the present one.

        Raises:
            InvalidDocument: There is no such state or event.
            Malformed: Both are given, or neither.
        """
        if bool(state) is bool(event):
            raise Malformed("a state or an event is to be given, one of them")
        try:
            if state:
                return self.states.machine.check_state(state)
            if not self.now:
                raise Malformed("the system is in none of its states; it is led to one by name")
            return self.states.machine.next(self.now, event)
        except Malformed as error:
            raise InvalidDocument(f"{self.source}: {error}") from error


def look(
    session: Session,
    document: SystemProfile,
    way: WayOptions,
    *,
    is_dry: bool = False,
    starts: bool = False,
    lock: PlanLocks | None = None,
) -> StatesReport:
    """Look in which state a system is; see `rtkit.Tree.states`, and `rtkit.api.planning.begin`."""
    from rtkit.api import planning

    begun = planning.begin(
        session, document, way, is_dry=is_dry, starts=starts, may_lack=not starts, lock=lock
    )
    return StatesReport(states_of(begun), begun.snapshot, document.source)


def lead(
    session: Session, report: StatesReport, target: str, event: str = "", *, rolls_back: bool
) -> None:
    """Lead a system to a state on command; the session must hold its managers' locks.

    Raises:
        RtkitError: It was not reached; tells where the system was led instead, if anywhere.
    """
    from rtkit.api import step_times
    from rtkit.deployment.applying import Applier
    from rtkit.deployment.states.leading import Leader, SystemTransition
    from rtkit.tree.grace import uninterrupted

    def reach(passage: SystemTransition) -> None:
        tree, goal = session.tree, report.states.goal(passage.state)
        snapshot = uninterrupted(tree.snapshot)
        with step_times.noting(session, goal.system, snapshot) as taken:
            applier = Applier(
                tree, goal, session.report, session.report, taken, careful=uninterrupted
            )
            applier.run(goal.plan(snapshot), snapshot, rolls_back=rolls_back)

    leader = Leader(report.states, reach, session.fail, time.monotonic)
    reached = leader.lead(SystemTransition(report.now, event or "goto", target)).state
    if reached != target:
        raise Refused(f"{target} was not reached; the system was led to {reached}")


def is_follow_wanted(session: Session, document: SystemProfile) -> bool:
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
    read_machine(document)
    check_one_manager(session, document)
    return True


def check_one_manager(session: Session, document: SystemProfile) -> None:
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


def follow(
    session: Session, document: SystemProfile, states: States, *, rolls_back: bool = False
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


def follow_from(session: Session, document: SystemProfile, goal: DeploymentGoal) -> None:
    """Have the system of a profile followed that was led to a goal.

    Raises:
        Refused: It is followed as another profile tells it.
    """
    from dataclasses import replace

    from rtkit.deployment.states.states import States
    from rtkit.rtc.enums import LifeCycleState

    base = replace(goal, state=LifeCycleState.ACTIVE, prunes=False, parallel=0)
    follow(session, document, States(document.profile.id, read_machine(document), base))


def follow_now(
    session: Session, document: SystemProfile, *, stand_in: bool = False, transmit: bool = False
) -> None:
    """Have the system of a profile followed from what lives now, perhaps with stand-ins.

    Raises:
        Refused: It is followed as another profile tells it.
    """
    from rtkit.api import planning

    way = planning.WayOptions((), planning.MEASURED, stand_in, transmit, False)
    follow(session, document, states_of(planning.begin(session, document, way, is_dry=False)))


def unfollow(tree: Tree, name: str) -> str:
    """Stop following a system, after the transition under way has ended; return a message.

    Raises:
        NotFound: It is not followed.
    """
    return tree.set(FOLLOW, json.dumps({"stop": name}))


def end_if_followed(session: Session, document: SystemProfile, facts: Snapshot) -> bool:
    """Stop following a system; return whether it was followed."""
    name = document.profile.id
    managers = [m.manager for m in (facts, *facts.others) if followed_in(m, name) is not None]
    for manager in managers:
        session.verbose(unfollow(session.tree.at(manager), name))
    return bool(managers)


def followed_in(facts: Snapshot, name: str) -> Followed | None:
    """Return the report on a followed system; None for one that is not followed."""
    return next((each for each in facts.systems if each.system == name), None)


def identity_of(facts: Snapshot, name: str) -> str:
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
