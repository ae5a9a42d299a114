"""The core opens service connectors: the provider first, each direction that there is."""

from __future__ import annotations

import pytest
from fake_shell import OWN, facts, wire

from rtkit.deployment.actions import Connect, Disconnect
from rtkit.errors import Unreachable
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.profiles import PortInterfaceProfile, PortProfile
from rtkit.rtc.serde import encode


def port(name, *interfaces):
    listed = tuple(
        PortInterfaceProfile(name, each[1:], Polarity.PROVIDED if each[0] == "+" else REQUIRED)
        for each in interfaces
    )
    return PortProfile(name, PortType.SERVICE, {}, listed)


REQUIRED = Polarity.REQUIRED
PORTS = (
    port("gives", "+Work"),
    port("needs", "-Work"),
    port("one", "+Work", "-Play"),
    port("other", "-Work", "+Play"),
    port("plain"),
)


@pytest.fixture
def ends(shell):
    keys = [shell.make(name, name.lower()) for name in ("A", "B")]
    for name, key in zip("AB", keys, strict=True):
        shell.say(key, facts=facts(name, PORTS))
    return keys


def test_in_one_process_by_one_message(shell):
    for name in ("A", "B"):
        shell.make(name)
        shell.say(OWN, facts=facts(name, PORTS))
    asked = shell.ask(Connect(wire("w", "A.needs", "B.gives")))
    call = shell.next("link")
    assert call.message["connector"] == encode(wire("w", "A.needs", "B.gives"))
    shell.reply(call)
    assert asked.result.ok


@pytest.mark.parametrize(
    ("one", "other", "provider"), [("A.needs", "B.gives", 1), ("A.gives", "B.needs", 0)]
)
def test_between_two_the_provider_opens_first_whichever_is_named_first(
    shell, ends, one, other, provider
):
    asked = shell.ask(Connect(wire("w", one, other)))
    offer = shell.next("offer")
    assert (offer.key, offer.message["end"]) == (ends[provider], provider)
    shell.reply(offer, "unix/p")
    consult = shell.next("consult")
    assert (consult.key, consult.message["end"]) == (ends[1 - provider], 1 - provider)
    assert consult.message["endpoint"] == "unix/p"
    assert not shell.state.connectors
    shell.reply(consult)
    assert asked.result.ok
    assert list(shell.state.connectors) == ["w"]


def test_both_directions_of_a_port_are_opened(shell, ends):
    asked = shell.ask(Connect(wire("w", "A.one", "B.other")))
    seen = []
    for op in ("offer", "consult", "offer", "consult"):
        call = shell.next(op)
        seen.append((op, call.key))
        shell.reply(call, "unix/x")
    a, b = ends
    assert seen == [("offer", a), ("consult", b), ("offer", b), ("consult", a)]
    assert asked.result.ok


def test_ports_that_list_no_interfaces_are_joined_in_the_books(shell, ends):
    asked = shell.ask(Connect(wire("w", "A.plain", "B.needs")))
    for key in ends:
        call = shell.next("keep")
        assert call.key == key
        shell.reply(call)
    assert asked.result.ok


def test_what_was_opened_is_taken_off_when_the_consumer_cannot_reach_it(shell, ends):
    asked = shell.ask(Connect(wire("w", "A.needs", "B.gives")))
    shell.reply(shell.next("offer"), "unix/p")
    shell.refuse(shell.next("consult"), Unreachable("nobody listens"))
    assert asked.result.why == "nobody listens"
    unlink = {"op": "unlink", "connector_id": "w"}
    assert sorted(shell.told, key=lambda each: each[0]) == [(key, unlink) for key in sorted(ends)]
    assert not shell.state.connectors


def test_both_ends_are_parted(shell, ends):
    shell.ask(Connect(wire("w", "A.needs", "B.gives")))
    for op in ("offer", "consult"):
        shell.reply(shell.next(op), "unix/p")
    shell.ask(Disconnect("w"))
    first = shell.next("unlink")
    shell.reply(first)
    assert {first.key, shell.next("unlink").key} == set(ends)
