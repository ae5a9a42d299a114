"""Checks the managers of this user, and their reports on slaves and components."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from threading import Thread
from typing import TYPE_CHECKING, TypeVar

from rtkit.cli.managers.doctor import ERROR, NOTE, OK, WARNING, Diagnosis
from rtkit.deployment.health import IN_DEBUGGER
from rtkit.errors import RtkitError
from rtkit.link import places
from rtkit.link.processes import state_of
from rtkit.rtc.manager_address import DEFAULT_PORT

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.listing import Listing

T = TypeVar("T")
_STOPPED = ("T", "t")


def managers(timeout_s: float, environment: Mapping[str, str]) -> Iterator[Diagnosis]:
    """Look at each manager that runs; all are asked at once, each for so long at most [s]."""
    from rtkit.link.running import managers as running

    names = running()
    yield from _asked_for(environment, names)
    if not names:
        yield Diagnosis("managers", NOTE, "no manager runs", "rtmgr start")
        yield from _port(environment.get("RTKIT_PORT", "") or str(DEFAULT_PORT))
    found = _at_once(_look, names, timeout_s)
    for name in names:
        yield from found.get(name) or [_silent(name, timeout_s)]


def _at_once(
    look: Callable[[str, float], T], names: Sequence[str], timeout_s: float
) -> dict[str, T]:
    """Look at several at once, for twice the time-out at most; who is late is left out."""
    found: dict[str, T] = {}

    def keep(name: str) -> None:
        found[name] = look(name, timeout_s)

    threads = [Thread(target=keep, args=(name,), daemon=True) for name in names]
    until = time.monotonic() + 2 * timeout_s
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(max(0.0, until - time.monotonic()))
    return dict(found)


def _port(asked: str) -> Iterator[Diagnosis]:
    """Tell whether a manager that is started now would get its TCP port; nothing listens for it."""
    import socket

    if not (asked.isascii() and asked.isdigit()):
        return
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", int(asked)))
        except (OSError, OverflowError) as error:
            text = f"TCP port {asked} cannot be had: {error}; a manager would have no door"
            cure = "rtmgr start -p PORT takes another one, -a none"
            yield Diagnosis("doors", WARNING, text, cure, asked)
        else:
            yield Diagnosis("doors", OK, f"TCP port {asked} is free", "", asked)


def _asked_for(environment: Mapping[str, str], names: Sequence[str]) -> Iterator[Diagnosis]:
    """Judge which manager commands would ask."""
    chosen = environment.get("RTKIT_MANAGER", "")
    if chosen and ":" not in chosen and chosen not in names:
        text = f"RTKIT_MANAGER names a manager that does not run: {chosen}"
        cure = f"rtmgr start {places.quoted(chosen)}, or unset RTKIT_MANAGER"
        yield Diagnosis("managers", ERROR, text, cure, chosen)
    elif not chosen and names and places.DEFAULT_MANAGER not in names:
        text = f"the usual manager does not run, but {', '.join(names)}"
        cure = f"rtmgr start, or export RTKIT_MANAGER={places.quoted(names[0])}"
        yield Diagnosis("managers", WARNING, text, cure)


def _look(name: str, timeout_s: float) -> list[Diagnosis]:
    pid = places.owner(name) or 0
    if state_of(pid) in _STOPPED:
        text = f"manager {name!r} (pid {pid}) is stopped"
        return [Diagnosis("managers", ERROR, text, f"kill -CONT {pid}", name)]
    from rtkit.tree.connect import connect

    try:
        with connect(name, timeout_s) as tree:
            listing, facts = tree.listing(), tree.snapshot()
            address, started = tree.get("rtkit.address"), float(tree.get("manager.started"))
    except (RtkitError, ImportError) as error:
        return [_silent(name, timeout_s, str(error))]
    return [
        *judge(name, listing, facts),
        *contexts(facts),
        *old_code(facts),
        *absences(facts),
        *endpoint(name, address, facts.properties, os.environ.get("RTKIT_PORT", "")),
        *_clock(name, started),
    ]


def _silent(name: str, timeout_s: float, why: str = "") -> Diagnosis:
    pid = places.owner(name)
    text = why or f"manager {name!r} (pid {pid}) does not answer within {timeout_s:g} s"
    quoted = places.quoted(name)
    cure = (
        f"rtdoctor --timeout 10 waits longer; if it hangs: kill -9 {pid}, then rtmgr start"
        f" {quoted}, which takes over the slaves that live on"
    )
    return Diagnosis("managers", ERROR, text, cure if pid else f"rtmgr start {quoted}", name)


def judge(name: str, listing: Listing, facts: Snapshot) -> Iterator[Diagnosis]:
    """Judge a manager's report on itself, its slaves and its components."""
    from rtkit import __version__

    if facts.version != __version__:
        text = f"manager {name!r} runs rtkit {facts.version}, the commands are of {__version__}"
        cure = f"rtmgr restart {places.quoted(name)} (it ends all components)"
        yield Diagnosis("versions", ERROR, text, cure, name)
    trouble = [*_processes(name, listing, facts), *_components(listing)]
    components, slaves = len(listing.rows), len(listing.slaves)
    text = f"manager {name!r} answers: {components} components, {slaves} slaves"
    yield Diagnosis("managers", OK, text, "", name)
    yield from trouble


