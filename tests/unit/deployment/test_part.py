"""The part of a snapshot that concerns a few components."""

from __future__ import annotations

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.part import part_of
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef, TypeProfile


def component(name: str) -> ComponentFacts:
    ports = (PortProfile("p", PortType.OUT),)
    return ComponentFacts(
        name,
        TypeProfile("T"),
        "m",
        ports,
        {"default": {"a": "1"}},
        names=(f"localhost/{name}.rtc",),
    )


def wire(one: str, other: str) -> ConnectorProfile:
    return ConnectorProfile(one + other, "w", (PortRef(one, "p"), PortRef(other, "p")))


WHOLE = Snapshot(
    "box",
    "m",
    1,
    "0",
    components=tuple(component(name) for name in "ABCD"),
    connectors=(wire("A", "B"), wire("B", "C"), wire("C", "D")),
    properties={"k": "v"},
)


def test_a_part_has_what_was_asked_for_in_full_and_its_neighbours_in_outline() -> None:
    part = part_of(WHOLE, ["A"])
    assert [each.instance for each in part.components] == ["A", "B"]
    assert part.component("A") == WHOLE.component("A")
    neighbour = part.component("B")
    assert neighbour is not None
    assert (neighbour.names, neighbour.ports) == (("localhost/B.rtc",), ())
    assert [each.connector_id for each in part.connectors] == ["AB"]


def test_parts_of_several_components() -> None:
    part = part_of(WHOLE, ["B", "D", "nobody"])
    assert [each.connector_id for each in part.connectors] == ["AB", "BC", "CD"]
    assert [bool(each.ports) for each in part.components] == [False, True, False, True]


def test_a_part_of_nobody_tells_of_the_manager_only() -> None:
    part = part_of(WHOLE, [""])
    assert (part.components, part.connectors) == ((), ())
    assert (part.host, part.properties) == ("box", {"k": "v"})
