"""What news mean, in the words of the observers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from rtkit.deployment.delta import delta_between
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, RestartStatus, Snapshot
from rtkit.deployment.user_events import heartbeats, user_events
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, PortType
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    PortProfile,
    PortRef,
    TypeProfile,
)

CONTEXT = ExecutionContextProfile("0", ExecutionKind.PERIODIC, 10.0, "A")
A = ComponentFacts(
    "A",
    TypeProfile("Thing"),
    "slave",
    (PortProfile("out", PortType.OUT),),
    {"default": {"gain": "1"}, "calm": {"gain": "0"}},
    "default",
    (CONTEXT,),
    ("localhost/A.rtc",),
)
B = replace(A, instance="B", names=())
SLAVE = ProcessFacts("slave", True, 2, "up")
BEFORE = Snapshot("host", "manager", 1, "0", (SLAVE,), (A,))


def told(after: Snapshot, before: Snapshot = BEFORE) -> list[str]:
    found = user_events(before, delta_between(before, after, "", 1))
    return [" ".join(filter(None, each[:6])) for each in found]


def with_a(**changes: Any) -> Snapshot:
    return replace(BEFORE, components=(replace(A, **changes),))


def context(**changes: Any) -> Snapshot:
    return with_a(contexts=(replace(CONTEXT, **changes),))


CHANGES = {
    "state": (context(state=LifeCycleState.ACTIVE), ["RTC_STATUS A slave 0 ACTIVE"]),
    "error": (
        with_a(contexts=(replace(CONTEXT, state=LifeCycleState.ERROR),), cause="ValueError: no"),
        ["RTC_STATUS A slave 0 ERROR ValueError: no"],
    ),
    "rate": (context(rate=5.0), ["EC_EVENT A slave 0 EC_RATE_CHANGED 5 Hz"]),
    "shutdown": (context(is_running=False), ["EC_EVENT A slave 0 EC_SHUTDOWN"]),
    "attached": (
        with_a(contexts=(CONTEXT, replace(CONTEXT, id="B/0"))),
        ["EC_EVENT A slave B/0 EC_ATTACHED"],
    ),
    "detached": (with_a(contexts=()), ["EC_EVENT A slave 0 EC_DETACHED"]),
    "port": (
        with_a(ports=(PortProfile("in", PortType.IN),)),
        ["PORT_EVENT A slave out PORT_REMOVE", "PORT_EVENT A slave in PORT_ADD"],
    ),
    "parameter": (
        with_a(sets={"default": {"gain": "2"}, "calm": {"gain": "0"}}),
        [
            "CONFIG_EVENT A slave default.gain CFG_UPDATE_PARAM 2",
            "CONFIG_EVENT A slave default CFG_UPDATE_SET",
        ],
    ),
    "sets": (
        with_a(sets={"default": {"gain": "1"}, "wild": {}}),
        ["CONFIG_EVENT A slave calm CFG_REMOVE_SET", "CONFIG_EVENT A slave wild CFG_ADD_SET"],
    ),
    "active set": (with_a(active_set="calm"), ["CONFIG_EVENT A slave calm CFG_ACTIVATE_SET"]),
    "profile": (with_a(names=(), members=("X",)), ["COMPONENT_PROFILE A slave names, members"]),
    "machine": (
        with_a(fsm_state="On", fsm_states={"On": {}}, fsm_events={"go": "T"}),
        [f"FSM_EVENT A slave FSM_{word}" for word in ("STRUCTURE", "PROFILE", "STATUS On")],
    ),
    "stuck": (with_a(trouble="stuck"), ["TREE_EVENT A slave NOT_ANSWERING stuck"]),
    "gone": (replace(BEFORE, components=()), ["TREE_EVENT A slave VANISHED"]),
    "new": (replace(BEFORE, components=(A, B)), ["TREE_EVENT B slave APPEARED Thing"]),
    "new and at work": (
        replace(
            BEFORE,
            components=(A, replace(B, contexts=(replace(CONTEXT, state=LifeCycleState.ACTIVE),))),
        ),
        ["TREE_EVENT B slave APPEARED Thing", "RTC_STATUS B slave 0 ACTIVE"],
    ),
    "lost": (
        replace(
            BEFORE,
            components=(replace(A, zombie="signal 9"),),
            processes=(replace(SLAVE, state="lost", reason="signal 9"),),
        ),
        ["TREE_EVENT slave PROCESS_LOST signal 9", "TREE_EVENT A slave ZOMBIE signal 9"],
    ),
    "halted": (
        replace(BEFORE, processes=(replace(SLAVE, state="stopped"),)),
        ["TREE_EVENT slave PROCESS_STOPPED"],
    ),
    "process": (
        replace(BEFORE, processes=(replace(SLAVE, pid=3),)),
        ["TREE_EVENT slave PROCESS_ENDED pid 2", "TREE_EVENT slave PROCESS_STARTED pid 3"],
    ),
}


UPKEEP = {
    "returning": (RestartStatus(), RestartStatus(returning="signal 9"), ["RETURNING signal 9"]),
    "made again": (
        RestartStatus(2, "signal 9", 0.5, returning="exit status 3"),
        RestartStatus(3, "exit status 3", 0.1623),
        ["MADE_AGAIN restart 3, for exit status 3, after 0.162 s"],
    ),
    "device gone": (
        RestartStatus(),
        RestartStatus(returning="no /dev/video0"),
        ["DEVICE_GONE no /dev/video0"],
    ),
    "device there": (
        RestartStatus(returning="no /dev/video0"),
        RestartStatus(1, "no /dev/video0", 0.1),
        ["DEVICE_APPEARED restart 1, for no /dev/video0, after 0.100 s"],
    ),
    "dead again": (
        RestartStatus(2, "signal 9", returning="signal 9"),
        RestartStatus(3, "signal 9", returning="cannot create A: no"),
        ["RETURNING cannot create A: no"],
    ),
    "given up": (
        RestartStatus(5, "signal 9", returning="signal 9"),
        RestartStatus(5, "signal 9", given_up="given up after 5"),
        ["GIVEN_UP given up after 5"],
    ),
    "reset": (RestartStatus(5, given_up="given up after 5"), RestartStatus(5), []),
    "degraded": (
        RestartStatus(),
        RestartStatus(degraded="out carries 0"),
        ["DEGRADED out carries 0"],
    ),
    "well": (RestartStatus(degraded="out carries 0"), RestartStatus(), ["WELL"]),
    "stopped": (RestartStatus(), RestartStatus(rested="t is 80"), ["STOPPED t is 80"]),
    "critical": (RestartStatus(), RestartStatus(halted="signal 9"), ["CRITICAL_STOP signal 9"]),
}


@pytest.mark.parametrize("what", UPKEEP)
def test_what_policies_did_is_told(what: str) -> None:
    before, after, events = UPKEEP[what]
    lines = told(with_a(restart_status=after), with_a(restart_status=before))
    assert lines == [f"SUPERVISION A slave {event}" for event in events]


def test_a_restart_is_told_in_numbers_and_not_of_one_that_has_died_again() -> None:
    before = with_a(
        zombie="signal 9", restart_status=RestartStatus(1, "signal 9", returning="signal 9")
    )
    restart_status = RestartStatus(2, "signal 9", 0.25)
    after = with_a(restart_status=restart_status)
    found = list(user_events(before, delta_between(before, after, "", 1)))
    assert [each.restart for each in found if each.event == "MADE_AGAIN"] == [restart_status]
    dead = with_a(zombie="signal 9", restart_status=restart_status)
    assert told(dead, before) == []


@pytest.mark.parametrize("what", CHANGES)
def test_what_changed_is_told(what: str) -> None:
    after, lines = CHANGES[what]
    assert told(after) == lines


def test_connections_are_told_at_both_ends() -> None:
    ends = (PortRef("A", "out"), PortRef("B", "out"))
    both = replace(BEFORE, components=(A, B))
    wired = replace(both, connectors=(ConnectorProfile("w", "w", ends),))
    assert told(wired, both) == [
        "PORT_EVENT A slave out PORT_CONNECT B:out",
        "PORT_EVENT B slave out PORT_CONNECT A:out",
    ]
    # Who goes is disconnected first.
    assert told(BEFORE, wired) == [
        "PORT_EVENT A slave out PORT_DISCONNECT B:out",
        "PORT_EVENT B slave out PORT_DISCONNECT A:out",
        "TREE_EVENT B slave VANISHED",
    ]


def test_heartbeats() -> None:
    assert [(each.subject, each.event) for each in heartbeats(A, ["0"])] == [
        ("", "RTC_HEARTBEAT"),
        ("0", "EC_HEARTBEAT"),
    ]
