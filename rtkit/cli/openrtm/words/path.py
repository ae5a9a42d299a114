"""``rtopenrtm path``: tell the folder by which Python finds the names of OpenRTM."""

from __future__ import annotations

import os

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command


@command(
    "path",
    is_local=True,
    examples=(
        ("rtopenrtm path", "Tell what to put into PYTHONPATH."),
        ("rtopenrtm path -v", "The same, with a traceback if it fails."),
    ),
)
def main(app: App) -> int:
    """Print the folder by which Python finds OpenRTM_aist, RTC, omniORB and others.

    With it in PYTHONPATH, ``python FILE`` does what `rtopenrtm run FILE` does, but does not mend
    tabs. An installed OpenRTM-aist is hidden by it.
    """
    from rtkit import openrtm_scripts

    terminal.write([os.path.join(os.path.dirname(openrtm_scripts.__file__), "path")])
    return 0
