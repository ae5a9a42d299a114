"""The manager as a process: one of its name, private, orderly to its end, bounded for everybody."""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from waiting import has_ended, until

from rtkit.deployment.actions import ChangeState, Connect, Create, Delete
from rtkit.errors import Unreachable
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree import managers
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

RUNS_PROCESSES = True
BOUND_S = 60.0
"""Bound on what comes soon; no test waits for it [s]."""

MODULE = '''
import os, subprocess, threading, time
from rtkit.component import Component, InPort, OutPort, TimedLong


class Thing(Component):
    """Notes its end; hangs where its option says."""

    rate = 200.0
    into = InPort(TimedLong)
    out = OutPort(TimedLong)
    last = number = 0

    def on_activated(self, context):
        if "child" in self.options:
            subprocess.Popen(["sleep", "1000"], start_new_session=True)

    def on_execute(self, context):
        if "source" in self.options:
            self.number += 1
            self.out.write(TimedLong(data=self.number))
        for value in self.into.read_all():
            if self.last not in (0, value.data - 1):
                raise ValueError(f"{value.data} came after {self.last}")
            self.last = value.data
            with open(os.environ["RTKIT_STATE_DIR"] + "/last", "w") as file:
                file.write(f"{self.last:9}")

    def on_finalize(self):
        with open(os.environ["RTKIT_STATE_DIR"] + "/ends", "a") as file:
            file.write(f"{self.instance}\\n")
        if "hang" in self.options:
            time.sleep(1000)


def ThingInit(manager):
    manager.register_factory(Thing)
'''


def thing(instance: str, slave: str = "", option: str = "") -> Create:
    place = f"&manager_name={slave}" if slave else ""
    return Create(f"Thing?instance_name={instance}{place}{f'&{option}=1' if option else ''}")


def activate(instance: str) -> ChangeState:
    return ChangeState(instance, "0", Transition.ACTIVATE)


def make(tree: Tree, *actions: Any) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


def pid_of(shell: Any, name: str = "") -> int:
    pid = json.loads(shell.ok(f"rtmgr status --json {name}"))["pid"]
    assert isinstance(pid, int)
    return pid


@pytest.fixture
def world(manager: Any, tree: Tree) -> Tree:
    """A manager that can make things."""
    (manager.modules / "Thing.py").write_text(MODULE)
    return tree


def ends(shell: Any) -> list[str]:
    """Return which components were finalised, in order."""
    file = shell.folder / "state" / "ends"
    return file.read_text().split() if file.exists() else []


# one of its name


