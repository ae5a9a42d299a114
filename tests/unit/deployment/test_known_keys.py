"""Properties of profiles that look like those of rtkit, and are none."""

from __future__ import annotations

import pytest

from rtkit.deployment.known_keys import (
    OF_COMPONENTS,
    OF_PORTS,
    OF_SYSTEMS,
    odd_key,
    odd_options,
    odd_properties,
)
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, InstancePort, RtsProfile
from rtkit.settings.options import unknown_options

ODD = [
    ("rtkit.restrat", OF_COMPONENTS, " (did you mean rtkit.restart?)"),
    ("rtkti.restart", OF_COMPONENTS, " (did you mean rtkit.restart?)"),
    ("rtkit.zzz", OF_COMPONENTS, ""),
    ("rtkit.states", OF_COMPONENTS, " (it belongs to the system)"),
    ("rtkit.event.lost", OF_COMPONENTS, " (it belongs to the system)"),
    ("rtkit.create", OF_SYSTEMS, " (it belongs to a component)"),
    ("rtkit.health.stuck", OF_SYSTEMS, " (it belongs to a component)"),
    ("rtkit.sates", OF_SYSTEMS, " (did you mean rtkit.states?)"),
    ("rtkit.interface", OF_PORTS, " (did you mean rtkit.interfaces?)"),
]
KNOWN = [
    ("rtkit.stand-in.out", OF_COMPONENTS),
    ("rtkit.restart.dely", OF_COMPONENTS),  # refused by who reads policies
    ("rtkit.health.rate.in", OF_COMPONENTS),
    ("rtkit.state.idle", OF_SYSTEMS),
    ("rtkit.restart.slave.arm", OF_SYSTEMS),
    ("vendor.colour", OF_COMPONENTS),
    ("colour", OF_PORTS),
]


@pytest.mark.parametrize(("key", "known", "hint"), ODD)
def test_what_is_not_known_is_told_with_what_may_be_meant(
    key: str, known: tuple[str, ...], hint: str
) -> None:
    assert odd_key(key, known) == f"unknown property: {key}{hint}"


@pytest.mark.parametrize(("key", "known"), KNOWN)
def test_what_is_known_or_of_others_is_not(key: str, known: tuple[str, ...]) -> None:
    assert odd_key(key, known) == ""


def profile(create: str = "", key: str = "vendor.x") -> RtsProfile:
    own = (ExtensionProperty("rtkit.create", create),) if create else ()
    port = InstancePort("A.out", properties=(ExtensionProperty("rtkit.sated-type", "x"),))
    made = ComponentInstance("RTC:M:c:T:1", "h/A.rtc", "A", data_ports=(port,), properties=own)
    said = (ExtensionProperty(key, "1"),)
    return RtsProfile("RTSystem:m:s:1", "0.2", "", "", properties=said, components=(made,))


def test_each_is_told_with_its_place() -> None:
    assert [(odd.steps, odd.text) for odd in odd_properties(profile(key="rtkit.hot"))] == [
        ((("properties", 0),), "unknown property: rtkit.hot (it belongs to a component)"),
        (
            (("components", 0), ("data_ports", 0), ("properties", 0)),
            "A: port A.out: unknown property: rtkit.sated-type (did you mean rtkit.stated-type?)",
        ),
    ]


@pytest.mark.parametrize(
    ("create", "told"),
    [
        ("T?instance_name=A&manager_name=s", []),
        ("T?x=1", []),
        ("T?manager_nme=s", ["A: unknown option: manager_nme (did you mean manager_name?)"]),
        (
            "T?rtkit.zzzz=1&conf.a=1",
            ["A: unknown option: rtkit.zzzz", "A: not conf.SET.PARAMETER: conf.a"],
        ),
        ("T?no", []),  # refused by who reads it
    ],
)
def test_options_of_create_strings_are_looked_at(create: str, told: list[str]) -> None:
    assert list(odd_options(profile(create), unknown_options)) == told
