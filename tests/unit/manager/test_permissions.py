"""Permissions of other hosts at a manager: each request has its role, and its words."""

from __future__ import annotations

import json
from typing import get_args

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.batch import Batch, batch_to_text
from rtkit.errors import Malformed, Refused
from rtkit.manager.gateway.permissions import permission
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef

CONNECTOR = ConnectorProfile("c1", "c", (PortRef("A", "out"), PortRef("B", "in")))
FAR = ConnectorProfile("c1", "c", (PortRef("A", "out"), PortRef("m2.mgr/B", "in")))
ROLES: list[tuple[Action, str, str]] = [
    (act.Load("./Arm.py", "init"), "administrator", "load ./Arm.py"),
    (act.Unload("Arm"), "administrator", "unload Arm"),
    (act.Create("Arm?password=hunter2"), "administrator", "create Arm"),
    (act.Delete("Arm0"), "administrator", "delete Arm0"),
    (act.EndSlave("s1"), "administrator", "end slave s1"),
    (act.Unregister("a/Arm0.rtc"), "administrator", "unregister a/Arm0.rtc"),
    (act.Register("Arm0", "a/b.rtc"), "administrator", "register Arm0"),
    (act.Connect(CONNECTOR), "operator", "connect A.out and B.in"),
    (act.Connect(FAR), "administrator", "connect A.out and m2.mgr/B.in"),
    (act.Disconnect("c1"), "operator", "disconnect c1"),
    (act.SetParameters("Arm0", "default", {"pin": "hunter2"}), "operator", "set parameters Arm0"),
    (act.RemoveSet("Arm0", "fast"), "operator", "remove set Arm0"),
    (act.ActivateSet("Arm0", "fast"), "operator", "activate set Arm0"),
    (act.ChangeState("Arm0", "0", Transition.RESET), "operator", "reset Arm0"),
    (act.SetRate("Arm0", "0", 10.0), "operator", "set rate Arm0"),
    (act.SetContext("Arm0", "0", {"priority": "9"}), "administrator", "set context Arm0"),
    (act.SetPolicy("Arm0"), "administrator", "set policy Arm0"),
    (act.Tick("Arm0", "0"), "operator", "tick Arm0"),
    (act.Attach("A", "0", "B"), "administrator", "attach A"),
    (act.Detach("A", "0", "B"), "administrator", "detach A"),
    (act.SetStructure("A", {}), "administrator", "set structure A"),
    (act.SetEventProfiles("A", {}), "administrator", "set event profiles A"),
]  # fmt: skip


def test_each_action_is_named_here() -> None:
    assert {type(action) for action, _, _ in ROLES} == set(get_args(Action))


@pytest.mark.parametrize(("action", "role", "what"), ROLES)
def test_an_action_takes_its_role(action: Action, role: str, what: str) -> None:
    assert permission("@/batch", batch_to_text(Batch((action,)))) == (role, what)


def test_a_batch_is_named_by_what_takes_most() -> None:
    actions = (act.Tick("A", "0"), *(act.Delete(f"B{n}") for n in range(5)))
    text = batch_to_text(Batch(actions))
    assert permission("@/batch", text) == (
        "administrator",
        "delete B0, delete B1, delete B2 and 2 more",
    )
    assert permission("@/batch", batch_to_text(Batch(()))) == ("viewer", "do nothing")
    long = batch_to_text(Batch((act.Delete("x\n\x1b[2J" + "y" * 100),)))
    assert permission("@/batch", long).what == "delete x??[2J" + "y" * 54


@pytest.mark.parametrize(
    ("name", "payload", "role"),
    [
        ("@/manager.pid", None, "viewer"),
        ("@/get_components_by_name", "A", "viewer"),
        ("@/get_components", None, "viewer"),
        ("@x/listing", None, "viewer"),
        ("@x/part/A%2CB", None, "viewer"),
        ("@x/lease", None, "viewer"),
        ("@x/line/tree", None, "viewer"),
        ("@x/dump", None, "administrator"),
        ("@x/lacking", "[]", "administrator"),
        ("@x/listing", "", "administrator"),
        ("@/create_component?id=0a-1", "Arm", "administrator"),
        ("@/stop", "", "administrator"),
        ("@/restart", "", "administrator"),
        ("@/restart", "forget", "administrator"),
        ("@/exec_cxt.periodic.rate", "10", "administrator"),
        ("@/batch", None, "viewer"),
        ("@x/terminal", '{"instance": "A"}', "viewer"),
        ("@x/terminal", '{"instance": "A", "input": "5"}', "operator"),
        ("@x/terminal", '{"instance": "A", "size": [24, 80]}', "operator"),
    ],
)
def test_what_else_is_asked_takes_its_role(name: str, payload: str | None, role: str) -> None:
    assert permission(name, payload).role == role


@pytest.mark.parametrize("name", ["", "@", "@/", "@/*", "@/a/**", "@y/a", "a", "@x/$*", "@/a?b=1",
                                  "@/a#", "@/a//b", "@/a\n", "@/a/",
                                  "@x/lease?id=0a-1", "@x/router?id=0a",
                                  "@/" + "a" * 1000])  # fmt: skip
def test_what_is_no_name_is_passed_on_to_nobody(name: str) -> None:
    with pytest.raises(Malformed, match="not a property of a manager"):
        permission(name, None)


@pytest.mark.parametrize(
    ("name", "payload"),
    [("@x/half", None), ("@x/half", "{}"), ("@/restart", "/proc/1/fd/3"), ("@/restart", " ")],
)
def test_what_takes_a_link_or_a_process_here_is_refused(name: str, payload: str | None) -> None:
    with pytest.raises(Refused, match=r"over links|own host only"):
        permission(name, payload)


def test_a_batch_that_is_none_is_malformed() -> None:
    for text in ("", "[]", "{}", json.dumps({"actions": [{"do": "Explode"}], "timeout": 1})):
        with pytest.raises(Malformed):
            permission("@/batch", text)
