"""A system profile with other places for components, and without some of its parts."""

from __future__ import annotations

import pytest
import rts_text

from rtkit.deployment.described import properties_of
from rtkit.deployment.placement.selection import with_other_places, without_parts
from rtkit.errors import NotFound, UsageProblem
from rtkit.profile.read import read_rts
from rtkit.profile.rts_model import RtsProfile

TEXT = rts_text.system(
    "Pair",
    rts_text.component("Source0", {"create": "Source?manager_name=s"}, port="out", gain="2"),
    rts_text.component("Sink0", {}, port="in", gain="1"),
    rts_text.wire("wire", "Source0.out", "Sink0.in"),
)


@pytest.fixture
def profile() -> RtsProfile:
    return read_rts(TEXT, "pair.xml").profile


def wires(profile: RtsProfile) -> list[str]:
    return [each.connector_id for each in profile.data_port_connectors]


def sets(profile: RtsProfile) -> dict[str, list[str]]:
    return {
        f"{each.instance_name}.{one.id}": [item.name for item in one.data]
        for each in profile.components
        for one in each.configuration_sets
    }


def test_a_component_takes_its_connectors_along(profile: RtsProfile) -> None:
    made = without_parts(profile, ["Sink0"])
    assert [each.instance_name for each in made.components] == ["Source0"]
    assert wires(made) == []
    assert wires(without_parts(profile, ["wire"])) == []
    assert without_parts(profile, []) == profile


def test_sets_and_parameters_are_left_out_and_what_is_gone_is_not_active(
    profile: RtsProfile,
) -> None:
    known = sets(profile)
    assert known["Source0.default"] == ["gain"]
    one = without_parts(profile, ["Source0.default.gain"])
    assert sets(one) == {**known, "Source0.default": []}
    for name in ("Source0.default", "Source0.*"):
        made = without_parts(profile, [name])
        assert sets(made) == {k: v for k, v in known.items() if k != "Source0.default"}
        assert not made.components[0].active_configuration_set


def test_a_component_goes_to_a_host_a_manager_or_a_slave(profile: RtsProfile) -> None:
    def place(text: str) -> tuple[str, str]:
        made = with_other_places(profile, {"Source0": text}, "manager")
        one, other = made.components
        assert other == profile.components[1]
        return one.path_uri, properties_of(one.properties)["rtkit.create"]

    create = "Source?manager_name=s"
    assert place("robot1") == ("robot1/Source0.rtc", create)
    assert place("/robot1/m.mgr") == ("robot1/m.mgr/Source0.rtc", create)
    assert place("localhost/manager.mgr") == ("localhost/Source0.rtc", create)
    assert place("localhost/m2.mgr/t.mgr") == (
        "localhost/m2.mgr/Source0.rtc",
        "Source?manager_name=t",
    )


@pytest.mark.parametrize("text", ["", "m.mgr", "a/b", "a/b.mgr/c", "a/b.mgr/c.mgr/d.mgr", "a/.mgr"])
def test_what_is_no_place_is_refused(profile: RtsProfile, text: str) -> None:
    with pytest.raises(UsageProblem, match="--place Source0="):
        with_other_places(profile, {"Source0": text}, "manager")


def test_what_is_not_there_is_named_with_what_is_near(profile: RtsProfile) -> None:
    with pytest.raises(NotFound, match=r"--place Sorce0=a: .*did you mean Source0"):
        with_other_places(profile, {"Sorce0": "a"}, "manager")
    with pytest.raises(NotFound, match=r"--without Sink: .*did you mean Sink0"):
        without_parts(profile, ["Sink"])
    with pytest.raises(UsageProblem, match=r"rtkit\.create .*needed for a slave \(t\)"):
        with_other_places(profile, {"Sink0": "localhost/manager.mgr/t.mgr"}, "manager")
