"""The core makes a composite where its members are."""

from __future__ import annotations

import pytest

from rtkit.deployment.actions import Create

TYPE = "PeriodicECSharedComposite"


@pytest.fixture
def shell(shell):
    shell.make("A", "s")
    shell.make("B", "s")
    shell.make("Far")
    return shell


@pytest.mark.parametrize("place", ["", "&manager_name=s"])
def test_in_the_process_of_its_members(shell, place):
    shell.ask(Create(f"{TYPE}?instance_name=W&members=A, B{place}"))
    assert shell.next("create").key == shell.state.containers["A"]


def test_without_members_where_it_is_told_to(shell):
    shell.ask(Create(f"{TYPE}?instance_name=W&manager_name=s&members="))
    assert shell.next("create").key == shell.state.containers["A"]
    shell.ask(Create(f"{TYPE}?instance_name=V"))
    assert shell.next("create").key == shell.state.containers["Far"]


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ("members=A,Far", "A is in s, Far in manager: members of a composite are in one process"),
        ("members=A&manager_name=t", "A is in s: a composite of it cannot be in t"),
        ("members=A,No", "no component named No"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_made(shell, options, why):
    asked = shell.ask(Create(f"{TYPE}?instance_name=W&{options}"))
    assert asked.result.why == why
    assert not [call for call in shell.calls if call.op == "create"]
    assert "W" not in shell.state.claims
