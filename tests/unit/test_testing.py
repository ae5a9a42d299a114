"""Components driven by hand: what `rtkit.testing` does for tests."""

from __future__ import annotations

import os
import time
from typing import Protocol

import pytest

from rtkit.component import (
    Component,
    FsmComponent,
    InPort,
    OutPort,
    Parameter,
    ReturnCode,
    ServicePort,
    Time,
    TimedLong,
)
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.testing import Trial, own_manager


class Scale(Component):
    """Multiply."""

    execution_type = "ExtTrigExecutionContext"
    into = InPort(TimedLong)
    out = OutPort(TimedLong)
    factor = Parameter(2)

    def on_activated(self, context):
        if self.factor < 0:
            raise ValueError("negative")

    def on_execute(self, context):
        for value in self.into.read_all():
            if not value.data:
                return ReturnCode.ERROR
            self.out.write(TimedLong(value.tm, value.data * self.factor))
        return None


class Lamp(FsmComponent):
    """A lamp."""

    states = {"Off": {"on": "On"}, "On": {"off": "Off"}}  # noqa: RUF012 - as users write it
    events = {"on": TimedLong, "off": bytes}  # noqa: RUF012 - as users write it


def test_values_go_in_and_come_out():
    with Trial(Scale, {"conf.default.factor": "3"}) as trial:
        trial.activate()
        trial.send("into", TimedLong(data=1))
        trial.send("into", TimedLong(data=2))
        trial.tick()
        assert [value.data for value in trial.received("out")] == [3, 6]
        assert trial.received("out") == []
        trial.deactivate()
        assert trial.state == "Inactive"
    assert not trial.component.is_alive


def test_the_value_that_arrives_by_default_is_zero():
    with Trial(Scale) as trial:
        trial.activate()
        trial.send("into")
        trial.tick()
        assert trial.state == "Error"
        assert "RTC_ERROR" in trial.component.cause
        with pytest.raises(Refused, match="it is Error"):
            trial.activate()
        trial.reset()
        assert trial.state == "Inactive"


def test_a_component_that_cannot_be_activated_says_why():
    with (
        Trial(Scale, {"conf.default.factor": "-1"}) as trial,
        pytest.raises(Refused, match="ValueError: negative"),
    ):
        trial.activate()


def test_ports_have_to_be_there():
    with Trial(Scale) as trial:
        with pytest.raises(NotFound, match="Scale0 has no in port out"):
            trial.send("out")
        with pytest.raises(NotFound, match="Scale0 has no out port into"):
            trial.received("into")


def test_events_move_a_state_machine():
    with Trial(Lamp) as trial:
        trial.activate()
        trial.send("event", event="on")
        trial.tick()
        assert trial.component.state == "On"
        trial.send("event", b"", event="off")
        trial.tick()
        assert trial.component.state == "Off"
        with pytest.raises(Refused, match="no event dim"):
            trial.send("event", event="dim")


def test_a_manager_of_its_own_leaves_nothing_behind(tmp_path):
    (tmp_path / "Mine.py").write_text(
        "from rtkit.component import Component\n"
        "class Mine(Component):\n    pass\n"
        "def MineInit(manager):\n    manager.register_factory(Mine)\n"
    )
    before = dict(os.environ)
    with own_manager(tmp_path) as tree:
        base = os.path.dirname(os.environ["RTKIT_RUNTIME_DIR"])
        tree.load("Mine.py")
        assert tree.create("Mine?manager_name=other") == "/localhost/Mine0.rtc"
        assert tree.ls() == ["Mine0.rtc", "manager.mgr"]
    assert dict(os.environ) == before
    assert not os.path.exists(base)


class Memory(Protocol):
    def recall(self, key: str) -> str: ...


class Asker(Component):
    """Ask, and tell the time."""

    rate = 4.0
    memory = ServicePort.required(Memory)
    out = OutPort(TimedLong)
    key = Parameter("a", constraint="(a,b)")

    def on_activated(self, context):
        self.begin = time.monotonic()

    def on_execute(self, context):
        self.answer = self.memory.client.recall(self.key)
        time.sleep(0.05)
        self.out.write(TimedLong(Time.now(), round(1000 * (time.monotonic() - self.begin))))


class Known:
    def recall(self, key):
        return f"all of {key}"


def test_a_trial_provides_what_is_needed_and_changes_parameters():
    with Trial(Asker) as trial:
        trial.provide("memory", Known())
        trial.activate()
        trial.tick()
        assert trial.component.answer == "all of a"
        trial.configure({"key": "b"})
        trial.tick()
        assert trial.component.answer == "all of b"
        trial.provide("memory", type("Other", (), {"recall": lambda self, key: "none"})())
        trial.tick()
        assert trial.component.answer == "none"
        with pytest.raises(Malformed, match="key"):
            trial.configure({"key": "c"})
        with pytest.raises(NotFound, match="no port out that needs a service"):
            trial.provide("out", Known())
        with pytest.raises(Refused, match="int does not implement Memory: it lacks recall"):
            trial.provide("memory", 3)


def test_a_trial_has_a_time_of_its_own():
    with Trial(Asker, clock=100.0) as trial:
        trial.provide("memory", Known())
        trial.activate()
        trial.tick(2)
        trial.wait(1.0)
        trial.tick()
        values = trial.received("out")
        assert [value.data for value in values] == [50, 350, 1650]
        assert values[0].tm == Time(100, 50_000_000)
        assert time.time() > 1e9
    with Trial(Scale) as trial, pytest.raises(Refused, match="clock=0"):
        trial.wait(1.0)


@pytest.mark.parametrize("value", ["abc", 5, TimedLong(data=2**40), Time(1, 2)])
def test_what_is_sent_has_to_be_of_the_type_of_the_port(value):
    with Trial(Scale) as trial, pytest.raises(Malformed, match="Scale0:into: TimedLong"):
        trial.send("into", value)
