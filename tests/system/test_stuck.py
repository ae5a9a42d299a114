"""Callbacks that do not come back are named, with the line they are at."""

from __future__ import annotations

import re
import time
from typing import Any

import pytest

KEEPS_MANAGER = True

MANAGER = "/localhost/manager.mgr"
STUCK = '''
import ctypes
import re
import time
from rtkit.component import Component, ConnectorEvent, InPort, OutPort, Parameter, TimedLong


class Stuck(Component):
    """Does not come back."""

    rate = 100.0
    how = Parameter("")
    into = InPort(TimedLong)
    out = OutPort(TimedLong)

    def on_initialize(self):
        self.into.add_listener(ConnectorEvent.CONNECTED, self.on_connected)
        if self.options.get("when") == "initialize":
            time.sleep(60)
        if self.options.get("when") == "c_sleep":
            with open("slept", "w") as file:
                print(ctypes.CDLL(None).usleep(900_000), file=file)

    def on_connected(self, connector, value):
        if connector.name == "slow":
            time.sleep(60)

    def on_execute(self, context):
        if self.how == "sleep":
            time.sleep(1.5)  # sleep
        if self.how == "loop":
            while True:
                self.n = 1  # loop
        if self.how == "lock":
            re.match("(a+)+$", "a" * 40 + "b")  # lock


def StuckInit(manager):
    manager.register_factory(Stuck)
'''


@pytest.fixture
def stuck(manager: Any) -> Any:
    (manager.modules / "Stuck.py").write_text(STUCK)
    return manager


def line_of(shell: Any, instance: str, mark: str) -> str:
    """Wait until the listing tells that an instance is in trouble; return what it tells."""
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        for line in shell.ok("rtls -l /localhost").splitlines():
            if f" {instance}.rtc" in line and mark in line:
                return str(line)
    raise AssertionError(f"{instance} is not said to be {mark}{shell.log()}")


@pytest.mark.parametrize("how", ["sleep", "loop", "lock"])
def test_a_stuck_callback_is_named_with_its_line(stuck: Any, how: str) -> None:
    stuck.ok(
        f"rtmgr {MANAGER} -c 'Stuck?instance_name=S&manager_name=s&conf.default.how={how}"
        "&exec_cxt.callback_deadline=0.2'"
    )
    # Code that holds the interpreter lock keeps the slave from answering that it was activated.
    stuck.run("rtact --timeout 1 /localhost/S.rtc")
    told = line_of(stuck, "S", "Stuck.py:")
    found = re.search(r"\(stuck in on_execute since [\d:]{8} \(Stuck\.py:(\d+) in on_exec", told)
    assert found is not None, told
    line = STUCK.splitlines()[int(found[1]) - 1]
    assert f"# {how}" in line or (how == "loop" and "while True" in line), line


def test_a_callback_that_comes_back_is_no_longer_in_trouble(stuck: Any) -> None:
    stuck.ok(
        f"rtmgr {MANAGER} -c 'Stuck?instance_name=S&manager_name=s&conf.default.how=sleep"
        "&exec_cxt.callback_deadline=0.2'"
    )
    stuck.ok("rtact /localhost/S.rtc")
    line_of(stuck, "S", "stuck")
    stuck.ok("rtdeact /localhost/S.rtc")
    line_of(stuck, "S", "S.rtc")
    assert "stuck" not in stuck.ok("rtls -l /localhost")


def test_a_creation_that_does_not_end_says_where_it_is(stuck: Any) -> None:
    line = f"rtmgr {MANAGER} --timeout 2 -c 'Stuck?instance_name=S&manager_name=s&when=initialize'"
    status, out, err = stuck.run(line)
    assert (status, out) == (1, "")
    assert re.search(r"S is stuck in on_initialize since [\d:]{8} \(Stuck\.py:\d+ in on_init", err)
    assert "S.rtc" not in stuck.ok("rtls /localhost")


def test_a_listener_that_does_not_end_says_where_it_is(stuck: Any) -> None:
    stuck.ok(f"rtmgr {MANAGER} -c 'Stuck?instance_name=S&manager_name=s' -c Stuck")
    stuck.ok("rtcon -n quick /localhost/Stuck0.rtc:out /localhost/S.rtc:into")
    status, _, err = stuck.run(
        "rtcon --timeout 2 -n slow /localhost/Stuck0.rtc:out /localhost/S.rtc:into"
    )
    assert status == 1
    assert re.search(r"from s in time: S is stuck in listener since [\d:]{8} \(Stuck\.py:\d+", err)


def test_another_command_says_what_it_waited_for(stuck: Any) -> None:
    stuck.ok(f"rtmgr {MANAGER} -c 'Stuck?instance_name=S&manager_name=s&conf.default.how=loop'")
    stuck.ok("rtact /localhost/S.rtc")
    line_of(stuck, "S", "stuck")
    status, _, err = stuck.run("rtdeact --timeout 0.5 /localhost/S.rtc")
    assert status == 1
    assert "no answer from s in time: S is stuck in on_execute" in err


def test_who_is_asked_where_it_is_sleeps_on(stuck: Any) -> None:
    """A signal would end a sleep of C code, in the thread that makes components."""
    stuck.ok(f"rtmgr {MANAGER} -c 'Stuck?instance_name=S&manager_name=s'")
    create = "'Stuck?instance_name=T&manager_name=s&when=c_sleep'"
    status, _, err = stuck.run(f"rtmgr {MANAGER} --timeout 0.3 -c {create}")
    assert status == 1
    assert re.search(r"T is stuck in on_initialize since [\d:]{8} \(Stuck\.py:\d+ in on_init", err)
    file = stuck.folder / "slept"
    deadline = time.monotonic() + 10.0
    while not (told := file.read_text()):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert told == "0\n"
