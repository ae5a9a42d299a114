"""Starts and stops managers of other hosts, several at once: ``rtmgr start --host robot1``."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.hosts.at_all import at_all, status
from rtkit.cli.shared.app import App
from rtkit.errors import Malformed, Unreachable, UsageProblem
from rtkit.fast_dataclass import replace
from rtkit.rtc.manager_address import is_address
from rtkit.rtc.names import check_instance_name, manager_on

if TYPE_CHECKING:
    from rtkit.hosts.bring_up import BroughtUp
    from rtkit.hosts.host import Host
    from rtkit.hosts.progress import Progress
    from rtkit.tree.client import Tree


def run_at_hosts(
    app: App,
    word: str,
    names: Sequence[str],
    manager: str,
    *,
    replaces: bool = False,
    is_kept: bool = False,
) -> int:
    """Start or stop the manager of each host; return the exit status.

    All are tried, at the same time, see `at_all`.
    """
    from rtkit.hosts import ssh_config

    if word not in ("start", "stop"):
        raise UsageProblem(f"--host is for rtmgr start and stop, not {word}")
    hosts = _hosts(word, [*dict.fromkeys(names)], manager)
    app.warn(ssh_config.remarks(hosts))
    near = _near(app) if word == "start" else _near_if_running(app)
    try:
        work = _work(app, word, near, replaces=replaces, is_kept=is_kept)
        return status(app, at_all(app, hosts, work, str))
    finally:
        if near is not None:
            near.close()


def _hosts(word: str, names: Sequence[str], manager: str) -> list[Host]:
    """Return the hosts of these names, each with the manager that is meant.

    Raises:
        NotFound: A host is not known.
        Malformed: A manager cannot have that name.
        UsageProblem: The name of the manager is that of a host.
    """
    from rtkit.hosts import inventory

    hosts = [inventory.host(name) for name in names]
    if manager in inventory.read():
        line = " ".join(f"--host {each}" for each in (*names, manager))
        raise UsageProblem(f"{manager} is a host: rtmgr {word} {line} (--host before each)")
    if not manager:
        return hosts
    if is_address(manager):
        raise Malformed(f"an address is no name of a manager: {manager}")
    check_instance_name(manager)
    return [replace(host, manager=manager) for host in hosts]


def _work(
    app: App, word: str, near: Tree | None, *, replaces: bool, is_kept: bool
) -> Callable[[Host, Progress], str]:
    """Return what is done for a host, and returns what was done."""
    from rtkit.hosts import bring_up

    def stop(host: Host, show: Progress) -> str:
        from rtkit.api.move_records import forget_moved_to

        try:
            was_running = bring_up.stop(host, near, app.timeout_s, is_kept=is_kept)
        finally:
            if not is_kept:
                forget_moved_to(manager_on(host.manager, host.name))
        return f"{host.manager} {'ended' if was_running else 'did not run'}"

    def start(host: Host, show: Progress) -> str:
        assert near is not None
        done = bring_up.start(host, near, show, replaces=replaces, timeout_s=app.timeout_s)
        return _summary(host, done)

    return stop if word == "stop" else start


def _summary(host: Host, done: BroughtUp) -> str:
    made = done.provisioned
    how = "replaced" if done.replaced_build else "ran already" if done.was_running else "started"
    parts = [f"linked, {host.manager} {how}"]
    if done.replaced_build:
        parts.append(f"that of rtkit {done.replaced_build} has ended, with its components")
    if done.unlinked:
        parts.append(f"the link to {done.unlinked} there has ended")
    if done.old_build:
        parts.append(f"it runs with rtkit {done.old_build} until --replace has it end")
    if made is not None and made.is_new:
        how = f"was damaged there ({made.damage}) and is made anew" if made.damage else ""
        size = f"{made.sent_bytes / 1e6:.1f} MB sent"
        if host.index:
            size += f", {made.fetched_bytes / 1e6:.1f} MB fetched from {host.index}"
        parts.append(f"rtkit {made.id} {how or 'is new there'}, {size}")
        if made.unfetched:
            parts.append(f"not fetched there: {made.unfetched}")
    return "; ".join(parts)


def _near(app: App) -> Tree:
    """Return the manager of this host that has the links; it is started if it does not run."""
    from rtkit.api.gathering import start_manager
    from rtkit.link import places
    from rtkit.tree.connect import connect

    name = os.environ.get("RTKIT_MANAGER") or places.DEFAULT_MANAGER
    if places.owner(name) is None:
        start_manager(name, app.timeout_s, app.fail)
        app.verbose(f"manager {name} of this host is started")
    return connect(name, app.timeout_s)


def _near_if_running(app: App) -> Tree | None:
    from rtkit.tree.connect import connect

    try:
        return connect("", app.timeout_s)
    except Unreachable:
        return None
