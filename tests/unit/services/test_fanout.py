"""Fan-out of a group: what stands for the answers of all, and where each member is sent."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rtkit
from rtkit.services.fanout import (
    MemberFailure,
    Members,
    combined,
    error_of,
    formation,
    markers_in,
    middle_of,
)
from rtkit.services.frames import Frames

NUMBER = st.floats(-1000, 1000)
W = rtkit.Word
R0, R1 = W("r0"), W("r1")
POSES = st.lists(st.tuples(NUMBER, NUMBER, NUMBER), min_size=1, max_size=8)


@given(POSES, st.tuples(NUMBER, NUMBER))
def test_the_middle_arrives_and_offsets_are_kept(
    places: list[tuple[float, ...]], target: tuple[float, ...]
) -> None:
    poses = {f"r{at}": (*each, 0.0, 0.0, 0.0) for at, each in enumerate(places)}
    ways = formation([rtkit.Marker(target, frame="world")], poses, Frames())
    ends = {name: way[0].location or () for name, way in ways.items()}
    middle, before = middle_of(ends.values()), middle_of(poses.values())
    assert middle[:2] == pytest.approx(target, abs=1e-6)
    for name, pose in poses.items():
        for at in range(2):
            assert ends[name][at] - middle[at] == pytest.approx(pose[at] - before[at], abs=1e-6)


def test_ahead_is_ahead_of_the_middle() -> None:
    north = (0.0, 0.0, 0.0, math.pi / 2)
    poses = {"a": (0.0, 1.0, *north), "b": (2.0, 1.0, *north)}
    markers = [
        rtkit.Marker((1.0, 0.0), type="goal"),
        rtkit.Marker((2, 0, 0, 0, 0, 0), frame="base"),
    ]
    ways = formation(markers, poses, Frames())
    assert ways["a"][0].location == pytest.approx((0.0, 2.0))
    assert ways["b"][1].location == pytest.approx((2.0, 3.0, 0.0, 0.0, 0.0, math.pi / 2))
    assert (ways["a"][0].type, ways["a"][0].frame) == ("goal", "world")
    with pytest.raises(rtkit.PropertyError, match="kitchen"):
        formation([rtkit.Marker((1, 0), frame="kitchen")], poses, Frames())


def test_directions_have_a_middle_where_angles_run_over() -> None:
    east = [(0.0, 0.0, 0.0, 0.0, 0.0, angle) for angle in (math.pi - 0.1, 0.1 - math.pi)]
    assert abs(middle_of(east)[5]) == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("answers", "one"),
    [
        ([1, 2.0], 1.5),
        ([(1, 2), (3, 4)], (2.0, 3.0)),
        (["idle", "idle"], "idle"),
        ([True, True], True),
        ([True, False], ((R0, True), (R1, False))),
        (["idle", 1], ((R0, "idle"), (R1, 1))),
        ([(1,), (1, 2)], ((R0, (1,)), (R1, (1, 2)))),
        ([()], ()),
    ],
)
def test_what_stands_for_all(answers: list[object], one: object) -> None:
    assert combined({f"r{at}": each for at, each in enumerate(answers)}, ()) == one


def test_turning_has_a_mean_where_it_is_no_direction() -> None:
    turning = {"r0": (0.0,) * 5 + (4.0,), "r1": (0.0,) * 5 + (5.0,)}
    assert combined(turning, (), "velocity")[5] == 4.5
    assert combined(turning, (), "location")[5] == pytest.approx(4.5 - math.tau)


def behavior(state: str) -> rtkit.Element:
    return rtkit.Element("behavior", {"state": state}, (rtkit.Element("target"),))


def test_a_behavior_runs_while_one_runs_and_who_stands_otherwise_is_named() -> None:
    late = MemberFailure("r9", "timeout", "no answer within 1 s")
    found = combined({"r1": behavior("done"), "r2": behavior("running")}, [late])
    assert found.attributes == {"state": "running"}
    assert found.find("others").leaf == ((R1, W("done")), (W("r9"), W("timeout")))
    assert combined({"r1": behavior("done"), "r2": behavior("failed")}, ()).attributes == {
        "state": "failed"
    }
    assert combined({"r1": behavior("done")}, ()).find("others") is None
    assert combined({"r1": behavior("odd")}, ()).attributes == {"state": "odd"}


def going(location: object, frame: str = "world") -> rtkit.Element:
    fields = {"type": W("home"), "location": location, "frame": W(frame)}
    parts = tuple(rtkit.Element(key, {}, (), each) for key, each in fields.items())
    target = rtkit.Element("target", {}, parts)
    return rtkit.Element("behavior", {"state": "running"}, (target,))


def test_the_target_of_all_is_that_of_the_middle() -> None:
    first = going((1.0, 1.0))
    found = combined({"r1": first, "r2": going((1.0, -1.0))}, ())
    assert found == going((1.0, 0.0))
    for other in (
        going((1.0, -1.0), "base"),
        going((1.0, -1.0, 0.0)),
        going((1.0, math.nan)),
        going("x"),
        behavior("done"),
    ):
        assert combined({"r1": first, "r2": other}, ()).find("target") == first.find("target")


def test_an_error_names_each_who_failed() -> None:
    slow, gone = MemberFailure("r1", "timeout", "late"), MemberFailure("r2", "no-service", "gone")
    assert error_of([slow], 3).code == "timeout"
    both = error_of([slow, gone], 3)
    assert (both.code, str(both)) == (
        "conflict", "2 of 3 failed: r1: timeout: late; r2: no-service: gone"
    )  # fmt: skip
    assert str(error_of([], 0)) == "there are no members"
    odd = [MemberFailure(name, "unknown", "no such property: x") for name in ("r3", "r4")]
    assert (error_of([*odd, slow], 3).code, str(error_of([*odd, slow], 3))) == (
        "unknown", "3 of 3 failed: r3 r4: unknown: no such property: x; r1: timeout: late"
    )  # fmt: skip
    assert error_of([*odd, MemberFailure("r5", "denied", "not that"), gone], 4).code == "conflict"


def test_members_have_names() -> None:
    members = Members(1.0)
    assert members.add("robots/r1") == ("r1", "robots/r1")
    assert members.add("line.7") == ("7", "line.7")
    assert members.add("left=zenoh:robots/r1") == ("left", "zenoh:robots/r1")
    assert members.add("robots/r1") == ("r1", "robots/r1")
    for robot, code in (("other/r1", "conflict"), ("", "bad-value"), ("a b=x", "bad-value"),
                        ("x=", "bad-value"), ("robots/", "bad-value")):  # fmt: skip
        with pytest.raises(rtkit.PropertyError) as caught:
            members.add(robot)
        assert caught.value.code == code
    members.remove("7")
    with pytest.raises(rtkit.PropertyError, match="no member: 7"):
        members.remove("7")
    assert members.present() == ["r1", "left"]
    with pytest.raises(rtkit.PropertyError, match="not served"):
        members.get(["r1"], "speed", {})


@pytest.mark.parametrize("deadline", [0, -1, math.inf, math.nan])
def test_a_deadline_is_a_time(deadline: float) -> None:
    with pytest.raises(rtkit.PropertyError, match="above 0 s"):
        Members(deadline)


def test_markers_are_found_alone_and_in_lists_and_nothing_else() -> None:
    marker = rtkit.Marker((1, 2))
    element = marker.__element__()
    assert [each.location for each in markers_in(element)] == [(1.0, 2.0)]
    assert len(markers_in((element, marker))) == 2
    for other in (1, "x", (1, 2), (), rtkit.Element("call"), (marker, 1)):
        assert markers_in(other) == []
