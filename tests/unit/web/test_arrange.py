"""Layouts of the page: frames around what they hold, wires from port to port."""

from __future__ import annotations

from itertools import pairwise

import pytest
from webfacts import component, manager

from rtkit.api.live_records import SystemRecords, records_of
from rtkit.api.live_scene import drawing_of
from rtkit.deployment.facts import ProcessFacts
from rtkit.fast_dataclass import replace
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.web.live.arrange import arranged

MANAGER, SLAVE, COMPOSITE = (
    "/localhost/manager.mgr",
    "/localhost/manager.mgr/s1.mgr",
    "/localhost/G.rtc",
)


def system() -> SystemRecords:
    """A in the manager, B in a slave, and a composite G with C in it; A feeds both."""
    parts = [
        component("A"),
        replace(component("B"), process="s1"),
        replace(component("C"), composite="G"),
        replace(component("G"), composite_type="Grouping", members=("C",), ports=()),
    ]
    connectors = [
        ConnectorProfile(end, end, (PortRef("A", "out"), PortRef(end, "in"))) for end in "BC"
    ]
    known = manager(*parts, connectors=connectors)
    processes = (*known.facts.processes, ProcessFacts("s1", True, 8, "up"))
    return records_of([known._replace(facts=replace(known.facts, processes=processes))], "host")


@pytest.mark.parametrize("folded", [[], [SLAVE], [COMPOSITE], [SLAVE, COMPOSITE], [MANAGER]])
def test_boxes_are_in_their_frames_and_wires_end_at_ports(folded: list[str]) -> None:
    layout = arranged(system(), folded)
    boxes = layout["boxes"]
    for box in boxes.values():
        around = boxes[box["parent"]] if box["parent"] else None
        if around is not None:
            assert around["x"] <= box["x"]
            assert around["y"] <= box["y"]
            assert box["x"] + box["width"] <= around["x"] + around["width"]
            assert box["y"] + box["height"] <= around["y"] + around["height"]
    ends = {
        (box["x"] + (box["width"] if port["side"] == "right" else 0), box["y"] + port["y"])
        for box in boxes.values()
        for port in box["ports"].values()
    }
    for path in layout["paths"].values():
        assert path[0] in ends
        assert path[-1] in ends
        assert all(a[0] == b[0] or a[1] == b[1] for a, b in pairwise(path))
    hidden = {SLAVE: "/localhost/B.rtc", COMPOSITE: "/localhost/C.rtc", MANAGER: "/localhost/A.rtc"}
    assert all(hidden[each] not in boxes for each in folded)
    assert set(layout["paths"]) == (set() if MANAGER in folded else {"B", "C"})


def test_a_service_wire_ends_at_the_side_where_it_enters_the_frame() -> None:
    records = system()
    for name in "AB":
        records.components[f"/localhost/{name}.rtc"]["ports"].append(
            {"name": "svc", "direction": "service", "type": "", "interfaces": []}
        )
    ends = ({"component": f"/localhost/{name}.rtc", "port": "svc"} for name in "AB")
    records.connectors["svc"] = {"id": "svc", **dict(zip(("source", "target"), ends, strict=True))}
    layout = arranged(records)
    inner, path = layout["boxes"]["/localhost/B.rtc"], layout["paths"]["svc"]
    port = inner["ports"]["svc"]
    assert port["side"] == "left"
    assert path[-1] == (inner["x"], inner["y"] + port["y"])
    assert max(x for x, _ in path) == inner["x"]


def test_a_wire_to_what_is_not_there_is_left_out() -> None:
    records = system()
    records.connectors["B"]["target"]["component"] = "/robot9/manager.mgr/X.rtc"
    assert set(arranged(records)["paths"]) == {"C"}
    assert len(drawing_of(records).scene.wires) == 1
