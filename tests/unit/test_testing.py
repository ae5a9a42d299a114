"""Components driven by hand: what `rtkit.testing` does for tests."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path
from typing import Protocol
from unittest.mock import Mock

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
    TimedShort,
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


def test_a_failure_at_a_manager_of_its_own_is_noted_with_what_lived():
    with pytest.raises(AssertionError) as caught, own_manager() as tree:  # noqa: PT012
        tree.create("ConsoleIn?instance_name=In0")
        assert tree.ls() == []
    status, log = caught.value.__notes__
    assert re.fullmatch(
        r"rtkit: status\nmanager manager, pid \d+: 1 components\n  /localhost/In0.rtc  Inactive",
        status,
    )
    assert log.startswith("rtkit: log\n[manager ")


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
    for method in (Trial.wait, Trial.run):
        with Trial(Scale) as trial, pytest.raises(Refused, match="clock=0"):
            method(trial, 1.0)


def test_a_trial_runs_for_a_time_that_does_not_really_pass():
    begin = time.monotonic()
    with Trial(Asker, clock=0.0) as trial:
        trial.provide("memory", Known())
        trial.activate()
        trial.run(3600.0)
        assert len(trial.received("out")) == 4 * 3600
    assert time.monotonic() - begin < 600.0


class Terse:
    def recall(self):
        return ""


class Lazy:
    async def recall(self, key):
        return key


class Broken:
    def recall(self, key):
        raise LookupError("forgotten")


@pytest.mark.parametrize(
    ("fake", "told"),
    [
        (
            Terse(),
            r"Asker0.memory: Terse.recall does not do as Memory.recall\(key\): "
            r"TypeError: too many positional arguments \(test_testing.py:\d+ in recall\)",
        ),
        (Lazy(), "Asker0.memory: Lazy.recall is a coroutine function"),
    ],
)
def test_a_fake_has_to_be_called_as_its_interface_says(fake, told):
    with Trial(Asker) as trial, pytest.raises(Refused, match=told):
        trial.provide("memory", fake)


def test_a_fake_may_be_a_mock():
    memory = Mock(recall=Mock(return_value="yes"))
    with Trial(Asker) as trial:
        trial.provide("memory", memory)
        trial.activate()
        trial.tick()
        assert trial.component.answer == "yes"
    memory.recall.assert_called_once_with("a")


class Provider(Component):
    """Provide what an `Asker` asks for."""

    memory = ServicePort.provided(Memory)

    def recall(self, key: str) -> str:
        return key * 2


def test_a_component_may_provide_for_another():
    with Trial(Provider) as other, Trial(Asker) as trial:
        trial.provide("memory", other.component)
        trial.activate()
        trial.tick()
        assert trial.component.answer == "aa"


def test_a_failure_names_the_place_in_the_fake_and_in_the_component():
    with Trial(Asker) as trial:
        trial.provide("memory", Broken())
        trial.activate()
        trial.tick()
        assert re.fullmatch(
            r"Asker0 is in Error: Refused: Asker0.memory: Memory.recall failed: LookupError: "
            r"forgotten \(test_testing.py:\d+ in recall\) \(test_testing.py:\d+ in on_execute\)",
            trial.trouble,
        )


class Nested(Component):
    """Fail below a callback."""

    def on_execute(self, context):
        self.work()

    def work(self):
        raise RuntimeError("no")


def test_a_test_that_fails_is_told_of_the_error_of_its_component():
    with pytest.raises(AssertionError) as caught, Trial(Nested) as trial:  # noqa: PT012
        trial.activate()
        trial.tick()
        assert trial.trouble == "", "as a test would look"
    (note,) = caught.value.__notes__
    begin = Nested.work.__code__.co_firstlineno
    where = f"test_testing.py:{begin + 1} in work, called by on_execute"
    assert note == f"Nested0 is in Error: RuntimeError: no ({where})"
    with pytest.raises(AssertionError) as caught, Trial(Scale) as trial:  # noqa: PT012
        trial.tick()
        assert trial.received("out") == [1]
    assert caught.value.__notes__ == ["Scale0 is Inactive"]
    with pytest.raises(AssertionError) as caught, Trial(Scale) as trial:  # noqa: PT012
        trial.activate()
        assert trial.received("out") == [1]
    assert not hasattr(caught.value, "__notes__")


def test_a_port_that_is_not_there_is_told_with_those_that_are():
    with Trial(Scale) as trial:
        with pytest.raises(NotFound, match=r"no in port inot, but into \(did you mean into\?\)"):
            trial.send("inot")
        with pytest.raises(NotFound, match="no port out that needs a service, but none"):
            trial.provide("out", 3)


def test_what_is_misspelt_is_told_with_what_is_meant():
    with Trial(Scale, {"conf.fast.factor": "9"}) as trial:
        with pytest.raises(NotFound, match=r"Scale0: .* fator \(did you mean factor\?\)"):
            trial.configure({"fator": 2})
        with pytest.raises(NotFound, match=r"Scale0: .* fats \(did you mean fast\?\)"):
            trial.configure({"factor": 2}, "fats")
        trial.configure({"factor": 3}, "fast")
        assert trial.component.factor == 3


def test_time_goes_on_only():
    for method in (Trial.wait, Trial.run):
        with Trial(Scale, clock=0.0) as trial, pytest.raises(Malformed, match="back: -1 s"):
            method(trial, -1.0)


def test_a_trial_is_of_a_class():
    with pytest.raises(TypeError, match="a class of components, not of 3"):
        Trial(3)


class Late(Component):
    """Make a port when it is made."""

    def on_initialize(self):
        self.add_in_port("late", TimedLong)


def test_a_wrong_value_names_the_line_of_the_port():
    lines = Path(__file__).read_text(encoding="utf-8").splitlines()
    with Trial(Scale) as trial, pytest.raises(Malformed) as caught:
        trial.send("into", "abc")
    declared = lines.index("    into = InPort(TimedLong)") + 1
    assert str(caught.value).endswith(f"(test_testing.py:{declared})")
    with Trial(Late) as trial, pytest.raises(Malformed) as caught:
        trial.send("late", "abc")
    assert str(caught.value).endswith(
        f"(test_testing.py:{lines.index('class Late(Component):') + 1})"
    )


@pytest.mark.parametrize("value", ["abc", 5, TimedLong(data=2**40), Time(1, 2), TimedShort(data=2)])
def test_what_is_sent_has_to_be_of_the_type_of_the_port(value):
    with Trial(Scale) as trial, pytest.raises(Malformed, match="Scale0:into: TimedLong"):
        trial.send("into", value)
