"""The sample system of a project: components connected where it is plain how."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.builder.sample_system import sample_system
from rtkit.profile.read import read_rts
from rtkit.profile.rtc_model import DataPortDeclaration


def subject(builder: Any, name: str, ports: str) -> Any:
    declared = []
    for port in ports.split():
        way, _, type = port.partition(":")
        kind = "DataInPort" if way.startswith("in") else "DataOutPort"
        declared.append(DataPortDeclaration(kind, way, f"RTC::{type}", "LEFT"))
    return builder.build(name, data_ports=tuple(declared)).subject


@pytest.mark.parametrize(
    ("components", "wired"),
    [
        (["out:TimedLong", "in:TimedLong"], ["A0.out-B0.in"]),
        (["in:TimedLong", "out:TimedLong"], []),
        (["out:TimedLong", "in:TimedDouble"], []),
        (["out1:TimedLong out2:TimedLong", "in:TimedLong"], []),
        (["out:TimedLong", "in1:TimedLong in2:TimedLong"], []),
        (
            ["out:TimedLong", "in:TimedLong out:TimedLong", "in:TimedLong"],
            ["A0.out-B0.in", "B0.out-C0.in"],
        ),
        (
            ["out:TimedLong log:TimedString", "in:TimedLong", "in:TimedString all:TimedLong"],
            ["A0.out-B0.in", "A0.log-C0.in"],
        ),
        (["out:TimedLong", "in:TimedLong", "in:TimedLong"], ["A0.out-B0.in", "A0.out-C0.in"]),
        (["in:TimedLong out:TimedLong"], []),
    ],
)
def test_ports_that_fit_the_component_before_are_connected(
    builder: Any, components: list[str], wired: list[str]
) -> None:
    subjects = [subject(builder, *each) for each in zip("ABCD", components, strict=False)]
    system = read_rts(sample_system(subjects).encode(), strict=True).profile
    found = [(w.connector_id, w.source, w.target) for w in system.data_port_connectors]
    assert [id for id, *_ in found] == wired
    assert all(f"{one.port_name}-{two.port_name}" == id for id, one, two in found)
    assert {w.data_type for w in system.data_port_connectors} <= {
        f"IDL:RTC/{name}:1.0" for name in ("TimedLong", "TimedString")
    }
