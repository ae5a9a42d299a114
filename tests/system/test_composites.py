"""Composites on real processes: made, changed, nested, saved, brought up again, ended."""

from __future__ import annotations

from typing import Any

import pytest
from waiting import facts_of

from rtkit.deployment import actions as act
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
STEP = """
import os
from rtkit.component import Component, InPort, OutPort, TimedLong


class Step(Component):
    rate = 200.0
    into = InPort(TimedLong)
    out = OutPort(TimedLong)
    done = False

    def note(self, *words):
        path = os.environ["RTKIT_STATE_DIR"] + "/diary"
        if os.path.exists(path):
            fd = os.open(path, os.O_WRONLY)
            os.write(fd, (" ".join(map(str, words)) + "\\n").encode())
            os.close(fd)

    def on_activated(self, context):
        self.done = False
        self.note(self.instance, context, "activated")

    def on_deactivated(self, context):
        self.note(self.instance, context, "deactivated")

    def on_execute(self, context):
        value = self.into.read() if self.into.is_new() else None
        if value is not None:
            self.note(self.instance, "got", value.data)
            self.out.write(TimedLong(data=value.data + 1))
        if not self.done:
            self.done = True
            self.note(self.instance, "executed")


class Source(Component):
    out = OutPort(TimedLong)

    def on_activated(self, context):
        self.out.write(TimedLong(data=1))


def StepInit(manager):
    manager.register_factory(Step)
    manager.register_factory(Source)
"""
TYPE = "PeriodicECSharedComposite"


@pytest.fixture
def tree(tree: Tree, manager: Any) -> Tree:
    (manager.modules / "Step.py").write_text(STEP)
    tree.perform(act.Load("Step.py"))
    for name in ("A", "B", "C"):
        make(tree, f"Step?instance_name={name}&manager_name=robot")
    return tree


def make(tree: Tree, create: str) -> str:
    return tree.perform(act.Create(create))


def compose(tree: Tree, instance: str, members: str, ports: str = "") -> None:
    options = f"&members={members}" * bool(members) + f"&exported_ports={ports}" * bool(ports)
    make(tree, f"{TYPE}?instance_name={instance}{options}")


def change(tree: Tree, instance: str, transition: Transition) -> None:
    tree.perform(act.ChangeState(instance, "0", transition))


def edit(tree: Tree, instance: str, **values: str) -> None:
    tree.perform(act.SetParameters(instance, "default", values))


def test_members_work_together_in_the_process_that_they_are_in(
    manager: Any, tree: Tree, notes: Any
) -> None:
    compose(tree, "W", "B,A", "B.into,A.out")
    whole, a = facts_of(tree, "W"), facts_of(tree, "A")
    assert whole.process == "robot"
    assert (whole.composite_type, whole.members) == ("PeriodicECShared", ("B", "A"))
    assert (a.composite, a.state) == ("W", "Inactive")
    assert [(c.id, c.is_running) for c in a.contexts] == [("0", False), ("W/0", True)]
    assert [port.name for port in whole.ports] == ["B.into", "A.out"]
    change(tree, "W", Transition.ACTIVATE)
    assert notes.next(4) == ["B W/0 activated", "A W/0 activated", "B executed", "A executed"]
    assert facts_of(tree, "A").state == "Active"
    with pytest.raises(Refused, match="a member of W changes its state with that"):
        change(tree, "A", Transition.ACTIVATE)
    shown = manager.ok("rtcat -l /localhost/W.rtc")
    for line in ("Type           Composite", "-Composition W", "Member  /localhost/B.rtc"):
        assert line in shown
    shown = manager.ok("rtcat /localhost/A.rtc")
    assert "Type           Monolithic composite member" in shown
    assert "+Parent composition W" in shown
    assert manager.ok("rtls -l /localhost/W.rtc").split()[:2] == ["Active", "2/0"]
    change(tree, "W", Transition.DEACTIVATE)
    assert notes.next(2) == ["B W/0 deactivated", "A W/0 deactivated"]


def test_values_go_through_the_ports_that_it_shows(tree: Tree, notes: Any) -> None:
    compose(tree, "W", "A,B", "A.into,B.out")
    make(tree, "Source?instance_name=S")
    for id, ends in (("in", "S.out W.A.into"), ("mid", "A.out B.into"), ("end", "W.B.out C.into")):
        refs = tuple(PortRef(*end.split(".", 1)) for end in ends.split())
        tree.perform(act.Connect(ConnectorProfile(id, id, refs)))
    for instance in ("W", "C", "S"):
        change(tree, instance, Transition.ACTIVATE)
    seen = [line for line in notes.next(9) if "got" in line]
    assert seen == ["A got 1", "B got 2", "C got 3"]
    edit(tree, "W", exported_ports="A.into")
    assert [wire.connector_id for wire in tree.snapshot().connectors] == ["in", "mid", "end"]
    tree.perform(act.ChangeState("S", "0", Transition.DEACTIVATE))
    change(tree, "S", Transition.ACTIVATE)
    assert notes.next(3) == ["A got 1", "B got 2", "C got 3"]
    change(tree, "W", Transition.DEACTIVATE)
    assert notes.next(2) == ["A W/0 deactivated", "B W/0 deactivated"]
    tree.perform(act.Delete("W"))
    assert [wire.connector_id for wire in tree.snapshot().connectors] == ["in", "mid", "end"]
    assert [c.id for c in facts_of(tree, "A").contexts if c.is_running] == ["0"]


