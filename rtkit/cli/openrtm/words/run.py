"""``rtopenrtm run``: run a module as its author runs it, by ``python FILE``."""

from __future__ import annotations

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments
from rtkit.errors import Malformed


class _PassesOn(click.Command):
    """A command whose options end at its first argument: the rest is for the script."""

    allow_interspersed_args = False


@command(
    "run",
    is_local=True,
    cls=_PassesOn,
    examples=(
        ("rtopenrtm run ConsoleIn.py", "Run a component in this process, until Ctrl-C."),
        ("rtopenrtm run ConsoleIn.py -f rtc.conf", "With a configuration file."),
    ),
    arguments=("file",),
)
def main(app: App, words: tuple[str, ...] = arguments("FILE [ARGUMENT...]")) -> int:
    """Run a module of OpenRTM-aist as a script.

    Its components live in this process, and are in the tree of the manager of this host, which is
    started where none runs. Its Manager.init takes -f FILE (rtc.conf), -o KEY:VALUE, and heeds
    manager.components.precreate, preconnect and preactivation; other options of OpenRTM-aist have
    no effect. `rtopenrtm path` tells how python itself runs such files.
    """
    from rtkit.openrtm_scripts.script import run_script

    if not words:
        raise Malformed("No file specified.")
    run_script(words[0], words[1:])
    return 0
