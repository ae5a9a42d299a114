"""Looks at the live system of a profile, and makes of the profile the wanted system."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

from rtkit.errors import Malformed, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.link.places import host_name
from rtkit.rtc.names import split_manager

NOTHING: Mapping[str, str] = {}

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.runner import Count, PlanRunner
    from rtkit.deployment.system import KnownType, WantedSystem
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.rtc.profiles import ConnectorProfile
    from rtkit.tree.plan_locks import PlanLocks


def wanted_system(
    session: Session,
    document: SystemProfile,
    snapshot: Snapshot,
    *,
    stand_in: bool = False,
    transmit: bool = False,
    known_types: Mapping[str, KnownType] | None = None,
    moving: Collection[str] = (),
) -> WantedSystem:
    """Return the wanted system; report the decisions taken when verbose.

    Components that are `moving` leave the managers that they live in.

    Raises:
        InvalidDocument: What it says of a component makes no sense; names the line.
    """
    from rtkit.deployment.wanted import wanted

    with document.naming():
        system = wanted(
            document.profile,
            snapshot.host,
            stand_in=stand_in,
            transmit=transmit,
            host_map=document.mapped,
            known_types=known_types,
            stand_ins={c.instance for c in snapshot.components if c.is_stand_in},
            managers=[each.manager for each in snapshot.others],
        )
    if moving:
        moved = (replace(c, may_move=c.may_move or c.instance in moving) for c in system.components)
        system = replace(system, components=tuple(moved))
    for note in system.notes:
        session.verbose(note)
    session.warn(_odd_keys(document.profile))
    for connector in system.connectors:
        if connector.is_data:
            found = _odd(connector.profile)
            session.warn(f"connector {connector.profile.connector_id}: {text}" for text in found)
    return system


def _odd_keys(profile: RtsProfile) -> Iterator[str]:
    """Yield unknown properties, and unknown options in create strings."""
    from rtkit.deployment.known_keys import odd_options, odd_properties

    yield from (odd.text for odd in odd_properties(profile))
    yield from odd_options(profile, _unknown_options)


def _unknown_options(options: Mapping[str, str]) -> Iterable[str]:
    from rtkit.settings.options import unknown_options

    return unknown_options(options)


def _odd(connector: ConnectorProfile) -> list[str]:
    """Return the unknown or senseless properties of a connector."""
    from rtkit.component.ports.options import parse_options, remarks

    try:
        parse_options(connector.properties)
    except Malformed as error:
        return [str(error)]
    return remarks(connector.properties)


def snapshot(session: Session) -> Snapshot:
    """Return a snapshot of the live system.

    Raises:
        Unreachable: No manager answers.
    """
    from rtkit.tree.grace import uninterrupted

    return uninterrupted(lambda: session.tree.snapshot())


def remains(session: Session) -> Snapshot:
    """Return a snapshot of the live system, where a manager may have ended.

    Raises:
        Unreachable: One that runs does not answer.
    """
    from rtkit.tree.grace import uninterrupted

    return uninterrupted(lambda: session.tree.remains())


def look(
    session: Session,
    document: SystemProfile,
    *,
    dry_run: bool,
    may_lack: bool = False,
    starts: bool = False,
    lock: PlanLocks | None = None,
    moving: Mapping[str, str] = NOTHING,
) -> Snapshot:
    """Return a snapshot of a profile's managers; a dry run reports missing ones and goes on.

    With `may_lack` some of several managers may be missing, but not all; where one is missing
    that `starts` can be started, it holds nothing. A `lock` is taken before it is looked, and
    given back when the command ends. Hosts for which another one stands are not asked.
    What is `moving` is to leave the place that is told of it.

    Raises:
        Unreachable: A manager does not run, or does not answer.
        Refused: Somebody else carries a plan out at one of them.
    """
    would_start, starts = starts and dry_run, starts and not dry_run
    if session.finds_managers:
        from rtkit.api import gathering

        if moving or gathering.names_another(document.profile):
            is_lenient = dry_run or may_lack
            empty = gathering.gather(
                session,
                document,
                is_lenient=is_lenient,
                starts=starts,
                would_start=would_start,
                moving=moving,
            )
            if empty is not None:
                return empty
    try:
        take(session, lock)
        return snapshot(session)
    except Unreachable as error:
        if starts and session.finds_managers and gathering.can_be_started(session.usual_manager):
            session.ask(gathering.unstarted(session))
            take(session, lock)
            return snapshot(session)
        if not dry_run:
            raise
        session.fail(f"{error}; shown as if nothing lived")
        return nothing(session.usual_manager)


def take(session: Session, lock: PlanLocks | None) -> None:
    """Take the locks of all managers that run, and of those that are started later."""
    if lock is not None:
        # That of the manager with the links holds off others who would use them.
        trees = session.tree.trees.items()
        lock.take(*(tree for name, tree in trees if not split_manager(name)[1]))
        here = session.tree.host
        session.tree.on_start = lambda tree: lock.take(tree) if tree.host == here else None


@contextmanager
def managers_started(session: Session, found: Snapshot, *, dry_run: bool) -> Iterator[Snapshot]:
    """Start the managers that were found not to run; yield the snapshot afterwards.

    Those that still hold nothing are ended when the body fails.
    """
    from rtkit.tree.grace import uninterrupted

    absent = [each.manager for each in (found, *found.others) if not each.pid]
    if not absent or dry_run:
        yield found
        return
    try:
        for name in absent:
            uninterrupted(partial(session.tree.start_manager, name))
            session.verbose(f"manager {name} was not running, and is started")
        yield snapshot(session)
    except BaseException:
        uninterrupted(session.tree.end_started)
        raise


def on_this_host(snapshot: Snapshot) -> Iterator[ComponentFacts]:
    """Yield the components that are on this host: only their files can be looked at."""
    others = (each for each in snapshot.others if split_manager(each.manager)[1])
    far = {facts.instance for each in others for facts in each.components}
    return (facts for facts in snapshot.components if facts.instance not in far)


def present_code(components: Iterable[ComponentFacts]) -> dict[str, str]:
    """Return the CRC-32 of each file that these components come from, as facts tell it.

    A file that cannot be read is left out: whether it has changed is not known.
    """
    lines = (line for facts in components for line in facts.code.splitlines())
    files = {line.partition(" ")[2] for line in lines}
    if not files:
        return {}
    import zlib

    found = {}
    for file in files:
        try:
            with open(file, "rb") as stream:
                found[file] = f"{zlib.crc32(stream.read()):08x}"
        except OSError:
            continue
    return found


def nothing(manager: str) -> Snapshot:
    """Return the snapshot of a host where nothing lives, and of its usual manager."""
    from rtkit.deployment.facts import Snapshot

    return Snapshot(host_name(), manager, 0, "")


def runner(
    session: Session,
    count: Count = lambda _done, _known: None,
    taken: list[tuple[Action, float]] | None = None,
) -> PlanRunner:
    """Return a runner of plans that reports on stderr; `taken` receives actions' durations [s]."""
    from rtkit.deployment.runner import PlanRunner
    from rtkit.tree.grace import uninterrupted

    return PlanRunner(
        session.tree,
        session.fail,
        session.verbose,
        count,
        taken,
        uninterrupted,
        is_strict=session.is_strict,
        watch=session.watch,
    )
