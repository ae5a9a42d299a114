"""Two managers keep one half of a connector each, notice each other's end, and meet again."""

from __future__ import annotations

import pytest
from fake_peers import FakeHost

from rtkit.deployment.actions import Connect, Delete, Disconnect
from rtkit.deployment.listing import listing_of
from rtkit.rtc.far_ends import far_name
from rtkit.rtc.profiles import ConnectorProfile, PortRef

WHOLE, GONE = "", None
BEGUN_ANEW = "manager m2 has begun anew, and does not know it"


@pytest.fixture
def host():
    """A in a slave of m1, B in one of m2."""
    host = FakeHost("m1", "m2")
    assert host.make("m1", "A", "a").result.ok
    assert host.make("m2", "B", "b").result.ok
    return host


def troubles(host, id="w"):
    """Return how each manager that runs shows a connector."""
    return [host.trouble(name, id) for name in host.shells]


def wired(host, flow="push"):
    asked = host.ask("m1", host.connector("w", "m1", flow))
    host.calm(1.0)
    assert asked.result.ok, asked.result
    assert troubles(host) == [WHOLE, WHOLE]
    return host


def pid_of(host, name):
    (slave,) = host.slaves[name]
    return slave


@pytest.mark.parametrize("flow", ["push", "pull"])
def test_each_keeps_its_half_before_the_answer(host, flow):
    wired(host, flow)
    assert host.is_joined("w")
    for name, ends in (
        ("m1", (PortRef("A", "out"), PortRef(far_name("B", "m2"), "in"))),
        ("m2", (PortRef(far_name("A", "m1"), "out"), PortRef("B", "in"))),
    ):
        assert host.shells[name].state.connectors["w"].ports == ends
        assert ("wire", "w") in host.rows[name]
        assert ("half", "w") in host.rows[name]


def test_what_the_peer_refuses_leaves_nothing(host):
    wrong = host.connector("w", "m1").connector
    ends = (wrong.ports[0], PortRef(far_name("B", "m2"), "text"))
    from rtkit.fast_dataclass import replace

    asked = host.ask("m1", Connect(replace(wrong, ports=ends)))
    host.calm()
    assert not asked.result.ok
    assert troubles(host) == [GONE, GONE]
    assert host.shells["m1"].watched == ()
    assert not any(slave.ends for slaves in host.slaves.values() for slave in slaves.values())


def test_a_peer_that_does_not_run_is_named(host):
    host.kill("m2")
    asked = host.ask("m1", host.connector("w", "m1"))
    host.calm(1.0)
    assert asked.result.kind == "unreachable"
    assert troubles(host) == [GONE]


def test_an_answer_that_is_lost_leaves_nothing_in_either(host):
    asked = host.ask("m1", host.connector("w", "m1"))
    host.deliver()  # m2 has made its half
    assert host.trouble("m2", "w") == WHOLE
    host.deliver(is_lost=True)
    assert not asked.result.ok
    host.calm()
    assert troubles(host) == [GONE, GONE]


@pytest.mark.parametrize("dead", [["m1"], ["m2"], ["m1", "m2"], ["m2", "m1"]])
@pytest.mark.parametrize("is_reversed", [False, True])
def test_they_meet_again_after_either_restarts_in_any_order(host, dead, is_reversed):
    wired(host)
    for name in dead:
        host.kill(name)
        for other in host.shells:
            assert host.trouble(other, "w") == f"manager {name} is not running"
    assert host.is_joined("w")  # data flow on
    for name in dead[:: -1 if is_reversed else 1]:
        host.start(name)
    host.calm(3.0)
    assert troubles(host) == [WHOLE, WHOLE]
    assert host.is_joined("w")


def test_a_slave_that_ends_leaves_a_half_that_says_why(host):
    wired(host)
    host.end_slave("m2", pid_of(host, "m2"))
    host.calm(3.0)
    assert troubles(host) == ["B ended: signal 9", GONE]
    assert not host.is_joined("w")
    (slave,) = host.slaves["m1"].values()
    assert not slave.ends


@pytest.mark.parametrize("where", ["m1", "m2"])
def test_a_component_that_is_deleted_takes_both_halves_along(host, where):
    wired(host)
    asked = host.ask(where, Delete("A" if where == "m1" else "B"))
    host.calm()
    assert asked.result.ok
    assert troubles(host) == [GONE, GONE]
    assert host.shells["m1"].watched == host.shells["m2"].watched == ()


