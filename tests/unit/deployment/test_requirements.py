"""Requirements of components about their place: read, refused by name, and told where unmet."""

from __future__ import annotations

import pytest

from rtkit.deployment.placement.choice import PlaceCandidate, PlacedComponent, PlacementProblem
from rtkit.deployment.placement.conflict import placed, unmet
from rtkit.deployment.placement.requirements import (
    DevicePolicy,
    Requirements,
    read_requirements,
    shared_slaves,
)
from rtkit.errors import Impossible, Malformed

MIB = 1 << 20
HOSTS = (
    PlaceCandidate("localhost", memory=900 * MIB, devices=frozenset(["/dev/video0"])),
    PlaceCandidate("robot1", frozenset(["arm"]), 120 * MIB, frozenset(["/dev/video0"])),
    PlaceCandidate("robot2", frozenset(["arm"]), 700 * MIB),
    PlaceCandidate("robot3", why_not="no answer within 2 s"),
)


def test_requirements_are_read():
    assert read_requirements(
        {
            "rtkit.place.hosts": "robot1, localhost",
            "rtkit.place.tags": "camera,gpu",
            "rtkit.place.memory": "500M",
            "rtkit.place.device": "video0,/opt/dev/can*,serial/by-id/usb-?",
            "rtkit.place.with": "A",
            "rtkit.place.not_with": "B",
            "rtkit.place.device_policy": "keep",
            "rtkit.restart": "always",
        }
    ) == Requirements(
        ("robot1", "localhost"),
        ("camera", "gpu"),
        500 * MIB,
        ("/dev/video0", "/opt/dev/can*", "/dev/serial/by-id/usb-?"),
        ("A",),
        ("B",),
        DevicePolicy.KEEP,
    )
    assert read_requirements({"rtkit.place.tags": " "}) == Requirements()


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [
        ("tag", "x", "unknown requirement: rtkit.place.tag (did you mean rtkit.place.tags?)"),
        ("memory", "lots", "rtkit.place.memory: not an amount of memory from 1M on"),
        ("memory", "-5M", "rtkit.place.memory: not an amount of memory from 1M on"),
        ("device", "../shadow", "rtkit.place.device: neither a name below /dev nor a path"),
        ("device", "/dev/*/0", "rtkit.place.device: * and ? may stand behind the last slash only"),
        ("device", "/dev//a", "rtkit.place.device: neither a name below /dev nor a path: /dev//a"),
        ("hosts", "robot1.rtc", "rtkit.place.hosts: not a name for a host"),
        ("tags", "a,,b", "rtkit.place.tags: an empty word in the list: a,,b"),
        ("not_with", "A,A", "rtkit.place.not_with: a word twice in the list: A,A"),
        ("device_policy", "panic", "rtkit.place.device_policy: not one of end, keep: panic"),
    ],
)
def test_a_requirement_that_makes_no_sense_is_refused_by_name(key, value, why):
    with pytest.raises(Malformed) as caught:
        read_requirements({f"rtkit.place.{key}": value})
    assert str(caught.value).startswith(why)


def test_a_component_cannot_be_with_and_not_with_another():
    with pytest.raises(Malformed, match=r"rtkit.place.with and rtkit.place.not_with both name A"):
        read_requirements({"rtkit.place.with": "A,B", "rtkit.place.not_with": "A"})


def test_components_of_one_process_share_the_slave_that_one_names():
    required = {
        "A": Requirements(with_=("B",)),
        "B": Requirements(),
        "C": Requirements(with_=("A",)),
        "D": Requirements(),
    }
    assert dict(shared_slaves(required, {"B": "eyes", "D": "arm"})) == {"A": "eyes", "C": "eyes"}
    assert dict(shared_slaves(required, {})) == {}
    with pytest.raises(Malformed, match="C and A share a process, but their create strings name"):
        dict(shared_slaves(required, {"A": "eyes", "C": "ears"}))
    with pytest.raises(Malformed, match=r"B asks for a slave of its own \(manager_%p\)"):
        dict(shared_slaves(required, {"B": "manager_%p"}))


def refusal(*components: PlacedComponent) -> str:
    with pytest.raises(Impossible) as caught:
        placed(PlacementProblem(components, HOSTS))
    return str(caught.value)


def test_each_host_is_told_with_what_it_lacks():
    required = Requirements(tags=("arm",), memory=500 * MIB, devices=("/dev/video0",))
    assert refusal(PlacedComponent("A", required)) == (
        "no place for A: localhost: lacks tag arm; robot1: 120 MiB free, 500 asked;"
        " robot2: no /dev/video0; robot3: no answer within 2 s"
    )


def test_what_is_not_met_where_components_live_is_told_and_memory_is_not():
    def at(name: str, home: str, **required: object) -> PlacedComponent:
        return PlacedComponent(name, Requirements(**required), home=home)

    tags, memory = ("arm",), 900 * MIB
    components = (
        at("A", "localhost", tags=tags, with_=("B",)),
        at("B", "robot1", tags=tags, memory=memory, with_=("A", "E")),
        at("C", "robot1", apart=("B", "A")),
        at("D", "robot1", apart=("A",), with_=("B",)),
        at("E", "", tags=("wings",)),
    )
    assert unmet(PlacementProblem(components, HOSTS)) == {
        "A": "lacks tag arm, A is to be in the process of B",
        "B": "B is to be in the process of A",
        "C": "C is not to be on the host of B",
    }


def test_what_components_ask_together_is_told():
    one, two = (PlacedComponent(n, Requirements(("robot2",), memory=400 * MIB)) for n in "AB")
    assert refusal(one, two) == (
        "no place for A and B together: localhost: not one of robot2 (A, B); robot1: not one of"
        " robot2 (A, B); robot2: 700 MiB free, 800 asked by A, B;"
        " robot3: no answer within 2 s (A, B)"
    )
    camera = PlacedComponent("A", Requirements(tags=("arm",)), "robot1")
    other = PlacedComponent("B", Requirements(apart=("A",)), "robot1")
    assert refusal(camera, other).startswith(
        "no place for A and B together: B is not to be on the host of A"
    )
