"""Starts and stops on the fake world, through the real client with its threads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import Event, Thread
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from worlds import things

from rtkit.deployment.actions import Action, ChangeState, Result
from rtkit.deployment.conditions import NO_ORDERS, Orders, OrderTarget, StartCondition
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.running import start_plan, stop_plan
from rtkit.deployment.system import WantedComponent, WantedSystem
from rtkit.errors import Refused, Unreachable
from rtkit.link.wakeup import Wakeup
from rtkit.rtc.enums import LifeCycleState, ReturnCode
from rtkit.rtc.pattern import ContextPattern
from rtkit.tree import grace
from rtkit.tree.client import Tree
from rtkit.tree.start import Starter

NAMES = "ABCD"
NO = Result(ReturnCode.ERROR, "refused", "no luck")


@pytest.fixture
def world() -> FakeManager:
    return things(NAMES)


@pytest.fixture
def tree(world: FakeManager) -> Iterator[Tree]:
    with fake_tree(world, 5.0) as tree:
        yield tree


def system(optional: str = "") -> WantedSystem:
    return WantedSystem(
        tuple(
            WantedComponent(
                "RTC:Me:test:Thing:1.0",
                name,
                f"localhost/{name}.rtc",
                f"/localhost/{name}.rtc",
                name not in optional,
                contexts=(ContextPattern(),),
            )
            for name in NAMES
        )
    )


def after(name: str, sequence: int = 1, **more: Any) -> StartCondition:
    return StartCondition(sequence, 0, OrderTarget(name, 0), **more)


def orders(**conditions: StartCondition | tuple[StartCondition, ...]) -> Orders:
    return {
        OrderTarget(name, 0): each if isinstance(each, tuple) else (each,)
        for name, each in conditions.items()
    }


class Start:
    """A start, or stop, of the four components."""

    def __init__(
        self, world: FakeManager, tree: Tree, ordered: Orders = NO_ORDERS, **how: Any
    ) -> None:
        wanted = system(how.pop("optional", ""))
        live = LiveIndex(world.snapshot(), wanted)
        plan_for: Callable[..., Any] = stop_plan if how.pop("stop", False) else start_plan
        plan = plan_for(wanted, live, ordered, wait=how.pop("wait", True))
        self.talk: list[str] = []
        self.starter = Starter(tree, plan, self.talk.append, self.talk.append, **how)

    def run(self) -> None:
        self.starter.run()


def sent(world: FakeManager) -> str:
    return "".join(a.instance for a in world.performed if isinstance(a, ChangeState))


def test_without_orders_one_after_the_other(world: FakeManager, tree: Tree) -> None:
    start = Start(world, tree)
    start.run()
    assert sent(world) == "ABCD"
    assert start.talk[0] == (
        "Executing {1} Activate /localhost/A.rtc in execution context 0 (Required)"
    )
    assert {world.state_of(name) for name in NAMES} == {"Active"}


def test_all_kinds_of_conditions(world: FakeManager, tree: Tree) -> None:
    ordered = orders(
        A=StartCondition(3, 30),
        B=after("A", 2),
        C=after("B", 1, is_sync=False),
        D=StartCondition(0),
    )
    start = Start(world, tree, ordered)
    start.run()
    assert sent(world) == "DABC"
    assert start.talk[1].startswith("Executing {4} [Order 3/Wait 30ms] Activate /localhost/A.rtc")


def test_a_stop(world: FakeManager, tree: Tree) -> None:
    Start(world, tree).run()
    world.performed.clear()
    Start(world, tree, orders(D=after("B"), C=after("D")), stop=True).run()
    assert sent(world) == "BADC"
    assert {world.state_of(name) for name in NAMES} == {"Inactive"}


def test_a_state_that_others_bring_about_is_told(
    world: FakeManager, tree: Tree, monkeypatch: pytest.MonkeyPatch
) -> None:
    world.fault = lambda action: NO if getattr(action, "instance", "") == "A" else None
    wait = Wakeup.wait

    def repaired_when_waited_for(wakeup: Wakeup, others: Any, timeout_s: float | None) -> bool:
        if others and sent(world) == "ACD":
            Thread(target=world.set_state, args=("A", LifeCycleState.ACTIVE)).start()
        return wait(wakeup, others, timeout_s)

    monkeypatch.setattr(Wakeup, "wait", repaired_when_waited_for)
    start = Start(world, tree, orders(B=after("A")), optional="A")
    start.run()
    assert sent(world) == "ACDB"
    assert start.talk[1] == "Action failed: /localhost/A.rtc: no luck"


def test_no_wait_only_sends_but_conditions_are_waited_for(world: FakeManager, tree: Tree) -> None:
    Start(world, tree, orders(B=after("A")), wait=False).run()
    assert sent(world) == "ACDB"
    assert not any(a.wait for a in world.performed if isinstance(a, ChangeState))


def test_a_dead_component_is_named_when_the_time_is_up(world: FakeManager, tree: Tree) -> None:
    def fault(action: Action) -> Result | None:
        if isinstance(action, ChangeState) and action.instance == "A":
            world.kill("sA")
            return NO
        return None

    world.fault = fault
    ordered = orders(B=after("A", timeout_ms=20), C=(after("B", is_sync=False),))
    start = Start(world, tree, ordered, optional="A")
    with pytest.raises(Refused) as caught:
        start.run()
    assert str(caught.value) == (
        "Error executing plan: Preceding condition timed out: action {3} waited 20ms"
        " for: Sync to /localhost/A.rtc (it is zombie (signal 9)); not run: {3}, {4}"
    )
    assert "Action failed: /localhost/A.rtc: no luck" in start.talk
    assert sent(world) == "AD"


def test_a_required_failure(world: FakeManager, tree: Tree) -> None:
    world.fault = lambda action: NO if getattr(action, "instance", "") == "B" else None
    start = Start(world, tree, orders(C=after("A")))
    with pytest.raises(Refused) as caught:
        start.run()
    told = "Required action failed: /localhost/B.rtc: no luck; not run: {3}, {4}"
    assert str(caught.value) == told
    assert sent(world) == "AB"


def test_optional_failures_are_told(world: FakeManager, tree: Tree) -> None:
    world.fault = lambda action: NO if getattr(action, "instance", "") in "BC" else None
    start = Start(world, tree, optional="BC")
    start.run()
    told = [f"Action failed: /localhost/{name}.rtc: no luck" for name in "BC"]
    assert [line for line in start.talk if "failed" in line] == told
    assert sent(world) == NAMES


def test_a_bound_on_the_whole(world: FakeManager, tree: Tree) -> None:
    start = Start(world, tree, orders(B=StartCondition(1, 600_000)), timeout_s=0.02)
    with pytest.raises(
        Refused, match=r"^Error executing plan: not finished within 0\.02 s; not run"
    ):
        start.run()


def test_a_manager_that_goes_away(world: FakeManager, tree: Tree) -> None:
    def fault(action: Action) -> None:
        if getattr(action, "instance", "") == "B":
            tree.close()

    world.fault = fault
    with pytest.raises(
        Unreachable, match=r"manager on box: .*; no answer to: \{3\}; not run: \{4\}"
    ):
        Start(world, tree).run()


def test_an_interruption_waits_for_what_is_under_way(
    world: FakeManager, tree: Tree, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = Start(world, tree, orders(B=StartCondition(1, 600_000)))
    wait = Wakeup.wait
    strikes = iter([KeyboardInterrupt])

    def interrupted_once(wakeup: Wakeup, others: Any, timeout_s: float | None) -> bool:
        for strike in strikes:
            raise strike
        return wait(wakeup, others, timeout_s)

    monkeypatch.setattr(Wakeup, "wait", interrupted_once)
    with pytest.raises(KeyboardInterrupt) as caught:
        start.run()
    assert caught.value.args == ("not run: {2}, {3}, {4}",)
    assert world.state_of("A") == "Active"


def test_an_interruption_does_not_wait_for_ever(
    world: FakeManager, tree: Tree, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(grace, "GRACE_S", 0.01)
    start = Start(world, tree)
    release = Event()

    def begin(*_: object, **__: object) -> Callable[[], tuple[Result, ...]]:
        def answer() -> tuple[Result, ...]:
            release.wait(10)
            return (Result(),)

        return answer

    def go_on() -> None:
        start.starter._execution.ready(0.0)
        raise KeyboardInterrupt

    monkeypatch.setattr(tree, "begin", begin)
    monkeypatch.setattr(start.starter, "_receive", go_on)
    with pytest.raises(KeyboardInterrupt) as caught:
        start.run()
    release.set()
    assert caught.value.args == ("no answer to: {1}; not run: {2}, {3}, {4}",)
