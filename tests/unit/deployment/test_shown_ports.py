"""Ports that composites show: by whichever name, it is the member's port."""

from __future__ import annotations

import pytest

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.listing import listing_of
from rtkit.deployment.part import part_of
from rtkit.deployment.properties import of_component
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef, TypeProfile


def facts(instance, *ports, members=()):
    kind = TypeProfile("Step")
    made = tuple(PortProfile(name, PortType.OUT) for name in ports)
    return ComponentFacts(instance, kind, "p", ports=made, members=tuple(members))


def snapshot(*wires):
    components = (
        facts("Outer", "Inner.A.out", "Inner.A.B.out", members=["Inner"]),
        facts("Inner", "A.out", "A.B.out", members=["A", "A.B"]),
        facts("A", "out"),
        facts("A.B", "out"),
        facts("C", "into"),
    )
    return Snapshot("h", "manager", 1, "1", components=components, connectors=wires)


def wire(id, one):
    return ConnectorProfile(id, id, (PortRef(*one), PortRef("C", "into")))


@pytest.mark.parametrize(
    ("name", "own"),
    [
        (("Outer", "Inner.A.out"), ("A", "out")),
        (("Outer", "Inner.A.B.out"), ("A.B", "out")),
        (("Inner", "A.B.out"), ("A.B", "out")),
        (("A", "out"), ("A", "out")),
        (("Inner", "A.nothing"), ("Inner", "A.nothing")),
        (("Nobody", "A.out"), ("Nobody", "A.out")),
    ],
)
def test_a_port_has_one_name_of_its_own(name, own):
    assert OwnEnds.of(snapshot()).end(PortRef(*name)) == PortRef(*own)


def test_a_connector_is_seen_at_all_who_show_its_port():
    joined = snapshot(wire("a", ("A", "out")), wire("b", ("A.B", "out")))
    rows = {row.instance: row.outs_connected for row in listing_of(joined).rows}
    assert rows == {"Outer": 2, "Inner": 2, "A": 1, "A.B": 1, "C": 1}
    for instance, count in (("Outer", 2), ("Inner", 2), ("A", 1), ("C", 2)):
        part = part_of(joined, [instance])
        here = part.component(instance)
        assert len(OwnEnds.of(part).connectors(here, part.connectors)) == count


def test_the_properties_of_a_composite_tell_who_is_connected():
    joined = snapshot(wire("a", ("A", "out")))
    outer = joined.component("Outer")
    ends = OwnEnds.of(joined).ends(outer)
    shown = {s.name: s.value for s in of_component(outer, joined.connectors, None, ends)}
    told = [len(value) for name, value in shown.items() if name.endswith(".connected")]
    assert told == [1, 0]
