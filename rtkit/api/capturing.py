"""Captures the live system as a profile."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.api import looking
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.profile.rts_model import RtsProfile


def capture(
    session: Session, servers: Sequence[str], about: Sequence[str], *, takes_all: bool
) -> RtsProfile:
    """Return the profile of what lives; see `rtkit.Tree.save`. Gaps are reported as failures.

    Raises:
        Malformed: A text `about` the system that XML cannot hold.
        NotFound: There is no such server.
    """
    from datetime import datetime

    from rtkit.deployment import capture as capturing

    for text in about:
        _check_text(text)
    from rtkit.api.gathering import gather_named, names_linked

    if session.finds_managers and names_linked(servers):
        servers = gather_named(session, servers)
    snapshot = looking.snapshot(session)
    date = datetime.now().replace(microsecond=0).isoformat()
    heading = capturing.SystemHeading(date, *about)
    hosts = [_host(server, snapshot) for server in servers]
    _report_gaps(session, snapshot)
    return capturing.capture(snapshot, heading, takes_all=takes_all, hosts=hosts)


def _host(server: str, snapshot: Snapshot) -> str:
    from rtkit.rtc.names import LOCAL, is_local_host
    from rtkit.tree.resolve import no_such_host

    host = server.strip("/")
    if is_local_host(host, snapshot.host):
        return LOCAL
    if not any(n.partition("/")[0] == host for c in snapshot.components for n in c.names):
        raise no_such_host(server, host)
    return host


def _report_gaps(session: Session, snapshot: Snapshot) -> None:
    """Report parts that could not be saved, or only as they were last reported."""
    from rtkit.rtc.far_ends import peer_of
    from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX

    for component in snapshot.components:
        if component.zombie:
            session.fail(f"not saved, zombie ({component.zombie}): {component.instance}")
        elif component.trouble:
            session.fail(f"saved as last reported ({component.trouble}): {component.instance}")
    for connector in snapshot.connectors:
        peer = peer_of(connector)
        if peer:
            host, _, manager = peer.rpartition("/")
            path = f"/{host or LOCAL}/{manager}{MANAGER_SUFFIX}"
            session.fail(f"not saved, its other end is below {path}: {connector.connector_id}")


def _check_text(text: str) -> str:
    """Return `text` if XML can hold it.

    Raises:
        Malformed: It has control characters.
    """
    if any(ord(c) < 32 for c in text):
        raise Malformed(f"control characters cannot be saved: {text!r}")
    return text
