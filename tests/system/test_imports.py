"""Modules that hang, exit or crash when they are imported harm nobody, least of all the manager."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from rtkit.deployment.actions import Connect, Create, Load
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
MODULE = """
import ctypes, os, re, sys, time
from rtkit.component import Component
{line}


class {name}(Component):
    '''Nothing.'''


def {name}Init(manager):
    manager.register_factory({name})
"""
ENDS = {
    "os._exit(3)": (Refused, r"module FILE ended the process that imported it: exit status 3"),
    "os._exit(0)": (Refused, r"module FILE ended the process that imported it: exit status 0"),
    "sys.exit(4)": (Refused, r"module does not import: SystemExit: 4 \(\S*/FILE:3\)"),
    "ctypes.string_at(0)": (Refused, r"imported it: signal 11 at FILE:3 in <module>"),
    "os.abort()": (Refused, r"module FILE ended the process that imported it: signal 6"),
    "os.kill(0, 9)": (Refused, r"module FILE ended the process that imported it: signal 9"),
    "import nonsuch": (Refused, r"ModuleNotFoundError: No module named 'nonsuch' \(\S*/FILE:3\)"),
    "raise MemoryError": (Refused, r"module does not import: MemoryError \(\S*/FILE:3\)"),
}
HANGS = {
    "sleep": "time.sleep(1e9)",
    "loop": "exec(compile('while True: pass', __file__, 'exec'))",
    "lock": "re.match('(a+)+$', 'a' * 40 + 'b')",
}
TELLER = """
import os, sys
from rtkit.component import Component, Manager, OutPort, TimedLong


class Teller(Component):
    'Tells what is imported in its process once it has been at work.'

    rate = 100.0
    out = OutPort(TimedLong)

    def on_execute(self, context: str) -> None:
        self.out.write(TimedLong())

    def on_deactivated(self, context: str) -> None:
        with open(os.environ["RTKIT_STATE_DIR"] + "/told", "w") as file:
            print(*sys.modules, file=file)


def TellerInit(manager: Manager) -> None:
    manager.register_factory(Teller)
"""
ZYGOTE = """
import importlib, runpy, sys
from rtkit.manager.slaves import zygote

for name in (*zygote.AHEAD, *zygote._AT_LEISURE):
    importlib.import_module(name)
for name in zygote._AT_LEISURE:
    zygote._make_types(name)
zygote.become_subreaper()
print(*sys.modules)
"""


def write(manager: Any, name: str, line: str) -> str:
    (manager.modules / f"{name}.py").write_text(MODULE.format(name=name, line=line).lstrip())
    return f"{name}.py"


def pid_of(tree: Tree) -> int:
    return tree.listing().pid


def slaves_of(pid: int) -> list[int]:
    """Return the children of the children of a process: what its zygote forked."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int(
                    (entry / "stat").read_text().rpartition(")")[2].split()[1]
                )
            except (FileNotFoundError, ProcessLookupError):
                continue
    return [each for each, parent in parents.items() if parents.get(parent) == pid]


def gone(tree: Tree) -> None:
    """Wait until no process is left that tried a module."""
    deadline = time.monotonic() + 30.0
    while slaves_of(pid_of(tree)):
        assert time.monotonic() < deadline, slaves_of(pid_of(tree))
        time.sleep(0.01)


@pytest.mark.parametrize("line", ENDS)
def test_a_module_that_ends_its_process_ends_not_the_manager(
    manager: Any, tree: Tree, line: str
) -> None:
    path = write(manager, "Bad", line)
    kind, why = ENDS[line]
    pid = pid_of(tree)
    for action in (Load(path), Create("Bad"), Create("Bad?manager_name=manager")):
        with pytest.raises(kind, match=why.replace("FILE", "Bad.py")):
            tree.perform(action)
    assert pid_of(tree) == pid
    assert tree.listing().slaves == ()
    assert tree.snapshot().modules == ()
    gone(tree)


@pytest.mark.parametrize("how", HANGS)
def test_a_module_that_hangs_is_given_up_in_time_and_holds_up_nobody(
    manager: Any, tree: Tree, how: str
) -> None:
    path = write(manager, "Slow", HANGS[how])
    for action in (Load(path), Create("Slow")):
        answer = tree.begin([action], timeout_s=1.5)
        for _ in range(3):
            assert tree.listing().rows == ()
        tree.perform(Create("ConsoleIn?instance_name=In"))
        tree.delete("/localhost/In.rtc")
        (result,) = answer()
        assert result.kind == "unreachable"
        place = r"stuck in import since [\d:]{8} \(Slow\.py:\d in <module>\)"
        assert re.fullmatch(rf"module Slow.py was not imported in time: it is {place}", result.why)
    gone(tree)


