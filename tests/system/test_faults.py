"""Components and slaves that fail in every way: what it does to them, and to nobody else."""

from __future__ import annotations

import os
import re
import resource
import signal
from pathlib import Path
from typing import Any

import pytest
from waiting import has_ended, slave_pid, until

from rtkit.deployment.actions import (
    ActivateSet,
    ChangeState,
    Connect,
    Create,
    Delete,
    Disconnect,
    Result,
)
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

KEEPS_MANAGER = True

FAULTY = '''
import ctypes, locale, os, signal, subprocess, sys, threading, time
from rtkit.component import Component


class Faulty(Component):
    """Does what the option `how` says in the callback that the option `when` names."""

    rate = 100.0

    def act(self, name):
        if self.options.get("when") == name:
            WAYS[self.options["how"]]()

    def on_initialize(self):
        self.act("on_initialize")

    def on_startup(self, context):
        self.act("on_startup")

    def on_activated(self, context):
        self.act("on_activated")

    def on_execute(self, context):
        self.act("on_execute")

    def on_deactivated(self, context):
        self.act("on_deactivated")

    def on_shutdown(self, context):
        self.act("on_shutdown")

    def on_finalize(self):
        self.act("on_finalize")


def hang():
    time.sleep(1000)


def spin():
    while True:
        pass


def raise_(error):
    raise error


def start_children():
    """Leave children: a plain one, one in a session of its own, orphans in other ones."""
    subprocess.Popen(["sleep", "1000"])
    subprocess.Popen(["sleep", "1000"], start_new_session=True)
    subprocess.Popen(["sh", "-c", "setsid sleep 1000 & exit"]).wait()
    bare = {"RTKIT_RUNTIME_DIR": os.environ["RTKIT_RUNTIME_DIR"]}
    hidden = ["/usr/bin/setsid", "--fork", "sh", "-c", "/bin/sleep 1000; :"]
    subprocess.Popen(hidden, env={**bare, "PATH": "/bin"}).wait()
    child = os.fork()
    if child:
        os.waitpid(child, 0)
        return
    os.setsid()
    if os.fork():
        os._exit(0)
    os.execve("/bin/sleep", ["sleep", "1000"], bare)


def leak():
    """Take memory until there is none."""
    kept = []
    while True:
        kept.append(bytearray(1 << 20))


def crowd():
    """Leave two hundred children, each in a session of its own."""
    for _ in range(200):
        subprocess.Popen(["sleep", "1000"], start_new_session=True)


def litter():
    """Change what a process has only once."""
    os.chdir("/")
    os.umask(0o777)
    for number in (signal.SIGTERM, signal.SIGCHLD, signal.SIGUSR1):
        ctypes.CDLL(None).signal(int(number), ctypes.c_void_p(int(signal.SIG_IGN)))
    sys.path.clear()
    sys.stdout.close()
    sys.stderr.close()
    locale.setlocale(locale.LC_ALL, "C")


WAYS = {
    "raise": lambda: raise_(ValueError("told to")),
    "sys.exit": lambda: sys.exit(3),
    "interrupt": lambda: raise_(KeyboardInterrupt()),
    "exit": lambda: os._exit(3),
    "exit 0": lambda: os._exit(0),
    "segv": lambda: ctypes.string_at(0),
    "abort": os.abort,
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "term": lambda: os.kill(os.getpid(), signal.SIGTERM),
    "recurse": lambda: (lambda f: f(f))(lambda f: f(f)),
    "exit in thread": lambda: threading.Thread(target=lambda: os._exit(4)).start() or hang(),
    "close": lambda: os.closerange(3, 256),
    "hang": hang,
    "spin": spin,
    "children": start_children,
    "leak": leak,
    "crowd": crowd,
    "litter": litter,
}


def FaultyInit(manager):
    manager.register_factory(Faulty)
'''
COUNTER = '''
from rtkit.component import Component, OutPort, TimedLong


class Counter(Component):
    """Count."""

    rate = 200.0
    out = OutPort(TimedLong)
    number = 0

    def on_execute(self, context):
        self.number += 1
        self.out.write(TimedLong(data=self.number))


def CounterInit(manager):
    manager.register_factory(Counter)
'''
CHECKER = '''
import os
from rtkit.component import Component, InPort, TimedLong


class Checker(Component):
    """Fail at the first number that is missing; keep the last one in a file."""

    rate = 200.0
    into = InPort(TimedLong)
    last = 0

    def on_execute(self, context):
        for value in self.into.read_all():
            if self.last not in (0, value.data - 1):
                raise ValueError(f"{value.data} came after {self.last}")
            self.last = value.data
        name = os.environ["RTKIT_STATE_DIR"] + "/" + self.instance
        with open(name + ".new", "w") as file:
            file.write(str(self.last))
        os.replace(name + ".new", name)


def CheckerInit(manager):
    manager.register_factory(Checker)
'''
BOUND_S = 60.0
"""Bound on what comes soon; no test waits for it [s]."""

