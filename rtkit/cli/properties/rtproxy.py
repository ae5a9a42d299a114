"""``rtproxy``: live properties behind another door, on another wire."""

from __future__ import annotations

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, working_directory
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import argument, insecure_flag, option, several


@command(
    "rtproxy",
    is_local=True,
    examples=(
        ("rtproxy robots/arm tcp:4711", "Read-only, for clients that know the user's secret."),
        ("rtproxy robots/arm unix:arm.sock --allow-set 'angle*'", "Some of it may be set."),
        (
            "rtproxy tcp:localhost:4711/robots/arm far/arm --prefix left",
            "From a TCP endpoint back into the tree, all names below left.",
        ),
        ("rtproxy /localhost/Motor0.rtc tcp:4712 --allow-set state", "A component."),
        (
            "rtproxy robots/arm mqtt:robot@localhost/lab",
            "At an MQTT broker, in the style of Homie.",
        ),
    ),
    arguments=("live", "live"),
)
def main(
    app: App,
    prefix: str = option("--prefix NAME", "Put this in front of all names.", default=""),
    allow_set: tuple[str, ...] = several(
        "--allow-set GLOB", "Names that may be set, actions that may be started (repeatable)."
    ),
    is_insecure: bool = insecure_flag(),
    source: str = argument("FROM"),
    target: str = argument("TO"),
) -> None:
    """Open another endpoint, on another wire, to live properties.

    FROM is a service or component: a path of the tree, or an address such as
    http://HOST:PORT/ps/SERVICE or serial:DEVICE. TO is what is opened: a name for the tree, or an
    address such as http:PORT, serial:DEVICE or mqtt:USER@HOST/TOPIC; rtkit help wires lists the
    forms of both. Once it is open, the command prints where.

    Values, errors and events pass as they are; nothing can be set unless --allow-set says so. While
    FROM is away requests are answered no-service and listeners hear that their values are stale;
    they hear on when it is back.
    """
    import sys

    from rtkit.cli.shared.signals import ended_by_sigterm
    from rtkit.proxy.bridge import bridge
    from rtkit.serving.refusals import Refusals

    def report(why: str) -> None:
        print(f"rtproxy: {source}: {f'gone: {why}' if why else 'back'}", file=sys.stderr)

    with (
        ended_by_sigterm() as ended,
        bridge(
            source,
            target,
            prefix=prefix,
            allow_set=allow_set,
            cwd=working_directory(),
            timeout_s=app.timeout_s,
            on_status=report,
            on_refusal=Refusals(),
            is_insecure=is_insecure,
        ) as opened,
    ):
        terminal.write_now([opened.address])
        ended.wait()
