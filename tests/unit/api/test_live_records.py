"""Records of snapshots: looks, ends of connectors between managers, what changes."""

from __future__ import annotations

import pytest
from webfacts import component, manager

from rtkit.api.live_records import change_between, records_of
from rtkit.deployment.facts import RestartStatus
from rtkit.fast_dataclass import replace
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.profiles import ConnectorProfile, PortRef


@pytest.mark.parametrize(
    ("changed", "look", "word"),
    [
        ({}, "active", "Active"),
        ({"trouble": "stopped"}, "stuck", "Active"),
        ({"zombie": "signal 9"}, "zombie", "zombie"),
        (
            {"zombie": "signal 9", "restart_status": RestartStatus(due_s=1e12)},
            "restarting",
            "restarting",
        ),
        ({"zombie": "no /dev/video0"}, "restarting", "restarting"),
    ],
)
def test_a_look_is_what_is_so(changed: dict[str, object], look: str, word: str) -> None:
    records = records_of([manager(replace(component("A"), **changed))], "host")
    record = records.components["/localhost/A.rtc"]
    assert (record["look"], record["word"]) == (look, word)
    assert (record["widgets"], record["constraints"]) == ({"a": "spin"}, {"a": "x<2"})
    assert record["sets"]["default"] == {"a": "1"}


def test_zombies_are_in_their_slaves_also_where_these_ended_before_the_manager_began() -> None:
    dead = {"A": "s1", "B": "s2"}
    parts = [replace(component(c), process=p, zombie="signal 9") for c, p in dead.items()]
    records = records_of([manager(*parts, component("C"))], "host")
    for name, process in dead.items():
        slave = f"/localhost/manager.mgr/{process}.mgr"
        assert records.components[f"/localhost/{name}.rtc"]["process"] == slave
        found = records.processes[slave]
        assert (found["state"], found["why"], found["is_slave"]) == ("lost", "signal 9", True)
    assert records.components["/localhost/C.rtc"]["process"] == "/localhost/manager.mgr"
    assert len(records.processes) == 3


def test_what_a_silent_manager_held_is_unreachable() -> None:
    records = records_of([manager(component("A"), why="was killed")], "host")
    assert records.managers["/localhost/manager.mgr"]["state"] == "gone"
    assert records.components["/localhost/A.rtc"]["look"] == "unreachable"


def test_a_connector_between_managers_is_one_and_as_bad_as_its_worse_half() -> None:
    half = ConnectorProfile("c", "c", (PortRef("A", "out"), PortRef("m2.mgr/B", "in")))
    other = ConnectorProfile("c", "c", (PortRef("manager.mgr/A", "out"), PortRef("B", "in")))
    first = manager(component("A"), connectors=[half])
    second = manager(
        component("B"), name="m2", connectors=[replace(other, trouble="the other half is missing")]
    )
    for order in ([first, second], [second, first]):
        record = records_of(order, "host").connectors["c"]
        assert record["trouble"] == "the other half is missing"
        assert record["source"] == {"component": "/localhost/A.rtc", "port": "out"}
        assert record["target"] == {"component": "/localhost/m2.mgr/B.rtc", "port": "in"}


def test_a_change_leads_from_one_moment_to_the_other() -> None:
    before = records_of([manager(component("A"), component("B"))], "host")
    after = records_of([manager(component("B", LifeCycleState.ERROR), component("C"))], "host")
    change = change_between(before, after)
    assert change.gone["components"] == ["/localhost/A.rtc"]
    assert list(change.fresh.components) == ["/localhost/B.rtc", "/localhost/C.rtc"]
    assert not change_between(after, after)