HUGE = {"dataport.buffer.length": "100000"}


def row(tree: Tree, instance: str) -> Any:
    return next((row for row in tree.listing().rows if row.instance == instance), None)


def one(results: tuple[Result, ...]) -> Result:
    (result,) = results
    return result


def activate(instance: str) -> ChangeState:
    return ChangeState(instance, "0", Transition.ACTIVATE)


def deactivate(instance: str) -> ChangeState:
    return ChangeState(instance, "0", Transition.DEACTIVATE)


def faulty(instance: str, slave: str, when: str = "", how: str = "") -> Create:
    text = f"Faulty?instance_name={instance}&manager_name={slave}"
    return Create(f"{text}&when={when}&how={how}" if when else text)


@pytest.fixture
def world(manager: Any, tree: Tree) -> Tree:
    """A manager that can make all the types above."""
    for name, text in (("Faulty", FAULTY), ("Counter", COUNTER), ("Checker", CHECKER)):
        (manager.modules / f"{name}.py").write_text(text)
    return tree


class Stream:
    """A counter in a slave whose numbers a checker in another one checks."""

    def __init__(self, tree: Tree, state: Path) -> None:
        self.tree = tree
        self._file = state / "Check"
        ends = (PortRef("Count", "out"), PortRef("Check", "into"))
        actions = [
            Create("Counter?instance_name=Count&manager_name=counting"),
            Create("Checker?instance_name=Check&manager_name=checking"),
            Connect(ConnectorProfile("stream", "stream", ends, HUGE)),
            activate("Check"),
            activate("Count"),
        ]
        for result in tree.apply(actions):
            result.raise_for_error()
        self.flows()

    @property
    def last(self) -> int:
        """The last number that came."""
        return int(self._file.read_text()) if self._file.exists() else 0

    def flows(self) -> None:
        """Check that numbers come, and that none was missed so far."""
        before = self.last
        until(lambda: self.last > before + 20, "numbers that flow")

    def is_whole(self) -> bool:
        """Whether no number was missed."""
        return bool(row(self.tree, "Check").state == "Active")


@pytest.fixture
def stream(manager: Any, world: Tree) -> Stream:
    return Stream(world, Path(manager.environment["RTKIT_STATE_DIR"]))


# a component that ends its process


