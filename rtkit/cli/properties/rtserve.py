"""``rtserve``: an ordinary Python object as a property service."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import argument, flag, insecure_flag, option, several, together
from rtkit.errors import Refused
from rtkit.wires.table import PORT, PUBLIC, WIRES

if TYPE_CHECKING:
    from rtkit.property.access import AccessPolicy

_MOST_KEPT = 100_000
_OPTIONS = [wire.option for wire in WIRES.values() if wire.option]


def _place(context: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
    _, _, port = (value or "0").rpartition(":")
    if not (port.isascii() and port.isdigit() and int(port) <= 65535):
        raise click.BadParameter(f"not {parameter.metavar}: {value}")
    return value


def _check_reach(endpoints: Mapping[str, str | None], *, is_insecure: bool) -> None:
    """Refuse what other hosts would reach and are not to."""
    from rtkit.keys import reach

    for scheme, wire in WIRES.items():
        value = endpoints.get(wire.option.name) if wire.option else None
        if wire.option is None or value is None or wire.option.metavar not in (PORT, PUBLIC):
            continue
        try:
            reach.check(scheme, value.rpartition(":")[0], is_insecure=is_insecure)
        except Refused as error:
            raise click.BadParameter(str(error), param_hint=f"'--{wire.option.name}'") from None


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

    policy = read_policy("\n".join(lines), "--rule", WIRES)
    for name in files:
        with open(name, encoding="utf-8", errors="replace") as stream:
            policy += read_policy(stream.read(), name, WIRES)
    return policy


_ENDPOINTS = {
    each.name.replace("-", "_"): option(
        f"--{each.name} {each.metavar}",
        each.help,
        callback=_place if each.metavar in (PORT, PUBLIC) else None,
    )
    for each in _OPTIONS
}
"""The option of each wire that objects are served over."""


@command(
    "rtserve",
    is_local=True,
    examples=(
        ("rtserve simple_pid:PID pid -a 1 -a 0.1", "A class, called with two arguments."),
        ("rtserve ./arm.py:Arm robots/arm --port 0", "Of a file, with a TCP endpoint too."),
        (
            "rtserve ./arm.py:Arm arm --serial /dev/ttyS0 --allow-set 'angle*'",
            "With a serial line, over which the angles may be set.",
        ),
        ("rtserve ./arm.py:Arm robots/arm --http 8080", "For curl and browsers too."),
        ("rtserve ./arm.py:Arm arm --tls 0.0.0.0:4711", "For other hosts, see rtkeys."),
        ("rtserve ./arm.py:Arm arm --host robot1", "For services of host robot1, too."),
        ("rtserve ./arm.py:Arm arm --history 'angle=100'", "Remember values for .history."),
        ("rtserve ./arm.py:Arm arm --rule 'deny zenoh * SET *'", "Read-only over zenoh."),
    ),
    arguments=("class", ""),
)
def main(
    app: App,
    arguments: tuple[str, ...] = several(
        "-a --argument [KEY=]VALUE", "What the class is called with (repeatable)."
    ),
    hide: tuple[str, ...] = several("--hide NAME", "Do not show this (repeatable)."),
    history: dict[str, int] = several(
        "--history GLOB=N",
        "Keep the last N values of these for .history (repeatable).",
        callback=_kept,
    ),
    endpoints: dict[str, str | None] = together(dict, _ENDPOINTS),
    is_insecure: bool = insecure_flag(),
    settable: tuple[str, ...] = several(
        "--allow-set GLOB", "Names that may be set over the serial line (repeatable)."
    ),
    notify: tuple[str, ...] = several(
        "--notify GLOB",
        "Listeners on any wire may have events SET to these properties: SERVICE/NAME of yours, "
        "or WIRE:ADDRESS/SERVICE/NAME (repeatable; default none).",
    ),
    hosts: tuple[str, ...] = several(
        "--host HOST",
        "Services of this other host may ask and set it, too, over the link that one of both has "
        "(repeatable; default none).",
    ),
    is_without_zenoh: bool = flag(
        "--no-zenoh", "Answer no zenoh queries, nor load it: other hosts do not find the service."
    ),
    files: tuple[str, ...] = several(
        "--rules FILE", "A rule: which client may do what over which wire; or a limit."
    ),
    lines: tuple[str, ...] = several(
        "--rule RULE", "A line of such a file: 'deny http * SET *' (repeatable)."
    ),
    thing: str = argument("MODULE:CLASS"),
    name: str = argument(None),
) -> None:
    """Serve a Python object as live properties.

    Its attributes, properties, getters and setters become properties that rtget, rtset and
    rtlisten know, its other public methods actions. MODULE is a name or a file; CLASS, which is
    called, may also be a function or an object. Once it serves, the command prints where.

    Behind a serial line all may be got and listened to, and set what --allow-set names. A device
    that is not there is waited for. Lines carry a check where the far side makes them.
    """
    from rtkit.cli.properties.served_object import made
    from rtkit.cli.shared.signals import ended_by_sigterm
    from rtkit.wires.line.wire import TCP_CLIENTS
    from rtkit.wires.serve import serve

    unknowing = [each.name for each in _OPTIONS if not each.knows_clients]
    if settable and all(endpoints[each] is None for each in unknowing):
        raise click.UsageError(f"--allow-set goes with --{' or --'.join(unknowing)}")
    if hosts and is_without_zenoh:
        raise click.UsageError("--host asks over zenoh: it does not go with --no-zenoh")
    _check_reach(endpoints, is_insecure=is_insecure)
    policy = _policy(files, lines)
    thing_made = made(thing, arguments)
    with ended_by_sigterm() as ended, serve(
        thing_made, name, settable=settable, hide=hide, history=history, rules=policy,
        notify=notify, hosts=hosts, is_on_zenoh=not is_without_zenoh, is_insecure=is_insecure,
        **endpoints,
    ) as served:  # fmt: skip
        # Addresses that --at takes without a scheme are printed without one.
        opened = [each.removeprefix(TCP_CLIENTS.prefix) for each in served.addresses.values()]
        terminal.write_now(["  ".join([f"/localhost/{served.name}", *opened])])
        ended.wait()
