"""Types commands at managers of its own, all of whose processes must be gone at the end."""

from __future__ import annotations

import os
import re
import select
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from forked import Commands

from rtkit.cli.shared.commands import TABLE
from rtkit.errors import RtkitError
from rtkit.link.zenoh import ZenohLink, open_client, unix_endpoint
from rtkit.tree.client import Tree

ROOT = Path(__file__).parents[2]
RUN_ID = "RTKIT_TEST_RUN"
_STOP_S = 30.0
SHARED_MEMORY = Path("/dev/shm")
_INTERPRETED = re.compile("PYTHON|LD_|LC_|LANG|TZ$|RTKIT_FAULT")
"""Variables that count when an interpreter begins, or rtkit is imported."""
_SETTINGS = (
    "COLUMNS",
    "FORCE_COLOR",
    "NO_COLOR",
    "RTCSH_CWD",
    "RTKIT_CWD",
    "RTKIT_EXIT_DETAIL",
    "RTKIT_MANAGER",
    "RTKIT_MODULE_PATH",
    "RTKIT_REALM",
    "RTKIT_SERVERS",
    "RTCTREE_NAMESERVERS",
    "RTC_MANAGER_CONFIG",
)


def _interpreted(environment: Mapping[str, str]) -> dict[str, str]:
    return {key: text for key, text in environment.items() if _INTERPRETED.match(key)}


class Outcome(NamedTuple):
    """What a command line came to."""

    status: int
    out: str
    err: str


class Shell:
    """Types commands at a manager of its own.

    Attributes:
        folder: A short folder of this test alone; `modules` below it is a load path.
        run_id: The mark in the environment of all processes that it starts.
        prefix: What commands, and so the manager, are run by, ``nsenter …``.
        commands: Runs commands as forks, where a test needs no interpreter of its own for each.
        environment: What commands, and so the manager, are started with.
    """

    def __init__(self, folder: Path, run_id: str, commands: Commands | None = None) -> None:
        self.folder = folder
        self.run_id = run_id
        self.prefix: list[str] = []
        self.commands = commands
        self._opened: list[subprocess.Popen[str]] = []
        self.modules = folder / "modules"
        self.modules.mkdir()
        for name in ("run", "state"):
            (folder / name).mkdir(mode=0o700)
        kept = {key: value for key, value in os.environ.items() if key not in _SETTINGS}
        paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
        self.environment = {
            **kept,
            "PYTHONPATH": os.pathsep.join(path for path in paths if path),
            "RTKIT_RUNTIME_DIR": str(folder / "run"),
            "RTKIT_STATE_DIR": str(folder / "state"),
            "RTKIT_MODULE_PATH": str(self.modules),
            "RTKIT_PORT": "none",
            "XDG_CONFIG_DIRS": str(folder / "system"),
            "XDG_CONFIG_HOME": str(folder / "user"),
            RUN_ID: run_id,
        }
        self._usual = _interpreted(self.environment)

    def command(self, line: str, begin: str = "") -> list[str]:
        """Return what to execute for a command line; Python statements may come before it."""
        name, *arguments = shlex.split(line)
        module = TABLE[name][0] if name in TABLE else "rtkit.cli"
        script = f"import sys; sys.argv[0] = {name!r}; from {module} import main; sys.exit(main())"
        return [*self.prefix, sys.executable, "-c", begin + script, *arguments]

    @property
    def _begins_as_usual(self) -> bool:
        """Whether an interpreter would begin as the one did that commands are forks of."""
        return _interpreted(self.environment) == self._usual

    def run(self, line: str, text: str = "", timeout_s: float = 30.0) -> Outcome:
        """Run a command to its end."""
        if self.commands is not None and not self.prefix and self._begins_as_usual:
            place = {"environment": self.environment, "folder": str(self.folder)}
            told = self.commands.run(shlex.split(line), text, **place)
            return Outcome(told["status"], told["out"], told["err"])
        done = subprocess.run(
            self.command(line),
            input=text,
            capture_output=True,
            text=True,
            env=self.environment,
            cwd=self.folder,
            timeout=timeout_s,
            check=False,
        )
        return Outcome(done.returncode, done.stdout, done.stderr)

    def ok(self, line: str) -> str:
        """Run a command that must succeed in silence and return what it printed."""
        outcome = self.run(line)
        assert (outcome.status, outcome.err) == (0, ""), f"{line}: {outcome.err}{self.log()}"
        return outcome.out

    def open(self, line: str, begin: str = "") -> subprocess.Popen[str]:
        """Start a command; Python statements may come before it."""
        process = subprocess.Popen(
            self.command(line, begin),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=self.environment,
            cwd=self.folder,
        )
        self._opened.append(process)
        return process

    def close(self) -> None:
        """Let go of what was opened: a test that fails does not come to its own end of it."""
        for process in self._opened:
            process.wait(_STOP_S)
            for pipe in (process.stdout, process.stderr):
                if pipe is not None:
                    pipe.close()
        self._opened.clear()

    def end_of(self, process: subprocess.Popen[str], timeout_s: float = 30.0) -> Outcome:
        """Wait for a command that was started, and return what it came to."""
        try:
            out, err = process.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise
        return Outcome(process.returncode, out, err)

    def log(self) -> str:
        """Return what managers and slaves logged and printed."""
        files = sorted((self.folder / "state").glob("*.[lo][ou][gt]"))
        return "".join(f"\n{file.name}:\n{file.read_text()}" for file in files)


