"""Templates of names, and the other values that are more than a word."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, Refused
from rtkit.rtc.profiles import TypeProfile
from rtkit.settings import formats, values

ARM = TypeProfile("Arm", "me/you", "Robot", "1.0")


def expand(*templates, type=ARM):
    return formats.expand(templates, instance="Arm0", host="box", manager="left", type=type, pid=7)


def test_every_letter():
    (name,) = expand("%h.host_cxt/%M.mgr/%c-%t-%m-%V-%v-%p-%%n/%n.rtc")
    assert name == "localhost/box.host_cxt/left.mgr/Robot-Arm-Arm-me_you-1.0-7-%n/Arm0.rtc"


def test_a_name_that_two_templates_give_is_one():
    assert expand("%n.rtc", "Arm0.rtc", "%t/%n.rtc") == (
        "localhost/Arm0.rtc",
        "localhost/Arm/Arm0.rtc",
    )


def test_a_name_never_leaves_its_folder():
    with pytest.raises(Malformed, match="empty element"):
        expand("%V/%n.rtc", type=TypeProfile("Arm"))
    with pytest.raises(Malformed, match="empty element"):
        expand("%V/%n.rtc", type=TypeProfile("Arm", ".."))


@pytest.mark.parametrize(
    ("template", "is_early"),
    [("%n.rtc", True), ("%h/%M/%n", True), ("%%t%n", True), ("%t/%n", False), ("%p", False)],
)
def test_what_is_known_before_a_component_is_made(template, is_early):
    assert formats.is_early(template) is is_early


@pytest.mark.parametrize(
    "text", ["%x", "%", "a%", "/%n", "a//b", "a/", "./a", "a:b", "*a", "a/*b", "a\x1bb"]
)
def test_templates_that_are_refused(text):
    with pytest.raises(Malformed):
        formats.check(text)


def test_a_list_of_templates():
    assert formats.check(" %n.rtc , %h.host_cxt/%n.rtc,") == ("%n.rtc", "%h.host_cxt/%n.rtc")


@pytest.mark.parametrize(
    ("text", "port"),
    [
        ("2811", 2811),
        (":2811", 2811),
        ("localhost:0", 0),
        ("127.0.0.1:1", 1),
        ("all", 2810),
        ("None", None),
    ],
)
def test_end_points(text, port):
    assert values.endpoint(text) == port


@pytest.mark.parametrize("text", ["", ":", "a", ":65536", ":-1", ":٣", ":1,:2"])
def test_no_end_points(text):
    with pytest.raises(Malformed):
        values.endpoint(text)


@pytest.mark.parametrize("text", ["*:2810", "box:2810", "[::]:2810"])
def test_end_points_that_others_could_reach(text):
    with pytest.raises(Refused, match="TLS"):
        values.endpoint(text)


def test_processors_and_modules():
    assert values.processors("0, 2-4,3") == {0, 2, 3, 4}
    assert values.modules("a.py (aInit), b ,c(d)") == (
        ("a.py", "aInit"),
        ("b", ""),
        ("c", "d"),
    )
    named = values.modules("my_robot.arm:ArmInit, ./b.py:bInit, /a:b/c.py")
    assert named == (("my_robot.arm", "ArmInit"), ("./b.py", "bInit"), ("/a:b/c.py", ""))
    for text in ("(x)", "a (", "a ()", "a (b) c"):
        with pytest.raises(Malformed):
            values.modules(text)
