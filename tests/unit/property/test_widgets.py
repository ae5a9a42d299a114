"""Widgets as ``.gui`` describes them: of each kind of property, of groups, of a whole service."""

from __future__ import annotations

import pytest
from conformance import subject

from rtkit.property.functional import FunctionalProperty
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.reading import read
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.service import Service
from rtkit.property.types import parse_type
from rtkit.property.values import Element, Word

LOCATION = Element("marker", {}, (Element("location", {}, (), (1.0, 2.0)),))
KINDS = [
    ("boolean", {}, True, "toggle"),
    ("number", {}, 1.0, "number"),
    ("number", {"minimum": 0}, 1.0, "number"),
    ("integer", {"minimum": 0, "maximum": 9}, 1, "slider"),
    ("word", {"choices": (Word("a"), Word("b"))}, Word("a"), "choice"),
    ("string", {}, "a", "text"),
    ("vector[3]", {}, (1.0, 2.0, 3.0), "vector"),
    ("vector[3]", {"access": "r"}, (1.0, 2.0, 3.0), "vector"),
    ("number", {"access": "r", "minimum": 0, "maximum": 9}, 1.0, "label"),
    ("marker", {}, LOCATION, "marker"),
    ("list<marker>", {"access": "r"}, (LOCATION,), "map"),
    ("list", {}, (1.0, Word("a")), "table"),
    ("element", {"access": "r"}, Element("a"), "tree"),
    ("any", {}, 1.0, "number"),
    ("any", {}, (LOCATION,), "table"),
    ("number", {"widget": {"kind": "knob", "ticks": "5"}}, 1.0, "knob"),
]


@pytest.mark.parametrize(("type_name", "declared", "value", "kind"), KINDS)
def test_the_kind_follows_from_type_access_range_and_choices(
    type_name: str, declared: dict[str, object], value: object, kind: str
) -> None:
    service = Service("it")
    service.add("p", value, PropertySpec(parse_type(type_name), **declared))  # type: ignore[arg-type]
    found = read(str(service.get("p.gui")))
    assert isinstance(found, Element)
    assert (found.attributes["kind"], found.attributes["name"]) == (kind, "p")
    assert found.attributes.get("ticks") == dict(declared.get("widget", {})).get("ticks")  # type: ignore[call-overload]


def test_pictures_are_known_by_their_names_and_parts_by_those_of_their_vector() -> None:
    service = Service("it")
    service.add("front.image", b"", PropertySpec(parse_type("bytes"), "r"))
    service.add("blob", b"", "bytes")
    service.add("location", (0.0,) * 6, "vector[6]")
    kinds = [read(str(service.get(f"{each}.gui"))).attributes["kind"]  # type: ignore[union-attr]
             for each in ("front.image", "blob", "location.x")]  # fmt: skip
    assert kinds == ["image", "label", "number"]
    assert 'labels="(x y z a b c)"' in str(service.get("location.gui"))
    assert 'name="location.x"' in str(service.get("location.x.gui"))


def test_a_service_is_one_tree_with_the_arguments_of_its_actions() -> None:
    service = Service("it")
    service.add("type", (Word("mobilerobot"),), "list<word>")
    service.add("arm.angle", 0.0, PropertySpec(parse_type("number"), minimum=-1, maximum=1))
    declared = (RequestParameter("n", parse_type("integer"), 3, (), "how many"),)
    action = FunctionalProperty(lambda n: n, declared)
    spec = PropertySpec(parameters=declared, is_functional=True)
    service.add("arm.wave", spec=spec, function=action)
    tree = read(str(service.get("gui")))
    assert isinstance(tree, Element)
    assert tree.attributes == {"kind": "group", "type": "(mobilerobot)", "name": ""}
    arm = tree.children[1]
    assert (arm.attributes["kind"], arm.attributes["name"]) == ("group", "arm")
    assert [each.attributes["name"] for each in arm.children] == ["arm.angle", "arm.wave"]
    (argument,) = arm.children[1].children
    assert argument.attributes == {
        "kind": "number", "name": "n", "type": "integer", "access": "rw", "doc": "how many",
        "argument": "true", "default": "3"}  # fmt: skip
    assert read(str(service.get("arm.gui"))) == arm


def test_a_behaviour_is_a_button_with_its_target() -> None:
    service = Service("it")
    service.add("behaviors.moveto", Element("behavior", {"state": "idle"}), "any")
    found = read(str(service.get("behaviors.moveto.gui")))
    assert isinstance(found, Element)
    assert found.attributes["kind"] == "button"
    assert [each.attributes["type"] for each in found.children] == ["marker"]


def test_who_may_not_set_sees_widgets_that_do_nothing() -> None:
    answers: list[str] = []
    stranger = Requester()
    asked = PropertyRequest("gui", None, lambda it: answers.append(str(it.payload)), stranger)
    subject().handle(asked)
    tree = read(answers[0])
    assert isinstance(tree, Element)
    assert {each.attributes.get("access") for each in tree.children} <= {"r", "w", None}
