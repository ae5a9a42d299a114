"""Further configuration sets by declaration: checked at definition, there from the beginning."""

from __future__ import annotations

import traceback

import pytest

from rtkit.builder.component_code import component_code
from rtkit.builder.prepare import Sources, prepare
from rtkit.builder.profile_of import profile_of
from rtkit.component import Component, Parameter
from rtkit.errors import Malformed, Refused
from rtkit.profile.read import read_rtc
from rtkit.profile.write import write_profile


class Drive(Component):
    """Drives."""

    version = "1.0"
    speed = Parameter(0.2, constraint="0<=x<=1.5", sets={"fast": 1, "slow": 0.1})
    gains = Parameter((1.0, 0.5), sets={"fast": [2, 1]})
    mode = Parameter("idle", constraint="(idle,drive)", sets={"fast": "drive"})
    count = Parameter(3)


def test_each_set_is_there_with_the_values_that_are_declared_for_it():
    sets = Drive("d0").configuration.sets
    assert sets["fast"] == {"speed": "1.0", "gains": "2.0,1.0", "mode": "drive"}
    assert sets["slow"] == {"speed": "0.1"}
    assert sets["default"] == {"speed": "0.2", "gains": "1.0,0.5", "mode": "idle", "count": "3"}


def test_the_create_string_takes_precedence_and_may_make_a_set_active():
    options = {"conf.fast.speed": "1.25", "configuration.active_config": "fast"}
    drive = Drive("d0", options)
    assert (drive.speed, drive.gains, drive.mode, drive.count) == (1.25, (2.0, 1.0), "drive", 3)


def test_a_declared_set_is_part_of_the_type_and_not_removed():
    with pytest.raises(Refused, match="fast was not added at run time"):
        Drive("d0").configuration.remove_set("fast")


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"sets": {"fast": 2}}, "cannot be '2' in set fast: it is to be 0<=x<=1.5"),
        ({"sets": {"fast": "x"}}, "cannot be 'x' in set fast: it is no number"),
        ({"sets": {"fast": object()}}, "a configuration parameter cannot be a object"),
        ({"sets": {"": 1}}, "name of a configuration set '' is empty"),
        ({"sets": {"a.b": 1}}, "'a.b' has characters that are not allowed: \\['.'\\]"),
        ({"sets": {"_fast": 1}}, "configuration set _fast could not be activated"),
        ({"sets": {"default": 1}}, "configuration set default is there already"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_where_it_is_declared(given, why):
    with pytest.raises(Malformed, match=why) as caught:
        Parameter(0.2, constraint="0<=x<=1.5", **given)
    files = [frame.filename for frame in traceback.extract_tb(caught.value.__traceback__)]
    assert files[0] == __file__


def test_the_profile_states_the_sets_and_the_generated_class_has_them():
    profile = profile_of(Drive("d0"), "2026-01-01T00:00:00", {})
    text = write_profile(profile, "xml")
    assert b'name="rtkit.set.fast" rtcExt:value="2.0,1.0"' in text
    again = read_rtc(text, "RTC.xml").profile
    subject, types = prepare(again, Sources())
    space: dict[str, object] = {}
    exec(component_code(subject, types), space)
    made = space["Drive"]
    assert isinstance(made, type)
    assert issubclass(made, Component)
    assert made("d0").configuration.sets == Drive("d0").configuration.sets


def test_a_value_of_a_profile_that_breaks_its_constraint_is_left_out_and_told():
    profile = profile_of(Drive("d0"), "2026-01-01T00:00:00", {})
    text = write_profile(profile, "xml").replace(b'rtcExt:value="1.0"', b'rtcExt:value="9"')
    subject, _ = prepare(read_rtc(text, "RTC.xml").profile, Sources())
    assert subject.notes == (
        "parameter speed cannot be '9.0' in set fast: it is to be 0<=x<=1.5; left out",
    )
    assert dict(subject.settings[0].sets) == {"slow": 0.1}
