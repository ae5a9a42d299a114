"""Property pages without services: descriptions, values as pages get them, components."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import pytest

from rtkit import Element, PropertyError
from rtkit.api.asked import Ask
from rtkit.api.client import Client
from rtkit.api.property_change import PropertyChange
from rtkit.errors import NotFound
from rtkit.panel.description import Panel, element_of, read_panel
from rtkit.panel.generic import generic
from rtkit.property.reading import read
from rtkit.property.writing import write
from rtkit.web.properties.description import PropertyDescriptions, watched
from rtkit.web.properties.foreign_components import ForeignComponents
from rtkit.web.properties.property_services import PropertyServices
from rtkit.web.properties.property_watches import shown_of
from rtkit.web.properties.room import set_line
from rtkit.wires.http.pages import COMPONENT_HEADERS

ROBOT = (
    '<gui kind="group" name="" type="(mobilerobot)">'
    '<gui kind="vector" name="location" type="vector[6]" access="r"/>'
    '<gui kind="joystick" name="velocity" type="vector[6]" access="rw" after="0.5"/>'
    '<gui kind="text" name="say" type="string" access="w"/>'
    '<gui kind="group" name="behaviors"><gui kind="button" name="behaviors.moveto" access="rw">'
    '<gui kind="marker" name="target" type="marker" argument="true"/></gui></gui></gui>'
)


class Answers:
    """A client that answers from a table; what is not in it is unknown."""

    def __init__(self, table: Mapping[str, str]) -> None:
        self.table = dict(table)

    def payload(self, ask: Ask, timeout_s: float) -> str:
        if ask.target not in self.table:
            raise PropertyError("unknown", f"{ask.target}: unknown")
        return self.table[ask.target]

    def get(self, target: str, **_options: object) -> Any:
        return read(self.payload(Ask(target), 1.0))


class Known(PropertyServices):
    """Services that are there, without a look."""

    def __init__(self, client: Answers, **types: tuple[str, ...]) -> None:
        super().__init__(cast("Client", client))
        self.types = types

    def of_type(self, word: str) -> list[str]:
        return [name for name, types in self.types.items() if word in types]


def descriptions(table: Mapping[str, str], **types: tuple[str, ...]) -> PropertyDescriptions:
    client = Answers(table)
    return PropertyDescriptions(cast("Client", client), Known(client, **types))


def names(panel: Panel) -> list[str]:
    return [f"{each.kind} {each.name}" for each in panel.all()]


def test_names_are_whole_targets_and_a_robot_has_a_map_with_what_others_know() -> None:
    table = {"r1.gui": ROBOT, "world.rooms.properties": "(hall)"}
    found = descriptions(table, model=("environment",), r1=("mobilerobot",), r2=("mobilerobot",),
                         world=("world",)).of("r1")  # fmt: skip
    assert names(found) == [
        "group r1", "map r1.location", "vector r1.location", "joystick r1.velocity", "text r1.say",
        "group r1.behaviors", "button r1.behaviors.moveto",
    ]  # fmt: skip
    layers = ["model.markers", "r2.location", "world.rooms.hall", "r1.behaviors.moveto"]
    assert found.children[0].texts("layers") == layers
    button = found.children[-1].children[0]
    assert [each.name for each in button.arguments] == ["target"]
    shown = ["r1.location", "r1.velocity", "r1.behaviors.moveto", *layers]
    assert sorted(set(watched(found))) == sorted(set(shown))


def test_a_part_of_a_service_is_a_page_without_a_map() -> None:
    part = '<gui kind="joystick" name="velocity" type="vector[6]" access="rw"/>'
    assert names(descriptions({"r1.velocity.gui": part}).of("r1.velocity")) == [
        "joystick r1.velocity"
    ]


def test_components_by_type_are_put_on_and_html_is_told_with_its_version() -> None:
    table = {
        "r1.gui": ROBOT,
        "gui.properties": "(mobilerobot.text mobilerobot.html)",
        "gui.mobilerobot.text": '<gui label="Drive"><gui name="velocity" label="Go"/></gui>',
        "gui.mobilerobot.html": "<p>one</p>",
    }
    client = Answers(table)
    described = PropertyDescriptions(cast("Client", client), Known(client, gui=("gui",)))
    before = described.of("r1")
    assert before.attributes["label"] == "Drive"
    assert [each.attributes.get("label") for each in before.children] == ["Go"]
    assert before.attributes["html"] == "gui.mobilerobot.html"
    client.table["gui.mobilerobot.html"] = "<p>two</p>"
    assert described.of("r1").attributes["version"] != before.attributes["version"]


def test_where_there_is_no_gui_types_make_the_widgets() -> None:
    table = {
        "old.properties": "(speed name)",
        "old.speed.meta": "<meta><type>number</type><access>rw</access><min>0</min><max>2</max>"
        "<unit>m/s</unit></meta>",
        "old.speed": "1.5",
        "old.name": "(1 2 3)",
    }
    found = descriptions(table).of("old")
    assert names(found) == ["group old", "slider old.speed", "vector old.name"]
    assert found.children[0].attributes["unit"] == "m/s"
    with pytest.raises(PropertyError, match=r"gone\.meta|gone"):
        descriptions({}).of("gone")


def test_meta_of_another_make_makes_a_widget_all_the_same() -> None:
    meta = read("<meta><type>strange!</type><access>often</access><min>(1)</min></meta>")
    assert isinstance(meta, Element)
    made = generic("p", meta, b"raw").attributes
    assert made == {"kind": "label", "name": "p", "type": "any", "access": "r"}


def test_a_page_put_together_has_properties_of_several_services_and_one_map() -> None:
    lamp = '<gui kind="toggle" name="on" type="boolean" access="rw"/>'
    place = '<gui kind="vector" name="location" type="vector[6]" access="r"/>'
    table = {"lamp.on.gui": lamp, "r1.location.gui": place, "r2.location.gui": place}
    page = read_panel(
        '<gui kind="group" label="Home"><gui name="lamp.on" label="Light"/>'
        '<gui name="r1.location" kind="map"/><gui name="r2.location" kind="map"/>'
        '<gui kind="group" label="Far"><gui name="gone.away"/></gui></gui>'
    )
    found = descriptions(table).of_page(page)
    assert names(found) == [
        "group ", "toggle lamp.on", "map r1.location", "group ", "label gone.away",
    ]  # fmt: skip
    assert found.children[0].attributes["label"] == "Light"
    assert found.children[1].texts("layers") == ["r2.location"]
    assert "unknown" in found.children[2].children[0].attributes["away"]
    assert read_panel(write(element_of(found))) == found


def test_a_page_has_a_bound() -> None:
    page = Panel({"kind": "group"}, (Panel({"name": "a"}),) * 201)
    with pytest.raises(PropertyError, match="200"):
        descriptions({}).of_page(page)


CHANGES = [
    (PropertyChange("p", "1.5", 0.0), ("1.5", "good", "", False)),
    (PropertyChange("p", b"1234", 0.0), ("4 bytes", "good", "", True)),
    (PropertyChange("p", "1.5", 0.0, "stale", "no-service"), ("1.5", "stale", "", False)),
    (PropertyChange("p", "", 0.0, "bad", "unknown"), ("", "bad", "unknown", False)),
]


@pytest.mark.parametrize(("change", "shown"), CHANGES)
def test_changes_as_pages_get_them(change: PropertyChange, shown: tuple[object, ...]) -> None:
    assert tuple(shown_of(change).values()) == shown


def test_an_address_of_a_component_is_good_once_and_its_policy_has_no_network() -> None:
    components = ForeignComponents()
    address = components.address_for("<p>code</p>")
    id = address.removeprefix("/component/")
    assert components.take(id) == "<p>code</p>"
    with pytest.raises(NotFound):
        components.take(id)
    policy = dict(COMPONENT_HEADERS)["Content-Security-Policy"]
    assert "sandbox allow-scripts;" in policy
    assert "default-src 'none'" in policy
    assert "connect-src" not in policy
    assert "allow-same-origin" not in policy


def test_a_component_that_nobody_takes_gives_way() -> None:
    components = ForeignComponents()
    first = components.address_for("1").removeprefix("/component/")
    for each in range(200):
        last = components.address_for(str(each)).removeprefix("/component/")
    with pytest.raises(NotFound):
        components.take(first)
    assert components.take(last) == "199"


@pytest.mark.parametrize(
    ("target", "text", "line"),
    [
        ("lamp.on", "true", "rtset lamp.on true"),
        ("lamp.name", "a b'c", "rtset lamp.name 'a b'\"'\"'c'"),
        ("arm.angle", "-0.5", "rtset -- arm.angle -0.5"),
    ],
)
def test_a_set_is_shown_as_the_command_line_that_does_it(target: str, text: str, line: str) -> None:
    assert set_line(target, text) == line
