"""Starts or stops a manager of its own host; run there over SSH, by the provisioned rtkit.

Its arguments are ``start|stop|keep|look NAME``; it writes what it found as JSON behind a mark.
"""

from __future__ import annotations

import json
import os
import re
import select
import sys
import time
from contextlib import closing, suppress

from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.hosts.far_program import MARK
from rtkit.link import places
from rtkit.link.folder_watch import FolderWatch
from rtkit.tree import managers
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect
from rtkit.version import __version__

_START_S = 20.0
_AGAIN_S = 0.2
_ENDING = ("stop", "keep")


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

            try:
                launch.start(name, CommandLineSettings(), _START_S)
            except Refused:
                if places.owner(name) is None:  # else another command has just started it
                    raise
                is_running = True
        elif word in _ENDING and is_running:
            managers.stop(name, _START_S, is_kept=word == "keep")
        build = os.path.basename(os.path.realpath(sys.prefix))
        found = {"was_running": is_running, "here": __version__, "build": build}
        if word not in _ENDING and places.owner(name) is not None:
            with _connected(name) as tree:
                its_build = _build_of(tree.get("manager.pid"))
                found |= {"version": tree.get("rtkit.version"), "its_build": its_build}
                found["host"] = tree.host
    except RtkitError as error:
        print(MARK + json.dumps({"error": str(error)}))
        return 1
    print(MARK + json.dumps(found))
    return 0


def _connected(name: str) -> Tree:
    """Connect to a manager, which another command may just be starting.

    Raises:
        Unreachable: It does not answer in time.
    """
    deadline = time.monotonic() + _START_S
    with closing(FolderWatch(places.runtime_dir())) as watch:
        while True:
            try:
                return connect(name, _START_S)
            except Unreachable:
                if places.owner(name) is None or time.monotonic() > deadline:
                    raise
            select.select([watch], [], [], _AGAIN_S)
            watch.take()


def _build_of(pid: str) -> str:
    """Return the folder of the version that a process runs with, by what it has mapped."""
    with suppress(OSError), open(f"/proc/{pid}/maps", errors="replace", encoding="utf-8") as file:
        found = re.search(r"/rtkit/versions/([^/]+)/", file.read())
        return found[1] if found else ""
    return ""


if __name__ == "__main__":
    sys.exit(main())
