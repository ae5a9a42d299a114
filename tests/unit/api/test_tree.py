"""The methods by which scripts do what commands do to a system."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from fake_manager import FakeManager
from fake_tree import tree_of
from worlds import made

import rtkit
from rtkit.api.data_tree import DataTree
from rtkit.api.tree import Tree
from rtkit.deployment import actions as act
from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused
from rtkit.rtc.enums import LifeCycleState, PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile

LONG = {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}
A, B = "/localhost/A.rtc", "/localhost/B.rtc"


@pytest.fixture
def world() -> FakeManager:
    ports = (PortProfile("in", PortType.IN, LONG), PortProfile("out", PortType.OUT, LONG))
    pattern = ComponentPattern(TypeProfile("Std"), ports, {"default": {"gain": "1"}})
    return made(FakeManager([pattern]), *(f"Std?instance_name={name}" for name in "AB"))


@pytest.fixture
def tree(world: FakeManager, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    with tree_of(Tree, world) as tree:
        yield tree


@pytest.fixture
def robot(tree: Tree, tmp_path: Path) -> Path:
    tree.connect(f"{A}:out", f"{B}:in", "wire")
    path = tmp_path / "robot.xml"
    tree.save("Robot", vendor="Us").write(path)
    return path


def states(world: FakeManager) -> dict[str, LifeCycleState]:
    return {name: each.state for name, each in world.components.items()}


def test_what_lives_is_saved_written_and_loaded(robot: Path) -> None:
    profile = rtkit.load(robot)
    assert profile.components == ["A", "B"]
    assert profile.profile.id == "RTSystem:Us:Robot:0"
    profile.write(robot.with_suffix(".yaml"))
    assert rtkit.load(robot.with_suffix(".yaml")).profile == profile.profile
    assert rtkit.load(profile) is profile


def test_a_profile_is_validated_and_checked_without_a_manager(robot: Path) -> None:
    profile = rtkit.load(str(robot))
    assert profile.validate().is_valid
    assert {each.rule for each in profile.check().findings} == {"no-profile"}
    robot.write_text("<no/>")
    with pytest.raises(InvalidDocument, match=r"robot\.xml"):
        rtkit.load(robot)
    with pytest.raises(NotFound, match=r"nowhere\.xml"):
        rtkit.load("nowhere.xml")


def test_a_plan_is_looked_at_and_then_carried_out(
    tree: Tree, world: FakeManager, robot: Path
) -> None:
    told: list[str] = []
    tree.notify = told.append
    plan = tree.plan(robot)
    assert plan
    assert (len(plan), sorted(plan.steps)) == (2, ["activate A", "activate B"])
    assert str(plan).startswith("plan: 2 steps, cost 2")
    assert plan.as_dict()["cost"] == plan.cost == 2
    assert plan.dot().startswith("digraph")
    assert set(states(world).values()) == {LifeCycleState.INACTIVE}, "nothing is done yet"
    plan.apply()
    assert set(states(world).values()) == {LifeCycleState.ACTIVE}
    assert sorted(told) == ["[1/1] activate A", "[1/1] activate B"]
    assert not tree.plan(robot)
    assert tree.check(robot)


def test_a_plan_that_is_exact_does_nothing_else(
    tree: Tree, world: FakeManager, robot: Path
) -> None:
    plan = tree.plan(robot)
    world.perform(act.Delete("A"))
    with pytest.raises(Refused, match="not as planned"):
        plan.apply(exact=True)
    assert states(world) == {"B": LifeCycleState.INACTIVE}


def test_a_profile_is_applied_at_once(tree: Tree, world: FakeManager, robot: Path) -> None:
    world.perform(act.Delete("A"))
    plan = tree.apply_profile(robot, state="Inactive")
    assert plan.steps[0] == "create A on manager"
    assert set(states(world).values()) == {LifeCycleState.INACTIVE}
    assert [each.connector_id for each in tree.snapshot().connectors] == ["wire"]
    with pytest.raises(ValueError, match="state is one of Active, Inactive, Any"):
        tree.apply_profile(robot, state="Flying")
    assert tree.check(robot, state="inactive")
    with pytest.raises(Malformed, match="state is one of Created, Inactive"):
        tree.check(robot, state="Flying")
    with pytest.raises(Malformed, match="No ports specified"):
        tree.values()


def test_a_system_starts_stops_and_is_torn_down(
    tree: Tree, world: FakeManager, robot: Path
) -> None:
    tree.start(robot)
    assert set(states(world).values()) == {LifeCycleState.ACTIVE}
    tree.stop(robot)
    assert set(states(world).values()) == {LifeCycleState.INACTIVE}
    tree.teardown(robot)
    assert tree.snapshot().connectors == ()
    tree.teardown(robot, end=True)
    assert not world.components
    tree.bring_up(robot)
    assert set(states(world)) == {"A", "B"}


def test_a_report_tells_each_deviation(tree: Tree, world: FakeManager, robot: Path) -> None:
    world.perform(act.Delete("B"))
    report = tree.check(robot, state="Inactive")
    assert not report
    assert [each.kind for each in report] == ["component", "connection"]
    assert "B.rtc" in str(report)
    assert tree.check(robot, hosts={"elsewhere": "localhost"}, state="Inactive").found


def test_it_waits_until_components_are_in_a_state(tree: Tree) -> None:
    tree.wait(A, B, state="inactive", timeout_s=5.0)
    with pytest.raises(TimeoutError, match=r"A.rtc is Inactive, not Active after 0.01 s"):
        tree.wait(A, state="Active", timeout_s=0.01)
    with pytest.raises(Malformed, match=r"no such state: activ \(did you mean active"):
        tree.wait(A, state="activ")
    with pytest.raises(Malformed, match="data come from a port"):
        tree.wait(A, state="data")


def test_what_an_author_uses_is_shown_first() -> None:
    assert {"connect", "load", "Tree", "SystemPlan", "SystemProfile"} <= set(dir(rtkit))
    assert all(not name.startswith("_") for name in dir(rtkit) if name != "__version__")


def test_each_shown_name_is_there(tree: Tree) -> None:
    assert all(hasattr(tree, name) for name in dir(tree))
    own = {name for name in {**vars(Tree), **vars(DataTree)} if not name.startswith("_")}
    assert own <= set(dir(tree))
