"""Brings managers of other hosts up, and links them to one of this host; takes them down again."""

from __future__ import annotations

import select
import time
from contextlib import closing
from typing import NamedTuple

from rtkit import fault
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.fast_dataclass import Record, replace
from rtkit.hosts import far_program, far_side, provisioned
from rtkit.hosts.connection import HostConnection, connect
from rtkit.hosts.host import Host
from rtkit.hosts.progress import HostStep, Progress
from rtkit.hosts.provisioned import Provisioned
from rtkit.link import host_links, places
from rtkit.link.folder_watch import FolderWatch
from rtkit.rtc.names import is_local_host
from rtkit.rtc.serde import decode_text, encode_text
from rtkit.tree import managers
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect as tree_at
from rtkit.version import __version__

_FAR_S = 40.0
LEAST_S = 60.0
"""How long a host may take at least to be linked: what is made there takes its time [s]."""


class _Found(Record):
    """Answer of `rtkit.hosts.far_manager`.

    Attributes:
        was_running: Whether the manager ran before.
        here: The version of rtkit that a manager there is started with.
        build: The same with the fingerprint of its wheels.
        version: The version of the manager that runs, empty if none does.
        its_build: The same with the fingerprint, empty if that is not known.
        host: The name by which the manager knows its host.
        error: Why nothing was done.
    """

    was_running: bool = False
    here: str = ""
    build: str = ""
    version: str = ""
    its_build: str = ""
    host: str = ""
    error: str = ""


class BroughtUp(NamedTuple):
    """Outcome at a host.

    Attributes:
        provisioned: The version of rtkit there; None where it is reached over TLS.
        was_running: Whether its manager ran already.
        old_build: The build of rtkit that this one runs with, if that is another one.
        replaced_build: The build of the one that was ended for it, if any was.
        unlinked: The manager there to which the link led before, if that is another one.
    """

    provisioned: Provisioned | None
    was_running: bool
    old_build: str
    replaced_build: str = ""
    unlinked: str = ""


def start(host: Host, near: Tree, show: Progress, *, replaces: bool, timeout_s: float) -> BroughtUp:
    """Have the manager of a host run, of this version of rtkit, and linked to `near`.

    Each step finds what an earlier run has done: it can be run again wherever it was interrupted.
    It may run in several threads, for a host each. The host may take `timeout_s` to answer [s].

    Raises:
        RtkitError: A step failed; names host and step. What was done before stays.
    """
    if is_local_host(host.name, near.host):
        raise Refused(f"{host.name} is the name of this host")
    _check_holder(host, near)
    if host.is_tls:
        return _join(host, near, show, timeout_s)
    show(host.name, HostStep("connecting"))
    with connect(host, timeout_s) as connection:
        show(host.name, HostStep("checking"))
        look = far_side.look(connection)
        fault.point("provision.looked")

        def check() -> None:
            if look.current and not replaces:
                _check_running(connection)

        done = provisioned.provision(connection, look, show, check)
        fault.point("provision.used")
        found, replaced_build = _run(connection, show, replaces=replaces)
    show(host.name, HostStep("linking"))
    unlinked = link(host, near, max(timeout_s, LEAST_S))
    show(host.name, HostStep("linked"))
    old_build = found.its_build if _is_old(found) else ""
    return BroughtUp(done, found.was_running, old_build, replaced_build, unlinked)


def _join(host: Host, near: Tree, show: Progress, timeout_s: float) -> BroughtUp:
    """Link a host that is reached over TLS: its manager runs already, as nobody can start it."""
    show(host.name, HostStep("linking"))
    unlinked = link(host, near, timeout_s)
    show(host.name, HostStep("linked"))
    return BroughtUp(None, was_running=True, old_build="", unlinked=unlinked)


def _run(connection: HostConnection, show: Progress, *, replaces: bool) -> tuple[_Found, str]:
    """Have the manager run; return it, and the build of one that was ended for it.

    Raises:
        RtkitError: It does not start, or is one that may not be replaced.
    """
    host = connection.host
    show(host.name, HostStep("starting its manager"))
    found = _ask(connection, "start")
    fault.point("provision.started")
    why = _misfit(host, found)
    if not (why or (replaces and _is_old(found))):
        return found, ""
    if not replaces:
        raise Refused(why)
    show(host.name, HostStep("replacing its manager"))
    _ask(connection, "stop")
    return _ask(connection, "start"), found.its_build or found.version


