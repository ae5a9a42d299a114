"""States of a system by scripts: looked at, led to, followed, as rtstate does."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rts_text
import statekit
from fake_manager import FakeManager
from fake_tree import tree_of
from statekit import KINDS, SYSTEM, TOLD

from rtkit.api.tree import Tree
from rtkit.deployment.facts import Followed
from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused


@pytest.fixture
def world() -> FakeManager:
    return statekit.make_world()


@pytest.fixture
def tree(world: FakeManager, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    with tree_of(Tree, world) as tree:
        yield tree


def written(file: Path, *parts: str) -> Path:
    components = [
        rts_text.component(f"{kind}0", {"create": f"{kind}?manager_name={kind}"}, gain="1", rate=10)
        for kind in KINDS
    ]
    file.write_text(rts_text.system("Robot", *components, *parts))
    return file


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    return written(tmp_path / "robot.xml", rts_text.properties(TOLD))


def test_a_system_is_looked_at_and_led(tree: Tree, world: FakeManager, robot: Path) -> None:
    report = tree.states(robot)
    assert (report.now, str(report), report.events) == ("", "between states", {})
    assert report.names == ["standby", "explore", "degraded"]
    assert [each.plan and each.plan.cost for each in report.ways()] == [16, 18, 9]
    assert world.performed == []
    with pytest.raises(InvalidDocument, match="the system is in none of its states"):
        tree.goto(robot, event="start")
    tree.goto(robot, "explore")
    report = tree.states(robot)
    assert (report.now, report.followed) == ("explore", None)
    assert report.events == {"motor_lost": "degraded", "stop": "standby"}
    tree.goto(robot, event="stop")
    assert str(tree.states(robot)) == "standby"
    tree.goto(robot, "standby")


def test_what_is_no_state_event_or_option_is_told(
    tree: Tree, world: FakeManager, robot: Path
) -> None:
    with pytest.raises(InvalidDocument, match=r"xml: no state explor \(did you mean explore"):
        tree.goto(robot, "explor")
    options: Any = {"prune": True}
    with pytest.raises(TypeError, match=r"goto\(\) has no option prune"):
        tree.goto(robot, "explore", **options)
    for state, event in (("", ""), ("explore", "stop")):
        with pytest.raises(Malformed, match="a state or an event"):
            tree.goto(robot, state, event=event)
    with pytest.raises(InvalidDocument, match="it tells no states"):
        tree.states(written(robot))
    assert world.performed == []


def test_the_manager_is_asked_to_follow_and_to_end_it(
    tree: Tree, world: FakeManager, robot: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[dict[str, Any]] = []
    told: list[str] = []

    def follow(_tree: Tree, _name: str, value: str, *, timeout_s: float | None = None) -> str:
        asked.append(json.loads(value))
        return "is so"

    monkeypatch.setattr(Tree, "set", follow)
    tree.notify = told.append
    tree.follow(robot, rollback=True)
    assert [*asked.pop()] == ["start"]
    world.systems = (Followed(SYSTEM),)
    assert tree.states(robot).followed == Followed(SYSTEM)
    tree.unfollow("Robot")
    assert (asked, told) == ([{"stop": SYSTEM}], ["is so"])
    with pytest.raises(NotFound, match="does not follow Robott; it follows"):
        tree.unfollow("Robott")
    text = robot.read_text().replace("localhost/Motor0.rtc", "localhost/m1.mgr/Motor0.rtc")
    robot.write_text(text)
    with pytest.raises(Refused, match=f"no manager can follow {SYSTEM}"):
        tree.follow(robot)


def test_shared_options_are_shown_one_by_one() -> None:
    """Help and completion read signatures."""
    way = {"replace", "costs", "stand_in", "transmit", "hosts", "strict"}
    for method in (Tree.plan, Tree.apply_profile, Tree.states, Tree.goto, Tree.follow):
        shown = inspect.signature(method).parameters
        assert way <= shown.keys(), method
        assert ("prune" in shown) is (method in (Tree.plan, Tree.apply_profile))
        assert all(each.kind is not each.VAR_KEYWORD for each in shown.values())
