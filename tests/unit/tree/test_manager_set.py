"""Several managers as one tree: who is asked what, what is refused, what strangers there may be."""

from __future__ import annotations

from dataclasses import replace
from typing import NoReturn

import pytest
from fake_manager import FakeManager, meet
from fake_tree import fake_tree

from rtkit.deployment import actions as act
from rtkit.deployment.applying import Applier
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.multi_manager import down, homes_in, inward, outward
from rtkit.deployment.runner import PlanRunner
from rtkit.deployment.wanted import wanted
from rtkit.errors import Refused, Unreachable
from rtkit.manager.core import events as ev
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.enums import LifeCycleState, PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef, TypeProfile
from rtkit.tree import managers
from rtkit.tree.manager_set import ManagerSet, subscription_at
from rtkit.tree.resurrect import resurrect

NAMES = ("manager", "m1")
PORTS = (PortProfile("out", PortType.OUT), PortProfile("in", PortType.IN))
NODE = ComponentPattern(TypeProfile("Node"), PORTS, {"default": {"a": "0"}})
LOADED = ComponentPattern(TypeProfile("Guest"), PORTS, {"default": {}})
MODULE = "/m/guest.py:GuestInit"


def make_world(name: str) -> FakeManager:
    world = FakeManager([NODE], manager=name, modules={"/m/guest.py": [LOADED]})
    return world


def component(name: str, path: str, **told: str) -> rts.ComponentInstance:
    properties = tuple(ExtensionProperty(f"rtkit.{key}", value) for key, value in told.items())
    kind = told["create"].partition("?")[0]
    context = rts.OwnedContext("0", "PERIODIC", 10.0)
    return rts.ComponentInstance(
        f"RTC:::{kind}:", path, name, execution_contexts=(context,), properties=properties
    )


def profile(
    *components: rts.ComponentInstance, wires: tuple[tuple[str, str], ...] = ()
) -> rts.RtsProfile:
    date = "2025-01-01T00:00:00"
    joined = tuple(
        rts.DataPortConnector(
            f"{one}-{other}",
            "wire",
            "IDL:RTC/TimedLong:1.0",
            "corba_cdr",
            "push",
            rts.TargetPort("RTC:::Node:", one, f"{one}.out"),
            rts.TargetPort("RTC:::Node:", other, f"{other}.in"),
        )
        for one, other in wires
    )
    return rts.RtsProfile(
        "RTSystem:a:b:1", "0.2", date, date, components=components, data_port_connectors=joined
    )


HERE = component("Here", "localhost/Here.rtc", create="Node")
THERE = component("There", "localhost/m1.mgr/There.rtc", create="Node?manager_name=s")
GUEST = component("Guest0", "localhost/m1.mgr/Guest0.rtc", create="Guest", module=MODULE)


class Host:
    def __init__(self, told: rts.RtsProfile) -> None:
        self.worlds = {name: make_world(name) for name in NAMES}
        meet(self.worlds)
        self.system = wanted(told, "box", managers=["m1"])
        homes = {c.instance: c.manager or "manager" for c in self.system.components}
        self.fleet = ManagerSet(NAMES, {n: fake_tree(w) for n, w in self.worlds.items()}, homes)

    def resurrect(self) -> None:
        runner = PlanRunner(self.fleet, lambda _: None)
        resurrect(self.fleet, self.system, self.fleet.snapshot(), runner)

    def apply(self) -> None:
        before = self.fleet.snapshot()
        goal = DeploymentGoal(self.system)
        Applier(self.fleet, goal, lambda _: None, lambda _: None).run(goal.plan(before), before)


@pytest.mark.parametrize("way", [Host.resurrect, Host.apply])
def test_each_manager_is_asked_for_what_is_its_own_in_its_own_words(way) -> None:
    host = Host(profile(HERE, THERE, GUEST))
    way(host)
    assert homes_in(host.fleet.snapshot()) == {"Here": "manager", "There": "m1", "Guest0": "m1"}
    there = host.worlds["m1"]
    assert there.components["There"].names == ("localhost/There.rtc",)
    assert list(there.loaded) == ["/m/guest.py"]
    assert host.worlds["manager"].loaded == {}
    assert act.Load("/m/guest.py", "GuestInit") in there.performed
    shown = {c.instance: c.names for c in host.fleet.snapshot().components}
    assert shown["There"] == ("localhost/m1.mgr/There.rtc",)


