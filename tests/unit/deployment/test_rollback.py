from rtkit.deployment import actions as act
from rtkit.deployment.traces import traces
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile, PortRef

WIRE = ConnectorProfile("w", "w", (PortRef("Source0", "out"), PortRef("Sink0", "in")))
SOURCE = act.Create("Source?instance_name=Source0&manager_name=a")
SINK = act.Create("Sink?instance_name=Sink0&manager_name=b")


def attempt(world, actions):
    """Perform, take back what was left, and return what that was."""
    before = world.snapshot()
    for action in actions:
        world.perform(action)
    left = traces(actions, before, world.snapshot())
    for trace in left:
        assert world.perform(trace.undo).ok
    return [trace.what for trace in left], before


def test_nothing_attempted_nothing_left(world):
    assert attempt(world, []) == ([], world.snapshot())


def test_what_was_made_goes_with_its_connections(world):
    what, before = attempt(world, [SOURCE, SINK, act.Connect(WIRE)])
    assert what == ["Sink0", "Source0"]
    assert world.snapshot() == before


def test_what_was_there_before_stays(world):
    world.batch([SOURCE, SINK, act.Connect(WIRE)])
    what, before = attempt(world, [SOURCE, SINK, act.Connect(WIRE)])
    assert what == []
    assert world.snapshot() == before


def test_connections_of_others_are_removed_alone(world):
    world.batch([SOURCE, SINK])
    what, before = attempt(world, [act.Connect(WIRE)])
    assert what == ["connection w"]
    assert world.snapshot() == before


def test_settings_are_put_back(world):
    world.batch([SOURCE, SINK])
    what, before = attempt(
        world,
        [
            act.SetParameters("Sink0", "default", {"gain": "5", "mode": "a"}),
            act.SetParameters("Sink0", "default", {"none": "5"}),
            act.ActivateSet("Source0", "fast"),
            act.ActivateSet("Sink0", "default"),
        ],
    )
    assert what == ["parameters gain of Sink0", "active set of Source0"]
    assert world.snapshot() == before


def test_a_set_that_was_added_is_removed_when_it_is_active_no_more(world):
    world.batch([SOURCE, SINK])
    what, before = attempt(
        world,
        [
            act.SetParameters("Sink0", "race", {"gain": "5"}, act.MISSING),
            act.ActivateSet("Sink0", "race"),
        ],
    )
    assert what == ["active set of Sink0", "set race of Sink0"]
    assert world.snapshot() == before


def test_what_failed_leaves_nothing(world):
    what, before = attempt(world, [act.Create("Nobody?instance_name=N0"), act.Connect(WIRE)])
    assert what == []
    assert world.snapshot() == before


def test_a_zombie_made_again_is_removed_and_one_that_stayed_is_not(world):
    world.batch([SOURCE, SINK])
    world.kill("a")
    assert attempt(world, [SOURCE])[0] == ["Source0"]
    assert world.snapshot().component("Source0") is None
    world.kill("b")
    world.fault = lambda action: act.Result() if action == SINK else None
    assert attempt(world, [SINK])[0] == []
    assert world.snapshot().component("Sink0").zombie


def test_modules_loaded_meanwhile_are_forgotten(world, make):
    world.modules["/m.py"] = (make.pattern("Late", "in", PortType.IN),)
    world.modules["/known.py"] = ()
    world.perform(act.Load("/known.py"))
    what, before = attempt(world, [act.Load("/m.py"), act.Load("/known.py"), act.Load("/no.py")])
    assert what == ["module /m.py"]
    assert world.snapshot() == before
