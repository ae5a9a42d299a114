"""Summaries of every profile there is, and how an outline becomes lines."""

from __future__ import annotations

import os.path
from dataclasses import replace

import pytest
from corpus import TYPED, everything, needs_corpus

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.read import read_file, read_rts
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.rts_rules import NO_DATE
from rtkit.profile_tools.outline import entry, outline_lines
from rtkit.profile_tools.summary import summary
from rtkit.resources import resource


def test_cells_stand_in_columns() -> None:
    rows = [
        entry("a", "bb", "c"),
        entry("aaa", "b", "", below=[entry("inner", "x"), entry("in", "y")]),
        entry("日本", "b", "long long"),
    ]

    def width(text: str) -> int:
        return sum(1 + (not c.isascii()) for c in text)

    assert list(outline_lines(rows, width, "> ")) == [
        "> a     bb  c",
        "> aaa   b",
        ">   inner  x",
        ">   in     y",
        "> 日本  b   long long",
    ]


def test_what_rtkit_says_of_a_component_is_told_and_what_others_say_is_not() -> None:
    profile = read_file(resource("profiles", "systems", "sensor-controller-motor.xml")).profile
    assert isinstance(profile, RtsProfile)
    first, *others = profile.components
    more = (
        ExtensionProperty("rtkit.limit.memory", "1G"),
        ExtensionProperty("editor.colour", "red"),
    )
    first = replace(first, properties=(*first.properties, *more))
    told = "\n".join(outline_lines([summary(replace(profile, components=(first, *others)))]))
    assert "rtkit.limit.memory  1G" in told
    assert "red" not in told


@needs_corpus
@pytest.mark.parametrize("file", everything(), ids=os.path.basename)
def test_every_profile_can_be_told(file: str) -> None:
    profile = read_file(file).profile
    lines = list(outline_lines([summary(profile)]))
    assert all(line == line.rstrip() and "\n" not in line for line in lines)
    text = "\n".join(lines)
    assert NO_DATE not in text
    names = [c.instance_name for c in getattr(profile, "components", ())]
    names += [port.name for port in getattr(profile, "data_ports", ())]
    assert [name for name in names if name not in text] == []


def test_orders_tell_what_is_waited_for() -> None:
    with open(TYPED / "pair.xml", "rb") as stream:
        profile = read_rts(stream.read()).profile
    assert profile.activation is not None
    lines = [line.strip() for line in outline_lines([summary(profile)])]
    start = lines.index("activation (2)")
    assert lines[start + 1 : start + 3] == [
        "1  Range0  after 20 ms",
        "2  Motor0  when Range0 is done (SYNC), at most 500 ms",
    ]
    shut = replace(profile, activation=None)
    assert not any("activation" in line for line in outline_lines([summary(shut)]))
