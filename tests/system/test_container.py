"""A manager as the first process of a container: without root, nothing to write but two folders.

Namespaces of processes and mounts are what a container has of the kernel; the image itself is held
by tests/house/test_containerfile.py.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
from pathlib import Path
from typing import Any

import mountkit
import pytest
from faultkit import Order, Points
from waiting import until

MANAGER = "/localhost/manager.mgr"
USER = 4711
# As in an image: no right but to read what only root may read here, the interpreter of the tests.
AS_USER = (
    f"setpriv --reuid {USER} --regid {USER} --clear-groups"
    " --inh-caps=-all,+dac_read_search --ambient-caps=+dac_read_search"
).split()
FORKS = """
import os

from rtkit.component import Component


class Forks(Component):
    def on_activated(self, context):
        if os.fork() == 0:
            if os.fork() == 0:
                os.setsid()
            os._exit(0)
        os.wait()


def ForksInit(manager):
    manager.register_factory(Forks)
"""

pytestmark = pytest.mark.skipif(bool(mountkit.missing()), reason=mountkit.missing())


class Container:
    """A manager with process id 1, its root file system read-only."""

    def __init__(self, shell: Any) -> None:
        shell.prefix = []
        folder = str(shell.folder)
        subprocess.run(["chown", "-R", str(USER), folder], check=True)
        begin = f"mount --bind {folder} {folder} && mount -o remount,ro,bind / && exec "
        run = [*AS_USER, *shell.command("rtmgr run")]
        unshare = ["unshare", "--pid", "--mount", "--fork", "--kill-child", "--mount-proc"]
        with (shell.folder / "errors").open("w") as errors:
            self._outer = subprocess.Popen(
                [*unshare, "sh", "-c", begin + '"$@"', "sh", *run],
                env=shell.environment,
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stderr=errors,
            )
        children = Path(f"/proc/{self._outer.pid}/task/{self._outer.pid}/children")
        self.pid = int(until(children.read_text, "unshare forks"))
        self._pidfd = os.pidfd_open(self.pid)
        inside = f"nsenter --target={self.pid} --pid --mount --wd={folder} --".split()
        shell.prefix = [*inside, *AS_USER]

    def zombies(self) -> list[str]:
        """Return the children of process 1 that ended and were not reaped."""
        children = Path(f"/proc/{self.pid}/task/{self.pid}/children").read_text().split()
        states = [Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2] for pid in children]
        return [state for state in states if state.split()[0] == "Z"]

    def terminate(self) -> int:
        """Return the exit status after SIGTERM."""
        os.kill(self.pid, signal.SIGTERM)
        assert select.select([self._pidfd], [], [], 20)[0], "SIGTERM does not end it"
        os.close(self._pidfd)
        return self._outer.wait(20)

    def kill(self) -> None:
        self._outer.kill()
        self._outer.wait()


def test_a_manager_is_the_first_process_of_a_container(shell: Any) -> None:
    (shell.modules / "Forks.py").write_text(FORKS)
    container = Container(shell)
    try:
        until(lambda: shell.run("rtls /localhost/manager.mgr").status == 0, "it is healthy")
        refused = subprocess.run([*shell.prefix, "touch", "/new"], capture_output=True, check=False)
        assert refused.returncode, "its root file system can be written"
        shell.ok(f"rtmgr -c Forks -c ConsoleOut?manager_name=s {MANAGER}")
        shell.ok("rtact /localhost/Forks0.rtc /localhost/ConsoleOut0.rtc")
        until(lambda: not container.zombies(), "what is left to process 1 is reaped")
        shell.ok("rtmgr restart")
        held = shell.ok("rtls -l /localhost")
        assert "Active" in held
        assert container.terminate() == 0
        assert not [*(shell.folder / "run").iterdir()]
        container = Container(shell)
        until(lambda: shell.run("rtls /localhost/manager.mgr").status == 0, "it is healthy")
        until(lambda: shell.ok("rtls -l /localhost") == held, "what it held is there again")
        assert container.terminate() == 0
    finally:
        container.kill()
        shell.prefix = []


def test_a_container_that_still_begins_can_be_stopped(shell: Any) -> None:
    """The kernel gives process 1 no signal that it has no handler for."""
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    points.arm(Order("manager.locked", 1, "delay", "60"))
    container = Container(shell)
    try:
        assert points.has_struck(1)
        assert container.terminate() == 128 + signal.SIGTERM
    finally:
        container.kill()
        shell.prefix = []
