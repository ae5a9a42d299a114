"""Shared parts of the system commands: options, the wanted system, messages on stderr."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import (
    arguments,
    flag,
    option,
    setting,
    several,
    strict_option,
    together,
)
from rtkit.errors import Malformed, Unreachable, UsageProblem

if TYPE_CHECKING:
    from rtkit.cli.system.document import SystemDocument
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.layered_plan import LayeredPlan
    from rtkit.deployment.runner import Count, PlanRunner
    from rtkit.deployment.start_schedule import StartPlan
    from rtkit.deployment.system import KnownType, WantedSystem
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.rtc.profiles import ConnectorProfile
    from rtkit.tree.plan_locks import PlanLocks

MOST_WAIT_S = 86_400.0


def form_options(verb: str, default: str, *forms: str) -> Any:
    """Return an option for each form that a profile may have; the last one sets `App.form`."""
    return together(
        None,
        {
            form: flag(
                "--json" if form == "json" else f"-{form[0]} --{form}",
                f"{verb} {form.upper()}{default if form == 'xml' else ''}.",
                **setting("form", form),
            )
            for form in forms
        },
    )


READ_FORMS = form_options("Read", "; without -x and -y, as name and content say", "xml", "yaml")
DRY_RUN = flag("--dry-run", "Print what would be done, and do nothing.")
WAIT = option(
    "--wait SECONDS",
    "Wait so long for another rtapply, rtresurrect or rtstate at work (default 0).",
    click.FloatRange(min=0, max=MOST_WAIT_S),
    default=0.0,
)


class DocumentOptions(NamedTuple):
    """Options and argument that name a system profile.

    Attributes:
        forms: Nothing: the run knows the form that was asked for.
        strict: Nothing: the run knows.
        mapped: ``HOST=HOST``: a host of the profile stands for another.
        files: The profile; none for stdin.
    """

    forms: None = READ_FORMS
    strict: None = strict_option("Refuse a profile that needs repair, or has warnings.")
    mapped: tuple[str, ...] = several(
        "--map HOST=HOST",
        "A host of the profile stands for another, e.g. 10.0.0.7=localhost; repeatable.",
    )
    files: tuple[str, ...] = arguments("[FILE]")


def host_map(mapped: tuple[str, ...]) -> dict[str, str]:
    """Read ``HOST=HOST`` options.

    Raises:
        UsageProblem: One is not of that form.
    """
    pairs = {}
    for item in mapped:
        host, equals, other = item.partition("=")
        if not (host and equals and other):
            raise UsageProblem(f"--map needs HOST=HOST: {item}")
        pairs[host] = other
    return pairs


def wanted_system(
    app: App,
    document: SystemDocument,
    snapshot: Snapshot,
    *,
    stand_in: bool = False,
    transmit: bool = False,
    mapped: tuple[str, ...] = (),
    known_types: Mapping[str, KnownType] | None = None,
) -> WantedSystem:
    """Return the wanted system; report the decisions taken when verbose.

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
            host_map=host_map(mapped),
            known_types=known_types,
            stand_ins={c.instance for c in snapshot.components if c.is_stand_in},
            managers=[each.manager for each in snapshot.others],
        )
    for note in system.notes:
        app.verbose(note)
    app.warn(_odd_keys(document.profile))
    for connector in system.connectors:
        if connector.is_data:
            found = _odd(connector.profile)
            app.warn(f"connector {connector.profile.connector_id}: {text}" for text in found)
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
    from rtkit.component.options import parse_options, remarks

    try:
        parse_options(connector.properties)
    except Malformed as error:
        return [str(error)]
    return remarks(connector.properties)


def snapshot(app: App) -> Snapshot:
    """Return a snapshot of the live system.

    Raises:
        Unreachable: No manager answers.
    """
    from rtkit.tree.grace import uninterrupted

    return uninterrupted(lambda: app.tree.snapshot())


def remains(app: App) -> Snapshot:
    """Return a snapshot of the live system, where a manager may have ended.

    Raises:
        Unreachable: One that runs does not answer.
    """
    from rtkit.tree.grace import uninterrupted

    return uninterrupted(lambda: app.tree.remains())


def look(
    app: App,
    profile: RtsProfile,
    *,
    dry_run: bool,
    may_lack: bool = False,
    starts: bool = False,
    lock: PlanLocks | None = None,
) -> Snapshot:
    """Return a snapshot of a profile's managers; a dry run reports missing ones and goes on.

    With `may_lack` some of several managers may be missing, but not all; where one is missing
    that `starts` can be started, it holds nothing. A `lock` is taken before it is looked, and
    given back when the command ends.

    Raises:
        Unreachable: A manager does not run, or does not answer.
        Refused: Somebody else carries a plan out at one of them.
    """
    starts = starts and not dry_run
    if app.finds_managers:
        from rtkit.cli.system import gathering

        if gathering.names_another(profile):
            is_lenient = dry_run or may_lack
            empty = gathering.gather(app, profile, is_lenient=is_lenient, starts=starts)
            if empty is not None:
                return empty
    try:
        take(app, lock)
        return snapshot(app)
    except Unreachable as error:
        if starts and app.finds_managers and gathering.can_be_started(gathering.usual_manager()):
            app.ask(gathering.unstarted(app))
            take(app, lock)
            return snapshot(app)
        if not dry_run:
            raise
        app.fail(f"{error}; shown as if nothing lived")
        return nothing()


def locks(app: App, files: tuple[str, ...], wait_s: float) -> PlanLocks:
    """Return the locks that keep others off until the command ends."""
    from rtkit.tree.plan_locks import PlanLocks

    made = PlanLocks(" ".join([app.name, *files]), wait_s, app.report if wait_s else app.verbose)
    click.get_current_context().call_on_close(made.close)
    return made


def take(app: App, lock: PlanLocks | None) -> None:
    """Take the locks of all managers that run, and of those that are started later."""
    if lock is not None:
        lock.take(*app.tree.trees.values())
        app.tree.on_start = lock.take


@contextmanager
def managers_started(app: App, found: Snapshot, *, dry_run: bool) -> Iterator[Snapshot]:
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
            uninterrupted(partial(app.tree.start, name))
            app.verbose(f"manager {name} was not running, and is started")
        yield snapshot(app)
    except BaseException:
        uninterrupted(app.tree.end_started)
        raise


def nothing() -> Snapshot:
    """Return the snapshot of a host without live components."""
    import os

    from rtkit.cli.system.gathering import usual_manager
    from rtkit.deployment.facts import Snapshot

    return Snapshot(os.uname().nodename, usual_manager(), 0, "")


def show(plan: LayeredPlan | StartPlan) -> None:
    """Print a plan on stdout."""
    for line in plan.lines():
        click.echo(line)


def runner(
    app: App,
    count: Count = lambda _done, _known: None,
    taken: list[tuple[Action, float]] | None = None,
) -> PlanRunner:
    """Return a runner of plans that reports on stderr; `taken` receives actions' durations [s]."""
    from rtkit.deployment.runner import PlanRunner
    from rtkit.tree.grace import uninterrupted

    return PlanRunner(
        app.tree, app.fail, app.verbose, count, taken, uninterrupted, is_strict=app.is_strict
    )


def check_text(text: str) -> str:
    """Return `text` if XML can hold it.

    Raises:
        Malformed: It has control characters.
    """
    if any(ord(c) < 32 for c in text):
        raise Malformed(f"control characters cannot be saved: {text!r}")
    return text
