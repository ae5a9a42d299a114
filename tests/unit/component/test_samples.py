"""The sample components, driven by hand."""

from __future__ import annotations

import ast
import importlib.util
import itertools
import logging
from pathlib import Path

import pytest

from rtkit import component as public
from rtkit.component import OutPort, TimedLong
from rtkit.component.factory import Factories
from rtkit.component.services.invocation import Direct
from rtkit.component.values.codec import codec_for
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.profiles import ConnectorProfile

SAMPLES = Path(__file__).parents[3] / "examples" / "basic"
NAMES = [
    "ConfigSample",
    "ConsoleIn",
    "ConsoleOut",
    "Controller",
    "Doubler",
    "Microwave",
    "MicrowaveKeys",
    "Motor",
    "MyServiceConsumer",
    "MyServiceProvider",
    "Sensor",
    "SeqIn",
    "SeqOut",
]


def load(name):
    spec = importlib.util.spec_from_file_location(f"sample_{name}", SAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def factories():
    made = Factories()
    for name in NAMES:
        getattr(load(name), f"{name}Init")(made)
    return made


def make(factories, create):
    made = factories.make(parse_create(create))
    made.initialize()
    (context,) = made.contexts.values()
    return made, context


def connect(out, into, id="c"):
    out.attach(id, into.open(ConnectorProfile(id, id, ())))


def test_the_table_is_complete():
    assert sorted(path.stem for path in SAMPLES.glob("*.py")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_identity(factories, name):
    profile = factories.find(name)
    assert profile.id == f"RTC:rtkit:example:{name}:1.0"
    assert profile.description


@pytest.mark.parametrize("name", NAMES)
def test_only_public_names_are_imported(name):
    tree = ast.parse((SAMPLES / f"{name}.py").read_text())
    imported = {
        alias.name: node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module.startswith("rtkit")
        for alias in node.names
    }
    assert set(imported.values()) <= {"rtkit", "rtkit.component"}
    assert all(n == "component" or n in public.__all__ for n in imported)


def test_numbers_go_from_one_console_to_the_other(factories, caplog):
    source, source_context = make(factories, "ConsoleIn?conf.default.values=4,5,6")
    sink, sink_context = make(factories, "ConsoleOut")
    connect(source.ports["out"], sink.ports["in"])
    source_context.activate_component(source)
    sink_context.activate_component(sink)
    for _ in range(4):
        source_context.tick()
    with caplog.at_level(logging.INFO):
        sink_context.tick()
    assert [record.args[0] for record in caplog.records] == [4, 5, 6, 4]
    assert sink.last.data == 4


def test_a_source_without_values_writes_nothing(factories):
    source, context = make(factories, "ConsoleIn?conf.default.values=")
    context.activate_component(source)
    context.tick()
    assert source.out.written == 0
    assert context.state_of(source) is LifeCycleState.ACTIVE


def test_every_basic_type_goes_through_and_can_be_carried(factories):
    source, source_context = make(factories, "SeqOut?conf.default.length=3")
    sink, sink_context = make(factories, "SeqIn")
    assert list(source.ports) == list(sink.ports)
    for name, port in source.ports.items():
        connect(port, sink.ports[name])
    source_context.activate_component(source)
    sink_context.activate_component(sink)
    for _ in range(130):
        source_context.tick()
        sink_context.tick()
        for name, value in sink.last.items():
            codec = codec_for(sink.ports[name].data_type)
            assert codec.decode(codec.encode(value)) == value
    assert set(sink.last) == set(sink.ports)
    assert sink.last["LongSeq"].data == (1, 2, 3)
    assert source_context.state_of(source) is LifeCycleState.ACTIVE
    assert sink_context.state_of(sink) is LifeCycleState.ACTIVE


def test_parameters_of_every_kind_are_seen(factories, caplog):
    sample, context = make(factories, "ConfigSample")
    context.activate_component(sample)
    with caplog.at_level(logging.INFO):
        context.tick()
        assert len(caplog.records) == 8
        caplog.clear()
        sample.configuration.set("default", {"vector_param0": "1,2", "int_param0": "7"})
        sample.configuration.activate("default")
        context.tick()
        context.tick()
    assert [record.getMessage() for record in caplog.records] == [
        "int_param0 is 7",
        "vector_param0 is (1.0, 2.0)",
    ]


@pytest.fixture
def robot(factories):
    parts = {name: make(factories, name) for name in ("Sensor", "Controller", "Motor")}
    sensor, controller, motor = (parts[name][0] for name in parts)
    connect(sensor.distance, controller.distance)
    connect(controller.velocity, motor.velocity)
    connect(motor.pose, sensor.pose)
    for component, context in parts.values():
        context.activate_component(component)
    return parts


def drive(robot, seconds):
    for _ in range(seconds * 100):
        for _, context in robot.values():
            context.tick()


def test_the_robot_stops_in_front_of_the_wall(robot):
    poses = []
    robot["Motor"][0].pose.attach("poses", poses.append)
    drive(robot, 20)
    xs = [pose.data.position.x for pose in poses]
    assert xs == sorted(xs)
    assert 3.9 < xs[-1] < 4.0
    assert max(b - a for a, b in itertools.pairwise(xs)) <= 0.5 / 100 + 1e-9


def test_the_robot_stops_when_its_controller_does(robot):
    drive(robot, 1)
    controller, context = robot["Controller"]
    context.deactivate_component(controller)
    drive(robot, 1)
    poses = []
    robot["Motor"][0].pose.attach("poses", poses.append)
    drive(robot, 1)
    assert poses[0].data == poses[-1].data
    assert poses[0].data.position.x > 0


def test_the_motor_stops_when_nobody_tells_it(robot):
    drive(robot, 1)
    robot["Controller"][0].velocity.detach("c")
    drive(robot, 1)
    poses = []
    robot["Motor"][0].pose.attach("poses", poses.append)
    drive(robot, 1)
    assert poses[0].data == poses[-1].data


def test_a_service_is_used(factories):
    provider, _ = make(factories, "MyServiceProvider")
    consumer, context = make(factories, "MyServiceConsumer?conf.default.text=hi")
    context.activate_component(consumer)
    context.tick()
    assert consumer.echoed.written == 0
    wire = ConnectorProfile("s", "s", ())
    targets = {each.interface.name: Direct(each) for each in provider.myservice.served}
    consumer.myservice.attach(wire, targets)
    heard = []
    consumer.echoed.attach("heard", lambda value: heard.append(value.data))
    consumer.value.attach("heard", lambda value: heard.append(value.data))
    context.tick()
    context.tick()
    assert heard == ["hi 1", 1.0, "hi 2", 2.0]
    assert provider.get_echo_history() == ["hi 1", "hi 2"]
    assert provider.get_value_history() == [0.0, 1, 2]


def settle(context):
    while context.is_due:
        context.tick()


def test_what_arrives_is_doubled_at_once(factories):
    doubler, context = make(factories, "Doubler")
    heard = []
    doubler.out.attach("heard", heard.append)
    source = OutPort(TimedLong, "source")
    connect(source, doubler.in_)
    doubler.in_.renew("c")
    context.activate_component(doubler)
    settle(context)
    for number in (1, 2):
        source.write(TimedLong(data=number))
    settle(context)
    assert [value.data for value in heard] == [2, 4]


def oven(factories, keys):
    """Return the states that an oven comes to, and the minutes that it tells."""
    pressing, keys_context = make(factories, f"MicrowaveKeys?conf.default.keys={keys}")
    oven, context = make(factories, "Microwave")
    for name, port in pressing.ports.items():
        wire = ConnectorProfile(name, name, ())
        port.attach(name, oven.event_in.open(wire))
    minutes = []
    oven.left.attach("heard", lambda value: minutes.append(value.data))
    context.activate_component(oven)
    keys_context.activate_component(pressing)
    states = [oven.state]
    for _ in keys.split(","):
        keys_context.tick()
        context.stir()
        settle(context)
        states.append(oven.state)
    return [state.rpartition(".")[2] for state in states], minutes


def test_the_oven_cooks_for_as_long_as_was_asked(factories):
    states, minutes = oven(factories, "start,minute,minute,start,tick,tick,tick")
    assert states == [
        "Idle", "Idle", "Programmed", "Programmed", "Cooking", "Cooking", "Idle", "Idle",
    ]  # fmt: skip
    assert minutes == [1, 2, 2, 1, 0]


def test_the_oven_does_not_cook_with_an_open_door(factories):
    states, minutes = oven(factories, "minute,minute,start,open,tick,start,close,start,stop")
    assert states == [
        "Idle", "Programmed", "Programmed", "Cooking", "Disabled", "Disabled", "Disabled",
        "Programmed", "Cooking", "Idle",
    ]  # fmt: skip
    assert minutes == [1, 2, 2, 2, 2, 2, 0]
