import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.deviations import check_lines, deviations
from rtkit.deployment.drift import otherwise_made
from rtkit.deployment.layered_plan import merged
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.planning.model_builder import ModelBuilder, WantedDeployment
from rtkit.deployment.wiring import wiring_plan
from rtkit.fast_dataclass import replace
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.profiles import ConnectorProfile

ACTIVE = LifeCycleState.ACTIVE
INACTIVE = LifeCycleState.INACTIVE
LONG = "IDL:RTC/TimedLong:1.0"


@pytest.fixture
def system(make, world):
    system, _ = make.live(make.pair(), world)
    for plan in (creation_plan, wiring_plan):
        for action, _ in merged(plan(system, LiveIndex(world.snapshot(), system)).steps):
            assert world.perform(action).ok
    return system


def texts(system, world, state=INACTIVE):
    return [each.text for each in deviations(system, LiveIndex(world.snapshot(), system), state)]


def test_nothing_deviates(system, world):
    assert texts(system, world) == []


def test_states(system, world):
    world.perform(act.ChangeState("Source0", "0", Transition.ACTIVATE))
    assert texts(system, world, ACTIVE) == [
        "Component /localhost/Sink0.rtc is in incorrect state Inactive"
    ]
    world.set_state("Sink0", LifeCycleState.ERROR, "ValueError: x (a.py:3)")
    assert texts(system, world, ACTIVE) == [
        "Component /localhost/Sink0.rtc is in incorrect state Error (ValueError: x (a.py:3))"
    ]


def test_unknown_means_no_context_at_all(system, world):
    assert len(texts(system, world, None)) == 2
    world.update("Sink0", contexts=())
    assert texts(system, world, None) == [
        "Component /localhost/Source0.rtc is in incorrect state Inactive"
    ]
    assert texts(system, world) == ["Component /localhost/Sink0.rtc has no execution context 0"]


def test_connections(system, world):
    wire = world.connectors.pop("wire")
    stem = "No connection between /localhost/Source0.rtc:out and /localhost/Sink0.rtc:in"
    assert texts(system, world) == [stem]
    world.perform(act.Connect(ConnectorProfile("other", "w", wire.ports, wire.properties)))
    assert texts(system, world) == [f"{stem} with ID wire (there is other)"]


def test_properties_of_connections_compare_in_any_case(system, world):
    wire = world.connectors["wire"]
    told = {**wire.properties, "dataport.dataflow_type": "PUSH"}
    world.connectors["wire"] = ConnectorProfile("wire", "wire", wire.ports, told)
    assert texts(system, world) == []
    told["dataport.subscription_type"] = "flush"
    assert texts(system, world) == [
        "Property dataport.subscription_type of connection from /localhost/Source0.rtc:out to"
        " /localhost/Sink0.rtc:in is incorrect. (value: flush)"
    ]


def test_every_property_of_a_connection_is_compared(system, world):
    wire = world.connectors["wire"]
    key, others = "dataport.push_interval", dict(wire.properties)
    system.connectors[0].profile.properties[key] = "0.5"
    stem = f"Property {key} of connection from /localhost/Source0.rtc:out to"
    for found, marks in (("0.50", []), ("2", ["2"]), ("", [""])):
        present = {**others, key: found} if found else others
        world.connectors["wire"] = ConnectorProfile("wire", "wire", wire.ports, present)
        told = [f"{stem} /localhost/Sink0.rtc:in is incorrect. (value: {mark})" for mark in marks]
        assert texts(system, world) == told


def test_sets_and_parameters(system, world):
    world.perform(act.ActivateSet("Sink0", "default"))
    world.perform(act.SetParameters("Source0", "fast", {"gain": "8"}))
    assert texts(system, world) == [
        "Wrong configuration set is active on /localhost/Sink0.rtc (Active set: default)",
        "Configuration parameter gain in set fast on component /localhost/Source0.rtc"
        " is incorrect (value: 8)",
    ]


def test_missing_parameters(make, world):
    world.perform(act.Create("Sink?instance_name=Sink0"))
    sets = {"default": {"no": "1"}, "__widget__": {"gain": "text"}}
    system, _ = make.live(make.profile(make.component("Sink0", sets=sets)), world)
    assert texts(system, world) == [
        "Configuration parameter no in set default on component /localhost/Sink0.rtc is missing"
    ]


