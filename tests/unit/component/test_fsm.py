"""Components with a state machine: which event a connector brings, what a move calls, changes."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest

from rtkit.component import FsmComponent, OutPort, State, TimedLong, TimedString, takes
from rtkit.component.describe import describe
from rtkit.component.ports.options import PortStatus
from rtkit.component.values.carried import passage
from rtkit.component.values.codec import codec_for
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, ReturnCode
from rtkit.rtc.profiles import ConnectorProfile, PortRef


class Door(FsmComponent):
    """A door that can be locked."""

    states: ClassVar = {
        "Open": {"close": "Shut"},
        "Shut.Free": {"lock": "Shut.Locked", "open": "Open"},
        "Shut.Locked": {"unlock": "Shut.Free", "kick": "Shut.Locked"},
    }
    events: ClassVar = {
        "open": TimedLong,
        "close": TimedLong,
        "lock": TimedString,
        "unlock": TimedString,
        "kick": bytes,
    }

    def __init__(self, instance, options=None):
        super().__init__(instance, options)
        self.notes = []
        self.fails = False

    def on_entry(self, state):
        self.notes.append(f"+{state}")

    def on_exit(self, state):
        self.notes.append(f"-{state}")

    def on_event(self, event, value):
        if event == "unlock" and value.data != "1234":
            return self.state
        if event == "lock" and value.data == "":
            return "Open"
        if self.fails:
            raise ValueError("jammed")
        return None

    def on_action(self, context):
        self.notes.append("!")


def wire(name="w", out="out", **properties):
    ends = (PortRef("Hand0", out), PortRef("Door0", "event"))
    named = {key.replace("__", "."): value for key, value in properties.items()}
    return ConnectorProfile(name, name, ends, named)


@pytest.fixture
def endpoint():
    endpoint = Door("Door0")
    endpoint.initialize()
    context = endpoint.contexts["0"]
    context.activate_component(endpoint)
    settle(context)
    endpoint.notes.clear()
    return endpoint


def settle(context):
    while context.is_due:
        context.tick()


def send(endpoint, event, value):
    port = endpoint.event_in
    port.open(wire(event, event))(value)
    port.close(event)
    settle(endpoint.contexts["0"])


def test_events_move_it(endpoint):
    send(endpoint, "close", TimedLong())
    assert endpoint.state == "Shut.Free"
    assert endpoint.notes == ["-Open", "+Shut", "+Shut.Free", "!"]
    endpoint.notes.clear()
    send(endpoint, "lock", TimedString(data="x"))
    assert endpoint.notes == ["-Shut.Free", "+Shut.Locked", "!"]


def test_it_is_event_driven_and_begins_at_activation(endpoint):
    context = endpoint.contexts["0"]
    assert context.kind is ExecutionKind.EVENT_DRIVEN
    send(endpoint, "close", TimedLong())
    endpoint.event_in.open(wire("open", "open"))(TimedLong())
    context.deactivate_component(endpoint)
    endpoint.notes.clear()
    context.activate_component(endpoint)
    settle(context)
    assert endpoint.state == "Open"
    assert endpoint.notes == ["+Open"]


def test_an_event_that_the_state_does_not_know_is_counted(endpoint):
    send(endpoint, "unlock", TimedString())
    assert (endpoint.state, endpoint.ignored, endpoint.notes) == ("Open", 1, [])


def test_on_event_may_stay_or_lead_elsewhere(endpoint):
    send(endpoint, "close", TimedLong())
    send(endpoint, "lock", TimedString(data="x"))
    endpoint.notes.clear()
    send(endpoint, "unlock", TimedString(data="0"))
    assert (endpoint.state, endpoint.notes) == ("Shut.Locked", [])
    send(endpoint, "unlock", TimedString(data="1234"))
    assert endpoint.state == "Shut.Free"
    endpoint.notes.clear()
    send(endpoint, "lock", TimedString(data=""))
    assert endpoint.notes == ["-Shut.Free", "-Shut", "+Open", "!"]


def test_a_state_that_leads_to_itself_is_left_and_entered(endpoint):
    send(endpoint, "close", TimedLong())
    send(endpoint, "lock", TimedString(data="x"))
    endpoint.notes.clear()
    send(endpoint, "kick", b"")
    assert endpoint.notes == ["-Shut.Locked", "+Shut.Locked", "!"]


def test_a_failure_leads_to_error_and_activation_begins_anew(endpoint):
    context = endpoint.contexts["0"]
    endpoint.fails = True
    send(endpoint, "close", TimedLong())
    assert context.state_of(endpoint) is LifeCycleState.ERROR
    assert "jammed" in endpoint.cause
    endpoint.fails = False
    context.reset_component(endpoint)
    context.activate_component(endpoint)
    assert endpoint.state == "Open"


def test_a_code_of_on_action_that_is_no_success_is_a_failure(endpoint):
    endpoint.on_action = lambda context: ReturnCode.ERROR
    send(endpoint, "close", TimedLong())
    assert "on_action returned RTC_ERROR" in endpoint.cause


def test_a_change_is_told_once_for_all_events_of_a_cycle(endpoint):
    context, told = endpoint.contexts["0"], []
    context.changed = told.append
    port = endpoint.event_in
    port.open(wire("close", "close"))(TimedLong())
    port.open(wire("lock", "lock"))(TimedString(data="x"))
    settle(context)
    assert endpoint.state == "Shut.Locked"
    assert told == [endpoint]


@pytest.mark.parametrize(
    ("connector", "event"),
    [
        (wire("open", "anything"), "open"),
        (wire("anything", "close"), "close"),
        (wire("open", "close"), "open"),
        (wire("open", "open", fsm_event_name="lock"), "lock"),
        (wire("x", "y", dataport__fsm_event_name="kick"), "kick"),
    ],
)
def test_the_event_that_a_connector_brings(endpoint, connector, event):
    assert endpoint.event_in.data_type_for(connector) is endpoint.events[event]
    write = endpoint.event_in.open(connector)
    write("value")
    assert endpoint.event_in.take() == (event, "value")


@pytest.mark.parametrize(
    ("connector", "why"),
    [
        (wire("x", "y"), r"say fsm_event_name=NAME \(events: open, close, lock, unlock, kick\)"),
        (wire("open", "open", fsm_event_name="sing"), "no event sing"),
        (
            wire("open", "open", dataport__data_type="RTC::TimedShort"),
            "event open carries RTC::TimedLong, not RTC::TimedShort",
        ),
    ],
)
def test_connectors_that_bring_no_event(endpoint, connector, why):
    with pytest.raises(Refused, match=why):
        endpoint.event_in.open(connector)
    assert endpoint.event_in.connectors == ()


def test_events_are_not_pulled(endpoint):
    with pytest.raises(Refused, match="pushed, not pulled"):
        endpoint.event_in.open_pull(wire("open", "open"), lambda: None)


def test_an_event_of_any_type_is_bytes(endpoint):
    kick = wire("kick", "kick")
    out = OutPort(TimedLong, "kick")
    sink = endpoint.event_in.open(kick)
    change = passage(out.data_type, endpoint.event_in.data_type_for(kick))
    out.attach("kick", lambda value: sink(change(value)))
    out.write(TimedLong(data=7))
    _, value = endpoint.event_in.take()
    assert codec_for(TimedLong).decode(value).data == 7


def test_a_flood_of_events_is_bounded():
    endpoint = Door("Door0")
    write = endpoint.event_in.open(wire("open", "open"))
    outcomes = [write(TimedLong()) for _ in range(1030)]
    assert outcomes.count(PortStatus.FULL) == 6
    assert len(endpoint.event_in.read_all()) == 1024
    assert endpoint.event_in.read() is None


def test_events_of_several_connectors_keep_their_order(endpoint):
    port = endpoint.event_in
    writes = {name: port.open(wire(name, name)) for name in ("open", "close")}
    order = ["open", "close", "close", "open", "open"]
    for name in order:
        writes[name](TimedLong())
    assert [port.take()[0] for _ in order] == order


def test_what_others_see(endpoint):
    send(endpoint, "close", TimedLong())
    told = describe(endpoint)
    assert told.fsm_state == "Shut.Free"
    assert list(told.fsm_states) == ["Open", "Shut", "Shut.Free", "Shut.Locked"]
    assert told.fsm_events == {
        "open": "RTC::TimedLong",
        "close": "RTC::TimedLong",
        "lock": "RTC::TimedString",
        "unlock": "RTC::TimedString",
        "kick": "Any",
    }
    (port,) = told.ports
    assert port.name == "event"
    assert port.properties["fsm.events"].startswith("open:RTC::TimedLong,close:RTC::TimedLong")


def test_other_events(endpoint):
    endpoint.set_events({"toggle": "TimedShort", "any": ""})
    assert describe(endpoint).fsm_events == {"toggle": "RTC::TimedShort", "any": "Any"}
    with pytest.raises(NotFound, match="event toggle: no data type TimedNothing"):
        endpoint.set_events({"toggle": "TimedNothing"})
    assert list(endpoint.event_in.events) == ["toggle", "any"]


def test_another_structure_keeps_the_state_where_it_can(endpoint):
    send(endpoint, "close", TimedLong())
    endpoint.set_structure({"Open": {}, "Shut.Free.Ajar": {"open": "Open"}})
    assert endpoint.state == "Shut.Free.Ajar"
    endpoint.set_structure({"New": {"open": "New"}})
    assert endpoint.state == "New"
    with pytest.raises(Malformed):
        endpoint.set_structure({})
    assert endpoint.machine.initial == "New"


def test_each_instance_has_events_and_queue_of_its_own():
    one, other = Door("A"), Door("B")
    one.set_events({"only": "TimedLong"})
    assert list(other.event_in.events) == list(Door.events)
    one.event_in.open(wire("only", "only"))(TimedLong())
    assert not other.event_in.is_new()


def test_an_event_that_no_state_knows_is_a_mistake():
    class Odd(FsmComponent):
        states: ClassVar = {"A": {"go": "A"}}
        events: ClassVar = {"go": TimedLong, "come": TimedLong}

    with pytest.raises(Malformed, match="no state knows event come"):
        Odd("Odd0")


class Waiting(State):
    def on_entry(self) -> None:
        self.component.notes.append("waits")

    def on_exit(self) -> None:
        self.component.notes.append("waits no more")

    @takes("go")
    def leave(self, value: Any) -> str | None:
        self.component.notes.append(f"go {value}")
        return {"off": "Off", "stay": "On.Waiting"}.get(value)


class On(State):
    @takes("halt")
    def halt(self, value: Any) -> str | None:
        self.component.notes.append("halt")


class Robot(FsmComponent):
    states: ClassVar = {
        "On.Waiting": {"go": "On.Working"},
        "On.Working": {"done": "On.Waiting"},
        "On": {"halt": "Off"},
        "Off": {},
    }
    state_classes: ClassVar = {"On.Waiting": Waiting, "On": On}

    def __init__(self, instance, options=None):
        self.notes = []
        super().__init__(instance, options)


@pytest.mark.parametrize(
    ("events", "state", "notes"),
    [
        ([("go", "")], "On.Working", ["waits", "go ", "waits no more"]),
        ([("go", "off")], "Off", ["waits", "go off", "waits no more"]),
        ([("go", "stay")], "On.Waiting", ["waits", "go stay"]),
        (
            [("go", ""), ("halt", "")],
            "Off",
            ["waits", "go ", "waits no more", "halt"],
        ),
        (
            [("go", ""), ("done", ""), ("halt", "")],
            "Off",
            ["waits", "go ", "waits no more", "waits", "halt", "waits no more"],
        ),
    ],
)
def test_the_class_of_a_state_does_what_is_done_in_it(events, state, notes):
    robot = Robot("R0")
    robot.on_activated("0")
    for event, value in events:
        robot._dispatch("0", event, value)
    assert (robot.state, robot.notes) == (state, notes)


@pytest.mark.parametrize(
    ("classes", "why"),
    [
        ({"Of": Waiting}, r"R0: Waiting is of no state Of \(did you mean Off\?\)"),
        ({"On": Waiting}, "R0: state On does not know event go"),
    ],
)
def test_classes_of_states_that_are_not_there_are_refused(classes, why):
    kind = type("Kind", (Robot,), {"state_classes": classes})
    with pytest.raises(Malformed, match=why):
        kind("R0")
