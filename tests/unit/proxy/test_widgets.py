"""Widgets as a proxy passes them on, and those of mounts in their places."""

from __future__ import annotations

import pytest

from rtkit.proxy.narrowing import ROUND, joined, narrowed
from rtkit.proxy.prefix import PrefixedNames

ROBOT = (
    '<gui kind="group" name="" type="(rover)"><gui kind="slider" name="speed" access="rw"/>'
    '<gui kind="button" name="arm.lift" access="rw"><gui kind="number" name="to" access="rw"'
    ' argument="true"/></gui></gui>'
)


def test_names_and_access_are_those_of_this_side_and_arguments_stay() -> None:
    assert narrowed("gui", ROBOT, lambda name: name != "r1.speed", PrefixedNames("r1").outward) == (
        '<gui kind="group" name="r1" type="(rover)"><gui kind="slider" name="r1.speed" access="r"/>'
        '<gui kind="button" name="r1.arm.lift" access="rw"><gui kind="number" name="to" access="rw"'
        ' argument="true"/></gui></gui>'
    )


def test_a_part_of_an_owner_has_names_from_there() -> None:
    text = '<gui kind="group" name="arm"><gui kind="label" name="arm.angle" access="r"/></gui>'
    assert narrowed("gui", text, lambda _: True, PrefixedNames("left", "arm").outward) == (
        '<gui kind="group" name="left"><gui kind="label" name="left.angle" access="r"/></gui>'
    )


@pytest.mark.parametrize("text", ["(1 2)", "<other/>", "word", "<<"])
def test_what_is_no_gui_is_passed_on_as_it_is(text: str) -> None:
    assert narrowed("gui", text, lambda _: False, lambda name: f"x.{name}") == text
    assert joined(text, {"a": ROBOT}) == text


def test_widgets_of_owners_take_the_places_of_their_mounts() -> None:
    own = (
        '<gui kind="group" name=""><gui kind="group" name="robots"><gui kind="table"'
        ' name="robots.a"/><gui kind="table" name="robots.b"/></gui><gui kind="button" name="job">'
        '<gui kind="number" name="robots.a" argument="true"/></gui></gui>'
    )
    a = '<gui kind="group" name="robots.a"><gui kind="label" name="robots.a.x"/></gui>'
    for told, why in (("<<", "away"), ("", "away"), (ROUND, "round")):
        found = joined(own, {"robots.a": a, "robots.b": told})
        assert found == (
            f'<gui kind="group" name=""><gui kind="group" name="robots">{a}'
            f'<gui kind="table" name="robots.b" {why}="true"/></gui><gui kind="button" name="job">'
            '<gui kind="number" name="robots.a" argument="true"/></gui></gui>'
        )