def test_what_is_to_be_done_says_where() -> None:
    host = Host(profile(HERE, THERE, GUEST))
    plan = creation_plan(host.system, LiveIndex(host.fleet.snapshot(), host.system))
    assert [step.text.partition(" at path ")[2] or step.text for step in plan.steps] == [
        f'Load module "{MODULE}" on m1',
        "/localhost/Here.rtc in the manager",
        "/localhost/m1.mgr/There.rtc in slave s on m1",
        "/localhost/m1.mgr/Guest0.rtc in manager m1",
    ]


def test_what_was_made_is_taken_back_where_it_was_made() -> None:
    host = Host(profile(HERE, GUEST, wires=(("Here", "Here"),)))
    here = host.worlds["manager"]
    here.fault = lambda action: (
        act.Result(act.ReturnCode.ERROR, "refused", "no") if type(action) is act.Connect else None
    )
    with pytest.raises(Refused, match=r"removed again: Guest0, Here, module /m/guest\.py"):
        host.resurrect()
    assert [world.components for world in host.worlds.values()] == [{}, {}]
    assert host.worlds["m1"].loaded == {}


@pytest.mark.parametrize("way", [Host.resurrect, Host.apply])
def test_a_connection_between_two_managers_is_one_of_the_system(way) -> None:
    host = Host(profile(HERE, THERE, wires=(("Here", "There"),)))
    way(host)
    ends = (PortRef("Here", "out"), PortRef("There", "in"))
    (wire,) = host.fleet.snapshot().connectors
    assert wire.ports == ends
    assert {
        name: [str(end) for end in w.connectors[wire.connector_id].ports]
        for name, w in host.worlds.items()
    } == {
        "manager": ["Here.out", "m1.mgr/There.in"],
        "m1": ["manager.mgr/Here.out", "There.in"],
    }
    left = DeploymentGoal(host.system).plan(host.fleet.snapshot()).moves
    assert {move.kind for move in left} <= {"activate"}
    assert host.fleet.apply([act.Disconnect(wire.connector_id)])[0].ok
    assert not any(world.connectors for world in host.worlds.values())


def test_half_a_connection_is_none_for_a_plan() -> None:
    host = Host(profile(HERE, THERE, wires=(("Here", "There"),)))
    host.apply()
    shell = host.worlds["manager"].shell
    shell.feed(ev.PeerLost("m1", "it ended"))
    assert host.fleet.snapshot().connectors == ()
    shell.feed(ev.PeerFound("m1"))
    host.worlds["manager"].serve()
    assert len(host.fleet.snapshot().connectors) == 1


def test_strangers_of_the_same_name_are_told_and_left_alone() -> None:
    host = Host(profile(HERE, THERE))
    here = host.worlds["manager"]
    assert here.perform(act.Create("Node?instance_name=There")).ok
    # Whether it is to move nobody knows: it is not made a second time.
    with pytest.raises(Refused, match="There is in manager manager, and stays there"):
        host.resurrect()
    assert host.worlds["m1"].components == {}
    assert host.worlds["m1"].perform(act.Create("Node?instance_name=There")).ok
    host.apply()
    assert here.components["There"].state == "Inactive"
    assert host.worlds["m1"].components["There"].state == "Active"


def test_results_come_in_the_order_of_the_actions_and_end_at_a_failure() -> None:
    host = Host(profile(HERE, THERE))
    create = [act.Create(f"Node?instance_name={name}") for name in ("There", "Here", "Other")]
    made = host.fleet.apply(create, is_ordered=False)
    assert [result.value for result in made] == ["There", "Here", "Other"]
    results = host.fleet.apply([act.Delete("Here"), act.Delete("Here"), act.Delete("There")])
    assert [result.ok for result in results] == [True, False]
    assert "There" in host.worlds["m1"].components


