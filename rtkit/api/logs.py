"""Logs of components and processes: which records are wanted, those there are, those that come."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

from rtkit.logs.selection import LEVELS as LEVELS
from rtkit.logs.selection import About, Selection

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.logs.logbook import Logbook, LogEntry
    from rtkit.rtc.names import Path
    from rtkit.tree.client import Tree
    from rtkit.tree.far_logs import FarLogbook

_SETTLE_S = 0.02
"""Wait for simultaneous records of other processes, so that they can be put in order [s]."""
_HOLD_S = 0.25
"""How long a record waits for older ones of other hosts, which are still on their way [s]."""


class FarLogs(NamedTuple):
    """Logs that the manager of another host is asked for."""

    tree: Tree
    selection: Selection


def pieces(
    session: Session,
    selection: Selection | None,
    last: int | None,
    until: float | None,
    *,
    is_over: bool,
    unlogged: Sequence[LogEntry] = (),
    far: Sequence[FarLogs] = (),
) -> Generator[list[LogEntry], None, None]:
    """Yield the records there are, then unless it `is_over` those that come, together what is.

    Args:
        session: Of whoever reads; what is amiss is reported to it.
        selection: Which records of this host; None for none.
        last: How many of those that are there; None for all.
        until: When to end, monotonic [s]; None for never.
        is_over: End after those that are there.
        unlogged: Records that are in no log yet.
        far: What to ask other hosts for.

    Raises:
        RtkitError: A host does not answer at the beginning.
    """
    books: list[Logbook | FarLogbook] = []
    try:
        present: list[LogEntry] = []
        if selection is not None:
            from rtkit.link.places import state_dir
            from rtkit.logs.logbook import Logbook

            near = Logbook(state_dir(), selection.wanted())
            books.append(near)
            present += near.there(last, unlogged)
        for tree, wanted in far:
            from rtkit.tree.far_logs import FarLogbook

            book = FarLogbook(tree, wanted)
            books.append(book)
            present += book.there(last, is_followed=not is_over)
            _report(session, tree, book)
        present.sort(key=attrgetter("time"))
        yield present if last is None else present[max(0, len(present) - last) :]
        if not is_over:
            session.verbose("following")
            yield from _coming(session, books, until)
        for each in books:
            if each.unreadable:
                session.fail(f"{each.unreadable} lines are no records")
            if lost := getattr(each, "lost", 0):
                session.fail(f"{lost} messages with records of another host did not arrive")
    finally:
        for each in books:
            each.close()


def _report(session: Session, tree: Tree, book: FarLogbook) -> None:
    """Report how the clock of a host differs, and what was too much to be sent."""
    clock = book.clock
    text = (
        f"clock of {tree.place}: {clock.offset_s:+.4f} s (± {clock.bound_s:.4f} s now, and 0.2 ms"
        " for each second before), taken off its times"
    )
    if abs(clock.offset_s) > clock.bound_s:
        session.fail(text)
    else:
        session.verbose(text)
    if book.left_out:
        session.fail(f"{book.left_out} older records of {tree.place} are left out")


def _coming(
    session: Session, books: Sequence[Logbook | FarLogbook], until: float | None
) -> Iterator[list[LogEntry]]:
    """Yield what comes, in order of time; those of several hosts wait for each other."""
    hold_s = _HOLD_S if len(books) > 1 else 0.0
    held: list[tuple[float, LogEntry]] = []
    while True:
        ends = [until] if until is not None else []
        wake = min([*(at + hold_s for at, _ in held), *ends], default=None)
        ready = session.wait_for([each.fileno() for each in books], wake)
        if ready:
            time.sleep(_SETTLE_S)
            now = time.monotonic()
            held += [(now, entry) for each in books for entry in each.delta()]
            for text in [text for each in books for text in each.news()]:
                session.fail(text)
        is_up = until is not None and time.monotonic() >= until
        due = [entry.time for at, entry in held if is_up or time.monotonic() - at >= hold_s]
        if due:
            # What is older goes before it, whenever it came.
            last = max(due)
            yield sorted((e for _, e in held if e.time <= last), key=attrgetter("time"))
            held = [each for each in held if each[1].time > last]
        if is_up:
            return


def follow(
    session: Session,
    tree: Tree,
    selection: Selection,
    last: int | None,
    until: float | None,
    *,
    is_over: bool,
) -> Generator[LogEntry | None, None, None]:
    """Yield None when ready, then records one by one of the host of a tree; see `pieces`."""
    near, far = selection, list[FarLogs]()
    if is_far(tree):
        near, far = None, [FarLogs(tree, selection)]  # type: ignore[assignment]
    with closing(pieces(session, near, last, until, is_over=is_over, far=far)) as read:
        present = next(read)
        yield None
        yield from present
        for piece in read:
            yield from piece


def is_far(tree: Tree) -> bool:
    """Return whether the manager of a tree runs on another host."""
    from rtkit.rtc.names import LOCAL

    return tree.place != LOCAL


def about(tree: Tree, path: Path) -> About:
    """Return what a path names at a manager.

    Raises:
        NotFound: Nothing is there.
        Unreachable: The manager cannot be asked.
    """
    from rtkit.tree.place import root_for
    from rtkit.tree.resolve import entry
    from rtkit.tree.view import NodeKind

    root, hostname = root_for(lambda: tree, path, is_deep=False)
    node = entry(root, path, hostname)
    manager = tree.manager
    if node.instance:
        return About(manager, True, (node.instance,))
    if node.is_slave:
        return About(f"{manager}.{node.process}")
    if node.kind is NodeKind.MANAGER:
        return About(manager, True)
    if node.kind is NodeKind.DIRECTORY:
        named = sorted({each.instance for each in node.walk() if each.instance})
        return About(manager, True, tuple(named))
    return About()


def about_name(path: Path) -> About:
    """Return what the last name of a path means, where no manager can be asked."""
    from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX

    if len(path.elements) < 2:
        return About()
    *_, above, name = path.elements
    if not name.endswith(MANAGER_SUFFIX):
        return About(instances=(name.removesuffix(COMPONENT_SUFFIX),))
    own = name.removesuffix(MANAGER_SUFFIX)
    if above.endswith(MANAGER_SUFFIX):
        return About(f"{above.removesuffix(MANAGER_SUFFIX)}.{own}")
    return About(own, True)