@pytest.mark.parametrize(
    ("when", "how", "reason"),
    [
        ("on_execute", "exit", "exit status 3"),
        ("on_execute", "exit 0", "exit status 0"),
        ("on_execute", "segv", "signal 11 at Faulty.py:LINE in <lambda>"),
        ("on_execute", "abort", "signal 6 at Faulty.py:LINE in act"),
        ("on_execute", "kill", "signal 9"),
        ("on_execute", "exit in thread", "exit status 4"),
        ("on_initialize", "exit", "exit status 3"),
        ("on_initialize", "segv", "signal 11 at Faulty.py:LINE in <lambda>"),
        ("on_activated", "exit in thread", "exit status 4"),
        ("on_activated", "kill", "signal 9"),
        ("on_finalize", "exit 0", "exit status 0"),
        ("on_finalize", "abort", "signal 6 at Faulty.py:LINE in act"),
    ],
)
def test_a_slave_that_a_component_ends(world: Tree, when: str, how: str, reason: str) -> None:
    made = one(world.apply([faulty("A", "s", when, how)]))
    if when == "on_initialize":
        assert made.kind == "unreachable"
        assert re.sub(r":\d+", ":LINE", made.why) == f"slave s ended: {reason}"
        assert world.listing().rows == ()
        assert world.listing().slaves == ()
        return
    assert made.ok, made.why
    action = Delete("A") if when == "on_finalize" else activate("A")
    result = one(world.apply([action]))
    if when != "on_execute":
        assert re.sub(r":\d+", ":LINE", result.why) == f"slave s ended: {reason}"
    zombie = until(lambda: (each := row(world, "A")) and each.zombie, "a zombie")
    assert re.sub(r":\d+", ":LINE", zombie) == reason
    assert one(world.apply([activate("A")])).why == f"zombie ({zombie}): A"
    again = one(world.apply([faulty("A", "s")]))
    assert again.value == "A"
    assert row(world, "A").zombie == ""


def test_a_term_from_outside_is_an_orderly_end_with_its_reason(world: Tree) -> None:
    world.perform(faulty("A", "s"))
    os.kill(slave_pid(world, "s"), signal.SIGTERM)
    assert until(lambda: row(world, "A").zombie, "a zombie") == "exit status 0"


@pytest.mark.parametrize(
    ("when", "how"),
    [
        ("on_execute", "raise"),
        ("on_execute", "sys.exit"),
        ("on_execute", "interrupt"),
        ("on_execute", "recurse"),
        ("on_activated", "sys.exit"),
        ("on_deactivated", "recurse"),
        ("on_shutdown", "interrupt"),
        ("on_finalize", "sys.exit"),
    ],
)
def test_a_component_that_raises_does_not_end_its_slave(world: Tree, when: str, how: str) -> None:
    world.perform(faulty("Other", "s"))
    world.perform(faulty("A", "s", when, how))
    pid = slave_pid(world, "s")
    world.apply([activate("Other"), activate("A")], is_ordered=False)
    if when in ("on_execute", "on_activated"):
        until(lambda: row(world, "A").state == "Error", "the error")
        assert world.snapshot().component("A").cause
    world.apply([deactivate("A")])
    assert one(world.apply([Delete("A")])).ok
    assert one(world.apply([faulty("Third", "s")])).ok
    assert row(world, "Other").state == "Active"
    assert slave_pid(world, "s") == pid


def test_a_component_that_closes_all_descriptors_harms_its_own_slave_only(
    stream: Stream, world: Tree
) -> None:
    world.perform(faulty("A", "s", "on_activated", "close"))
    world.apply([activate("A")], timeout_s=2.0)
    stream.flows()
    assert stream.is_whole()


def test_a_component_that_changes_its_process_harms_its_own_slave_only(
    stream: Stream, world: Tree
) -> None:
    for instance in "AB":
        world.perform(faulty(instance, "s", "on_activated", "litter"))
        world.perform(activate(instance))
    stream.flows()
    assert stream.is_whole()
    for instance in "AB":
        world.perform(deactivate(instance))
        world.perform(Delete(instance))
    until(lambda: "s" not in [name for name, _, _ in world.listing().slaves], "its end")


