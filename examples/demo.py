"""Shows rtkit in half a minute: bring a robot up, watch it, break it, repair it, take it down.

Runs the installed commands as a user would, in folders of its own, and checks what they show;
the exit status is 0 only when everything was as it must be and nothing is left. ``make demo``.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent
SYSTEM = "sensor-controller-motor.xml"
COMPONENTS = ("Controller0.rtc", "Motor0.rtc", "Sensor0.rtc")
PATIENCE_S = 10.0


class NotAsExpected(Exception):
    """The demo did not go as it must."""


class Shell:
    """Runs commands, showing each as it would be typed, and what it answers."""

    def __init__(self, folder: Path, variables: Mapping[str, str]) -> None:
        self.folder = folder
        self.environment = {**os.environ, **variables}

    def run(self, line: str, *, is_shown: bool = True) -> str:
        """Run one command line and return what it wrote on stdout."""
        if is_shown:
            print(f"$ {line}", flush=True)
        # Both streams into one, as on a terminal; the demo only reads what it shows.
        done = subprocess.run(
            shlex.split(line),
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=60,
        )
        if is_shown and done.stdout:
            print(done.stdout, end="", flush=True)
        check(done.returncode == 0, f"{line} ended with status {done.returncode}: {done.stdout}")
        return done.stdout


def check(is_as_expected: bool, otherwise: str) -> None:
    """Go on only if things are as they must be."""
    if not is_as_expected:
        raise NotAsExpected(otherwise)


def tell(text: str) -> None:
    """Say what comes next."""
    print(f"\n# {text}", flush=True)


def until(is_done: Callable[[], bool], what: str) -> None:
    """Wait for something that happens elsewhere."""
    deadline = time.monotonic() + PATIENCE_S
    while not is_done():
        check(time.monotonic() < deadline, f"{what} did not happen within {PATIENCE_S:g} s")
        time.sleep(0.05)


def main() -> int:
    """Play the demo; return its exit status."""
    folder = Path(tempfile.mkdtemp(prefix="rtd"))
    variables = {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}",
        "RTKIT_RUNTIME_DIR": str(folder / "run"),
        "RTKIT_STATE_DIR": str(folder / "state"),
        "RTKIT_MANAGER": "manager",
        "RTKIT_CWD": "/",
        "RTKIT_EXIT_DETAIL": "",
    }
    profile = HERE.parent / "profiles" / "systems" / SYSTEM
    (folder / SYSTEM).symlink_to(profile)
    (folder / "PoseLog.py").symlink_to(HERE / "demo" / "PoseLog.py")
    begin = time.monotonic()
    shell = Shell(folder, variables)
    try:
        play(shell, folder)
        check(not list((folder / "run").iterdir()), "something is left in the runtime folder")
        check(not left_over(folder), "processes are left")
    except NotAsExpected as surprise:
        print(f"\ndemo: not as expected: {surprise}", file=sys.stderr)
        print(f"demo: the logs are in {folder / 'state'}", file=sys.stderr)
        return 1
    finally:
        for pid in left_over(folder):
            os.kill(pid, signal.SIGKILL)
    shutil.rmtree(folder)
    tell(f"No process, no socket is left. That took {time.monotonic() - begin:.1f} s.")
    return 0


def play(shell: Shell, folder: Path) -> None:
    """Play all scenes."""
    log = folder / "state" / "manager.log"
    bring_up(shell)
    watch(shell, log)
    destroy(shell)
    repair(shell, log)
    take_down(shell)


def bring_up(shell: Shell) -> None:
    """Start a manager and a system of three processes."""
    tell("A manager is the one daemon of a host. Start it.")
    shell.run("rtmgr start")
    tell("Bring up a robot from its profile: three components, a process each, connected.")
    shell.run(f"rtresurrect {SYSTEM}")
    expect(shell.run("rtls -l /localhost"), dict.fromkeys(COMPONENTS, "Inactive"))
    tell("Activate them. The motor drives towards a wall 5 m away and must stop 1 m before it.")
    shell.run(f"rtstart {SYSTEM}")
    expect(shell.run("rtls -l /localhost"), dict.fromkeys(COMPONENTS, "Active"))


def watch(shell: Shell, log: Path) -> None:
    """Connect a component that logs where the robot is."""
    tell("Do values flow? Load one more component that logs poses, and connect it.")
    shell.run("rtmgr /localhost/manager.mgr -l ./PoseLog.py:PoseLogInit -c PoseLog")
    shell.run("rtcon /localhost/Motor0.rtc:pose /localhost/PoseLog0.rtc:pose")
    shell.run("rtact /localhost/PoseLog0.rtc")
    until(lambda: len(places(log)) >= 4, "a flow of poses")
    show(places(log)[:4])
    tell("Faster: change the controller's configuration while it runs.")
    shell.run("rtconf /localhost/Controller0.rtc set max_speed 1.0")
    seen = len(places(log))
    until(lambda: len(places(log)) >= seen + 4, "more poses")
    show(places(log)[seen : seen + 4])


def destroy(shell: Shell) -> None:
    """Kill one slave."""
    tell("Now break it: kill the process of the controller, as a crash would.")
    about = shell.run("rtcat /localhost/manager.mgr/controller.mgr", is_shown=False)
    found = re.search(r"Process ID: (\d+)", about)
    check(found is not None, f"no process id in: {about}")
    pid = found.group(1) if found else ""
    shell.run(f"kill -9 {pid}")
    until(
        lambda: "*Controller0.rtc" in shell.run("rtls /localhost", is_shown=False),
        "the mark of the zombie",
    )
    tell("Its entry is a zombie (*) that tells why. The others run on; the motor stops by itself.")
    shown = shell.run("rtls -l /localhost")
    expect(shown, {"Motor0.rtc": "Active", "Sensor0.rtc": "Active", "*Controller0.rtc": "-"})
    check("signal 9" in shown, f"the reason is not told: {shown}")


def repair(shell: Shell, log: Path) -> None:
    """Bring up what is missing, and only that."""
    before = processes(shell)
    tell("Repair: the same command again makes exactly what is missing.")
    shell.run(f"rtresurrect {SYSTEM}")
    after = processes(shell)
    for slave in ("motor", "sensor"):
        check(before[slave] == after[slave], f"{slave} was not left alone: {before} {after}")
    expect(
        shell.run("rtls -l /localhost"),
        {"Controller0.rtc": "Inactive", "Motor0.rtc": "Active", "Sensor0.rtc": "Active"},
    )
    shell.run(f"rtstart {SYSTEM}")
    shell.run(f"rtcheck {SYSTEM}")
    tell("The robot drives on, and stops where it must: 4.00 m.")
    until(lambda: places(log)[-1].endswith("x = 4.00 m"), "the arrival")
    show(places(log)[-1:])


def take_down(shell: Shell) -> None:
    """Leave nothing."""
    tell("Take it down.")
    shell.run(f"rtteardown --exit {SYSTEM}")
    shell.run("rtls -l /localhost")
    shell.run("rtmgr stop")


def expect(shown: str, states: Mapping[str, str]) -> None:
    """Compare a long listing with the states that entries must have."""
    cells = [line.split() for line in shown.splitlines()]
    found = {line[5]: line[0] for line in cells if len(line) > 5}
    for name, state in states.items():
        check(found.get(name) == state, f"{name} is not {state}: {found}")


def processes(shell: Shell) -> dict[str, str]:
    """Return the process id of each slave that lives."""
    slaves = {}
    for line in shell.run("rtls -1 /localhost/manager.mgr", is_shown=False).split():
        name = line.rstrip("/")
        if name.endswith(".mgr") and not name.startswith("*"):
            about = shell.run(f"rtcat /localhost/manager.mgr/{name}", is_shown=False)
            found = re.search(r"Process ID: (\d+)", about)
            slaves[name.removesuffix(".mgr")] = found.group(1) if found else ""
    return slaves


def places(log: Path) -> list[str]:
    """Return what the log says of the robot's place."""
    records = [json.loads(line) for line in log.read_text().split("\n")[:-1]]
    return [
        f"{record['time']} {record['component']}: {record['message']}"
        for record in records
        if record["message"].startswith("x = ")
    ]


def show(lines: list[str]) -> None:
    """Show lines of the log."""
    for line in lines:
        print(f"  log: {line}", flush=True)


def left_over(folder: Path) -> list[int]:
    """Return the processes, other than this one, that use the demo's runtime folder."""
    mark = f"RTKIT_RUNTIME_DIR={folder}/".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit() or int(entry.name) == os.getpid():
            continue
        try:
            environment = (entry / "environ").read_bytes()
        except OSError:
            continue  # it ended meanwhile, or is another user's
        if mark in environment:
            found.append(int(entry.name))
    return found


if __name__ == "__main__":
    sys.exit(main())
