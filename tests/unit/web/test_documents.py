"""Documents of the page: opened, edited, checked and saved with nothing running."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from corpus import corpus, needs_corpus

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.profile.examine import examine
from rtkit.profile.parameters.naming import Reference, with_references
from rtkit.profile.read import read_file
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.words import property_value
from rtkit.resources import resource
from rtkit.web.documents.component_types import TypeStock
from rtkit.web.documents.document import Document, opened
from rtkit.web.documents.document_edits import edited
from rtkit.web.documents.document_view import fitting_ports
from rtkit.web.documents.lost_variables import lost_variables
from rtkit.web.jobs.running import outcome_of

SHIPPED = Path(resource("profiles"))
SYSTEM = SHIPPED / "systems" / "sensor-controller-motor.xml"
TYPES = TypeStock([str(SHIPPED)])
SYSTEMS = [each for each in corpus("rts/*", "yaml/*") if examine(each.read_bytes()).kind == "rts"]


def copied(folder: Path, source: Path = SYSTEM) -> Document:
    file = folder / source.name
    file.write_bytes(source.read_bytes())
    return opened("1", str(file), TYPES)


def do(document: Document, verb: str, **given: Any) -> str:
    """Edit a document; return the sentence that tells what was done."""
    profile, text = edited(document, {"do": verb, **given}, TYPES)
    document.edit(profile, text)
    return text


def type_file(name: str) -> str:
    return next(each["file"] for each in TYPES.records() if each["name"] == name)


@needs_corpus
@pytest.mark.parametrize("file", SYSTEMS, ids=lambda file: file.name[:60])
def test_a_profile_of_the_corpus_is_drawn_and_saved_as_the_same_model(
    file: Path, tmp_path: Path
) -> None:
    document = copied(tmp_path, file)
    record = document.record([])
    assert set(record["layout"]["boxes"]) == {each["id"] for each in record["components"]}
    assert not document.is_changed
    document.save(str(tmp_path / file.name), is_replaced=True)
    assert read_file(str(tmp_path / file.name)).profile == read_file(str(file)).profile


@needs_corpus
@pytest.mark.parametrize("file", SYSTEMS, ids=lambda file: file.name[:60])
def test_what_is_arranged_and_undone_is_as_before(file: Path, tmp_path: Path) -> None:
    document = copied(tmp_path, file)
    before = document.profile
    do(document, "arrange")
    located = document.profile.components
    document.save(str(tmp_path / f"moved{file.suffix}"), is_replaced=False)
    again = opened("2", document.file, TYPES)
    assert again.profile.components == located
    if before.components:
        document.move(-1)
        assert document.profile == before


@needs_corpus
def test_places_and_bend_points_of_other_editors_are_used_and_kept(tmp_path: Path) -> None:
    (file,) = corpus("rts/*navSystem.xml")
    document = copied(tmp_path, file)
    record = document.record([])
    places = {c.instance_name: c.location for c in document.profile.components}
    assert record["places"] == {
        name: {"x": at.x, "y": at.y, "direction": at.direction}
        for name, at in places.items()
        if at is not None
    }
    (points,) = record["bends"].values()
    assert points == [[933, 248], [541, 393], [102, 353]]
    moved = next(iter(places))
    at = places[moved]
    assert at is not None
    do(document, "move", places={moved: {"x": 7.4, "y": 9}})
    after = next(c.location for c in document.profile.components if c.instance_name == moved)
    assert after is not None
    assert (after.x, after.y) == (7, 9)
    assert (after.width, after.height, after.direction) == (at.width, at.height, at.direction)
    assert document.record([])["bends"] == record["bends"]


def findings_of(document: Document) -> list[tuple[str, str, str]]:
    found = document.record([])["findings"]
    return sorted((each["severity"], each["rule"], each["text"]) for each in found)


def test_findings_are_those_of_the_command(tmp_path: Path) -> None:
    document = copied(tmp_path)
    assert findings_of(document) == []
    do(document, "configure", component="Motor0", set="default", values={"nothing": "1"})
    do(document, "add", type=type_file("MyServiceConsumer"))
    document.save(document.file, is_replaced=False)
    line = ("rtprofile", "check", "--json", "--components", str(SHIPPED), document.file)
    told = asyncio.run(outcome_of(line))
    listed = json.loads(told.out)["findings"]
    assert len(listed) >= 2
    assert findings_of(document) == sorted(
        (each["severity"], each["rule"], each["text"]) for each in listed
    )


def test_a_component_is_added_renamed_connected_and_removed(tmp_path: Path) -> None:
    document = copied(tmp_path)
    before = document.profile
    assert do(document, "add", type=type_file("Motor"), at={"x": 5, "y": 6}) == "Add Motor1"
    do(document, "rename", component="Motor1", name="Left")
    made = document.profile.components[-1]
    assert (made.instance_name, made.path_uri) == ("Left", "localhost/Left.rtc")
    assert all(each.name.startswith("Left.") for each in made.data_ports)
    do(document, "connect", source="Left:velocity", target="Controller0:velocity")
    wire = document.profile.data_port_connectors[-1]
    assert (wire.source.instance_name, wire.target.instance_name) == ("Controller0", "Left")
    with pytest.raises(Refused, match="connected already"):
        do(document, "connect", source="Controller0:velocity", target="Left:velocity")
    do(document, "remove", components=["Left"], connectors=[])
    assert document.profile == before
    assert not document.is_changed
    for _ in range(4):
        document.move(-1)
    with pytest.raises(Refused, match="nothing to undo"):
        document.move(-1)


def test_a_component_is_added_beside_what_is_there(tmp_path: Path) -> None:
    document = copied(tmp_path)
    do(document, "add", type=type_file("Motor"))
    assert document.places() == {}  # the layout places all, so that none lie on each other
    do(document, "arrange")
    do(document, "add", type=type_file("Motor"))
    record = document.record([])
    lowest = max(box["y"] for id, box in record["places"].items() if id != "Motor2")
    assert record["places"]["Motor2"]["y"] > lowest


def named(document: Document) -> set[str]:
    """Return the components that a profile names anywhere."""
    found = {each.instance_name for each in document.profile.components}

    def note(reference: Reference) -> Reference:
        found.add(reference.instance_name)
        return reference

    with_references(document.profile, note)
    return found


def test_what_refers_to_a_component_follows_its_name_and_goes_with_it(tmp_path: Path) -> None:
    document = copied(tmp_path)
    do(document, "rename", component="Controller0", name="Brain")
    assert {"Brain", "Sensor0", "Motor0"} == named(document)
    do(document, "remove", components=["Brain"], connectors=[])
    assert {"Sensor0", "Motor0"} == named(document)


def test_a_port_that_does_not_fit_says_why(tmp_path: Path) -> None:
    document = copied(tmp_path)
    whys = {e["path"]: e["why"] for e in fitting_ports(document.view, "Sensor0:distance")}
    assert whys["Controller0:distance"] == ""
    assert "Data types differ" in whys["Motor0:velocity"] or "port type" in whys["Motor0:velocity"]
    with pytest.raises(Refused, match="cannot be connected"):
        do(document, "connect", source="Sensor0:distance", target="Motor0:velocity")


@pytest.mark.parametrize(
    ("verb", "given", "error", "text"),
    [
        ("rename", {"component": "Motor0", "name": "Sensor0"}, Refused, "named Sensor0"),
        ("rename", {"component": "Motor0", "name": "a/b"}, Malformed, "a/b"),
        ("rename", {"component": "Nobody", "name": "a"}, NotFound, "Nobody"),
        ("add", {"type": "/etc/passwd"}, NotFound, "/etc/passwd"),
        ("remove", {"components": [], "connectors": ["zz"]}, NotFound, "zz"),
        ("move", {"places": {"Motor0": {"x": "left"}}}, Malformed, "x and y"),
        ("remove_set", {"component": "Motor0", "set": "none"}, NotFound, "none"),
        ("resize", {"component": "Motor0", "width": 0, "height": 9}, Malformed, "above 0"),
        ("turn", {"component": "Motor0", "direction": "NORTH"}, Malformed, "NORTH"),
        ("bend", {"connector": "1", "points": [{"x": 1}]}, Malformed, "x and y"),
        ("bend", {"connector": "zz", "points": []}, NotFound, "zz"),
        ("identify", {"vendor": "a:b", "name": "n", "version": "1"}, Malformed, "vendor"),
        ("fly", {}, Malformed, "fly"),
    ],
)
def test_an_edit_that_makes_no_sense_is_refused_and_changes_nothing(
    verb: str, given: dict[str, Any], error: type[Exception], text: str, tmp_path: Path
) -> None:
    document = copied(tmp_path)
    with pytest.raises(error, match=text):
        do(document, verb, **given)
    assert not document.is_changed


def test_sets_properties_and_the_identity_are_edited(tmp_path: Path) -> None:
    document = copied(tmp_path)
    do(document, "add_set", component="Motor0", set="slow", source="")
    do(document, "configure", component="Motor0", set="slow", values={"a": "1", "b": "2"})
    do(document, "configure", component="Motor0", set="slow", values={"a": None})
    do(document, "activate_set", component="Motor0", set="slow")
    with pytest.raises(Refused, match="active set"):
        do(document, "remove_set", component="Motor0", set="slow")
    do(document, "require", component="Motor0", is_required=False)
    do(document, "state", component="Motor0", key="rtkit.restart", value="never")
    do(document, "identify", vendor="V", name="N", version="2", comment="c", log=["first"])
    (motor,) = [c for c in document.profile.components if c.instance_name == "Motor0"]
    assert [(d.name, d.data) for d in motor.configuration_sets[-1].data] == [("b", "2")]
    assert motor.active_configuration_set == "slow"
    assert not motor.is_required
    assert property_value(motor.properties, "rtkit.restart") == "never"
    assert document.profile.id == "RTSystem:V:N:2"
    document.save(document.file, is_replaced=False)
    assert read_file(document.file).profile == document.profile
    assert isinstance(document.profile, RtsProfile)
    assert document.profile.version_up_logs == ("first",)


def test_a_box_is_resized_and_turned_and_a_wire_is_bent(tmp_path: Path) -> None:
    document = copied(tmp_path)
    before = document.profile
    drawn = document.record([])["layout"]["boxes"]["Motor0"]
    do(document, "turn", component="Motor0", direction="DOWN")
    do(document, "resize", component="Motor0", width=300.4, height=120)
    place = document.record([])["places"]["Motor0"]
    assert place == {"x": max(drawn["x"], 1), "y": drawn["y"], "width": 300, "height": 120,
                     "direction": "DOWN"}  # fmt: skip
    id = document.record([])["connectors"][0]["id"]
    points = [{"x": 5, "y": 6}, {"x": -7, "y": 8}]
    do(document, "bend", connector=id, points=points)
    assert document.record([])["bends"] == {id: [[5, 6], [-7, 8]]}
    document.save(str(tmp_path / "bent.xml"), is_replaced=False)
    again = opened("2", document.file, TYPES)
    assert again.record([])["bends"] == {id: [[5, 6], [-7, 8]]}
    assert again.record([])["places"] == {"Motor0": place}
    do(document, "bend", connector=id, points=[])
    assert document.record([])["bends"] == {}
    for _ in range(4):
        document.move(-1)
    assert document.profile == before


def test_what_a_connector_is_said_to_be_is_said_once(tmp_path: Path) -> None:
    document = copied(tmp_path)
    connector = document.profile.data_port_connectors[0]
    given = {"dataport.subscription_type": "flush"}
    do(document, "connector", connector=connector.connector_id, properties=given)
    assert document.profile.data_port_connectors[0].subscription_type == "flush"


def test_variables_that_an_edit_would_replace_are_named(tmp_path: Path) -> None:
    file = tmp_path / "variable.xml"
    text = SYSTEM.read_text(encoding="utf-8")
    first = read_file(str(SYSTEM)).profile
    assert isinstance(first, RtsProfile)
    component = next(c for c in first.components if c.configuration_sets)
    chosen, item = component.configuration_sets[0], component.configuration_sets[0].data[0]
    stated = f'rts:data="{item.data}" rts:name="{item.name}"'
    if stated not in text:
        stated = f'rts:name="{item.name}" rts:data="{item.data}"'
    assert stated in text
    file.write_text(text.replace(stated, stated.replace(f'"{item.data}"', '"${wall}"'), 1))
    document = opened("1", str(file), TYPES)
    name = component.instance_name
    edit = {"do": "configure", "component": name, "set": chosen.id, "values": {item.name: "7"}}
    changed, _ = edited(document, edit, TYPES)
    assert lost_variables(document.profile, changed) == [
        f"{name}.{chosen.id}.{item.name} is ${{wall}}"
    ]
    moved, _ = edited(document, {"do": "move", "places": {name: {"x": 1, "y": 2}}}, TYPES)
    assert lost_variables(document.profile, moved) == []
    gone, _ = edited(document, {"do": "remove", "components": [name], "connectors": []}, TYPES)
    assert lost_variables(document.profile, gone) == []


def test_parts_of_included_files_are_shown_resolved_and_only_read(tmp_path: Path) -> None:
    for each in (SHIPPED / "systems").iterdir():
        (tmp_path / each.name).write_bytes(each.read_bytes())
    document = opened("1", str(tmp_path / "two-robots.xml"), TYPES)
    record = document.record([])
    included = [each for each in record["components"] if each["origin"]]
    assert included
    with pytest.raises(Refused, match="which this profile includes"):
        do(document, "rename", component=included[0]["id"], name="other")
    do(document, "add", type=type_file("Motor"))
    origins = {each["name"]: each["origin"] for each in document.record([])["components"]}
    assert [name for name, origin in origins.items() if not origin] == ["Motor0"]
    document.save(document.file, is_replaced=False)
    profile = read_file(document.file).profile
    assert isinstance(profile, RtsProfile)
    assert len(profile.components) == len(document.profile.components)
    assert profile.includes


def test_a_file_that_somebody_else_changed_is_not_overwritten(tmp_path: Path) -> None:
    document = copied(tmp_path)
    do(document, "require", component="Motor0", is_required=False)
    file = Path(document.file)
    file.write_bytes(file.read_bytes() + b"\n")
    with pytest.raises(Refused, match="changed by somebody else"):
        document.save(document.file, is_replaced=False)
    other = tmp_path / "other.yaml"
    other.write_text("kept")
    with pytest.raises(Refused, match="is there already"):
        document.save(str(other), is_replaced=False)
    assert other.read_text() == "kept"
    document.save(str(other), is_replaced=True)
    assert read_file(str(other)).profile == document.profile


def test_a_file_that_is_no_system_says_so(tmp_path: Path) -> None:
    file = tmp_path / "Motor.xml"
    file.write_bytes((SHIPPED / "Motor.xml").read_bytes())
    with pytest.raises(Malformed, match="no sound system profile"):
        opened("1", str(file), TYPES)