@pytest.fixture
def own(shell: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A shell whose managers this process can talk to."""
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, shell.environment[key])
    return shell


def start_at_once(shell: Any, contenders: dict[str, int]) -> None:
    """Start managers of these names, each so many times, all at once; then stop them."""
    names = [name for name, count in contenders.items() for _ in range(count)]
    started = [(name, shell.open(f"rtmgr start {name}")) for name in names]
    outcomes = [(name, shell.end_of(process, BOUND_S)) for name, process in started]
    for name, count in contenders.items():
        assert (name, (0, "", "")) in outcomes, f"{outcomes}{shell.log()}"
        with connect(name) as tree:
            pid = tree.listing().pid
        refusal = (1, "", f"rtmgr: manager '{name}' is running already (pid {pid})\n")
        found = sorted(tuple(outcome) for each, outcome in outcomes if each == name)
        assert found == [(0, "", ""), *[refusal] * (count - 1)]
        managers.stop(name, BOUND_S)


def test_of_several_starts_at_once_exactly_one_of_each_name_serves(own: Any) -> None:
    start_at_once(own, {"a": 2, "b": 2, "c": 2, "d": 6})


@pytest.mark.campaign
@pytest.mark.timeout(600)
def test_two_starts_at_once_fifty_times(own: Any) -> None:
    for _ in range(50):
        start_at_once(own, {"a": 2})


def test_a_killed_manager_s_sockets_are_taken_over(shell: Any) -> None:
    shell.ok("rtmgr start")
    os.kill(pid_of(shell), signal.SIGKILL)
    until(lambda: shell.run("rtls").status, "its end")
    left = {path.name for path in (shell.folder / "run").iterdir()}
    assert {"manager.sock", "manager.ctl", "manager.lock"} <= left
    outcome = shell.run("rtls")
    where = f"{shell.folder}/run/manager.sock (start it with: rtmgr start)"
    told = f"rtls: manager 'manager' is not running: nobody is behind its socket {where}\n"
    assert outcome.err == told
    shell.ok("rtmgr start")
    shell.ok("rtls")


@pytest.mark.parametrize("command", ["start", "run"])
def test_what_a_script_holds_is_not_held_by_what_outlives_it(shell: Any, command: str) -> None:
    read, write = os.pipe()
    (shell.modules / "Thing.py").write_text(MODULE)
    script = subprocess.Popen(
        shell.command(f"rtmgr {command}"),
        env=shell.environment,
        cwd=shell.folder,
        pass_fds=(write,),
        stdout=subprocess.DEVNULL,
    )
    os.close(write)
    with open(read, "rb") as held, script:
        until(lambda: not shell.run("rtls").status, "the manager")
        shell.ok("rtmgr /localhost/manager.mgr -c 'Thing?instance_name=A&manager_name=s'")
        if command == "run":
            script.kill()
        assert select.select([held], [], [], BOUND_S)[0], "somebody holds it"
        assert held.read() == b""


def test_a_manager_leaves_the_sockets_of_others_whose_names_begin_alike(shell: Any) -> None:
    (shell.modules / "Thing.py").write_text(MODULE)
    shell.environment["RTKIT_MANAGER"] = "a.b"
    shell.ok("rtmgr start a.b")
    shell.ok("rtmgr /localhost/a.b.mgr -c 'Thing?instance_name=A&manager_name=s'")
    shell.ok("rtmgr /localhost/a.b.mgr -c 'Thing?instance_name=B&manager_name=t'")
    shell.ok("rtcon /localhost/A.rtc:out /localhost/B.rtc:into")
    before = {path.name for path in (shell.folder / "run").iterdir()}
    assert any(name.endswith(".data") for name in before)
    shell.ok("rtmgr start a")
    shell.ok("rtmgr stop a")
    assert {path.name for path in (shell.folder / "run").iterdir()} == before


@pytest.mark.parametrize("name", ["manager.sock", "manager.ctl"])
@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_what_is_no_socket_is_not_removed(shell: Any, name: str, kind: str) -> None:
    path = shell.folder / "run" / name
    if kind == "folder":
        path.mkdir()
    elif kind == "file":
        path.write_text("precious")
    else:
        path.symlink_to(shell.folder / "state")
    outcome = shell.run("rtmgr start")
    assert (outcome.status, outcome.err) == (
        1,
        f"rtmgr: not a socket, remove it yourself: {path}\n",
    )
    assert path.exists()
    (path.rmdir if kind == "folder" else path.unlink)()
    shell.ok("rtmgr start")


def test_a_lock_that_is_a_link_is_refused(shell: Any) -> None:
    target = shell.folder / "precious"
    target.write_text("x")
    (shell.folder / "run" / "manager.lock").symlink_to(target)
    assert "cannot open lock file" in shell.run("rtmgr start").err
    assert target.read_text() == "x"
    (shell.folder / "run" / "manager.lock").unlink()


# folders


@pytest.mark.parametrize("variable", ["RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"])
def test_folders_that_are_not_private(shell: Any, variable: str) -> None:
    folder = Path(shell.environment[variable])
    folder.chmod(0o770)
    assert shell.run("rtmgr start").err.startswith(
        f"rtmgr: folder is open to other users (mode 770): {folder}"
    )
    folder.chmod(0o700)
    folder.rmdir()
    folder.write_text("")
    assert shell.run("rtmgr start").status == 1
    folder.unlink()
    folder.symlink_to(shell.modules)
    assert "not a folder" in shell.run("rtmgr start").err
    folder.unlink()
    shell.ok("rtmgr start")
    assert folder.stat().st_mode & 0o777 == 0o700


def test_a_path_that_is_too_long(shell: Any) -> None:
    folder = shell.folder / ("x" * 100)
    shell.environment["RTKIT_RUNTIME_DIR"] = str(folder)
    outcome = shell.run("rtmgr start")
    assert outcome.status == 1
    assert "set RTKIT_RUNTIME_DIR to a shorter folder" in outcome.err
    assert "\n" not in outcome.err.rstrip("\n")


@pytest.mark.parametrize("name", ["a b", "ä", "a#b", "a;b", 'a"b', "a\\b", "a*b", "%p", "-a"])
def test_a_name_of_any_characters_works_or_is_refused(shell: Any, name: str) -> None:
    quoted = name.replace("\\", "\\\\").replace('"', '\\"')
    outcome = shell.run(f'rtmgr start -- "{quoted}"')
    if outcome.status:
        assert outcome.err.startswith("rtmgr: ")
        assert outcome.err.count("\n") == 1
        return
    assert shell.run(f'rtmgr status -- "{quoted}"').status == 0
    assert shell.run(f'rtmgr stop -- "{quoted}"').status == 0


# the end


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_is_an_orderly_end(manager: Any, world: Tree, number: signal.Signals) -> None:
    make(world, thing("A"), thing("B", "s"), thing("C"), thing("D", "t"))
    make(world, *map(activate, "ABCD"))
    pid = world.listing().pid
    slaves = [process.pid for process in world.snapshot().processes]
    os.kill(pid, number)
    until(lambda: has_ended(pid), "the end")
    ended = ends(manager)
    assert sorted(ended) == ["A", "B", "C", "D"]
    assert ended.index("C") < ended.index("A")  # those of one process in turn, processes at once
    assert all(map(has_ended, slaves))


def test_more_signals_do_not_disturb_the_end(manager: Any, world: Tree) -> None:
    make(world, *(thing(f"A{number}", f"s{number % 3}") for number in range(9)))
    pid = world.listing().pid
    pidfd = os.pidfd_open(pid)
    try:
        while not has_ended(pid):
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGCHLD):
                signal.pidfd_send_signal(pidfd, number)
            time.sleep(0.001)
    except ProcessLookupError:
        assert has_ended(pid)
    finally:
        os.close(pidfd)
    assert sorted(ends(manager)) == sorted(f"A{number}" for number in range(9))
    assert "Traceback" not in manager.log()


def test_hanging_components_have_one_grace_together(manager: Any, world: Tree) -> None:
    make(world, *(thing(f"A{number}", f"s{number}", "hang") for number in range(5)))
    make(world, thing("Own", "", "hang"))
    slaves = [process.pid for process in world.snapshot().processes]
    began = time.monotonic()
    managers.stop("manager", BOUND_S)
    assert time.monotonic() - began < 10 * 7.0
    assert all(map(has_ended, slaves))


def test_stopped_slaves_do_not_hold_up_the_end(manager: Any, world: Tree) -> None:
    make(world, thing("A", "s"), thing("B", "t"))
    slaves = [process.pid for process in world.snapshot().processes if process.is_slave]
    os.kill(slaves[0], signal.SIGSTOP)
    managers.stop("manager", BOUND_S)
    assert all(map(has_ended, slaves))
    assert sorted(ends(manager)) == ["A", "B"]


def _sleeps(entry: Path, own: bytes) -> bool:
    """Whether an entry of /proc is a sleep that a component of this test started."""
    try:
        is_sleep = entry.name.isdigit() and (entry / "cmdline").read_bytes().startswith(b"sleep")
        return is_sleep and own in (entry / "environ").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return False  # it ended while we looked


def test_stopping_ends_what_components_started(manager: Any, world: Tree) -> None:
    make(world, thing("A", "s", "child"), thing("B", "", "child"), activate("A"), activate("B"))
    own = str(manager.folder).encode()
    asleep = [int(entry.name) for entry in Path("/proc").iterdir() if _sleeps(entry, own)]
    assert len(asleep) == 2
    managers.stop("manager", BOUND_S)
    assert all(map(has_ended, asleep))


def test_stopping_answers_who_waits(manager: Any, world: Tree) -> None:
    (manager.modules / "Slow.py").write_text(
        "import time\n"
        "from rtkit.component import Component\n"
        "class Slow(Component):\n"
        "    def on_initialize(self):\n"
        "        open('begun', 'w').close()\n"
        "        time.sleep(1000)\n"
        "def SlowInit(manager):\n"
        "    manager.register_factory(Slow)\n"
    )
    waiting = manager.open("rtmgr --timeout 600 -c 'Slow?manager_name=s' /localhost/manager.mgr")
    until((manager.folder / "begun").exists, "the creation")
    managers.stop("manager", BOUND_S)
    _, err = waiting.communicate(timeout=BOUND_S)
    assert (waiting.returncode, err) == (
        1,
        "rtmgr: Failed to create component: Slow?manager_name=s (the manager is stopping)\n",
    )


# a manager that is stopped by SIGSTOP


@pytest.fixture
def halted(world: Tree) -> Iterator[Tree]:
    """A connection to a manager that was then stopped."""
    pid = world.listing().pid
    os.kill(pid, signal.SIGSTOP)
    yield world
    os.kill(pid, signal.SIGCONT)


def test_every_call_to_a_stopped_manager_is_bounded(halted: Tree) -> None:
    halted.timeout_s = 0.3
    calls: list[Callable[[], object]] = [
        halted.listing,
        halted.snapshot,
        lambda: halted.get("manager.pid"),
        lambda: halted.set("stop-not", ""),
        lambda: halted.apply([Create("Thing")]),
        lambda: halted.apply([Create("Thing")] * 3, is_ordered=False),
        lambda: connect(timeout_s=0.3),
        lambda: managers.status("manager", 0.3),
        lambda: managers.stop("manager", 0.3),
    ]
    began = time.monotonic()
    for call in calls:
        with pytest.raises(Unreachable):
            call()
    assert time.monotonic() - began < 10 * len(calls) * 1.5


def test_a_manager_that_goes_on_kills_nobody_for_being_late(manager: Any, world: Tree) -> None:
    make(world, *(thing(f"A{number}", f"s{number}") for number in range(5)))
    pid = world.listing().pid
    waiting = manager.open(
        "rtmgr --timeout 0.5 -c 'Thing?instance_name=B&manager_name=t' /localhost/manager.mgr"
    )
    os.kill(pid, signal.SIGSTOP)
    waiting.communicate(timeout=BOUND_S)
    os.kill(pid, signal.SIGCONT)
    make(world, *(activate(f"A{number}") for number in range(5)))
    assert {row.zombie for row in world.listing().rows} == {""}


def test_data_flow_while_the_manager_is_stopped_and_not_one_is_lost(
    manager: Any, world: Tree
) -> None:
    ends = (PortRef("A", "out"), PortRef("B", "into"))
    held = {"dataport.buffer.length": "10000"}  # for a moment in which B is not scheduled
    make(world, thing("A", "s", "source"), thing("B", "t"))
    make(world, Connect(ConnectorProfile("w", "w", ends, held)), activate("B"), activate("A"))
    file = manager.folder / "state" / "last"

    def last() -> int:
        return int(file.read_text().strip() or 0) if file.exists() else 0

    until(lambda: last() > 20, "the first numbers")
    pid = world.listing().pid
    os.kill(pid, signal.SIGSTOP)
    try:
        before = last()
        until(lambda: last() > before + 200, "numbers without the manager")
    finally:
        os.kill(pid, signal.SIGCONT)
    before = last()
    until(lambda: last() > before + 20, "numbers with it again")
    states = {row.instance: row.state for row in world.listing().rows}
    assert states == {"A": "Active", "B": "Active"}  # B fails at the first number that is missing


# many, and at their limits


def test_a_hundred_slaves_at_once(manager: Any, world: Tree) -> None:
    actions = [thing(f"A{number}", f"s{number}") for number in range(100)]
    results = world.apply(actions, is_ordered=False, timeout_s=BOUND_S)
    assert {result.why for result in results} == {""}
    results = world.apply(
        [activate(f"A{number}") for number in range(100)], is_ordered=False, timeout_s=BOUND_S
    )
    assert {result.why for result in results} == {""}
    listing = world.listing()
    assert len(listing.slaves) == 100
    assert {row.state for row in listing.rows} == {"Active"}
    results = world.apply(
        [Delete(f"A{number}") for number in range(50)], is_ordered=False, timeout_s=BOUND_S
    )
    assert {result.why for result in results} == {""}
    assert len(world.listing().slaves) == 50
    managers.stop("manager", BOUND_S)
    assert len(ends(manager)) == 100


def test_a_client_that_is_killed_in_the_middle_of_a_batch(manager: Any, world: Tree) -> None:
    chain = " ".join(f"-c 'Thing?instance_name=A{n}&manager_name=s{n}'" for n in range(10))
    client = manager.open(f"rtmgr {chain} /localhost/manager.mgr")
    until(lambda: world.listing().rows, "the first component")
    client.kill()
    client.communicate()
    until(lambda: len(world.listing().rows) == 10, "the rest of what was asked for")
    assert {row.zombie + row.trouble for row in world.listing().rows} == {""}
    make(world, *map(activate, (row.instance for row in world.listing().rows)))


def test_a_manager_without_descriptors_refuses_the_new_and_keeps_the_old(
    manager: Any, world: Tree
) -> None:
    make(world, thing("A", "s"))
    pid = world.listing().pid
    used = {int(entry.name) for entry in Path(f"/proc/{pid}/fd").iterdir()}
    free = min(set(range(len(used) + 1)) - used)
    soft, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (free, hard))
    try:
        (refused,) = world.apply([thing("B", "t")], timeout_s=2.0)
        why = "the manager has no descriptors left: Too many open files"
        assert refused.why == f"slave t could not be started: {why}"
        make(world, activate("A"))
        with socket.socket(socket.AF_UNIX) as another:
            another.settimeout(BOUND_S)
            another.connect(str(manager.folder / "run" / "manager.ctl"))
            assert another.recv(1) == b""  # turned away, else it would wake the loop for ever
        before = cpu_s(pid)
        refused_at = time.monotonic()
        until(lambda: time.monotonic() > refused_at + 0.5, "half a second")
        assert cpu_s(pid) - before < 0.25  # it does not spin
    finally:
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (soft, hard))
    until(lambda: "t" not in [name for name, _, _ in world.listing().slaves], "the end of t")
    make(world, thing("B", "t"))


def cpu_s(pid: int) -> float:
    """Return the processor time that a process has used [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_a_manager_at_rest_does_nothing(manager: Any, world: Tree) -> None:
    make(world, *(thing(f"A{number}", f"s{number % 3}") for number in range(30)))
    pids = [process.pid for process in world.snapshot().processes]
    before = {pid: cpu_s(pid) for pid in pids}
    began = time.monotonic()
    until(lambda: time.monotonic() > began + 1.0, "a second")
    assert sum(cpu_s(pid) - before[pid] for pid in pids) < 0.5


def test_files_are_private_whatever_the_umask(shell: Any) -> None:
    for name in ("run", "state"):
        (shell.folder / name).rmdir()
    command = ["sh", "-c", 'umask 000; exec "$@"', "sh", *shell.command("rtmgr start")]
    subprocess.run(command, env=shell.environment, cwd=shell.folder, check=True)
    (shell.modules / "Thing.py").write_text(MODULE)
    (shell.modules / "Thing.py").chmod(0o644)
    shell.ok("rtmgr /localhost/manager.mgr -c 'Thing?manager_name=s' -c 'Thing?manager_name=t'")
    shell.ok("rtcon /localhost/Thing0.rtc:out /localhost/Thing1.rtc:into")
    for name in ("run", "state"):
        assert (shell.folder / name).stat().st_mode & 0o077 == 0
    for path in (shell.folder / "state").iterdir():
        assert path.stat().st_mode & 0o077 == 0, path


def test_another_user_reaches_nothing(manager: Any, world: Tree) -> None:
    make(world, thing("A", "s"))
    assert (manager.folder / "run").stat().st_mode & 0o777 == 0o700
    if os.getuid():
        return  # only root can become somebody else and try
    script = (
        "import socket, sys\n"
        "for path in sys.argv[1:]:\n"
        "    try:\n"
        "        socket.socket(socket.AF_UNIX).connect(path)\n"
        "    except PermissionError:\n"
        "        continue\n"
        "    sys.exit(path)\n"
    )
    manager.folder.chmod(0o755)
    paths = [str(path) for path in (manager.folder / "run").iterdir()]
    assert any(path.endswith(".sock") for path in paths)
    command = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    done = subprocess.run(
        [*command, "/usr/bin/env", "python3", "-c", script, *paths],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
