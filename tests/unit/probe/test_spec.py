"""Port specifications of data tools."""

from __future__ import annotations

import pytest

from rtkit.deployment.actions import Create
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.probe.port_spec import find_streams, parse_spec
from rtkit.rtc.enums import PortType
from rtkit.tree.client import Tree


def specs(*texts: str):
    return [parse_spec(text, "/localhost") for text in texts]


@pytest.mark.parametrize(
    "text", ["", "a.rtc", "a.rtc:", "a.rtc:x#", "a.rtc:x#1", "a.rtc:x:y", "a.rtc:x#a-b", "a\n:x"]
)
def test_what_is_no_specification(text):
    with pytest.raises(Malformed, match="Bad port specification"):
        parse_spec(text)


def test_a_formatter_stands_behind_a_hash():
    spec = parse_spec("/localhost/a.rtc:out#mod.show")
    assert (spec.path.port, spec.formatter) == ("out", "mod.show")


def test_streams_are_numbered_unless_they_are_named(tree: Tree):
    tree.perform(Create("Std?instance_name=A"))
    tree.perform(Create("Std?instance_name=B"))
    found = find_streams(tree, specs("A.rtc:out", "B.rtc:out.mine"), PortType.OUT)
    assert [stream.name for stream in found] == ["input0", "mine"]
    found = find_streams(tree, specs("A.rtc:in", "B.rtc:in"), PortType.IN)
    assert [stream.name for stream in found] == ["output0", "output1"]


def test_ports_of_one_stream_share_it(tree: Tree):
    tree.perform(Create("Std?instance_name=A"))
    tree.perform(Create("Output?instance_name=B"))
    (stream,) = find_streams(tree, specs("A.rtc:out.x", "B.rtc:out.x"), PortType.OUT)
    assert [end.ref.instance for end in stream.ends] == ["A", "B"]
    assert stream.data_type == "IDL:RTC/TimedLong:1.0"


def test_ports_of_one_stream_have_one_type_and_one_formatter(tree: Tree):
    tree.perform(Create("Std?instance_name=A"))
    tree.perform(Create("Text?instance_name=T"))
    with pytest.raises(Refused, match="x, have different properties"):
        find_streams(tree, specs("A.rtc:in.x", "T.rtc:in.x"), PortType.IN)
    with pytest.raises(Refused, match="different properties"):
        find_streams(tree, specs("A.rtc:out.x#rawpy", "A.rtc:out.x"), PortType.OUT)


def test_what_is_not_there_is_told_as_typed(tree: Tree):
    tree.perform(Create("Std?instance_name=A"))
    with pytest.raises(NotFound, match=r"No such object: B\.rtc:out"):
        find_streams(tree, specs("B.rtc:out"), PortType.OUT)
    with pytest.raises(NotFound, match=r"Port not found: A\.rtc:nil"):
        find_streams(tree, specs("A.rtc:nil"), PortType.OUT)
    with pytest.raises(Refused, match=r"Port is not output: A\.rtc:in"):
        find_streams(tree, specs("A.rtc:in"), PortType.OUT)
