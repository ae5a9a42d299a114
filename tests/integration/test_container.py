"""A holder with real components in one process: what it answers, and that facts come before."""

from __future__ import annotations

import itertools
import queue
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rtkit.container.component_factory import ComponentFactory
from rtkit.container.container import ComponentContainer
from rtkit.container.port_wiring import PortWiring
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.link.local.streams import LocalStreams
from rtkit.modules.loader import Loader
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.rtc.serde import decode, encode

PATIENCE_S = 30.0
"""Bound on what comes soon [s]."""

MODULE = '''
import builtins
import threading
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong

LIVING = {}
CALLS = []


class Probe(Component):
    """Fails where its option says, with the exception that it names."""

    rate = 200.0
    into = InPort(TimedLong)
    out = OutPort(TimedLong)
    text = Parameter("")
    fail = ""
    error = "ValueError"

    def __init__(self, instance, options=None):
        super().__init__(instance, options)
        LIVING[instance] = self
        self.gate = threading.Event()
        self.values = []
        self.number = 0
        self.fail = self.options.get("fail", "")
        self.error = self.options.get("error", "ValueError")
        self.note("__init__")

    def note(self, name):
        CALLS.append((self.instance, name))
        if name == self.fail:
            raise getattr(builtins, self.error)("told to")

    def on_initialize(self):
        self.note("on_initialize")

    def on_finalize(self):
        self.note("on_finalize")

    def on_startup(self, context):
        self.note("on_startup")

    def on_shutdown(self, context):
        self.note("on_shutdown")

    def on_activated(self, context):
        self.note("on_activated")

    def on_deactivated(self, context):
        self.note("on_deactivated")

    def on_aborting(self, context):
        self.note("on_aborting")

    def on_error(self, context):
        if self.fail == "on_error":
            self.note("on_error")

    def on_reset(self, context):
        self.note("on_reset")

    def on_state_update(self, context):
        if self.fail in ("on_state_update",):
            self.note("on_state_update")

    def on_execute(self, context):
        if self.fail in ("on_execute", "on_aborting", "on_error", "on_reset"):
            CALLS.append((self.instance, "on_execute"))
            raise ValueError("needs an error")
        if "block" in self.options:
            self.gate.wait(30.0)
        if "source" in self.options:
            self.number += 1
            self.out.write(TimedLong(data=self.number))
        self.values += [value.data for value in self.into.read_all()]


def ProbeInit(manager):
    manager.register_factory(Probe)
'''


class Process:
    """A holder on a thread of its own, and the manager's side of it."""

    def __init__(self, folder: Path) -> None:
        (folder / "Probe.py").write_text(MODULE)
        self.heard: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        wires = PortWiring("host", LocalStreams(f"{folder}/data"))
        self.loader = Loader([str(folder)])
        self.container = ComponentContainer(self.heard.put, wires, ComponentFactory(self.loader))  # type: ignore[arg-type]
        self.facts: dict[str, ComponentFacts] = {}
        self.before: list[dict[str, Any]] = []
        self._numbers = itertools.count(1)
        self._thread = threading.Thread(target=self.container.run)
        self._thread.start()
        self.ok("load", path="Probe.py", init="")
        (self.module,) = [m for n, m in sys.modules.items() if n.endswith("Probe_py")][-1:]
        self.living = self.module.LIVING
        self.calls = self.module.CALLS

    def close(self) -> None:
        """End the holder; it finalises what it holds."""
        for component in self.living.values():
            component.gate.set()
        self.container.close()
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive()

    def hear(self) -> dict[str, Any]:
        """Take the next message, and keep facts."""
        message: dict[str, Any] = self.heard.get(timeout=PATIENCE_S)
        if "facts" in message:
            told = decode(ComponentFacts, message["facts"])
            self.facts[told.instance] = told
        elif "gone" in message:
            del self.facts[message["gone"]]
        return message

    def ask(self, op: str, **arguments: Any) -> int:
        """Send a request and return its number."""
        number = next(self._numbers)
        self.container.put({"op": op, "call": number, **arguments})
        return number

    def answer(self, number: int) -> dict[str, Any]:
        """Return the answer to a request; `before` has what was said before it."""
        self.before = []
        while (message := self.hear()).get("reply") != number:
            self.before.append(message)
        return message

    def call(self, op: str, **arguments: Any) -> dict[str, Any]:
        """Ask and wait."""
        return self.answer(self.ask(op, **arguments))

    def ok(self, op: str, **arguments: Any) -> Any:
        """Ask for what must succeed and return the value."""
        answer = self.call(op, **arguments)
        assert "kind" not in answer, answer
        return answer["value"]

    def create(self, instance: str, **options: str) -> None:
        """Make a component of type Probe."""
        text = "&".join(f"{k}={v}" for k, v in {"instance_name": instance, **options}.items())
        assert self.ok("create", create=f"Probe?{text}", pattern=None, modules=[]) == instance

    def change(self, instance: str, transition: str) -> dict[str, Any]:
        """Ask for a transition and return the answer."""
        return self.call(
            "change_state", instance=instance, context="0", transition=Transition(transition)
        )

    def until(self, instance: str, state: str) -> ComponentFacts:
        """Hear reports until a component is in that state."""
        while self.facts[instance].state != state:
            self.hear()
        return self.facts[instance]

    def connect(self, connector_id: str, **properties: str) -> ConnectorProfile:
        """Connect A.out with B.into."""
        ends = (PortRef("A", "out"), PortRef("B", "into"))
        named = {f"dataport.{key.replace('__', '.')}": text for key, text in properties.items()}
        wire = ConnectorProfile(connector_id, connector_id, ends, named)
        self.ok("link", connector=encode(wire))
        return wire


