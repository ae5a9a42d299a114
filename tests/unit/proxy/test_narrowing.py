"""Meta data through a proxy tell the access that there is through it, and nothing else changes."""

from __future__ import annotations

import re

import pytest

from rtkit.property.messages import Answer
from rtkit.property.property_spec import PropertySpec
from rtkit.property.requests import PropertyRequest
from rtkit.property.service import Service
from rtkit.property.types import parse_type
from rtkit.proxy.narrowing import describes_access, narrowed


@pytest.fixture
def service() -> Service:
    service = Service("robot")
    for name, access in (("speed", "rw"), ("arm.angle", "rw"), ("serial", "r"), ("kick", "w")):
        service.add(name, 1.0, PropertySpec(parse_type("number"), access, doc="(odd) <text>"))
    return service


def ask(service: Service, target: str) -> str:
    answers: list[Answer] = []
    service.handle(PropertyRequest(target, None, answers.append))
    return str(answers[0].value())


@pytest.mark.parametrize("name", ["speed", "arm.angle", "serial", "kick"])
def test_only_the_access_of_what_may_not_be_set_is_narrowed(service: Service, name: str) -> None:
    for target in (f"{name}.meta", f"{name}.meta.access"):
        text = ask(service, target)
        assert narrowed(target, text, lambda asked: asked == name) == text
        assert narrowed(target, text, lambda _: False) == text.replace("rw", "r")


@pytest.mark.parametrize(
    ("target", "place"),
    [("properties?all&meta", ""), ("arm.properties?meta", "arm."), ("properties?meta&values", "")],
)
def test_a_listing_is_narrowed_name_by_name(service: Service, target: str, place: str) -> None:
    text = ask(service, target)
    told = narrowed(target.partition("?")[0], text, lambda name: name == "speed")
    assert told == re.sub(r"\(([^\s()]+) <meta>.*?</meta>", read_only, text)
    asked: list[str] = []
    narrowed(target.partition("?")[0], text, lambda name: bool(asked.append(name)))
    assert all(name.startswith(place) for name in asked)
    assert asked


def read_only(row: re.Match[str]) -> str:
    """Return the beginning of a row of a listing, as it is where only the speed may be set."""
    return row[0] if row[1] == "speed" else row[0].replace("rw", "r")


@pytest.mark.parametrize(
    ("name", "parameters", "tells"),
    [
        ("speed.meta", {}, True),
        ("speed.meta.access", {}, True),
        ("arm.properties", {"meta": None}, True),
        ("properties", {"all": None}, False),
        ("speed", {}, False),
        ("speed.gui", {}, True),
        ("gui", {}, True),
        ("speed.gui.html", {}, False),
    ],
)
def test_answers_that_tell_no_access_are_not_looked_at(
    name: str, parameters: dict[str, str | None], tells: bool
) -> None:
    assert describes_access(name, parameters) is tells


def test_what_cannot_be_read_is_passed_on_as_it_is() -> None:
    assert narrowed("speed.meta", "<<", lambda _: False) == "<<"
