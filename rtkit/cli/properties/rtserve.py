"""``rtserve``: an ordinary Python object as a property service."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, command

if TYPE_CHECKING:
    from rtkit.property.access import AccessPolicy

_MOST_KEPT = 100_000
_LOCAL = frozenset({"", "localhost", "127.0.0.1"})


def _port(context: click.Context, parameter: click.Parameter, value: str | None) -> int | None:
    if value is None:
        return None
    name, _, port = value.rpartition(":")
    if not (port.isascii() and port.isdigit() and int(port) <= 65535):
        raise click.BadParameter(f"not [HOST:]PORT: {value}")
    if name not in _LOCAL:
        raise click.BadParameter(f"this host only, not {name}: nothing would be encrypted")
    return int(port)


def _kept(
    context: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> dict[str, int]:
    kept: dict[str, int] = {}
    for value in values:
        pattern, _, most = value.rpartition("=")
        if not (pattern and most.isascii() and most.isdigit() and 0 < int(most) <= _MOST_KEPT):
            raise click.BadParameter(f"not GLOB=N, N from 1 to {_MOST_KEPT}: {value}")
        kept[pattern] = int(most)
    return kept


def _policy(files: tuple[str, ...], lines: tuple[str, ...]) -> AccessPolicy:
    from rtkit.property.access import read_policy

    policy = read_policy("\n".join(lines), "--rule")
    for name in files:
        with open(name, encoding="utf-8", errors="replace") as stream:
            policy += read_policy(stream.read(), name)
    return policy


@command("rtserve", is_local=True)
@click.option("-a", "--argument", "arguments", multiple=True, metavar="[KEY=]VALUE",
              help="What the class is called with (repeatable).")  # fmt: skip
@click.option("--hide", multiple=True, metavar="NAME", help="Do not show this (repeatable).")
@click.option("--history", multiple=True, metavar="GLOB=N", callback=_kept,
              help="Keep the last N values of these for .history (repeatable).")  # fmt: skip
@click.option("--port", metavar="[HOST:]PORT", callback=_port,
              help="Also open a TCP endpoint on this host, 0 for any free port.")  # fmt: skip
@click.option("--serial", metavar="DEVICE",
              help="Also open this serial line (DEVICE?baud=115200&check=auto).")  # fmt: skip
@click.option("--allow-set", "settable", multiple=True, metavar="GLOB",
              help="Names that may be set over the serial line (repeatable).")  # fmt: skip
@click.option("--notify", multiple=True, metavar="GLOB",
              help="SERVICE/NAME of yours that events may be SET to (repeatable).")  # fmt: skip
@click.option("--http", metavar="[HOST:]PORT", callback=_port,
              help="Also open an HTTP endpoint on this host, 0 for any free port.")  # fmt: skip
@click.option("--ice", metavar="[HOST:]PORT", callback=_port,
              help="Also open an Ice endpoint on this host, 0 for any free port.")  # fmt: skip
@click.option("--rules", "files", multiple=True, metavar="FILE",
              help="A rule: which client may do what over which wire; or a limit.")  # fmt: skip
@click.option("--rule", "lines", multiple=True, metavar="RULE",
              help="A line of such a file: 'deny http * SET *' (repeatable).")  # fmt: skip
@click.argument("thing", metavar="MODULE:CLASS")
@click.argument("name")
def main(
    app: App,
    arguments: tuple[str, ...],
    hide: tuple[str, ...],
    history: dict[str, int],
    port: int | None,
    serial: str | None,
    settable: tuple[str, ...],
    notify: tuple[str, ...],
    http: int | None,
    ice: int | None,
    files: tuple[str, ...],
    lines: tuple[str, ...],
    thing: str,
    name: str,
) -> None:
    """Serve a Python object as live properties.

    Its attributes, properties, getters and setters become properties that rtget, rtset and
    rtlisten know, its other public methods actions. MODULE is a name or a file; CLASS, which is
    called, may also be a function or an object. Once it serves, the command prints where.

    Behind a serial line all may be got and listened to, and set what --allow-set names. A device
    that is not there is waited for. Lines carry a check where the far side makes them.
    """
    import signal
    import threading

    from rtkit.cli.properties.served_object import made
    from rtkit.cli.shared.signals import heard_by_main
    from rtkit.wires.serial.address import SCHEME
    from rtkit.wires.serve import serve

    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    if settable and serial is None:
        raise click.UsageError("--allow-set goes with --serial")
    policy = _policy(files, lines)
    thing_made = made(thing, arguments)
    with heard_by_main(), serve(
        thing_made, name, port=port, serial=serial, settable=settable, http=http, ice=ice,
        hide=hide, history=history, rules=policy, notify=notify,
    ) as served:  # fmt: skip
        endpoints = [f"/localhost/{served.name}"]
        endpoints += [] if served.port is None else [f"localhost:{served.port}"]
        endpoints += [] if serial is None else [f"{SCHEME}{serial.removeprefix(SCHEME)}"]
        endpoints += (
            [] if served.http is None else [f"http://localhost:{served.http}/ps/{served.name}"]
        )
        endpoints += [] if served.ice is None else [f"ice://localhost:{served.ice}/{served.name}"]
        terminal.write(["  ".join(endpoints)])
        import sys

        sys.stdout.flush()
        ended.wait()