def test_what_all_tell_is_heard() -> None:
    host = Host(profile(HERE, THERE))
    with subscription_at(host.fleet) as subscription:
        host.worlds["m1"].perform(act.Create("Node?instance_name=There"))
        host.worlds["manager"].perform(act.Create("Node?instance_name=Here"))
        while len(subscription.facts.components) < 2:
            assert subscription.wait()
        assert homes_in(subscription.facts) == {"Here": "manager", "There": "m1"}


def test_one_that_does_not_run_holds_nothing() -> None:
    host = Host(profile(HERE, THERE))
    fleet = ManagerSet(NAMES, {"m1": host.fleet.trees["m1"]}, host.fleet.homes)
    assert [each.pid > 0 for each in (fleet.snapshot(), *fleet.snapshot().others)] == [False, True]
    plan = DeploymentGoal(host.system).plan(fleet.snapshot())
    assert [move.text for move in plan.moves][:2] == [
        "start manager manager",
        "create Here on manager",
    ]
    # The others do their part before it is told that one did not.
    create = [act.Create(f"Node?instance_name={name}") for name in ("Here", "There")]
    for is_ordered in (True, False):
        with pytest.raises(Unreachable, match="manager 'manager' is not running"):
            fleet.apply(create, is_ordered=is_ordered)
        assert ("There" in host.worlds["m1"].components) is not is_ordered


def test_of_a_batch_that_failed_it_is_told_what_was_done() -> None:
    host = Host(profile(HERE, THERE))
    host.worlds["m1"].fault = lambda _: act.Result(act.ReturnCode.ERROR, "refused", "no luck")
    before = host.fleet.snapshot()
    done: list[str] = []
    applier = Applier(host.fleet, goal := DeploymentGoal(host.system), lambda _: None, done.append)
    with pytest.raises(Refused, match="no luck; 5 steps left"):
        applier.run(goal.plan(before), before)
    assert done == ["[1/3] create Here on manager"]


def test_the_way_back_leaves_out_what_was_in_a_manager_that_ended() -> None:
    host = Host(profile(HERE, THERE))
    host.apply()
    before = host.fleet.snapshot()
    there = host.worlds["m1"]

    def end(_action: act.Action) -> NoReturn:
        there.gone = "m1 ended"
        raise Unreachable(there.gone)

    there.fault = end
    host.fleet.trees["m1"].has_ended = lambda: True
    goal = DeploymentGoal(host.system, LifeCycleState.INACTIVE)
    applier = Applier(host.fleet, goal, lambda _: None, lambda _: None)
    with pytest.raises(
        Unreachable, match="before, but for what was in manager m1, which has ended"
    ):
        applier.run(goal.plan(before), before, rolls_back=True)
    here = host.worlds["manager"]
    assert here.components["Here"].state == "Active"
    assert [a.transition.value for a in here.performed[-2:] if type(a) is act.ChangeState] == [
        "deactivate",
        "activate",
    ]


