"""Settings of execution contexts on real threads, refusals of the system, missed periods."""

from __future__ import annotations

import json
import os
import resource
import threading
from pathlib import Path
from typing import Any

import browser
import pytest
from waiting import facts_of, slave_pid, told_pid, until
from webkit import served

from rtkit.deployment import actions as act
from rtkit.errors import RtkitError
from rtkit.rtc.enums import Transition
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
MODULE = """
import gc
import os
import sys
import threading
import time

from rtkit.component import Component, Parameter


class Told(Component):
    rate = 100.0

    def on_activated(self, context):
        self.is_told = False
        self.model = [1]

    def on_execute(self, context):
        if self.is_told:
            return
        self.is_told = True
        policies = []
        thread = threading.Thread(target=lambda: policies.append(os.sched_getscheduler(0)))
        thread.start()
        thread.join()
        with open(f"/proc/{threading.get_native_id()}/timerslack_ns") as file:
            slack = file.read().strip()
        words = (
            os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK,
            os.sched_getparam(0).sched_priority,
            policies[0] & ~os.SCHED_RESET_ON_FORK,
            gc.isenabled(),
            f"{sys.getswitchinterval():g}",
            slack,
            "looked-through" if any(self.model is each for each in gc.get_objects()) else "frozen",
        )
        fd = os.open(os.environ["RTKIT_STATE_DIR"] + "/diary", os.O_WRONLY)
        os.write(fd, (" ".join(map(str, words)) + "\\n").encode())
        os.close(fd)


class Sleeper(Component):
    rate = 1000.0
    at_first = Parameter(0.0)
    nap = Parameter(0.0)

    def on_activated(self, context):
        time.sleep(self.at_first)
        self.has_slept = False

    def on_execute(self, context):
        if self.nap and not self.has_slept:
            self.has_slept = True
            time.sleep(self.nap)


def ToldInit(manager):
    manager.register_factory(Told)
    manager.register_factory(Sleeper)
"""
_USUAL = "0 0 0 True"


def can_be_real_time() -> bool:
    """Return whether a thread of this user can have what the tests want of the system."""
    found = []

    def ask() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(7))
        except PermissionError:
            found.append("SCHED_RR")

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    return not found and (limit == resource.RLIM_INFINITY or os.geteuid() == 0)


is_real_time = pytest.mark.skipif(
    not can_be_real_time(), reason="this user has neither real-time priorities nor locked memory"
)


def load(manager: Any) -> None:
    (manager.modules / "Told.py").write_text(MODULE)
    manager.ok(f"rtmgr -l Told.py:ToldInit {MANAGER}")


def make(tree: Tree, instance: str, options: str = "", type_name: str = "Told") -> None:
    given = "&".join(filter(None, (f"instance_name={instance}&manager_name=s", options)))
    tree.perform(act.Create(f"{type_name}?{given}"))


def change(tree: Tree, instance: str, transition: Transition) -> None:
    tree.perform(act.ChangeState(instance, "0", transition))


def locked_kb(pid: int) -> int:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmLck:")))


@is_real_time
def test_settings_are_those_of_the_thread_and_end_with_it(
    tree: Tree, manager: Any, notes: Any
) -> None:
    load(manager)
    settings = "sched_policy=rr", "priority=7", "memory_lock=YES", "garbage_collector=off"
    make(tree, "A", "&".join(f"exec_cxt.{each}" for each in settings))
    make(tree, "B")
    change(tree, "A", Transition.ACTIVATE)
    assert notes.next(1) == [f"{os.SCHED_RR} 7 0 False 0.001 0 frozen"]
    pid = slave_pid(tree, "s")
    assert locked_kb(pid) > 0
    (context,) = facts_of(tree, "A").contexts
    assert context.trouble == ""
    assert context.properties["priority"] == "7"
    change(tree, "A", Transition.DEACTIVATE)
    until(lambda: locked_kb(pid) == 0, "the memory stays locked")
    change(tree, "B", Transition.ACTIVATE)
    assert notes.next(1) == [f"{_USUAL} 0.001 10000 looked-through"]


def test_settings_of_one_context_and_of_all(tree: Tree, manager: Any, notes: Any) -> None:
    load(manager)
    contexts = "execution_contexts=PeriodicExecutionContext(a)&ec.a.rate=1"
    make(tree, "A", f"{contexts}&exec_cxt.garbage_collector=off&ec.a.garbage_collector=frozen")
    tree.perform(act.ChangeState("A", "a", Transition.ACTIVATE))
    assert notes.next(1) == [f"{_USUAL} 0.005 50000 frozen"]
    (context,) = facts_of(tree, "A").contexts
    assert context.properties == {"garbage_collector": "frozen"}