@pytest.fixture
def process() -> Iterator[Process]:
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        process = Process(Path(folder))
        try:
            yield process
        finally:
            process.close()


def test_facts_come_before_the_answer(process: Process) -> None:
    process.create("A")
    assert [list(message) for message in process.before] == [["facts"]]
    assert process.facts["A"].state == "Inactive"
    assert process.change("A", "activate")["value"] == ""
    assert process.facts["A"].state == "Active"
    process.ok("delete", instance="A")
    assert {"gone": "A"} in process.before
    assert process.facts == {}
    last = [name for instance, name in process.calls if instance == "A"]
    assert last[-3:] == ["on_deactivated", "on_shutdown", "on_finalize"]


@pytest.mark.parametrize("error", ["ValueError", "SystemExit", "KeyboardInterrupt", "MemoryError"])
@pytest.mark.parametrize("callback", ["__init__", "on_initialize"])
def test_a_failure_at_birth_makes_nothing(process: Process, callback: str, error: str) -> None:
    text = f"Probe?instance_name=A&fail={callback}&error={error}"
    answer = process.call("create", create=text, pattern=None, modules=[])
    assert answer["kind"] == "refused"
    assert f"{error}: told to (Probe.py:" in answer["why"]
    assert process.before == []
    assert process.call("delete", instance="A")["kind"] == "not-found"
    process.create("A")