class Starting(Host):
    """A host of which only the first manager runs; the other one is started when asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        super().__init__(profile(HERE, THERE))
        self.stopped: list[str] = []
        monkeypatch.setattr(managers, "stop", lambda name, _timeout_s: self.stopped.append(name))
        trees = {"manager": self.fleet.trees["manager"]}
        self.fleet = ManagerSet(
            NAMES, trees, self.fleet.homes, lambda name: fake_tree(self.worlds[name])
        )
        self.told: list[str] = []

    def attempt(self, *, is_exact: bool = False) -> str:
        before = self.fleet.snapshot()
        goal = DeploymentGoal(self.system)
        applier = Applier(self.fleet, goal, self.told.append, self.told.append)
        try:
            applier.run(goal.plan(before), before, rolls_back=True, is_exact=is_exact)
        except Refused as error:
            return str(error)
        return ""


def failing(action: act.Action) -> act.Result | None:
    is_start = isinstance(action, act.ChangeState) and action.transition == "activate"
    return act.Result(act.ReturnCode.ERROR, "refused", "no luck") if is_start else None


def test_a_manager_that_does_not_run_is_started_and_what_it_brings_back_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    host = Starting(monkeypatch)
    assert host.attempt() == ""
    assert host.told[0] == "[1/4] start manager m1"
    assert host.worlds["m1"].components["There"].state == "Active"

    host = Starting(monkeypatch)
    create = "Node?instance_name=There&manager_name=s"
    host.worlds["m1"].perform(act.Create(create, ("localhost/There.rtc",)))
    host.worlds["manager"].fault = host.worlds["m1"].fault = failing
    assert host.attempt().endswith("everything is as it was before, but manager m1 runs")
    why = "not as planned: a manager came back with what it kept"
    assert f"{why}; planning anew from what is" in host.told
    assert list(host.worlds["m1"].components) == ["There"]
    assert (host.worlds["manager"].components, host.stopped) == ({}, [])
    trees = {"manager": host.fleet.trees["manager"]}
    start = {name: fake_tree(world) for name, world in host.worlds.items()}
    host.fleet = ManagerSet(NAMES, trees, host.fleet.homes, start.__getitem__)
    assert host.attempt(is_exact=True).startswith(f"{why}; the rest of the saved plan is left; ")


def test_a_manager_that_was_started_is_ended_on_the_way_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    host = Starting(monkeypatch)
    host.worlds["m1"].fault = failing
    assert host.attempt().endswith("; everything is as it was before")
    assert host.stopped == ["m1"]
    assert list(host.fleet.trees) == ["manager"]


def test_a_manager_that_cannot_be_started_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    host = Starting(monkeypatch)

    def start(_name: str) -> NoReturn:
        raise Refused("no memory")

    host.fleet = ManagerSet(NAMES, host.fleet.trees, host.fleet.homes, start)
    assert host.attempt() == "start manager m1: no memory; everything is as it was before"
    host.fleet = ManagerSet(NAMES, host.fleet.trees, host.fleet.homes)
    assert "m1 does not run; start it with: rtmgr start m1" in host.attempt()


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("localhost/A.rtc", "localhost/m1.mgr/A.rtc"),
        ("localhost/dir/A.rtc", "localhost/m1.mgr/dir/A.rtc"),
        ("box/A.rtc", "box/A.rtc"),
    ],
)
def test_names_of_another_manager_are_shown_below_it(name: str, shown: str) -> None:
    assert outward(name, "m1") == shown
    assert outward(shown, "m1") == shown
    assert inward(shown, "m1") == name
    assert inward(name, "m2") == name


def test_facts_of_one_manager_stay_as_they_are() -> None:
    host = Host(profile(HERE))
    tree = host.fleet.trees["manager"]
    one = ManagerSet(NAMES[:1], {"manager": tree}, {})
    assert one.snapshot() == tree.snapshot()
    assert replace(one.snapshot(), pid=1).others == ()


def test_a_connector_of_two_other_hosts_is_whole_where_no_manager_here_is_asked() -> None:
    ends = {"robot1": ("A", "robot2/manager.mgr/B"), "robot2": ("robot1/manager.mgr/A", "B")}
    trees, told = {}, []
    for host, (out, into) in ends.items():
        wire = ConnectorProfile("w", "w", (PortRef(out, "out"), PortRef(into, "in")), {})
        world = make_world("manager")
        world.perform(act.Create(f"Node?instance_name={'A' if host == 'robot1' else 'B'}"))
        told.append(replace(world.snapshot(), host=host, connectors=(wire,)))
        trees[f"manager@{host}"] = fake_tree(world)
        trees[f"manager@{host}"].host = host
    here = down("laptop", "manager")
    (wire,) = ManagerSet(["manager", *trees], trees, {}).joined([here, *told]).connectors
    assert wire.ports == (PortRef("A", "out"), PortRef("B", "in"))
