"""Owned systems: the policy of movable components, and where they are."""

from __future__ import annotations

import pytest
import rts_text

from rtkit.deployment.owned import OwnedComponent, OwnedSystem, placed, read_movable, rules_of
from rtkit.errors import Malformed
from rtkit.profile.read import read_rts
from rtkit.rtc.serde import decode_text, encode_text

OWNED = OwnedSystem("S", "s.xml", "", {"A0": OwnedComponent("m@robot1", "m@robot1", 100)})


@pytest.mark.parametrize(
    ("text", "rule"),
    [("5", (5.0, ())), ("0", (0.0, ())), (" 2.5 robot2 localhost", (2.5, ("robot2", "localhost")))],
)
def test_a_policy_is_a_time_and_hosts(text, rule):
    assert read_movable("A0", text) == rule


@pytest.mark.parametrize("text", ["", "yes", "-1", "nan", "inf", "1e9", "robot2 5", "5s"])
def test_what_is_no_policy_is_refused_with_the_name(text):
    with pytest.raises(Malformed, match=r"A0: rtkit.movable: not SECONDS"):
        read_movable("A0", text)


def test_epochs_grow_with_the_time_and_without_it():
    once = OWNED.moved("A0", "manager", 500.7, is_stale=True)
    assert once.components["A0"] == OwnedComponent("manager", "m@robot1", 500, ("m@robot1",))
    assert once.is_pending
    again = once.moved("A0", "m@robot1", 3.0, is_stale=False)
    assert again.components["A0"] == OwnedComponent("m@robot1", "m@robot1", 501)
    assert not again.is_pending
    assert decode_text(OwnedSystem, encode_text(again)) == again


def test_only_what_was_moved_has_another_path():
    a, b = (
        rts_text.component(name, {"movable": "1"}, port="p", folder="robot1/arm.host_cxt")
        for name in ("A0", "B0")
    )
    text = rts_text.system("S", a, b, rts_text.wire("w", "A0.p", "B0.p"))
    profile = read_rts(text.encode(), "s.xml").profile
    assert set(rules_of(profile)) == {"A0", "B0"}
    assert placed(profile, OWNED) == profile
    moved = placed(profile, OWNED.moved("A0", "manager@robot2", 500, is_stale=True))
    assert [each.path_uri for each in moved.components] == [
        "robot2/A0.rtc",
        "robot1/arm.host_cxt/B0.rtc",
    ]
