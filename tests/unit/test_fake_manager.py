from fake_manager import FakeManager

from rtkit.deployment import actions as act
from rtkit.rtc.enums import LifeCycleState, PortType, Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef, TypeProfile

SOURCE = ComponentPattern(
    TypeProfile("Source", "rtkit", "test", "1.0"),
    (PortProfile("out", PortType.OUT),),
    {"default": {"gain": "1"}, "fast": {"gain": "2"}},
)
SINK = ComponentPattern(TypeProfile("Sink"), (PortProfile("in", PortType.IN),))
WIRE = ConnectorProfile("w", "w", (PortRef("Source0", "out"), PortRef("Sink0", "in")))


def wired() -> FakeManager:
    world = FakeManager([SOURCE, SINK])
    made = [
        act.Create("Source?manager_name=a&instance_name=Source0"),
        act.Create("Sink"),
        act.Connect(WIRE),
    ]
    assert all(result.ok for result in world.batch(made))
    return world


def test_create_places_names_and_numbers():
    world = wired()
    source, sink = world.components["Source0"], world.components["Sink0"]
    assert (source.process, sink.process) == ("a", "manager")
    assert source.names == ("localhost/Source0.rtc",)
    assert world.processes["a"].is_slave
    assert world.perform(act.Create("Sink")).value == "Sink1"


def test_create_of_one_that_lives_returns_it():
    world = wired()
    assert world.perform(act.Create("Source?instance_name=Source0")).value == "Source0"
    assert len(world.components) == 2


def test_create_refuses_unknown_types_and_taken_names():
    world = wired()
    assert world.perform(act.Create("Nobody")).kind == "not-found"
    assert world.perform(act.Create("RTC:other::Source::")).kind == "not-found"
    taken = world.perform(act.Create("Sink", ("localhost/Sink0.rtc",)))
    assert (taken.kind, taken.why) == ("refused", "name /localhost/Sink0.rtc is taken by Sink0")


def test_connect_same_twice_is_one_but_another_is_refused():
    world = wired()
    assert world.perform(act.Connect(WIRE)).ok
    other = ConnectorProfile("w", "w", WIRE.ports, {"dataport.dataflow_type": "pull"})
    assert "dataport.dataflow_type" in world.perform(act.Connect(other)).why
    turned = ConnectorProfile("v", "v", WIRE.ports[::-1])
    assert world.perform(act.Connect(turned)).why == "Wrong port type."
    assert list(world.connectors) == ["w"]


def test_set_is_all_or_none():
    world = wired()
    bad = act.SetParameters("Source0", "fast", {"gain": "3", "loss": "1"})
    assert world.perform(bad).why == "No such configuration parameter: loss"
    assert world.components["Source0"].sets["fast"] == {"gain": "2"}


def test_states_and_their_refusals():
    world = wired()
    activate = act.ChangeState("Source0", "0", Transition.ACTIVATE)
    assert world.perform(activate).ok
    assert world.perform(activate).ok
    reset = world.perform(act.ChangeState("Source0", "0", Transition.RESET))
    assert reset.why == "precondition not met (state is Active): Source0"
    world.set_state("Source0", LifeCycleState.ERROR)
    assert not world.perform(activate).ok
    assert not world.perform(act.ChangeState("Source0", "7", Transition.RESET)).ok


def test_kill_leaves_zombies_that_create_replaces():
    world = wired()
    world.kill("a")
    assert world.components["Source0"].zombie == "signal 9"
    assert not world.connectors
    assert world.perform(act.ActivateSet("Source0", "fast")).why == "zombie (signal 9): Source0"
    again = world.components["Source0"].create
    assert world.perform(act.Create(again)).ok
    assert not world.components["Source0"].zombie
    assert world.processes["a"].state == "up"


def test_delete_takes_connections_names_and_the_empty_slave():
    world = wired()
    assert world.perform(act.Delete("Source0")).ok
    assert not world.connectors
    assert list(world.processes) == ["manager"]
    assert world.perform(act.Delete("Source0")).kind == "not-found"


def test_modules_bring_types():
    world = FakeManager(modules={"/m/sink.py": [SINK]})
    assert not world.perform(act.Create("Sink")).ok
    assert world.perform(act.Load("/m/sink.py", "init")).ok
    assert world.perform(act.Create("Sink")).ok
    assert world.perform(act.Unload("/m/sink.py")).ok
    assert not world.perform(act.Unload("/m/sink.py")).ok


def test_contexts_of_the_fake_are_shared_and_driven_as_by_a_manager():
    world = wired()
    here = "Sink1"
    assert world.perform(act.Create("Sink")).value == here
    assert world.perform(act.Attach("Sink0", "0", "Source0")).kind == "refused"
    assert world.perform(act.Attach("Sink0", "0", here)).ok
    assert world.perform(act.Attach("Sink0", "0", here)).kind == "refused"
    assert world.components["Sink0"].contexts[0].participants == (here,)
    assert [c.id for c in world.components[here].contexts] == ["0", "Sink0/0"]
    assert world.perform(act.SetRate("Sink0", "0", 5.0)).ok
    assert world.components["Sink0"].contexts[0].rate == 5.0
    assert world.perform(act.SetRate("Sink0", "0", 0.0)).kind == "malformed"
    assert world.perform(act.Tick("Sink0", "0")).kind == "refused"
    assert world.perform(act.Detach("Sink0", "0", here)).ok
    assert [c.id for c in world.components[here].contexts] == ["0"]
    assert world.perform(act.Detach("Sink0", "0", here)).kind == "refused"


def test_state_machines_of_the_fake_are_changed_as_by_a_manager():
    world = wired()
    assert world.perform(act.SetStructure("Sink0", {"A": {}})).why == "Sink0 has no state machine"
    world.update("Sink0", fsm_states={"A": {"go": "A"}}, fsm_state="A")
    assert world.perform(act.SetStructure("Sink0", {"B": {"go": "B"}})).ok
    assert world.perform(act.SetEventProfiles("Sink0", {"go": "TimedLong"})).ok
    sink = world.components["Sink0"]
    assert (sink.fsm_state, sink.fsm_states, sink.fsm_events) == (
        "B",
        {"B": {"go": "B"}},
        {"go": "TimedLong"},
    )
