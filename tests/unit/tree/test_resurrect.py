"""Bringing a system up on the fake world: all of it, or nothing."""

import pytest
from fake_tree import fake_tree
from worlds import source_and_sink

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.creation import bring_up_plans
from rtkit.deployment.runner import PlanRunner
from rtkit.deployment.system import WantedComponent, WantedConnector, WantedSystem
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import PortType, ReturnCode
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef
from rtkit.tree.resurrect import resurrect

PORTS = {"Source": PortProfile("out", PortType.OUT), "Sink": PortProfile("in", PortType.IN)}


def wanted(kind, **told):
    return WantedComponent(
        f"RTC:Me:test:{kind}:1.0",
        f"{kind}0",
        f"localhost/{kind}0.rtc",
        f"/localhost/{kind}0.rtc",
        told.pop("required", True),
        (PORTS[kind],),
        {"default": {"gain": "2"}},
        "fast",
        create=told.pop("create", f"{kind}?manager_name={kind}&instance_name={kind}0"),
        **told,
    )


def system(source=None, sink=None, required=True):
    ends = (PortRef("Source0", "out"), PortRef("Sink0", "in"))
    wire = WantedConnector(ConnectorProfile("w", "w", ends), True, required)
    return WantedSystem((source or wanted("Source"), sink or wanted("Sink")), (wire,))


@pytest.fixture
def world():
    return source_and_sink(sets={"default": {"gain": "1"}, "fast": {"gain": "9"}})


@pytest.fixture
def bring_up(world):
    def run(what, **how):
        tree, talk = fake_tree(world), []
        before = tree.snapshot()
        runner = PlanRunner(tree, talk.append)
        resurrect(tree, what, before, runner, **how)
        return talk

    return run


def test_all_of_it(world, bring_up):
    assert bring_up(system()) == []
    assert set(world.connectors) == {"w"}
    assert world.components["Sink0"].sets["default"] == {"gain": "2"}
    assert world.components["Sink0"].active_set == "fast"


def test_a_dry_run_plans_just_what_is_carried_out(world, bring_up):
    plans = bring_up_plans(system(), fake_tree(world).snapshot())
    planned = [type(step.action) for plan in plans for step in plan.steps if step.action]
    bring_up(system())
    assert planned == [type(action) for action in world.performed]


def test_again_changes_nothing(world, bring_up):
    bring_up(system())
    world.performed.clear()
    bring_up(system())
    assert world.performed == []


def test_after_a_slave_was_killed_only_that_is_repaired(world, bring_up):
    bring_up(system())
    sound = world.components["Source0"]
    world.kill("Sink")
    world.performed.clear()
    bring_up(system())
    assert world.components["Source0"] is sound
    assert world.components["Sink0"].active_set == "fast"
    assert {type(action) for action in world.performed} == {
        act.Create,
        act.Connect,
        act.SetParameters,
        act.ActivateSet,
    }
    assert not any(getattr(a, "instance", "") == "Source0" for a in world.performed)


@pytest.mark.parametrize(
    ("what", "why"),
    [
        (system(sink=wanted("Sink", create="Nobody")), "component type Nobody is not known"),
        (system(sink=wanted("Sink", create="Source?instance_name=Sink0")), "ID of component at"),
        (system(source=wanted("Source", create="Sink?instance_name=Source0")), "ID of component"),
    ],
)
def test_nothing_is_left_of_a_failure(world, bring_up, what, why):
    before = world.snapshot()
    with pytest.raises(Refused, match=f"^Required action failed: .*{why}.*; removed again: "):
        bring_up(what)
    assert world.snapshot() == before


def test_what_is_missing_is_found_before_anything_changes(world, bring_up):
    with pytest.raises(Refused, match=r"Required component missing: /localhost/Sink0\.rtc"):
        bring_up(system(sink=wanted("Sink", create="")))
    assert world.performed == []


def test_a_connection_that_is_refused_takes_everything_back(world, bring_up):
    refusal = Result(ReturnCode.ERROR, "refused", "Wrong port type.")
    world.fault = lambda action: refusal if isinstance(action, act.Connect) else None
    before = world.snapshot()
    with pytest.raises(Refused, match=r"Wrong port type\.; removed again: Sink0, Source0"):
        bring_up(system())
    assert world.snapshot() == before


def test_optional_components_may_fail(world, bring_up):
    sink = wanted("Sink", create="Nobody", required=False)
    assert bring_up(system(sink=sink, required=False)) == [
        "Action failed: /localhost/Sink0.rtc: component type Nobody is not known",
        "Action failed: Destination component missing: /localhost/Sink0.rtc",
        "Action failed: Component missing: /localhost/Sink0.rtc",
    ]
    assert list(world.components) == ["Source0"]


def test_without_creation(world, bring_up):
    with pytest.raises(Refused, match=r"Required component missing: /localhost/Sink0\.rtc"):
        bring_up(system(), may_create=False)
    for kind in ("Source", "Sink"):
        world.perform(act.Create(f"{kind}?instance_name={kind}0"))
    bring_up(system(), may_create=False)
    assert set(world.connectors) == {"w"}


def test_unknown_hosts_are_named_before_anything_changes(world, bring_up):
    with pytest.raises(NotFound, match="no such host: far"):
        bring_up(system(sink=wanted("Sink", unknown_host="far")))
    assert world.performed == []


@pytest.mark.parametrize("kind", [act.Create, act.Connect, act.SetParameters, act.ActivateSet])
def test_an_interruption_leaves_nothing(world, bring_up, kind, monkeypatch):
    class Impatient(PlanRunner):
        def _send(self, actions):
            results = super()._send(actions)
            if any(isinstance(action, kind) for action in actions):
                raise KeyboardInterrupt
            return results

    monkeypatch.setitem(globals(), "PlanRunner", Impatient)
    before = world.snapshot()
    with pytest.raises(KeyboardInterrupt) as caught:
        bring_up(system())
    assert str(caught.value) == "removed again: Sink0, Source0"
    assert world.snapshot() == before