_CURES = {
    "RLIMIT_RTPRIO": "USER - rtprio 99 in /etc/security/limits.d/rtkit.conf, or LimitRTPRIO=99 in"
    " the unit of a service; then log in anew and rtmgr restart",
    "RLIMIT_MEMLOCK": "USER - memlock unlimited in /etc/security/limits.d/rtkit.conf, or"
    " LimitMEMLOCK=infinity in the unit of a service; then log in anew and rtmgr restart",
}
"""Cures of settings of contexts that the system refuses, by a word of the refusal."""


def contexts(facts: Snapshot) -> Iterator[Diagnosis]:
    """Name the contexts that run without a setting that the system refused."""
    for component in facts.components:
        path = f"/{component.names[0]}" if component.names else component.instance
        for context in component.contexts:
            if context.trouble and context.owner == component.instance:
                text = f"context {context.id} of {path} runs without {context.trouble}"
                cure = "; ".join(text for word, text in _CURES.items() if word in context.trouble)
                yield Diagnosis("components", WARNING, text, cure, path)


def old_code(facts: Snapshot) -> Iterator[Diagnosis]:
    """Name the components that run other code than their files have now."""
    from rtkit.api.looking import present_code

    present = present_code(facts.components)
    by_hand = {process.name for process in facts.processes if process.is_guest}
    for component in facts.components:
        file = component.changed_code(present)
        if file:
            path = f"/{component.names[0]}" if component.names else component.instance
            cure = "rtapply --replace PROFILE makes it again with the present code"
            cure = "start it again" if component.process in by_hand else cure
            text = f"{path} runs code that has changed since it was loaded ({file})"
            yield Diagnosis("components", WARNING, text, cure, path)


def absences(facts: Snapshot) -> Iterator[Diagnosis]:
    """Name what modules written for OpenRTM-aist use that rtkit does not have.

    Modules that are loaded are looked at, and the files of all components.
    """
    from rtkit.api.looking import present_code

    files = {each.file for each in facts.modules if each.file} | {*present_code(facts.components)}
    for file in sorted(files):
        try:
            yield from _absences_in(file)
        except OSError as error:
            text = f"module {file} cannot be read any more: {error.strerror}"
            cure = "what is loaded goes on; rtmgr -u forgets the module"
            yield Diagnosis("modules", WARNING, text, cure, file)
        except RtkitError as error:  # it was edited since: what it says of Python 2 has the cure
            yield Diagnosis("modules", WARNING, str(error), "", file)


def _absences_in(file: str) -> Iterator[Diagnosis]:
    from rtkit.openrtm.migrate.source import MARK

    with open(file, "rb") as stream:
        source = stream.read()
    if MARK not in source:
        return
    from rtkit.openrtm.loading.absences import absences_in  # native ones have none

    for line, name in absences_in(source, file):
        text = f"{file}:{line} uses {name} of OpenRTM-aist, which rtkit does not have"
        cure = "what calls it fails; the others work"
        yield Diagnosis("modules", WARNING, text, cure, file)


