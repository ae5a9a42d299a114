"""Starts or stops a manager of its own host; run there over SSH, by the provisioned rtkit.

Its arguments are ``start|stop|look NAME``; it writes what it found as JSON behind a mark.
"""

from __future__ import annotations

import json
import os
import re
import sys
from contextlib import suppress

from rtkit.errors import RtkitError
from rtkit.hosts.far_program import MARK
from rtkit.link import places
from rtkit.tree import managers
from rtkit.tree.connect import connect
from rtkit.version import __version__

_START_S = 20.0


def main() -> int:
    """Be the program."""
    word, name = sys.argv[1:3]
    places.keep_runtime_folder()
    # A manager keeps its version when the link to the one in use leads to another.
    sys.executable = os.path.join(os.path.realpath(sys.prefix), "bin", "python")
    try:
        is_running = places.owner(name) is not None
        if word == "start" and not is_running:
            from rtkit.manager import launch
            from rtkit.settings.configuration import CommandLineSettings

            launch.start(name, CommandLineSettings(), _START_S)
        elif word == "stop" and is_running:
            managers.stop(name, _START_S)
        build = os.path.basename(os.path.realpath(sys.prefix))
        found = {"was_running": is_running, "here": __version__, "build": build}
        if word != "stop" and places.owner(name) is not None:
            with connect(name, _START_S) as tree:
                its_build = _build_of(tree.get("manager.pid"))
                found |= {"version": tree.get("rtkit.version"), "its_build": its_build}
                found["host"] = tree.host
    except RtkitError as error:
        print(MARK + json.dumps({"error": str(error)}))
        return 1
    print(MARK + json.dumps(found))
    return 0


def _build_of(pid: str) -> str:
    """Return the folder of the version that a process runs with, by what it has mapped."""
    with suppress(OSError), open(f"/proc/{pid}/maps", errors="replace", encoding="utf-8") as file:
        found = re.search(r"/rtkit/versions/([^/]+)/", file.read())
        return found[1] if found else ""
    return ""


if __name__ == "__main__":
    sys.exit(main())
