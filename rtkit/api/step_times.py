"""Records how long steps took on this installation, in a small file beside the logs.

Two commands that end together may each miss what the other measured; that does no harm.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rtkit.errors import Malformed, RtkitError

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.planning.measured_times import Times
    from rtkit.deployment.system import WantedSystem

_NAME = "step-times.json"
_MOST = 1 << 20


def path() -> str:
    """Return where they are kept."""
    from rtkit.link.places import state_dir

    return os.path.join(state_dir(), _NAME)


def read(session: Session) -> Times:
    """Return the measured durations; a damaged file is reported and ignored."""
    from rtkit.deployment.planning.measured_times import Times, times_from_text

    try:
        with open(path(), "rb") as stream:
            data = stream.read(_MOST + 1)
        if len(data) > _MOST:
            raise Malformed(f"larger than {_MOST} bytes")
        return times_from_text(data.decode())
    except FileNotFoundError:
        return Times()
    except (OSError, UnicodeDecodeError, Malformed) as error:
        why = error.strerror if isinstance(error, OSError) else error
        session.fail(f"{path()} is damaged and not used; steps cost what the table says ({why})")
        return Times()


def note(session: Session, taken: Sequence[tuple[Action, float]], types: Mapping[str, str]) -> None:
    """Add the durations of actions [s]; a file that cannot be written is reported, not raised."""
    if not taken:
        return
    from rtkit.deployment.planning.measured_times import times_to_text
    from rtkit.link.atomic import write_output
    from rtkit.link.places import make_private, state_dir

    times = read(session).noting(taken, types)
    try:
        make_private(state_dir())
        write_output(times_to_text(times).encode(), path(), is_lasting=False)
    except RtkitError as error:
        session.fail(f"what steps took is not kept: {error}")


@contextmanager
def noting(
    session: Session, system: WantedSystem, snapshot: Snapshot
) -> Iterator[list[tuple[Action, float]]]:
    """Yield a list for durations of actions [s], and record it however the body ends."""
    taken: list[tuple[Action, float]] = []
    try:
        yield taken
    finally:
        note(session, taken, types_of(system, snapshot))


def types_of(system: WantedSystem, snapshot: Snapshot) -> dict[str, str]:
    """Return the type names of components, by their names."""
    from rtkit.deployment.described import type_of

    found = {facts.instance: facts.type.type_name for facts in snapshot.components}
    found.update((each.instance, type_of(each.id).type_name) for each in system.components)
    return found
