"""Patterns of ports: which ports they stand for."""

from __future__ import annotations

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.deployment.actions import Create
from rtkit.errors import NotFound, Refused
from rtkit.probe.port_pattern import expanded
from rtkit.probe.port_spec import find_streams, parse_spec
from rtkit.rtc.enums import PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile
from rtkit.tree.client import Tree

_LONG = {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}


def pattern(name: str, *ports: str, vendor: str = "Me", category: str = "test") -> ComponentPattern:
    made = tuple(
        PortProfile(port, PortType.IN if port.startswith("in") else PortType.OUT, _LONG)
        for port in ports
    )
    return ComponentPattern(TypeProfile(name, vendor, category, "1.0"), made)


@pytest.fixture
def tree() -> Tree:
    tool = pattern("Tool", "out", vendor="rtkit", category="tool")
    types = [pattern("Sensor", "in", "out", "raw"), pattern("Odd", "out.a", "out"), tool]
    tree = fake_tree(FakeManager(types))
    for each in ("Sensor?instance_name=Sensor0", "Sensor?instance_name=Sensor10", "Odd", "Tool"):
        tree.perform(Create(each))
    return tree


def found(tree: Tree, *texts: str, cwd: str = "/", **more: bool) -> list[str]:
    specs = [parse_spec(text, cwd) for text in texts]
    return [str(each.path) for each, _ in expanded(tree.snapshot(), specs, PortType.OUT, **more)]


@pytest.mark.parametrize(
    ("text", "cwd", "ports"),
    [
        ("Sensor*:out", "/", ["Sensor0.rtc:out", "Sensor10.rtc:out"]),
        ("Sensor?:out", "/", ["Sensor0.rtc:out"]),
        ("Sensor?.rtc:*", "/localhost", ["Sensor0.rtc:out", "Sensor0.rtc:raw"]),
        ("/localhost/S*:ra?", "/", ["Sensor0.rtc:raw", "Sensor10.rtc:raw"]),
        ("/*/Sensor0*:raw", "/", ["Sensor0.rtc:raw"]),
        ("/127.0.0.1/Sensor0*:raw", "/", ["Sensor0.rtc:raw"]),
        ("Sensor0.rtc:*.all", "/localhost", ["Sensor0.rtc:out.all", "Sensor0.rtc:raw.all"]),
        ("*:out.a", "/", ["Odd0.rtc:out.a", "Sensor0.rtc:out.a", "Sensor10.rtc:out.a"]),
        (
            "*:*",
            "/",
            [
                *("Odd0.rtc:out.a", "Odd0.rtc:out", "Sensor0.rtc:out", "Sensor0.rtc:raw"),
                *("Sensor10.rtc:out", "Sensor10.rtc:raw"),
            ],
        ),
    ],
)
def test_ports_that_a_pattern_stands_for(tree: Tree, text: str, cwd: str, ports: list[str]) -> None:
    assert found(tree, text, cwd=cwd) == [f"/localhost/{each}" for each in ports]


def test_each_port_is_there_once_as_it_was_named_first(tree: Tree) -> None:
    named = "/localhost/Sensor0.rtc:out.mine"
    assert found(tree, "Sensor0*:*", named, "*:out") == [
        named,
        "/localhost/Sensor0.rtc:raw",
        *("/localhost/Odd0.rtc:out", "/localhost/Sensor10.rtc:out"),
    ]


@pytest.mark.parametrize("text", ["Motor*:out", "Sensor*:in", "/localhost/x/*:out", "/*:out"])
def test_a_pattern_that_matches_nothing(tree: Tree, text: str) -> None:
    with pytest.raises(NotFound, match="No output port matches: "):
        found(tree, text)
    assert found(tree, text, is_patient=True) == []


def test_streams_of_ports_without_names_of_their_own_are_apart(tree: Tree) -> None:
    specs = [parse_spec(f"/localhost/{each}") for each in ("Odd0.rtc:out.a.x", "Odd0.rtc:out")]
    streams = find_streams(tree, specs, PortType.OUT, lambda _number, _ref: "x")
    assert [stream.name for stream in streams] == ["x", "x_"]


def test_what_is_named_exactly_is_no_pattern(tree: Tree) -> None:
    with pytest.raises(Refused, match="Port is not output: "):
        find_streams(tree, [parse_spec("/localhost/Sensor0.rtc:in")], PortType.OUT)


def test_each_specification_has_its_port(tree: Tree) -> None:
    specs = [
        parse_spec(f"/localhost/{each}") for each in ("Gone.rtc:x", "Odd0.rtc:out.y", "S*:out")
    ]
    refs = [ref and str(ref) for _, ref in expanded(tree.snapshot(), specs, PortType.OUT)]
    assert refs == [None, "Odd0.out", "Sensor0.out", "Sensor10.out"]