def _processes(name: str, listing: Listing, facts: Snapshot) -> Iterator[Diagnosis]:
    pids = {each.name: each.pid for each in facts.processes}
    if listing.trouble:
        yield Diagnosis("managers", ERROR, f"manager {name!r}: {listing.trouble}", "", name)
    for slave, state, reason in listing.slaves:
        pid = pids.get(slave, 0)
        if state == "stopped":
            text = f"slave {slave} (pid {pid}) is stopped"
            yield Diagnosis("slaves", ERROR, text, f"kill -CONT {pid}", slave)
        elif state == "lost":
            text = f"slave {slave} has ended: {reason or 'nobody knows why'}"
            cure = "rtdel -z takes its entries away, rtresurrect makes them again"
            yield Diagnosis("slaves", ERROR, text, cure, slave)
        elif reason:
            text = f"slave {slave} (pid {pid}): {reason}"
            cure = f"rtexit --force /localhost/{name}.mgr/{slave}.mgr"
            yield Diagnosis("slaves", WARNING, text, cure, slave)


def _components(listing: Listing) -> Iterator[Diagnosis]:
    for row in listing.rows:
        path = f"/{row.names[0]}" if row.names else row.instance
        if row.zombie:
            text = f"{path} is a zombie: {row.zombie}"
            cure = f"rtdel -z {path}, or rtresurrect makes it again"
            yield Diagnosis("components", ERROR, text, cure, path)
        elif row.trouble:
            is_debugged = row.trouble.startswith(IN_DEBUGGER)
            cure = "" if is_debugged else f"rtexit --force {path} if it does not come back"
            level = NOTE if is_debugged else WARNING
            yield Diagnosis("components", level, f"{path}: {row.trouble}", cure, path)
        elif row.state == "Error":
            text = f"{path} is in Error" + (f": {row.cause}" if row.cause else "")
            yield Diagnosis("components", WARNING, text, f"rtreset {path}", path)


def endpoint(
    name: str, address: str, properties: Mapping[str, str], asked: str = ""
) -> Iterator[Diagnosis]:
    """Judge the TCP endpoint of a manager; `asked` is the value of RTKIT_PORT here."""
    if address:
        yield Diagnosis("doors", OK, f"manager {name!r} listens at {address}", "", name)
    elif properties.get("manager.net_servant", "YES").upper() == "NO" or asked == "none":
        yield Diagnosis("doors", OK, f"manager {name!r} has no TCP door, as was asked", "", name)
    else:
        text = f"manager {name!r} has no TCP door: its port was taken when it started"
        cure = "free the port and rtmgr restart, or rtmgr start -p PORT, or -a for none"
        yield Diagnosis("doors", WARNING, text, cure, name)


def _clock(name: str, started: float) -> Iterator[Diagnosis]:
    if started > time.time() + 1:
        text = f"the clock went back since manager {name!r} started: stamps will be wrong"
        yield Diagnosis("clock", ERROR, text, "timedatectl set-ntp true", name)


def links() -> Iterator[Diagnosis]:
    """Tell which of the hosts that are linked cannot be reached, and why."""
    from rtkit.link import host_links

    for host in host_links.hosts():
        why = host_links.read(host).why
        text = f"host {host} cannot be reached: {why}" if why else f"host {host} is linked"
        command = "rtmgr start --host" if host_links.is_cured_by_start(why) else "rthost check"
        cure = f"{command} {host}" if why else ""
        yield Diagnosis("hosts", ERROR if why else OK, text, cure, host)


def servers(environment: Mapping[str, str], timeout_s: float) -> Iterator[Diagnosis]:
    """Check that the endpoints of RTKIT_SERVERS accept connections; all at once."""
    from rtkit.tree.place import servers as named
    from rtkit.tree.place import strange_servers

    for why in strange_servers() if environment else []:
        yield Diagnosis("doors", ERROR, why, "write HOST:PORT, with ; between several")
    addresses = named() if environment else []
    reasons = _at_once(_knock, addresses, timeout_s)
    for address in addresses:
        why = reasons.get(address, f"{address} does not answer within {timeout_s:g} s")
        if why:
            cure = "start a manager there, or take it out of RTKIT_SERVERS"
            yield Diagnosis("doors", ERROR, f"RTKIT_SERVERS: {why}", cure, address)
        else:
            yield Diagnosis("doors", OK, f"{address} answers", "", address)


def _knock(address: str, timeout_s: float) -> str:
    """Return why an address does not answer; empty if it does."""
    from rtkit.tree.connect import connect

    try:
        with connect(address, timeout_s) as tree:
            tree.listing()
    except (RtkitError, ImportError) as error:
        return str(error)
    return ""
