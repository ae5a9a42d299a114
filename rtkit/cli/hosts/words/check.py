"""``rthost check``: can hosts be reached, and does rtkit run there?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag
from rtkit.errors import Refused, RtkitError

if TYPE_CHECKING:
    from rtkit.hosts.far_side import HostLook
    from rtkit.hosts.host import Host


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
    """Look at hosts over SSH, all of the inventory by default.

    Nothing is changed there. What keeps rtkit from being made there is told, all of it, and the
    status is 1 then. The clock is compared with the one here, as exactly as half the time that a
    question takes allows.
    """
    from rtkit.hosts import inventory

    known = inventory.read()
    hosts = [inventory.host(name) for name in names] if names else [*known.values()]
    failed: list[RtkitError] = []
    for host, found in _looks(hosts, app.timeout_s):
        if isinstance(found, RtkitError):
            failed.append(found)
            app.fail(str(found))
            continue
        obstacles = found.far.obstacles()
        if is_json:
            terminal.write([json_records.line("host-check", _record(host, found, obstacles))])
        else:
            terminal.write([f"{host.name}:", *_lines(host, found)])
        for each in obstacles:
            failed.append(Refused(each))
            app.fail(f"{host.name}: {each}")
    return app.status(failed[0]) if failed else 0


def _looks(hosts: list[Host], timeout_s: float) -> list[tuple[Host, HostLook | RtkitError]]:
    """Look at all at once."""
    from concurrent.futures import ThreadPoolExecutor

    from rtkit.hosts.connection import connect
    from rtkit.hosts.far_side import look

    def one(host: Host) -> HostLook | RtkitError:
        try:
            with connect(host, timeout_s) as connection:
                return look(connection)
        except RtkitError as error:
            return error

    with ThreadPoolExecutor(max_workers=max(1, len(hosts))) as pool:
        return [*zip(hosts, pool.map(one, hosts), strict=True)]


def _lines(host: Host, found: HostLook) -> list[str]:
    far = found.far
    rows = [
        ("Address", str(host)),
        ("Host name", far.hostname),
        ("Python", ".".join(map(str, far.python))),
        ("Machine", f"{far.machine}, {' '.join(far.libc)}, {far.processors} processors"),
        ("Memory free", f"{far.memory_bytes >> 20} MiB"),
        ("Disk free", f"{far.free_bytes >> 20} MiB in {far.home}"),
        ("rtkit", far.current or "not there yet (rtmgr start --host makes it)"),
        ("Round trip", f"{found.round_trip_s * 1e3:.1f} ms"),
        ("Clock", f"{found.offset_s:+.3f} s (± {found.round_trip_s / 2:.3f} s)"),
    ]
    return [*terminal.pairs(rows, "  ")]


def _record(host: Host, found: HostLook, obstacles: list[str]) -> dict[str, object]:
    far = found.far
    return {
        "name": host.name,
        "address": str(host),
        "hostname": far.hostname,
        "python": ".".join(map(str, far.python)),
        "machine": far.machine,
        "libc": " ".join(far.libc),
        "processors": far.processors,
        "memory_bytes": far.memory_bytes,
        "free_bytes": far.free_bytes,
        "rtkit": far.current,
        "round_trip_s": found.round_trip_s,
        "clock_offset_s": found.offset_s,
        "obstacles": obstacles,
    }