def test_memory_that_is_used_up_is_an_error_of_who_wants_more(stream: Stream, world: Tree) -> None:
    """Where the system limits it: the slave and what else it holds go on."""
    world.perform(faulty("Other", "s"))
    world.perform(faulty("A", "s", "on_execute", "leak"))
    world.perform(activate("Other"))
    pid = slave_pid(world, "s")
    resource.prlimit(pid, resource.RLIMIT_DATA, (300 << 20, 300 << 20))
    world.perform(activate("A"))
    until(lambda: row(world, "A").state == "Error", "the error")
    assert "MemoryError" in world.snapshot().component("A").cause
    assert (row(world, "Other").state, slave_pid(world, "s")) == ("Active", pid)
    stream.flows()
    assert stream.is_whole()


# one that hangs


@pytest.mark.parametrize("how", ["hang", "spin"])
def test_a_creation_that_hangs_is_given_up_in_time_and_cleaned_away(world: Tree, how: str) -> None:
    world.perform(faulty("A", "warm"))  # slaves can be forked now
    world.perform(Delete("A"))
    result = one(world.apply([faulty("A", "s", "on_initialize", how)], timeout_s=1.0))
    assert result.kind == "unreachable"
    line = rf"A is stuck in on_initialize since [\d:]{{8}} \(Faulty\.py:\d+ in {how}\)"
    assert re.search(line, result.why), result.why
    assert world.listing().rows == ()
    until(lambda: not world.listing().slaves, "the end of the slave")
    assert one(world.apply([faulty("A", "s")])).ok


def test_a_creation_that_hangs_beside_others_leaves_them(world: Tree) -> None:
    world.perform(faulty("Other", "s"))
    result = one(world.apply([faulty("A", "s", "on_initialize", "hang")], timeout_s=0.5))
    assert result.kind == "unreachable"
    assert [row.instance for row in world.listing().rows] == ["Other"]
    assert one(world.apply([faulty("A", "t")])).ok  # its name is free
    os.kill(slave_pid(world, "s"), signal.SIGKILL)  # which else takes all its grace to end


@pytest.mark.parametrize("how", ["hang", "spin"])
def test_one_that_hangs_while_it_works_holds_up_itself_only(world: Tree, how: str) -> None:
    world.perform(faulty("Other", "s"))
    world.perform(faulty("A", "s", "on_execute", how))
    world.perform(activate("A"))
    actions = [deactivate("A"), activate("Other"), ActivateSet("Other", "default")]
    results = world.apply(actions, is_ordered=False, timeout_s=2.0)
    assert [result.ok for result in results] == [False, True, True]
    with pytest.raises(Unreachable):
        world.perform(Delete("A"), timeout_s=0.5)
    assert row(world, "Other").state == "Active"
    os.kill(slave_pid(world, "s"), signal.SIGKILL)  # which else takes all its grace to end


# slaves that are killed, stopped and go on


def test_a_killed_slave_costs_nobody_else_a_message(stream: Stream, world: Tree) -> None:
    ends = (PortRef("Count", "out"), PortRef("Third", "into"))
    for number in range(3):
        made = world.apply(
            [
                Create("Checker?instance_name=Third&manager_name=third"),
                Connect(ConnectorProfile("other", "other", ends, HUGE)),
                activate("Third"),
            ]
        )
        assert [result.why for result in made] == ["", "", ""], number
        os.kill(slave_pid(world, "third"), signal.SIGKILL)
        assert until(lambda: row(world, "Third").zombie, "a zombie") == "signal 9"
        assert [wire.connector_id for wire in world.snapshot().connectors] == ["stream"]
        stream.flows()
    assert stream.is_whole()
    assert row(world, "Count").state == "Active"


