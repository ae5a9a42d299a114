"""Records as plain data: nothing that arrives is trusted."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.errors import Malformed
from rtkit.rtc.enums import LifeCycleState, PortType, merged_state
from rtkit.rtc.profiles import ConnectorProfile, ExecutionContextProfile, PortProfile, PortRef
from rtkit.rtc.serde import decode, encode

WIRE = ConnectorProfile("w", "n", (PortRef("A", "out"), PortRef("B", "in")), {"k": "v"})


def test_defaults_are_left_out() -> None:
    assert encode(PortProfile("in", PortType.IN)) == {"name": "in", "port_type": "DataInPort"}
    assert encode(WIRE)["ports"][0] == {"instance": "A", "port": "out"}


def test_there_and_back() -> None:
    assert decode(ConnectorProfile, encode(WIRE)) == WIRE


@pytest.mark.parametrize(
    ("cls", "data"),
    [
        (ConnectorProfile, None),
        (ConnectorProfile, []),
        (ConnectorProfile, {}),
        (ConnectorProfile, {**encode(WIRE), "ports": "AB"}),
        (ConnectorProfile, {**encode(WIRE), "ports": [1]}),
        (ConnectorProfile, {**encode(WIRE), "properties": {"k": 1}}),
        (ConnectorProfile, {**encode(WIRE), "properties": {1: "k"}}),
        (ConnectorProfile, {**encode(WIRE), "name": None}),
        (PortProfile, {"name": "in", "port_type": "Hatch"}),
        (PortProfile, {"name": "in", "port_type": ["DataInPort"]}),
        (
            ExecutionContextProfile,
            {"id": "0", "kind": "PERIODIC", "rate": "fast", "owner": "A"},
        ),
        (
            ExecutionContextProfile,
            {"id": "0", "kind": "PERIODIC", "rate": 1.0, "owner": "A", "is_running": "yes"},
        ),
    ],
)
def test_what_does_not_have_the_shape(cls: type[Any], data: object) -> None:
    with pytest.raises(Malformed):
        decode(cls, data)


@pytest.mark.parametrize(
    ("states", "merged"),
    [
        ([], "Unknown"),
        (["Created"], "Created"),
        (["Created", "Inactive"], "Inactive"),
        (["Inactive", "Active"], "Active"),
        (["Active", "Error", "Created"], "Error"),
    ],
)
def test_merged_state(states: list[str], merged: str) -> None:
    assert merged_state([LifeCycleState(state) for state in states]) == merged