@pytest.mark.parametrize(
    ("option", "why"),
    [
        ("exec_cxt.priority=100", "exec_cxt.priority: not a priority from 1 to 99: 100"),
        ("ec.a.priority=high", "ec.a.priority: not a priority from 1 to 99: high"),
        (
            "exec_cxt.sched_policy=fast",
            "exec_cxt.sched_policy: no scheduling policy: fast (one of other, fifo, rr)",
        ),
        ("exec_cxt.memory_lock=maybe", "exec_cxt.memory_lock: neither YES nor NO: maybe"),
        (
            "ec.a.garbage_collector=never",
            "ec.a.garbage_collector: no mode of the garbage collector: never"
            " (one of on, frozen, between, off)",
        ),
    ],
)
def test_nonsense_is_refused_by_name(manager: Any, option: str, why: str) -> None:
    load(manager)
    status, _, err = manager.run(f"rtmgr -c 'Told?{option}' {MANAGER}")
    assert (status, "Told0.rtc" in manager.ok("rtls /localhost")) == (1, False)
    assert why in err
    if option.startswith("exec_cxt."):
        status, _, err = manager.run(f"rtmgr -s {option} {MANAGER}")
        assert status == 1
        assert why.partition(": ")[2] in err


@pytest.fixture
def limited(shell: Any) -> Any:
    """A shell whose manager has neither the capabilities for it nor the limits, as most users."""
    limits = ["prlimit", "--rtprio=0", "--memlock=8388608"]
    as_root = ["setpriv", "--bounding-set=-sys_nice,-ipc_lock"] if os.geteuid() == 0 else []
    shell.prefix = [*limits, *as_root]
    shell.ok("rtmgr start")
    load(shell)
    return shell


@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_the_page_shows_what_is_missed_and_refused(limited: Any, tmp_path: Path) -> None:
    settings = "conf.default.nap=0.3&exec_cxt.priority=30"
    limited.ok(f"rtmgr -c 'Sleeper?manager_name=s&{settings}' {MANAGER}")
    limited.prefix = []
    folder = str(tmp_path.resolve())
    with served(limited) as client, browser.opened(folder, "", "") as page:
        page.picture("/dev/null", 1200, 800)
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        node = '.react-flow__node[data-id="/localhost/Sleeper0.rtc"]'
        page.wait_for(f"document.querySelector('{node}') !== null")
        limited.ok("rtact /localhost/Sleeper0.rtc")
        page.click(node)
        told = "document.querySelector('.contexts')?.textContent"
        page.wait_for(f"{told}?.includes('periods were missed.')")
        page.wait_for(f"{told}?.includes('It runs without sched_policy fifo, priority 30')")
        assert page.troubles() == []


def test_what_the_system_refuses_is_told(limited: Any) -> None:
    shell = limited
    settings = "exec_cxt.priority=30&exec_cxt.memory_lock=YES"
    shell.ok(f"rtmgr -c 'Told?manager_name=s&{settings}' {MANAGER}")
    until(lambda: "Trouble" in shell.ok("rtcat -l /localhost/Told0.rtc"), "no refusal is told")
    os.mkfifo(shell.folder / "state" / "diary")
    diary = os.open(shell.folder / "state" / "diary", os.O_RDWR)
    shell.ok("rtact /localhost/Told0.rtc")
    assert os.read(diary, 100).decode().startswith(_USUAL)
    os.close(diary)
    refused = (
        "sched_policy fifo, priority 30: Operation not permitted (RLIMIT_RTPRIO is 0);"
        " memory_lock: RLIMIT_MEMLOCK is 8192 kB, it has to be unlimited"
    )
    assert f"runs without {refused}" in shell.ok("rtcat -l /localhost/Told0.rtc")
    assert f"context 0 runs without {refused}" in shell.ok("rtstatus /localhost/Told0.rtc")
    assert refused in shell.ok("rtget /localhost/Told0.rtc.contexts.0.trouble")
    assert f"context 0 of Told0 runs without {refused}" in shell.log()
    found = map(json.loads, shell.ok("rtdoctor --json").splitlines())
    (finding,) = [each for each in found if refused in each["text"]]
    assert "rtprio 99" in finding["cure"]
    assert "memlock unlimited" in finding["cure"]
    assert locked_kb(told_pid(shell, "s")) == 0


def policies(pid: int) -> set[tuple[int, int]]:
    """Return scheduling policies and priorities of the threads of a process."""
    found = set()
    for thread in map(int, os.listdir(f"/proc/{pid}/task")):
        try:
            policy = os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK
            found.add((policy, os.sched_getparam(thread).sched_priority))
        except ProcessLookupError:
            continue
    return found