@contextmanager
def opened_shell(commands: Commands | None = None) -> Iterator[Shell]:
    """Open a shell without a manager; whatever it starts must be gone at the end.

    With `commands`, what `run` and `ok` run are forks; what is opened is a process of its own.
    """
    run_id = uuid.uuid4().hex
    before = set(SHARED_MEMORY.iterdir())
    # A socket's path may have 107 bytes: the folders that pytest makes are too long.
    folder = Path(tempfile.mkdtemp(prefix="rtk"))
    shell = Shell(folder, run_id, commands)
    try:
        yield shell
        for socket in (folder / "run").glob("*.sock"):
            if not _stopped(socket):
                shell.run(f"rtmgr stop {socket.stem}")
        left = wait_for_end(processes_of(run_id), 5.0)
        found = {
            "processes": [_describe(pid) for pid in left],
            "files": sorted(path.name for path in (folder / "run").iterdir()),
            "shared memory": _orphans(set(SHARED_MEMORY.iterdir()) - before),
        }
        assert not any(found.values()), f"left behind: {found}{shell.log()}"
    finally:
        for pid in processes_of(run_id):
            os.kill(pid, 9)
        shell.close()
        shutil.rmtree(folder)


def tree_at(socket: Path, timeout_s: float) -> Tree:
    """Connect to the manager at a socket."""
    link = ZenohLink(open_client(unix_endpoint(str(socket)), timeout_s))
    return Tree(link, os.uname().nodename, socket.stem, timeout_s)


def _stopped(socket: Path) -> bool:
    """Stop a manager as `rtmgr stop` does, without the cost of a command; False if it is gone."""
    try:
        with tree_at(socket, _STOP_S) as tree:
            pid = int(tree.get("manager.pid"))
            pidfd = os.pidfd_open(pid)
            try:
                tree.set("stop", "")
                return bool(select.select([pidfd], [], [], _STOP_S)[0])
            finally:
                os.close(pidfd)
    except (RtkitError, ProcessLookupError):
        return False


def processes_of(run_id: str) -> list[int]:
    """Return the processes of a shell: those that have its mark in their environment."""
    wanted = f"{RUN_ID}={run_id}".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            environment = (entry / "environ").read_bytes()
        except OSError:
            continue
        if wanted in environment.split(b"\0"):
            found.append(int(entry.name))
    return found


def wait_for_end(pids: list[int], timeout_s: float) -> list[int]:
    """Wait for processes to end and return those that did not."""
    deadline = time.monotonic() + timeout_s
    left = []
    for pid in pids:
        try:
            pidfd = os.pidfd_open(pid)
        except ProcessLookupError:
            continue
        try:
            if not select.select([pidfd], [], [], max(0.0, deadline - time.monotonic()))[0]:
                left.append(pid)
        finally:
            os.close(pidfd)
    return left


def _describe(pid: int) -> str:
    try:
        return f"{pid} {Path(f'/proc/{pid}/cmdline').read_bytes()!r}"
    except OSError:
        return str(pid)


def _orphans(files: set[Path]) -> list[str]:
    """Return those files of shared memory that no living process maps.

    Not those of zenoh: a session that carries port data leaves 12 kB, the next one sweeps them.
    Nor folders: a campaign that runs beside this test has some there.
    """
    files = {file for file in files if file.suffix != ".zenoh" and not file.is_dir()}
    if not files:
        return []
    mapped = set()
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                text = (entry / "maps").read_text(errors="replace")
            except OSError:
                continue
            mapped |= {str(file) for file in files if str(file) in text}
    return sorted(str(file) for file in files if str(file) not in mapped and file.exists())