def test_missing_components_and_zombies_do_not_hide_the_rest(system, world):
    world.kill("slaveSink0")
    world.perform(act.SetParameters("Source0", "fast", {"gain": "8"}))
    assert texts(system, world) == [
        "Required component missing: /localhost/Sink0.rtc (zombie: signal 9)",
        "No connection between /localhost/Source0.rtc:out and /localhost/Sink0.rtc:in",
        "Configuration parameter gain in set fast on component /localhost/Source0.rtc"
        " is incorrect (value: 8)",
    ]


def test_a_stopped_component_is_not_taken_for_sound(system, world):
    world.update("Sink0", trouble="stopped")
    assert texts(system, world) == ["Component /localhost/Sink0.rtc does not answer (stopped)"]


def test_another_data_type_is_told(make, world, system):
    out = make.port("Source0.out", {"dataport.data_type": "Me::Other"})
    parts = [make.component("Source0", ports=(out,)), make.component("Sink0")]
    wished, live = make.live(make.profile(*parts), world)
    (found,) = [each for each in deviations(wished, live, INACTIVE) if each.kind == "type"]
    path = "/localhost/Source0.rtc"
    text = f"Data type of port out of component {path} is incorrect (value: {LONG})"
    assert (found.text, found.is_required) == (text, True)
    assert (found.path, found.wanted, found.found) == (path, "Me::Other", LONG)
    told = f"{path}: its data type of port out is {LONG}, not Me::Other"
    built = ModelBuilder(WantedDeployment(wished), live).run()
    for each in (built.notes, built.unmet):
        assert each == (f"{told}; only other code in its place changes that",)


def test_the_data_types_of_a_stand_in_are_made_again(make, world):
    _, live = make.live(make.profile(make.component("Source0")), world, stand_in=True)
    system, _ = make.live(make.profile(make.component("Source0")), world, stand_in=True)
    for action, _ in merged(creation_plan(system, live).steps):
        assert world.perform(action).ok
    out = make.port("Source0.out", {"dataport.data_type": LONG, "port.port_type": "DataOutPort"})
    first = make.component("Source0", ports=(out,))
    other = make.port("Source0.out", {"dataport.data_type": "Me::Other"})
    made = world.snapshot().component("Source0")
    assert made.is_stand_in
    wished, _ = make.live(make.profile(first), world, stand_in=True)
    facts = replace(made, ports=wished.components[0].ports)
    assert list(otherwise_made(wished.components[0], facts)) == []
    wished, _ = make.live(make.profile(replace(first, data_ports=(other,))), world, stand_in=True)
    (found,) = otherwise_made(wished.components[0], facts)
    assert found == ("data type of port out", "Me::Other", LONG)


def test_a_dry_run_lists_all_that_is_compared(make, world):
    out = make.port("Source0.out", {"dataport.data_type": "TimedLong"})
    told = {"rtkit.create": "Source?manager_name=s&x=1", "rtkit.restart": "always"}
    sets = {"__constraints__": {"gain": "0<=x<9"}}
    part = make.component("Source0", ports=(out,), properties=told, sets=sets)
    system, _ = make.live(make.profile(part), world)
    at = "component at path /localhost/Source0.rtc"
    assert list(check_lines(system, "Active"))[1:] == [
        f'Check {at} has port "out" of data type "TimedLong"',
        f'Check constraint of "gain" on {at} is "0<=x<9"',
        f"Check rate of execution context 0 of {at} is 1000",
        f'Check policy of {at} is "rtkit.restart=always"',
        f'Check create string of {at} is "Source?x=1"',
        f"Check {at} is in state Active in execution context 0",
    ]


def test_what_is_optional_is_marked(make, world):
    system, live = make.live(make.pair(required=False), world)
    found = list(deviations(system, live, ACTIVE))
    assert [each.kind for each in found] == ["component", "component", "connection"]
    assert not any(each.is_required for each in found)
    assert found[0].text == "Component missing: /localhost/Source0.rtc"


def test_dry_run(system):
    lines = list(check_lines(system, "Active"))
    source, sink = "/localhost/Source0.rtc", "/localhost/Sink0.rtc"
    assert lines[:3] == [
        'Check for required component "RTC:Me:test:Source:1.0", "Source0"'
        f" at path {source} (Required)",
        f'Check for required component "RTC:Me:test:Sink:1.0", "Sink0" at path {sink} (Required)',
        f"Check for connection from {source}:out to {sink}:in with ID wire (Required)",
    ]
    assert f'Check set "fast" is active on component at path {sink}' in lines
    assert f'Check parameter "gain" in set "fast" on component at path {sink} is "9"' in lines
    assert lines[-1] == f"Check component at path {sink} is in state Active in execution context 0"
