"""Brings managers of other hosts up, and links them to one of this host; takes them down again."""

from __future__ import annotations

import select
import time
from contextlib import closing
from typing import NamedTuple

from rtkit import fault
from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.fast_dataclass import Record
from rtkit.hosts import far_program, far_side, provisioned
from rtkit.hosts.connection import HostConnection, connect
from rtkit.hosts.host import Host
from rtkit.hosts.provisioned import Notify, Progress, Provisioned, unshown
from rtkit.link import host_links, places
from rtkit.link.folder_watch import FolderWatch
from rtkit.rtc.names import is_local_host
from rtkit.rtc.serde import decode_text, encode_text
from rtkit.tree.client import Tree

_FAR_S = 40.0
LEAST_S = 60.0
"""How long a host may take at least to be linked: what is made there takes its time [s]."""


class _Found(Record):
    """Answer of `rtkit.hosts.far_manager`: the manager there, and the version it would have."""

    was_running: bool = False
    here: str = ""
    version: str = ""
    host: str = ""
    error: str = ""


class BroughtUp(NamedTuple):
    """Outcome at a host: what was provisioned, and whether its manager ran already."""

    provisioned: Provisioned
    was_running: bool


def start(
    host: Host,
    near: Tree,
    notify: Notify,
    *,
    replaces: bool,
    timeout_s: float,
    show: Progress = unshown,
) -> BroughtUp:
    """Have the manager of a host run, of this version of rtkit, and linked to `near`.

    Each step finds what an earlier run has done: it can be run again wherever it was interrupted.
    It may run in several threads, for a host each.

    Raises:
        RtkitError: A step failed; names host and step. What was done before stays.
    """
    if is_local_host(host.name, near.host):
        raise Refused(f"{host.name} is the name of this host")
    with connect(host, timeout_s) as connection:
        look = far_side.look(connection)
        fault.point("provision.looked")
        done = provisioned.provision(connection, look, notify, show)
        fault.point("provision.used")
        found = _ask(connection, "start")
        fault.point("provision.started")
        if found.version != found.here or found.host != host.name:
            found = _replace(connection, found, replaces=replaces)
    link(host, near, timeout_s)
    return BroughtUp(done, found.was_running)


def stop(host: Host, near: Tree | None, timeout_s: float) -> bool:
    """Stop the manager of a host, and end the link to it; return whether it ran."""
    with connect(host, timeout_s) as connection:
        found = _ask(connection, "stop")
    if near is not None and host.name in near.get("get_hosts").splitlines():
        near.set("unlink_host", host.name)
    return found.was_running


def link(host: Host, near: Tree, timeout_s: float) -> None:
    """Have a manager of this host linked to that of another one; return when it is.

    Raises:
        Unreachable: It was not in time; tells why. The manager goes on trying.
    """
    with closing(FolderWatch(places.runtime_dir())) as watch:
        near.set("link_host", encode_text(host))
        deadline = time.monotonic() + timeout_s
        while (why := _why(host.name)) and (left_s := deadline - time.monotonic()) > 0:
            select.select([watch], [], [], left_s)
            watch.take()
    if why:
        raise Unreachable(f"host {host.name} is not linked within {timeout_s:g} s: {why}")


def _why(name: str) -> str:
    """Return why a link is not up; its file is made by the manager as soon as it is asked."""
    try:
        return host_links.read(name).why
    except Unreachable as error:
        return str(error)


def _replace(connection: HostConnection, found: _Found, *, replaces: bool) -> _Found:
    """Restart a manager of another version, or of another name of its host.

    Raises:
        Refused: That is not wanted.
    """
    host = connection.host
    other = f"rtkit {found.version}, as host {found.host}"
    if not replaces:
        raise Refused(
            f"{host.name}: manager {host.manager} runs there with {other}; here is"
            f" {found.here}: --replace has it end, with its components, and starts this one"
        )
    _ask(connection, "stop")
    return _ask(connection, "start")


def _ask(connection: HostConnection, word: str) -> _Found:
    host = connection.host
    command = [*provisioned.python(connection), "-m", "rtkit.hosts.far_manager", word, host.manager]
    try:
        found = decode_text(_Found, far_program.ask(connection, command, timeout_s=_FAR_S))
    except (Malformed, Refused) as error:
        raise type(error)(f"{host.name}: {word}: {error}") from None
    if found.error:
        raise Refused(f"{host.name}: {found.error}")
    return found