def test_what_hangs_only_in_the_manager_holds_up_its_own_components_and_nobody_else(
    manager: Any, tree: Tree
) -> None:
    write(manager, "Sly", f"if os.getpid() == {pid_of(tree)}: time.sleep(1e9)")
    with pytest.raises(Unreachable, match=r"Sly is stuck in creation .*\(Sly\.py:3 in <module>\)"):
        tree.perform(Create("Sly?instance_name=Sly"), timeout_s=1.0)
    assert "Sly is stuck in creation" in manager.ok("rtls -l /localhost")
    tree.perform(Create("ConsoleIn?manager_name=s"))
    with pytest.raises(Unreachable, match="no answer from manager in time: Sly is stuck"):
        tree.perform(Create("ConsoleIn"), timeout_s=0.5)


def test_modules_are_imported_only_where_their_components_are(manager: Any, tree: Tree) -> None:
    write(manager, "Note", "print(os.getpid(), file=open(os.environ['RTKIT_STATE_DIR']+'/n', 'a'))")
    note = Path(manager.environment["RTKIT_STATE_DIR"]) / "n"

    def importers() -> list[int]:
        return [int(line) for line in note.read_text().split()]

    own = pid_of(tree)
    tree.perform(Load("Note.py"))
    assert own not in importers()
    tree.perform(Create("Note?instance_name=A&manager_name=s"))
    assert importers()[1:] == [p.pid for p in tree.snapshot().processes if p.name == "s"]
    tree.perform(Create("Note?instance_name=B"))
    assert importers()[2:] == [own]  # it has been tried when it was loaded
    tree.perform(Create("Note?instance_name=C"))
    assert importers()[3:] == []
    (manager.modules / "Other.py").write_text("raise ValueError('nobody wants it')")
    tree.perform(Create("Note?instance_name=D&manager_name=t"))


def test_a_slave_imports_nothing_but_the_modules_of_its_components(
    manager: Any, tree: Tree
) -> None:
    (manager.modules / "Teller.py").write_text(TELLER)
    tree.perform(Create("Teller?instance_name=T&manager_name=s"))
    tree.perform(Create("ConsoleOut?instance_name=O&manager_name=t"))
    ends = PortRef("T", "out"), PortRef("O", "in")
    tree.perform(Connect(ConnectorProfile("wire", "wire", ends)))
    manager.ok("rtact /localhost/T.rtc")
    manager.ok("rtdeact /localhost/T.rtc")
    told = Path(manager.environment["RTKIT_STATE_DIR"], "told").read_text().split()
    ahead = subprocess.run([sys.executable, "-c", ZYGOTE], capture_output=True, check=True)
    own = [name for name in told if name not in ahead.stdout.decode().split()]
    assert [name.partition("_module_")[0] for name in own] == ["rtkit"], own


def test_a_trial_is_no_slave_and_its_name_is_nobody_s(manager: Any, tree: Tree) -> None:
    path = write(manager, "Slow", HANGS["sleep"])
    answer = tree.begin([Load(path)], timeout_s=1.0)
    for _ in range(10):
        assert tree.listing().slaves == ()
        assert tree.get("get_slave_managers") == ""
    assert not answer()[0].ok
    with pytest.raises(RtkitError, match="not allowed"):
        tree.perform(Create("ConsoleIn?manager_name=@modules"))


def test_a_manager_that_stops_ends_a_trial_at_once(manager: Any, tree: Tree) -> None:
    path = write(manager, "Slow", HANGS["sleep"])
    answer = tree.begin([Load(path)], timeout_s=600.0)
    pid = pid_of(tree)
    while not slaves_of(pid):
        time.sleep(0.01)
    (trial,) = slaves_of(pid)
    pidfd = os.pidfd_open(trial)
    manager.ok("rtmgr stop")
    with pytest.raises(RtkitError):
        answer()[0].raise_for_error()
    os.close(pidfd)
    assert not Path(f"/proc/{trial}").exists()