def test_a_port_that_a_composite_shows_is_the_port_of_its_member(manager: Any, tree: Tree) -> None:
    compose(tree, "W", "A,B", "A.into,B.out")
    shown, own = "/localhost/W.rtc:A.into", "/localhost/A.rtc:into"
    manager.ok(f"rtcon -i one /localhost/C.rtc:out {shown}")
    for port in (shown, own):
        assert "Connected to  /localhost/C.rtc:out" in manager.ok(f"rtcat -l {port}")
        assert manager.run(f"rtcon -d /localhost/C.rtc:out {port}").status == 1
    for component in ("A", "W"):
        assert manager.ok(f"rtls -l /localhost/{component}.rtc").split()[1:3] == ["2/1", "1/1"]
    manager.ok("rtmgr restart")
    assert "Connected to" in manager.ok(f"rtcat -l {shown}")
    manager.ok(f"rtdis {own}")
    manager.ok("rtcon -i two /localhost/B.rtc:out /localhost/C.rtc:into")
    manager.ok("rtdis /localhost/W.rtc")
    assert tree.snapshot().connectors == ()


def test_members_come_and_go(tree: Tree) -> None:
    compose(tree, "W", "")
    assert facts_of(tree, "W").process == "manager"
    tree.perform(act.Delete("W"))
    make(tree, f"{TYPE}?instance_name=W&manager_name=robot")
    edit(tree, "W", members="A,C", exported_ports="C.out")
    assert facts_of(tree, "W").members == ("A", "C")
    edit(tree, "W", members="C")
    assert facts_of(tree, "A").composite == ""
    tree.perform(act.Delete("C"))
    whole = facts_of(tree, "W")
    assert (whole.members, whole.ports) == ((), ())
    assert whole.sets["default"]["members"] == "C"
    edit(tree, "W", members="B", exported_ports="")
    assert facts_of(tree, "W").members == ("B",)


def test_what_cannot_be_is_refused_and_changes_nothing(tree: Tree) -> None:
    make(tree, "Step?instance_name=Far")
    compose(tree, "W", "A")
    before = facts_of(tree, "W").sets
    for members, ports, error, why in (
        ("A,Nobody", "", NotFound, "no component named Nobody"),
        ("A,Far", "", NotFound, "no component named Far"),
        ("A", "A.nothing", NotFound, "Port not found: A.nothing"),
        ("W", "", Refused, "cannot be a member of itself"),
    ):
        with pytest.raises(error, match=why):
            edit(tree, "W", members=members, exported_ports=ports)
    assert facts_of(tree, "W").sets == before
    for members, place, error, why in (
        ("B,Far", "", Refused, "B is in robot, Far in manager: members of a composite"),
        ("B", "&manager_name=other", Refused, "a composite of it cannot be in other"),
        ("A", "", Refused, "A is a member of W already"),
        ("No", "", NotFound, "no component named No"),
    ):
        with pytest.raises(error, match=why):
            make(tree, f"{TYPE}?instance_name=V&members={members}{place}")
    assert tree.snapshot().component("V") is None
    assert facts_of(tree, "B").contexts[0].is_running
    with pytest.raises(Refused, match="A is a member of W; take it out of there"):
        tree.perform(act.Detach("W", "0", "A"))


def test_nested_composites_live_and_end_together(tree: Tree, notes: Any) -> None:
    compose(tree, "Inner", "A,B")
    compose(tree, "Outer", "Inner,C")
    change(tree, "Outer", Transition.ACTIVATE)
    assert notes.next(6)[:3] == [f"{name} Outer/0 activated" for name in ("A", "B", "C")]
    assert {facts_of(tree, n).state for n in ("Outer", "Inner", "A", "B", "C")} == {"Active"}
    tree.perform(act.Delete("Inner"))
    assert notes.next(2) == ["A Outer/0 deactivated", "B Outer/0 deactivated"]
    assert facts_of(tree, "Outer").members == ("C",)
    assert [c.id for c in facts_of(tree, "A").contexts] == ["0"]


def test_saved_and_brought_up_again(manager: Any, tree: Tree) -> None:
    make(tree, f"{TYPE}?instance_name=W&manager_name=robot")
    compose(tree, "Outer", "W")
    edit(tree, "W", members="A,B", exported_ports="A.into")
    edit(tree, "Outer", exported_ports="W.A.into")
    make(tree, "Source?instance_name=S")
    ends = (PortRef("S", "out"), PortRef("Outer", "W.A.into"))
    tree.perform(act.Connect(ConnectorProfile("w", "w", ends)))
    saved = manager.ok("rtcryo")
    assert 'compositeType="PeriodicECShared"' in saved
    file = manager.folder / "sys.xml"
    file.write_text(saved)
    before = {
        c.instance: (c.members, c.composite, len(c.ports)) for c in tree.snapshot().components
    }
    manager.ok(f"rtteardown {file}")
    for instance in ("S", "Outer", "W", "A", "B"):
        tree.perform(act.Delete(instance))
    assert manager.run(f"rtresurrect {file}").status == 0
    after = {c.instance: (c.members, c.composite, len(c.ports)) for c in tree.snapshot().components}
    assert after == before
    assert [wire.connector_id for wire in tree.snapshot().connectors] == ["w"]
    tree.perform(act.Delete("C"))
    assert manager.run(f"rtstart {file}").status == 0
    assert {c.state for c in tree.snapshot().components} == {"Active"}
    assert manager.run(f"rtcheck {file}") == (0, "", "")
    assert manager.run(f"rtstop {file}").status == 0
    assert {c.state for c in tree.snapshot().components} == {"Inactive"}
