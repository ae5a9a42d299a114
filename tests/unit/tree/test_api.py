"""The calls by path that scripts make."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from worlds import made

from rtkit.deployment import actions as act
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import LifeCycleState, PortType, Transition
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

LONG = {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}
A, B = "/localhost/A.rtc", "/localhost/B.rtc"


@pytest.fixture
def world() -> FakeManager:
    ports = (PortProfile("in", PortType.IN, LONG), PortProfile("out", PortType.OUT, LONG))
    pattern = ComponentPattern(
        TypeProfile("Std"), ports, {"default": {"gain": "1"}, "fast": {"gain": "9"}}
    )
    return made(FakeManager([pattern]), *(f"Std?instance_name={name}" for name in "AB"))


@pytest.fixture
def tree(world: FakeManager) -> Iterator[Tree]:
    with fake_tree(world) as tree:
        yield tree


def test_ls(tree: Tree) -> None:
    assert tree.ls() == ["A.rtc", "B.rtc", "manager.mgr"]
    assert tree.ls("/") == ["localhost"]
    assert tree.ls(A) == ["A.rtc"]
    with pytest.raises(NotFound, match=r"No such object: /localhost/C.rtc"):
        tree.ls("/localhost/C.rtc")


def test_component(tree: Tree) -> None:
    assert tree.component(A).type.type_name == "Std"
    with pytest.raises(NotFound):
        tree.component("/localhost/C.rtc")
    with pytest.raises(Refused, match="Not a component: /localhost"):
        tree.component("/localhost")


def test_create_and_delete(tree: Tree, world: FakeManager) -> None:
    assert tree.create("Std") == "/localhost/Std0.rtc"
    assert tree.create("Std?instance_name=Std0") == "/localhost/Std0.rtc"
    tree.delete("/localhost/Std0.rtc")
    assert "Std0" not in world.components
    with pytest.raises(NotFound, match="No such object"):
        tree.delete("/localhost/Std0.rtc")
    with pytest.raises(Refused, match="Not a component: /localhost"):
        tree.delete("/localhost")
    with pytest.raises(Malformed, match=r"Not a component: /localhost/A.rtc:in"):
        tree.delete("/localhost/A.rtc:in")
    assert "A" in world.components
    with pytest.raises(NotFound, match="component type Nix is not known"):
        tree.create("Nix")


def test_what_is_made_is_found_where_it_is_registered(tree: Tree, world: FakeManager) -> None:
    world.perform(act.Create("Std?instance_name=C", ("box/dir.host_cxt/C.rtc",)))
    assert tree.create("Std?instance_name=C") == "/localhost/dir.host_cxt/C.rtc"
    world.update("C", names=())
    path = tree.create("Std?instance_name=C")
    assert path == "/localhost/manager.mgr/C.rtc"
    tree.activate(path)


def test_it_tells_what_it_is(tree: Tree) -> None:
    assert repr(tree) == "<Tree: manager 'manager' on box>"


@pytest.mark.parametrize("nothing", [None, 5, ["/localhost/A.rtc"]])
def test_what_is_no_text_is_a_type_error(tree: Tree, world: FakeManager, nothing: Any) -> None:
    for call in (
        tree.ls,
        tree.component,
        tree.create,
        tree.delete,
        tree.activate,
        tree.disconnect,
        tree.get,
        lambda value: tree.connect(f"{A}:out", value),
        lambda value: tree.disconnect(f"{A}:out", value),
        lambda value: tree.set("naming.formats", value),
        connect,
    ):
        with pytest.raises(TypeError, match="is text, not"):
            call(nothing)
    assert world.performed == []


@pytest.mark.parametrize("context", [None, 1.0, True])
def test_an_execution_context_is_a_number_or_text(tree: Tree, context: Any) -> None:
    with pytest.raises(TypeError, match="an execution context is a number or text"):
        tree.activate(A, context)


def test_connections_are_between_ports(tree: Tree) -> None:
    with pytest.raises(Malformed, match=f"Not a port: {A}"):
        tree.connect(f"{A}:out", A)
    with pytest.raises(Malformed, match=f"Not a port: {A}"):
        tree.disconnect(A)


def test_a_zombie_can_be_deleted(tree: Tree, world: FakeManager) -> None:
    tree.create("Std?instance_name=Z&manager_name=s")
    world.kill("s")
    tree.delete("/localhost/Z.rtc")
    assert "Z" not in world.components


def test_transitions(tree: Tree, world: FakeManager) -> None:
    tree.activate(A)
    assert world.state_of("A") == "Active"
    tree.deactivate(A)
    assert world.state_of("A") == "Inactive"
    world.set_state("A", LifeCycleState.ERROR)
    with pytest.raises(Refused, match="precondition not met"):
        tree.activate(A)
    tree.reset(A)
    assert world.state_of("A") == "Inactive"
    with pytest.raises(NotFound, match="no execution context 7 on A"):
        tree.activate(A, "7")
    assert world.performed[0] == act.ChangeState("A", "0", Transition.ACTIVATE)


def test_contexts_by_number_or_id(tree: Tree, world: FakeManager) -> None:
    contexts = (ContextPattern("Ec1"), ContextPattern("slow"))
    world.types["Two"] = ComponentPattern(TypeProfile("Two"), contexts=contexts)
    world.types["None"] = ComponentPattern(TypeProfile("None"))
    world.perform(act.Create("Two?instance_name=T"))
    world.perform(act.Create("None?instance_name=N"))
    world.update("N", contexts=())
    path = "/localhost/T.rtc"

    def states() -> list[str]:
        return [context.state.value for context in world.components["T"].contexts]

    tree.activate(path)
    assert states() == ["Active", "Inactive"]
    tree.activate(path, 1)
    tree.deactivate(path, 0)
    assert states() == ["Inactive", "Active"]
    tree.deactivate(path, "slow")
    assert states() == ["Inactive", "Inactive"]
    for wrong in (2, -1):
        with pytest.raises(Malformed, match=f"Bad execution context index: {wrong}"):
            tree.activate(path, wrong)
    with pytest.raises(Malformed, match="Bad execution context index: 0"):
        tree.activate("/localhost/N.rtc")


def test_connections(tree: Tree, world: FakeManager) -> None:
    made = tree.connect(f"{A}:in", f"{B}:out", dataport__subscription_type="flush")
    wire = world.connectors[made]
    assert str(wire.ports[0]) == "B.out"
    assert wire.properties["dataport.subscription_type"] == "flush"
    assert tree.connect(f"{A}:out", f"{B}:in", "mine") == "mine"
    assert tree.disconnect(f"{A}:in", f"{B}:out") == 1
    assert list(world.connectors) == ["mine"]
    assert tree.disconnect(f"{A}:out") == 1
    assert tree.disconnect(f"{A}:out") == 0
    with pytest.raises(Refused, match="Wrong port type"):
        tree.connect(f"{A}:in", f"{B}:in")


def test_paths_must_be_readable(tree: Tree) -> None:
    with pytest.raises(Malformed, match="Bad path"):
        tree.activate("a:b:c")


@pytest.mark.parametrize("name", ["größe 部品", "a*b$c#d", "50%", "a.b"])
def test_names_with_all_kinds_of_characters(tree: Tree, world: FakeManager, name: str) -> None:
    world.perform(act.Create("Std?instance_name=" + name.replace("%", "%25")))
    assert tree.component(f"/localhost/{name}.rtc").instance == name
    assert [each.instance for each in tree.part([name, "A"]).components] == ["A", name]


def test_a_large_part_is_the_whole(tree: Tree) -> None:
    assert len(tree.part(["A"] * 51).components) == 2
    assert len(tree.part(["A"] * 50).components) == 1
    assert tree.part([]).components == ()