def test_a_stopped_slave_is_answered_for_at_once_and_hears_of_it_later(
    stream: Stream, world: Tree
) -> None:
    pid = slave_pid(world, "checking")
    os.kill(pid, signal.SIGSTOP)
    try:
        assert until(lambda: row(world, "Check").trouble, "the mark") == "stopped"
        why = "slave checking does not answer: it is stopped"
        actions = [activate("Check"), Create("Checker?manager_name=checking"), Delete("Check")]
        results = world.apply(actions, is_ordered=False, timeout_s=600.0)
        help_ = f"{why}; rtexit --force ends its slave checking"
        assert [result.why for result in results] == [why, why, help_]
        assert one(world.apply([Disconnect("stream")], timeout_s=600.0)).ok
        assert row(world, "Count").state == "Active"
    finally:
        os.kill(pid, signal.SIGCONT)
    until(lambda: not row(world, "Check").trouble, "the end of the mark")
    ends = (PortRef("Count", "out"), PortRef("Check", "into"))
    again = Connect(ConnectorProfile("stream", "stream", ends, HUGE))
    result = one(world.apply([again]))
    assert result.ok, result.why  # the end that it held was taken off
    assert one(world.apply([Delete("Check")])).ok


def test_a_slave_that_is_stopped_at_birth_is_given_up(world: Tree, manager: Any) -> None:
    (manager.modules / "Slow.py").write_text(
        "import os, signal\nos.kill(os.getpid(), signal.SIGSTOP)\n"
    )
    with pytest.raises(RtkitError):
        world.perform(Create("Slow?manager_name=s"), timeout_s=0.5)
    until(lambda: not world.listing().slaves, "the end of the slave")


# the zygote


def zygote_of(tree: Tree) -> int:
    """Return the pid of the process that forks slaves."""
    own = tree.listing().pid
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                command = (entry / "cmdline").read_bytes()
            except (FileNotFoundError, ProcessLookupError):
                continue
            slaves = {process.pid for process in tree.snapshot().processes}
            if parent == own and b"zygote" in command and int(entry.name) not in slaves:
                return int(entry.name)
    raise AssertionError("no zygote")


def test_a_killed_zygote_is_replaced_and_its_slaves_run_on(stream: Stream, world: Tree) -> None:
    first = zygote_of(world)
    os.kill(first, signal.SIGKILL)
    made = [one(world.apply([faulty(name, name)])) for name in ("A", "B", "C")]
    assert all(result.ok for result in made[1:]), made  # only what it had been asked for is lost
    assert zygote_of(world) != first
    stream.flows()
    assert stream.is_whole()
    pid = slave_pid(world, "checking")
    os.kill(pid, signal.SIGSTOP)
    assert until(lambda: row(world, "Check").trouble, "the mark of a stop") == "stopped"
    os.kill(pid, signal.SIGCONT)
    until(lambda: not row(world, "Check").trouble, "the end of the mark")
    os.kill(pid, signal.SIGSEGV)
    assert until(lambda: row(world, "Check").zombie, "a zombie") == "signal 11"
    assert row(world, "Count").state == "Active"
    assert one(world.apply([Delete("Count")])).ok
    until(lambda: "counting" not in [name for name, _, _ in world.listing().slaves], "its end")


def test_a_zygote_that_dies_again_and_again(world: Tree) -> None:
    for number in range(5):
        os.kill(zygote_of(world), signal.SIGKILL)
        until(lambda n=number: one(world.apply([faulty(f"A{n}", f"s{n}")])).ok, "a slave")
    assert len(world.listing().slaves) == 5


def test_a_stopped_zygote_costs_only_new_slaves(stream: Stream, world: Tree) -> None:
    zygote = zygote_of(world)
    os.kill(zygote, signal.SIGSTOP)
    try:
        why = f"no slave can be started: the zygote is stopped (pid {zygote})"
        assert until(lambda: world.listing().trouble, "the remark") == why
        assert one(world.apply([faulty("A", "s")], timeout_s=600.0)).why == why
        assert one(world.apply([faulty("B", "checking")])).ok
        stream.flows()
    finally:
        os.kill(zygote, signal.SIGCONT)
    until(lambda: not world.listing().trouble, "the end of the remark")
    assert one(world.apply([faulty("A", "s")])).ok


# what components leave behind


