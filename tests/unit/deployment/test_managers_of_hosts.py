"""Managers of other hosts in plans: what they tell and are sent, in their words and in a plan's."""

from __future__ import annotations

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.multi_manager import expected_at, in_plan, inward, joined, outward, sent
from rtkit.rtc.profiles import ConnectorProfile, PortRef

HOMES = {"A": "manager", "B": "manager@robot1", "C": "manager@robot2"}


def connector(out: str, into: str) -> ConnectorProfile:
    return ConnectorProfile("w", "w", (PortRef(out, "out"), PortRef(into, "in")), {})


def told(host: str, wire: ConnectorProfile) -> Snapshot:
    return Snapshot(host, "manager", 1, "", connectors=(wire,))


@pytest.mark.parametrize(
    ("out", "into", "at_out", "at_into"),
    [
        ("A", "B", ("A", "robot1/manager.mgr/B"), ("laptop/manager.mgr/A", "B")),
        ("B", "A", ("B", "laptop/manager.mgr/A"), ("robot1/manager.mgr/B", "A")),
        ("B", "C", ("B", "robot2/manager.mgr/C"), ("robot1/manager.mgr/B", "C")),
    ],
)
def test_both_halves_of_a_connector_between_hosts_are_one_in_a_plan(
    out: str, into: str, at_out: tuple[str, str], at_into: tuple[str, str]
) -> None:
    wire, hosts = connector(out, into), {"A": "laptop", "B": "robot1", "C": "robot2"}
    made = sent(act.Connect(wire), HOMES[out], HOMES, "laptop")
    assert made == act.Connect(connector(*at_out))

    whole = f"{hosts[out]}/manager.mgr/{out}", f"{hosts[into]}/manager.mgr/{into}"
    assert expected_at(wire, HOMES, "laptop") == (HOMES[into], connector(*whole))

    halves = [
        in_plan(told(hosts[name], connector(*ends)), HOMES[name], "laptop")
        for name, ends in ((out, at_out), (into, at_into))
    ]
    ends = {tuple(end.instance for end in half.connectors[0].ports) for half in halves}
    far = {name: f"{HOMES[name]}.mgr/{name}" for name in (out, into)}
    assert ends == {(out, far[into]), (far[out], into)}
    assert [each.manager for each in (joined(halves, HOMES), *joined(halves, HOMES).others)] == [
        HOMES[out],
        HOMES[into],
    ]


def test_a_connector_of_one_host_is_expected_by_nobody() -> None:
    assert expected_at(connector("A", "B"), {"A": "m1", "B": "m2"}, "laptop") is None
    homes = {"A": "m1@robot1", "B": "m2@robot1"}
    assert expected_at(connector("A", "B"), homes, "laptop") is None
    assert sent(act.Connect(connector("A", "B")), "m1@robot1", homes, "laptop") == act.Connect(
        connector("A", "m2.mgr/B")
    )


def test_names_of_another_host_are_shown_below_it() -> None:
    assert outward("localhost/arm/B.rtc", "manager@robot1") == "robot1/arm/B.rtc"
    assert inward("robot1/arm/B.rtc", "manager@robot1") == "localhost/arm/B.rtc"
