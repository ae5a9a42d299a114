"""``rthost check``: can hosts be reached, and does rtkit run there?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag
from rtkit.cli.shared.progress import metered_each
from rtkit.errors import Refused, RtkitError

if TYPE_CHECKING:
    from rtkit.hosts.far_side import FarSide
    from rtkit.hosts.host import Host
    from rtkit.tree.clock import ClockOffset

    Found = tuple[FarSide | str, ClockOffset]
    """Findings of a shell there; over TLS only the version of its manager."""

_TITLE = "Looking at hosts"


@command(
    "check",
    examples=(
        ("rthost check robot1", "Its Python, room, clock and version of rtkit."),
        ("rthost check --json", "All hosts, for another program."),
    ),
    json=("host-check",),
    arguments=("known-host",),
)
def main(
    app: App, is_json: bool = json_flag(), names: tuple[str, ...] = arguments("[NAME]...")
) -> int:
    """Look at hosts over SSH or TLS, all of the inventory by default.

    Nothing is changed there. All obstacles to making rtkit there are told, and the status is 1
    then. The clock is compared with the one here by several questions, as exactly as half the time
    of the shortest allows. All are asked at once: silent hosts cost one time-out.
    """
    from rtkit.hosts import inventory, ssh_config

    known = inventory.read()
    names = names or tuple(known)
    hosts = [inventory.host(name) for name in dict.fromkeys(names)]
    app.warn(ssh_config.remarks(hosts))
    failed: list[RtkitError] = []
    for host, found in _looks(app, hosts):
        if isinstance(found, RtkitError):
            failed.append(found)
            app.fail(str(found))
            continue
        obstacles = [] if isinstance(found[0], str) else found[0].obstacles()
        if is_json:
            terminal.write([json_records.line("host-check", _record(host, *found, obstacles))])
        else:
            terminal.write([f"{host.name}:", *_lines(host, *found)])
        for each in obstacles:
            failed.append(Refused(each))
            app.fail(f"{host.name}: {each}")
    return app.status(failed[0]) if failed else 0


def _looks(app: App, hosts: list[Host]) -> Iterator[tuple[Host, Found | RtkitError]]:
    """Look at all at once; yield each as soon as it and those before it have been looked at."""
    from contextlib import nullcontext

    from rtkit.hosts.at_once import at_once
    from rtkit.hosts.clock import compare
    from rtkit.hosts.connection import connect
    from rtkit.hosts.far_side import look
    from rtkit.tree.clock import compare as clock_of
    from rtkit.tree.connect import connect as tree_at

    def one(host: Host) -> Found:
        if host.is_tls:
            with tree_at(host.tls_address, app.timeout_s) as tree:
                host.check_manager(tree.host, tree.manager)
                return tree.get("rtkit.version"), clock_of(tree)
        with connect(host, app.timeout_s) as connection:
            return look(connection), compare(connection)

    done: dict[str, Found | RtkitError] = {}
    pending = [*hosts]
    with metered_each(app, [_TITLE], is_writing=True) as meter:
        for host, found in at_once(hosts, one, meter.hidden if meter else nullcontext):
            done[host.name] = found
            if meter:
                meter.show(_TITLE, len(done), len(hosts), f"{len(done)}/{len(hosts)}")
            while pending and pending[0].name in done:
                first = pending.pop(0)
                yield first, done[first.name]


def _lines(host: Host, far: FarSide | str, clock: ClockOffset) -> list[str]:
    rows = [
        ("Address", str(host)),
        *([("rtkit", far)] if isinstance(far, str) else _rows(far)),
        *_link(host.name),
        ("Round trip", f"{clock.round_trip_s * 1e3:.1f} ms"),
        ("Clock", f"{round(clock.offset_s, 4) + 0.0:+.4f} s (± {clock.bound_s:.4f} s)"),
    ]
    return [*terminal.pairs(rows, "  ")]


def _rows(far: FarSide) -> list[tuple[str, str]]:
    return [
        ("Host name", far.hostname),
        ("Python", ".".join(map(str, far.python))),
        ("Machine", f"{far.machine}, {' '.join(far.libc)}, {far.processors} processors"),
        ("Memory free", f"{far.memory_bytes >> 20} MiB"),
        ("Disk free", f"{far.free_bytes >> 20} MiB in {far.home}"),
        ("rtkit", far.current or "not there yet (rtmgr start --host makes it)"),
        *(
            [("Damaged", f"{far.damage} (rtmgr start --host makes rtkit anew)")]
            if far.damage
            else ()
        ),
    ]


def _link(name: str) -> Iterator[tuple[str, str]]:
    """Yield a row about the link of this host to another one, if there is one."""
    from rtkit.link import host_links

    if host_links.is_linked(name):
        yield "Link", host_links.read(name).why or "linked"


def _record(
    host: Host, far: FarSide | str, clock: ClockOffset, obstacles: list[str]
) -> dict[str, object]:
    found = {"rtkit": far} if isinstance(far, str) else _of_shell(far)
    return {
        "name": host.name,
        "address": str(host),
        **found,
        "round_trip_s": clock.round_trip_s,
        "clock_offset_s": clock.offset_s,
        "clock_bound_s": clock.bound_s,
        "obstacles": obstacles,
    }


def _of_shell(far: FarSide) -> dict[str, object]:
    return {
        "hostname": far.hostname,
        "python": ".".join(map(str, far.python)),
        "machine": far.machine,
        "libc": " ".join(far.libc),
        "processors": far.processors,
        "memory_bytes": far.memory_bytes,
        "free_bytes": far.free_bytes,
        "rtkit": far.current,
        "damaged": [*far.damaged.get(far.current, ())],
    }