def stop(host: Host, near: Tree | None, timeout_s: float, *, is_kept: bool = False) -> bool:
    """End the link to a manager of another host, then that manager; return whether it ran.

    A link to another manager there stays. What the manager that is ended holds is there again at
    its next start only if it `is_kept`.

    Raises:
        RtkitError: The host cannot be reached, or its manager does not end; the link has ended.
    """
    is_linked = near is not None and host.name in near.get("get_hosts").splitlines()
    is_linked = is_linked and _linked_manager(host.name) in ("", host.manager)
    if near is not None and is_linked:
        near.set("unlink_host", host.name)
    try:
        if host.is_tls:
            with tree_at(host.tls_address, timeout_s) as tree:
                host.check_manager(tree.host, tree.manager)
            managers.stop_at(host.tls_address, timeout_s, is_kept=is_kept)
            return True
        with connect(host, timeout_s) as connection:
            return _stop(connection, "keep" if is_kept else "stop")
    except RtkitError as error:
        ended = "; the link to it has ended" if is_linked else ""
        raise type(error)(f"{error}{ended}; its manager may still run") from error


def _stop(connection: HostConnection, word: str) -> bool:
    try:
        return _ask(connection, word).was_running
    except Refused:
        if not far_side.look(connection).current:
            return False  # there is no rtkit yet, so no manager
        raise


def link(host: Host, near: Tree, timeout_s: float) -> str:
    """Have a manager of this host linked to that of another one; return when it is.

    The result is the manager there to which the link led before, if that is another one.
    The manager tries at once, also where it was refused before: only a try since then counts.

    Raises:
        Refused: Another manager here has a link to it. Or the manager is not let in, or not sure of
            the host, which it goes on trying; tells why.
        Unreachable: It was not in time; tells why. The manager goes on trying.
    """
    _check_holder(host, near)
    asked_at = time.monotonic()
    before = _linked_manager(host.name)
    with closing(FolderWatch(places.runtime_dir())) as watch:
        near.set("link_host", encode_text(host))
        deadline = time.monotonic() + timeout_s
        while (why := _why(host.name, asked_at)) and (left_s := deadline - time.monotonic()) > 0:
            select.select([watch], [], [], left_s)
            watch.take()
    if why:
        raise Unreachable(f"host {host.name} is not linked within {timeout_s:g} s: {why}")
    return before if before != host.manager else ""


def _check_holder(host: Host, near: Tree) -> None:
    """Refuse a second link to a host: it would have the same file and the same keys.

    Raises:
        Refused: Another manager here has it.
    """
    holder = host_links.holder(host.name)
    if holder not in ("", near.manager):
        gives_up = f"RTKIT_MANAGER={holder} rtmgr stop --host {host.name} ends both"
        raise Refused(f"{host.name}: manager {holder} of this host has the link to it ({gives_up})")


def _linked_manager(name: str) -> str:
    """Return the manager of another host to which its link leads; empty if that is not known."""
    try:
        return host_links.read(name).far_manager
    except Unreachable:
        return ""


def _why(name: str, asked_at: float) -> str:
    """Return why a link is not up; its file is made by the manager as soon as it is asked.

    Raises:
        Refused: It was refused since the manager was asked.
    """
    try:
        state = host_links.read(name)
    except Unreachable as error:
        return str(error)
    if state.refused_at >= asked_at:
        raise Refused(f"manager {state.manager} of this host cannot link {name}: {state.why}")
    return state.why


def _check_running(connection: HostConnection) -> None:
    """Refuse a manager of another version before this one is brought there.

    Raises:
        Refused: One runs there.
    """
    try:
        found = _ask(connection, "look")
    except RtkitError:
        return  # what is there does not run any more: it gets this version
    if found.version and (why := _misfit(connection.host, replace(found, here=__version__))):
        raise Refused(why)


def _misfit(host: Host, found: _Found) -> str:
    """Return why a manager is not to be linked, empty if it is of this version and this host."""
    if (found.version, found.host) == (found.here, host.name):
        return ""
    return (
        f"{host.name}: manager {host.manager} runs there with rtkit {found.version}, as host"
        f" {found.host}; here is {found.here}: --replace has it end, with its components, and"
        " starts this one"
    )


def _is_old(found: _Found) -> bool:
    """Return whether a manager runs with another build of this version."""
    return bool(found.its_build) and found.its_build != found.build


def _ask(connection: HostConnection, word: str) -> _Found:
    host = connection.host
    command = [*far_program.python(connection), "-m", "rtkit.hosts.far_manager", word, host.manager]
    try:
        found = decode_text(_Found, far_program.ask(connection, command, timeout_s=_FAR_S))
    except (Malformed, Refused) as error:
        raise type(error)(f"{host.name}: {word}: {error}") from None
    if found.error:
        raise Refused(f"{host.name}: {found.error}")
    return found