def leftovers() -> list[int]:
    """Return what still sleeps of what components of this user started."""
    run_id = os.environ["RTKIT_RUNTIME_DIR"].encode()
    found = []
    for entry in Path("/proc").iterdir():
        try:
            is_ours = run_id in (entry / "environ").read_bytes()
            is_asleep = (entry / "cmdline").read_bytes().endswith(b"sleep\x001000\x00")
        except OSError:
            continue
        if entry.name.isdigit() and is_ours and is_asleep:
            found.append(int(entry.name))
    return found


@pytest.mark.parametrize("end", ["delete", "kill", "term"])
def test_what_a_component_started_ends_with_its_slave(world: Tree, end: str) -> None:
    world.perform(faulty("A", "s", "on_activated", "children"))
    world.perform(activate("A"))
    until(lambda: len(leftovers()) == 5, "the children")
    left = leftovers()
    pid = slave_pid(world, "s")
    if end == "delete":
        world.perform(Delete("A"))
    else:
        os.kill(pid, signal.SIGKILL if end == "kill" else signal.SIGTERM)
    until(lambda: all(map(has_ended, left)), "the end of the children")


def test_two_hundred_children_end_with_their_slave(world: Tree) -> None:
    world.perform(faulty("A", "s", "on_activated", "crowd"))
    world.perform(activate("A"))
    left = until(lambda: len(leftovers()) == 200 and leftovers(), "the children")
    os.kill(slave_pid(world, "s"), signal.SIGKILL)
    until(lambda: all(map(has_ended, left)), "the end of the children")


def test_a_program_that_a_component_runs_in_the_manager_tells_its_status(
    world: Tree, manager: Any
) -> None:
    (manager.modules / "Runner.py").write_text(
        "import subprocess\n"
        "from rtkit.component import Component\n"
        "class Runner(Component):\n"
        "    def on_activated(self, context):\n"
        "        for status in list(range(20)) * 3:\n"
        "            done = subprocess.run(['sh', '-c', f'exit {status}'])\n"
        "            assert done.returncode == status, (done, status)\n"
        "def RunnerInit(manager):\n"
        "    manager.register_factory(Runner)\n"
    )
    world.perform(Create("Runner?instance_name=R"))
    world.perform(activate("R"))


# modules


def test_modules_that_cannot_be_used(world: Tree, manager: Any) -> None:
    sources = {
        "Broken": ("def (", r"Broken.py:1"),
        "Lost": ("import nonsuch", "ModuleNotFoundError"),
        "Raising": ("raise SystemExit(3)", "SystemExit: 3"),
        "Without": ("", "no init function WithoutInit"),
        "Wrong": ("def WrongInit(m): m.register_factory(5)", "not a component class"),
        "Failing": ("def FailingInit(m): 1/0", "ZeroDivisionError"),
    }
    for name, (source, why) in sources.items():
        (manager.modules / f"{name}.py").write_text(source)
        for place in ("", "?manager_name=s"):
            result = one(world.apply([Create(f"{name}{place}")]))
            assert not result.ok
            assert why in result.why
    (manager.modules / "Open.py").write_text(FAULTY.replace("Faulty", "Open"))
    (manager.modules / "Open.py").chmod(0o666)
    with pytest.raises(Refused, match="may be written by everybody"):
        world.perform(Create("Open"))
    until(lambda: not world.listing().slaves, "the end of the slaves")
    assert world.listing().rows == ()


@pytest.mark.parametrize("how", ["os._exit(5)", "os.kill(os.getpid(), 9)"])
def test_a_module_that_ends_the_slave_that_imports_it(world: Tree, manager: Any, how: str) -> None:
    (manager.modules / "Deadly.py").write_text(f"import os\n{how}\n")
    with pytest.raises(Unreachable, match=r"slave s ended: (exit status 5|signal 9)"):
        world.perform(Create("Deadly?manager_name=s"))
    assert world.listing().slaves == ()
