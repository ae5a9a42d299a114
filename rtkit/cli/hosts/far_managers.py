"""Starts and stops managers of other hosts, several at once: ``rtmgr start --host robot1``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.errors import RtkitError, Unreachable, UsageProblem
from rtkit.fast_dataclass import replace

if TYPE_CHECKING:
    from rtkit.cli.shared.progress import Show
    from rtkit.hosts.host import Host
    from rtkit.hosts.provisioned import Progress
    from rtkit.tree.client import Tree


def run_at_hosts(app: App, word: str, names: Sequence[str], manager: str, *, replaces: bool) -> int:
    """Start or stop the manager of each host; return the exit status.

    All are tried, at the same time; those that failed are told, each with its step.
    """
    from rtkit.cli.shared.progress import metered
    from rtkit.hosts import inventory, ssh_config

    if word not in ("start", "stop"):
        raise UsageProblem(f"--host is for rtmgr start and stop, not {word}")
    hosts = [inventory.host(name) for name in dict.fromkeys(names)]
    if manager:
        hosts = [replace(host, manager=manager) for host in hosts]
    app.warn(ssh_config.remarks(hosts))
    near = _near(app) if word == "start" else _near_if_running(app)
    failures: list[RtkitError] = []

    def one(host: Host) -> None:
        try:
            _do(app, word, host, near, show, replaces=replaces)
        except RtkitError as error:
            failures.append(error)
            app.fail(str(error))

    try:
        with (
            metered(app, word, is_asking=True) as meter,
            ThreadPoolExecutor(max_workers=len(hosts)) as pool,
        ):
            show = _summed(meter)
            list(pool.map(one, hosts))
    finally:
        if near is not None:
            near.close()
    return app.status(failures[0]) if failures else 0


def _summed(meter: Show) -> Progress:
    """Return what shows the progress of several hosts as one."""
    counts: dict[str, tuple[int, int]] = {}

    def show(name: str, done: int, total: int, text: str) -> None:
        counts[name] = done, total
        dones, totals = zip(*list(counts.values()), strict=True)
        meter(sum(dones), sum(totals), f"{name} {text}")

    return show


def _do(
    app: App, word: str, host: Host, near: Tree | None, show: Progress, *, replaces: bool
) -> None:
    from rtkit.hosts import bring_up

    timeout_s = max(app.timeout_s, bring_up.LEAST_S)
    if word == "stop":
        was_running = bring_up.stop(host, near, app.timeout_s)
        app.verbose(f"{host.name}: {'ended' if was_running else 'did not run'}")
        return
    assert near is not None
    done = bring_up.start(
        host, near, app.verbose, replaces=replaces, timeout_s=timeout_s, show=show
    )
    app.verbose(f"{host.name}: linked, {'ran already' if done.was_running else 'started'}")


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