@pytest.mark.parametrize("error", [ValueError, SystemExit, KeyboardInterrupt])
def test_whatever_is_raised_in_an_operation_does_not_end_the_process(
    process: Process, error: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error("on purpose")

    monkeypatch.setattr(ComponentFactory, "load", fail)
    answer = process.call("load", path="Any.py", init="AnyInit")
    assert (answer["kind"], answer["why"]) == ("error", f"{error.__name__}: on purpose")
    process.container.post(fail)
    process.create("A")


@pytest.mark.parametrize("error", ["ValueError", "SystemExit", "KeyboardInterrupt"])
@pytest.mark.parametrize(
    ("callback", "transitions", "state"),
    [
        ("on_startup", (), "Inactive"),
        ("on_activated", ("activate",), "Error"),
        ("on_execute", ("activate",), "Error"),
        ("on_state_update", ("activate",), "Error"),
        ("on_aborting", ("activate",), "Error"),
        ("on_error", ("activate",), "Error"),
        ("on_deactivated", ("activate", "deactivate"), "Inactive"),
        ("on_shutdown", ("activate",), "Active"),
        ("on_finalize", ("activate",), "Active"),
    ],
)
def test_a_failure_in_a_callback_harms_nobody_else(
    process: Process, callback: str, transitions: tuple[str, ...], state: str, error: str
) -> None:
    process.create("Other")
    process.change("Other", "activate")
    process.create("A", fail=callback, error=error)
    for transition in transitions:
        process.change("A", transition)
    facts = process.until("A", state)
    if state == "Error":
        assert "Probe.py:" in facts.cause
    process.ok("delete", instance="A")
    assert ("A", "on_finalize") in process.calls
    assert process.facts["Other"].state == "Active"
    assert process.change("Other", "deactivate")["value"] == ""


def test_a_reset_that_fails_stays_in_error(process: Process) -> None:
    process.create("A", fail="on_reset")
    process.change("A", "activate")
    process.until("A", "Error")
    answer = process.change("A", "reset")
    assert "on_reset failed: ValueError: told to" in answer["why"]
    assert process.facts["A"].state == "Error"


def test_what_a_state_does_not_allow_is_refused_with_its_code(process: Process) -> None:
    process.create("A")
    answer = process.change("A", "reset")
    assert answer["value"] == ""  # it is inactive already
    process.change("A", "activate")
    answer = process.change("A", "reset")
    assert (answer["code"], answer["kind"]) == ("PRECONDITION_NOT_MET", "refused")
    answer = process.call("change_state", instance="A", context="9", transition="activate")
    assert answer["kind"] == "not-found"
    assert process.call("nonsense")["kind"] == "malformed"


def test_settings_are_acknowledged_when_the_component_sees_them(process: Process) -> None:
    process.create("A", block="yes")
    component = process.living["A"]
    process.ok("set", instance="A", set_id="default", values={"text": "at rest"})
    assert component.text == "at rest"
    process.change("A", "activate")
    number = process.ask("set", instance="A", set_id="default", values={"text": "new"})
    process.create("B")  # the holder goes on while A is inside on_execute
    assert component.text == "at rest"
    component.gate.set()
    process.answer(number)
    assert component.text == "new"
    assert process.facts["A"].sets["default"]["text"] == "new"


def test_settings_of_one_that_is_deleted_are_answered(process: Process) -> None:
    process.create("A", block="yes")
    process.change("A", "activate")
    setting = process.ask("set", instance="A", set_id="default", values={"text": "x"})
    deleting = process.ask("delete", instance="A")
    process.living["A"].gate.set()
    answers = {}
    while len(answers) < 2:
        message = process.hear()
        answers[message.get("reply", 0)] = message
        answers.pop(0, None)
    assert set(answers) == {setting, deleting}


def test_two_deletions_at_once_are_both_answered(process: Process) -> None:
    process.create("A", block="yes")
    process.change("A", "activate")
    numbers = [process.ask("delete", instance="A") for _ in range(2)]
    process.living["A"].gate.set()
    for number in numbers:
        assert process.answer(number)["value"] == ""
    assert [call for call in process.calls if call == ("A", "on_finalize")] == [
        ("A", "on_finalize")
    ]


def test_wrong_settings_change_nothing(process: Process) -> None:
    process.create("A")
    wrong = {"text": "x", "no": "y"}
    assert process.call("set", instance="A", set_id="default", values=wrong)["kind"] == "not-found"
    assert process.call("set", instance="A", set_id="no", values={})["kind"] == "not-found"
    assert process.call("activate_set", instance="A", set_id="_x")["kind"] == "refused"
    assert process.living["A"].text == ""


# connectors inside one process


@pytest.fixture
def pair(process: Process) -> Process:
    process.create("A", source="yes")
    process.create("B")
    for instance in "BA":
        process.change(instance, "activate")
    return process


def received(process: Process, count: int) -> list[int]:
    """Return the first values that B got, when it has that many."""
    values: list[int] = process.living["B"].values
    pause = threading.Event()
    for _ in range(int(PATIENCE_S / 0.005)):
        if len(values) >= count:
            return values[:count]
        pause.wait(0.005)
    raise AssertionError(f"only {len(values)} values came")


def test_a_direct_connector_carries_every_value(pair: Process) -> None:
    pair.connect("w")
    values = received(pair, 20)
    assert values == list(range(values[0], values[0] + 20))


def test_a_periodic_connector_sends_at_its_own_rate(pair: Process) -> None:
    pair.connect(
        "w", subscription_type="periodic", publisher__push_rate="50", publisher__push_policy="all"
    )
    values = received(pair, 20)
    assert values == sorted(set(values))


def test_a_skipping_connector_sends_every_third(pair: Process) -> None:
    pair.connect("w", publisher__push_policy="skip", publisher__skip_count="2")
    values = received(pair, 10)
    assert {later - earlier for earlier, later in itertools.pairwise(values)} == {3}


def test_a_pull_connector_is_asked(pair: Process) -> None:
    pair.connect("w", dataflow_type="pull")
    values = received(pair, 10)
    assert values == sorted(set(values))


@pytest.mark.parametrize(
    "properties",
    [
        {},
        {"subscription_type": "periodic"},
        {"publisher__push_policy": "skip", "publisher__skip_count": "1"},
        {"dataflow_type": "pull"},
    ],
)
def test_parting_leaves_nothing_and_the_same_can_be_made_again(
    pair: Process, properties: dict[str, str]
) -> None:
    for _ in range(3):
        pair.connect("w", **properties)
        received(pair, 3)
        pair.ok("unlink", connector_id="w")
        for instance in "AB":
            assert all(not port.connectors for port in pair.living[instance].ports.values())
        pair.living["B"].values.clear()
    for thread in threading.enumerate():
        if thread.name.startswith("publish "):
            thread.join(PATIENCE_S)
            assert not thread.is_alive()
    assert pair.facts["A"].state == "Active"
    pair.ok("unlink", connector_id="never")


@pytest.mark.parametrize("dataflow", ["push", "pull"])
def test_a_connector_that_one_port_refuses_is_taken_off_the_other(
    pair: Process, dataflow: str
) -> None:
    limited = "fan_in" if dataflow == "pull" else "fan_out"
    port = pair.living["B" if dataflow == "pull" else "A"].ports[
        "into" if dataflow == "pull" else "out"
    ]
    port.properties[f"dataport.{limited}"] = "1"
    pair.connect("first", dataflow_type=dataflow)
    ends = (PortRef("A", "out"), PortRef("B", "into"))
    second = ConnectorProfile("second", "", ends, {"dataport.dataflow_type": dataflow})
    assert "no more than 1" in pair.call("link", connector=encode(second))["why"]
    for instance, name in (("A", "out"), ("B", "into")):
        assert pair.living[instance].ports[name].connectors == ("first",)


@pytest.mark.parametrize("deleted", ["A", "B"])
def test_deleting_an_end_parts_it(pair: Process, deleted: str) -> None:
    pair.connect("w")
    other = pair.living["A" if deleted == "B" else "B"]
    pair.ok("delete", instance=deleted)
    assert all(not port.connectors for port in other.ports.values())
    pair.create(deleted)
    pair.connect("w")


def test_wrong_ends(pair: Process) -> None:
    for ends, why in (
        ((PortRef("B", "into"), PortRef("A", "out")), "Wrong port type."),
        ((PortRef("A", "no"), PortRef("B", "into")), "Port not found: A.no"),
        ((PortRef("C", "out"), PortRef("B", "into")), "no component named C"),
    ):
        wire = encode(ConnectorProfile("w", "w", ends))
        assert pair.call("link", connector=wire)["why"] == why


# streams between two processes, here two holders


class Apart(NamedTuple):
    """A sends in one process, B receives in another."""

    sender: Process
    receiver: Process

    def offer(self) -> dict[str, Any]:
        """Open the receiving end; return what the sending one is to be told."""
        ends = (PortRef("A", "out"), PortRef("B", "into"))
        wire = encode(ConnectorProfile("w", "w", ends))
        return {"connector": wire, "endpoint": self.receiver.ok("sink", connector=wire)}

    def part(self) -> None:
        """Take the connector off both ends."""
        for process in self:
            process.ok("unlink", connector_id="w")

    @property
    def open_ends(self) -> list[tuple[str, ...]]:
        """The connectors of the two ports."""
        sender, receiver = self.sender.living["A"], self.receiver.living["B"]
        return [sender.ports["out"].connectors, receiver.ports["into"].connectors]


@pytest.fixture
def apart(process: Process) -> Iterator[Apart]:
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        receiver = Process(Path(folder))
        try:
            process.create("A", source="yes")
            receiver.create("B")
            process.change("A", "activate")
            receiver.change("B", "activate")
            yield Apart(process, receiver)
        finally:
            receiver.close()


def test_a_stream_is_opened_and_parted_many_times_while_its_sender_writes(apart: Apart) -> None:
    for _ in range(20):
        apart.sender.ok("source", **apart.offer())
        received(apart.receiver, 3)
        apart.part()
        assert apart.open_ends == [(), ()]
        apart.receiver.living["B"].values.clear()
    assert apart.sender.change("A", "deactivate")["value"] == ""
    assert apart.sender.facts["A"].cause == ""


def test_a_source_that_is_unlinked_while_it_is_being_opened(apart: Apart) -> None:
    number = apart.sender.ask("source", **apart.offer())
    apart.sender.ok("unlink", connector_id="w")
    before = [message.get("reply") for message in apart.sender.before]
    if number not in before:
        assert "removed while it was made" in apart.sender.answer(number)["why"]
    apart.receiver.ok("unlink", connector_id="w")
    assert apart.open_ends == [(), ()]
    apart.sender.ok("source", **apart.offer())
    received(apart.receiver, 5)


def test_a_source_whose_component_is_deleted_while_it_is_being_opened(apart: Apart) -> None:
    numbers = [
        apart.sender.ask("source", **apart.offer()),
        apart.sender.ask("delete", instance="A"),
    ]
    answers: dict[int, dict[str, Any]] = {}
    while len(answers) < len(numbers):
        message = apart.sender.hear()
        if message.get("reply") in numbers:
            answers[message["reply"]] = message
    assert "kind" not in answers[numbers[1]]
    apart.receiver.ok("unlink", connector_id="w")
    apart.sender.create("A", source="yes")
    apart.sender.change("A", "activate")
    apart.sender.ok("source", **apart.offer())
    received(apart.receiver, 3)


def test_a_receiver_that_does_not_exist(apart: Apart) -> None:
    wish = apart.offer()
    for endpoint in ("unixsock-stream//tmp/rt-none/x", "nonsense", "", 'a"b'):
        answer = apart.sender.call("source", **{**wish, "endpoint": endpoint})
        assert answer["kind"] == "unreachable", answer
    assert apart.open_ends[0] == ()
    apart.sender.ok("source", **wish)
    received(apart.receiver, 3)


def test_a_receiver_that_ends_leaves_its_sender_active(apart: Apart) -> None:
    apart.sender.ok("source", **apart.offer())
    received(apart.receiver, 3)
    apart.receiver.ok("delete", instance="B")
    apart.sender.ok("unlink", connector_id="w")
    assert apart.sender.change("A", "deactivate")["value"] == ""
    assert apart.sender.facts["A"].cause == ""


def test_a_silent_receiver_holds_up_nobody_else(apart: Apart) -> None:
    wish = apart.offer()
    ends = (PortRef("A", "out"), PortRef("B", "into"))
    other = encode(ConnectorProfile("silent", "silent", ends))
    with (
        tempfile.TemporaryDirectory(prefix="rt") as folder,
        socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener,
    ):
        endpoint = f"{folder}/silent"
        listener.bind(endpoint)
        listener.listen()
        number = apart.sender.ask("source", connector=other, endpoint=endpoint)
        apart.sender.ok("source", **wish)
        assert number not in [message.get("reply") for message in apart.sender.before]
        received(apart.receiver, 5)
        assert apart.sender.answer(number)["kind"] == "unreachable"
    assert apart.sender.living["A"].ports["out"].connectors == ("w",)


def metrics(process: Process) -> Any:
    """Ask for figures and return those of the first component."""
    process.container.put({"op": "metrics"})
    while "metrics" not in (message := process.hear()):
        pass
    return decode(ComponentMetrics, message["metrics"][0])


def test_what_a_component_does_is_counted(process: Process) -> None:
    process.create("A")
    (context,) = metrics(process).contexts
    assert (context.id, context.has_work, context.is_running, context.ticks) == (
        "0",
        False,
        True,
        0,
    )
    process.change("A", "activate")
    deadline = time.monotonic() + PATIENCE_S
    while not (told := metrics(process)).contexts[0].ticks:
        assert time.monotonic() < deadline
    (context,) = told.contexts
    assert context.has_work
    assert 0 < context.longest_s <= context.busy_s
    assert (set(told.written), set(told.read)) == ({"out"}, {"into"})
    process.change("A", "deactivate")
    while (context := metrics(process).contexts[0]).longest_s:
        assert time.monotonic() < deadline
    assert not context.has_work
    assert context.ticks >= told.contexts[0].ticks


def test_one_that_rests_is_deleted_without_a_thread(
    process: Process, monkeypatch: pytest.MonkeyPatch
) -> None:
    process.create("A")
    process.change("A", "activate")
    process.change("A", "deactivate")
    pacer = process.container._pacers["A", "0"]
    until = time.monotonic() + PATIENCE_S
    while not pacer.is_resting:
        assert time.monotonic() < until
    begun: list[str] = []
    monkeypatch.setattr(pacer, "_run", lambda: begun.append("A"))
    process.ok("delete", instance="A")
    assert begun == []
    last = [name for instance, name in process.calls if instance == "A"]
    assert last[-3:] == ["on_deactivated", "on_shutdown", "on_finalize"]