def test_a_half_and_a_deletion_while_the_peer_is_away_are_shown(host):
    wired(host)
    host.kill("m2")
    (row,) = listing_of(host.shells["m1"].state.snapshot()).rows
    assert row.again == "half a connection at out: manager m2 is not running"
    asked = host.ask("m1", Delete("A"))
    assert asked.result.note == "other halves of its connections go when m2 is back"
    host.start("m2")
    host.calm(3.0)
    assert troubles(host) == [GONE, GONE]


@pytest.mark.parametrize("where", ["m1", "m2"])
def test_either_disconnects_and_both_halves_are_gone_at_the_answer(host, where):
    wired(host)
    asked = host.ask(where, Disconnect("w"))
    while not asked.is_answered:
        host.deliver()
    assert asked.result.ok
    assert not asked.result.note
    assert troubles(host) == [GONE, GONE]
    host.calm(1.0)
    assert all(("wire", "w") not in rows for rows in host.rows.values())


def test_whom_nobody_tells_removes_its_half_when_it_is_back(host):
    wired(host)
    host.kill("m2")
    asked = host.ask("m1", Disconnect("w"))
    host.calm(3.0)
    away = "the other half of connection w is removed when it is back"
    assert asked.result.note.endswith(away)
    assert troubles(host) == [GONE]
    host.kill("m1")  # it remembers nothing of that
    host.start("m2")
    host.calm(1.0)
    assert troubles(host) == ["manager m1 is not running"]
    host.start("m1")
    host.calm(3.0)
    assert troubles(host) == [GONE, GONE]


def test_a_former_peer_that_cannot_be_told_is_no_trouble_of_the_present_one():
    """A connector was made to another manager before the first one had been told of its end."""
    host = FakeHost("m1", "m2", "m3")
    for name, instance in (("m1", "A"), ("m2", "B"), ("m3", "B")):
        assert host.make(name, instance, "slave").result.ok
    host.ask("m1", _wire_to("m2"))
    host.calm(1.0)
    host.ask("m1", Disconnect("w"))
    host.deliver(is_lost=True)
    asked = host.ask("m1", _wire_to("m3"))
    (second,) = (each for each in host.letters if each.asked.peer == "m2")
    host.letters.remove(second)
    host.calm(0.5)
    assert asked.result.ok, asked.result
    host.letters.append(second)
    host.deliver(is_lost=True)
    assert host.trouble("m1", "w") == WHOLE
    host.calm(3.0)
    assert troubles(host) == [WHOLE, GONE, WHOLE]


def _wire_to(peer):
    ends = (PortRef("A", "out"), PortRef(far_name("B", peer), "in"))
    return Connect(ConnectorProfile("w", "w", ends, {"dataport.dataflow_type": "push"}))


def test_who_has_begun_anew_is_no_reason_to_forget(host):
    wired(host)
    host.forget("m2")
    host.start("m2")
    host.calm(3.0)
    assert troubles(host) == [BEGUN_ANEW, GONE]
    host.make("m2", "B", "b")
    again = host.ask("m1", host.connector("w", "m1"))
    host.calm(3.0)
    assert again.result.ok
    assert troubles(host) == [WHOLE, WHOLE]
    assert host.is_joined("w")


def test_a_coordinator_that_dies_in_the_making_leaves_no_half(host):
    host.ask("m1", host.connector("w", "m1"))
    host.deliver()
    host.kill("m1")
    assert host.trouble("m2", "w") == "manager m1 is not running"
    host.start("m1")
    host.calm(3.0)
    assert troubles(host) == [GONE, GONE]


def test_a_half_that_cannot_be_kept_is_taken_back_in_both(host):
    host.shells["m2"].disk = "the disk is full"
    asked = host.ask("m1", host.connector("w", "m1"))
    host.calm(3.0)
    assert "the disk is full" in asked.result.why
    host.shells["m2"].disk = ""
    host.calm()
    assert troubles(host) == [GONE, GONE]


def test_the_same_again_is_what_was_asked_for(host):
    wired(host)
    again = host.ask("m1", host.connector("w", "m1"))
    assert again.result.ok
    assert not host.letters
    other = host.ask("m1", host.connector("w", "m1", "pull"))
    assert other.result.why == "connection w exists with another dataport.dataflow_type"
