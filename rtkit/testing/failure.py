"""Describes a failed test: its trials, the live things of its realm, its log."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rtkit.errors import RtkitError

_MOST = 100
"""How many records of logs are shown."""
_TIMEOUT_S = 2.0
Section = tuple[str, str]
"""Title and text."""


def troubles(values: Mapping[str, Any]) -> Iterator[Section]:
    """Yield the trials among the values of fixtures that are in Error, with the reasons."""
    from rtkit.testing.trial import Trial

    for name, value in values.items():
        if isinstance(value, Trial) and value.trouble:
            yield f"rtkit: {name}", value.trouble


def system() -> Iterator[Section]:
    """Yield what lives in the realm of this process, and the last records of its logs."""
    yield "rtkit: status", "\n".join(_status())
    yield "rtkit: log", "\n".join(_log())


def _status() -> Iterator[str]:
    from rtkit.link import running
    from rtkit.tree.connect import connect
    from rtkit.tree.view import build, once

    managers = running.managers()
    if not managers:
        yield "no manager runs any more"
    for name in managers:
        try:
            with connect(name, _TIMEOUT_S) as tree:
                listing = tree.listing()
        except RtkitError as error:
            yield f"manager {name}: {error}"
            continue
        yield f"manager {name}, pid {listing.pid}: {len(listing.rows)} components"
        for node in once(build(listing).walk()):
            if node.row is not None:
                yield f"  {node.path}  {node.row.state}  {node.remark}".rstrip()


def _log() -> Iterator[str]:
    from rtkit.link.places import state_dir
    from rtkit.logs.logbook import Logbook

    logbook = Logbook(state_dir(), lambda _entry: True)
    try:
        for entry in logbook.there(_MOST):
            who = entry.component or entry.process
            yield f"[{who} {entry.time}] {entry.level}: {entry.message}"
            if entry.exception:
                yield entry.exception.rstrip()
    finally:
        logbook.close()