@is_real_time
def test_settings_change_while_it_runs(tree: Tree, manager: Any) -> None:
    load(manager)
    make(tree, "Z", "conf.default.nap=0", "Sleeper")
    change(tree, "Z", Transition.ACTIVATE)
    pid, path = slave_pid(tree, "s"), "/localhost/Z.rtc.contexts.0"
    for key, value, wanted in (
        ("priority", "7", (os.SCHED_FIFO, 7)),
        ("sched_policy", "rr", (os.SCHED_RR, 7)),
        ("priority", "''", (os.SCHED_RR, 1)),
        ("sched_policy", "''", None),
    ):
        manager.ok(f"rtset {path}.{key} {value}")
        others = {(os.SCHED_OTHER, 0)}
        expected = others | {wanted} if wanted else others
        until(lambda expected=expected: policies(pid) == expected, f"{key} is not {value}")  # type: ignore[misc]
    manager.ok(f"rtset {path}.memory_lock YES")
    until(lambda: locked_kb(pid), "the memory is not locked")
    facts = facts_of(tree, "Z")
    assert facts.contexts[0].properties == {"memory_lock": "YES"}
    assert "ec.0.memory_lock=YES" in facts.create
    status, _, err = manager.run(f"rtset {path}.priority 100")
    assert (status, "ec.0.priority: not a priority from 1 to 99: 100" in err) == (1, True)
    assert facts_of(tree, "Z").contexts[0].properties == {"memory_lock": "YES"}
    manager.ok("rtmgr restart")
    assert manager.ok(f"rtget {path}.memory_lock").strip() == "YES"
    until(lambda: locked_kb(told_pid(manager, "s")), "what was set is gone after a restart")


def test_missed_periods_are_counted_and_told(tree: Tree, manager: Any) -> None:
    load(manager)
    make(tree, "Z", "conf.default.nap=0.3", "Sleeper")
    change(tree, "Z", Transition.ACTIVATE)
    until(lambda: facts_of(tree, "Z").contexts[0].missed, "no period is told as missed")
    assert facts_of(tree, "Z").contexts[0].missed >= 299
    rows = manager.ok("rtcat -l /localhost/Z.rtc").splitlines()
    (row,) = [line.split() for line in rows if "Missed periods" in line]
    assert int(row[-1]) >= 299
    assert int(manager.ok("rtget /localhost/Z.rtc.contexts.0.missed")) >= 299
    assert "periods missed" in manager.ok("rtstatus /localhost/Z.rtc")
    until(lambda: "context 0 of Z missed" in manager.log(), "missed periods are not logged")


def test_no_period_is_missed_before_anything_is_active(tree: Tree, manager: Any) -> None:
    load(manager)
    make(tree, "Z", "conf.default.at_first=1", "Sleeper")
    change(tree, "Z", Transition.ACTIVATE)
    change(tree, "Z", Transition.DEACTIVATE)
    assert facts_of(tree, "Z").contexts[0].missed < 900


def test_one_that_misses_periods_is_not_well(tree: Tree, manager: Any) -> None:
    load(manager)
    with pytest.raises(RtkitError, match=r"rtkit\.health\.missed: not a number of 0 or more"):
        make(tree, "Z", "rtkit.health.missed=few:degrade", "Sleeper")
    make(tree, "Z", "rtkit.health.missed=50:degrade&conf.default.nap=2.5", "Sleeper")
    change(tree, "Z", Transition.ACTIVATE)
    until(
        lambda: "periods a second, above 50" in facts_of(tree, "Z").restart_status.degraded,
        "the rule is not broken",
    )


PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts"
  xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" rts:id="RTSystem:me:Told:1"
  rts:version="0.2">
  <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:::Told:"
    rts:pathUri="localhost/A.rtc" rts:instanceName="A" rts:isRequired="true"
    rtsExt:visible="true">
    <rtsExt:Properties rtsExt:name="rtkit.create" rtsExt:value="Told?manager_name=s"/>
    <rtsExt:Properties rtsExt:name="exec_cxt.garbage_collector" rtsExt:value="{mode}"/>
  </rts:Components>
</rts:RtsProfile>
"""


def test_a_profile_states_settings(tree: Tree, manager: Any) -> None:
    load(manager)
    profile = manager.folder / "told.xml"
    profile.write_text(PROFILE.format(mode="never"))
    status, _, err = manager.run(f"rtresurrect {profile}")
    why = "A: exec_cxt.garbage_collector: no mode of the garbage collector: never"
    assert (status, why in err) == (1, True), err
    profile.write_text(PROFILE.format(mode="off"))
    manager.ok(f"rtresurrect {profile}")
    (context,) = facts_of(tree, "A").contexts
    assert context.properties == {"garbage_collector": "off"}
    manager.ok(f"rtcheck {profile}")
