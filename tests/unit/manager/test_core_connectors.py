"""The core joins and parts ports, and leaves no half of a connector behind."""

from __future__ import annotations

import pytest
from fake_shell import OWN, PORTS, facts, wire

from rtkit.deployment.actions import Connect, Delete, Disconnect
from rtkit.errors import NotFound, Refused
from rtkit.manager.core import events as ev
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.rtc.serde import encode

UNLINK = {"op": "unlink", "connector_id": "w"}


@pytest.fixture
def ends(shell):
    """A in slave `a`, B in slave `b`; returns their keys."""
    return shell.make("A", "a"), shell.make("B", "b")


def test_in_one_process_by_one_message(shell):
    shell.make("A")
    shell.make("B")
    asked = shell.ask(Connect(wire("w")))
    call = shell.next("link")
    assert (call.key, call.message["connector"]) == (OWN, encode(wire("w")))
    assert not shell.state.connectors
    shell.reply(call)
    assert asked.result.value == "w"
    assert list(shell.state.connectors) == ["w"]


def test_between_two_the_receiver_opens_first(shell, ends):
    a, b = ends
    asked = shell.ask(Connect(wire("w")))
    sink = shell.next("sink")
    assert sink.key == b
    shell.reply(sink, "unix/b")
    source = shell.next("source")
    assert (source.key, source.message["endpoint"]) == (a, "unix/b")
    shell.reply(source)
    assert asked.result.ok


def test_pulling_the_side_that_is_asked_opens_first(shell, ends):
    a, b = ends
    asked = shell.ask(Connect(wire("w", dataport__dataflow_type="pull")))
    serve = shell.next("serve")
    assert serve.key == a
    shell.reply(serve, "unix/a")
    fetch = shell.next("fetch")
    assert (fetch.key, fetch.message["endpoint"]) == (b, "unix/a")
    shell.reply(fetch)
    assert asked.result.ok


def test_service_ports_need_no_stream(shell, ends):
    asked = shell.ask(Connect(wire("w", "A.svc", "B.svc")))
    for key in ends:
        call = shell.next("keep")
        assert call.key == key
        shell.reply(call)
    assert asked.result.ok
    assert not shell.calls


def test_the_same_again_is_what_was_asked_for(shell, ends):
    wanted = wire("w", dataport__subscription_type="flush", other="x")
    shell.ask(Connect(wanted))
    shell.serve()
    assert shell.ask(Connect(wanted)).result.ok
    assert shell.ask(Connect(wire("w", other="x"))).result.ok
    changed = shell.ask(Connect(wire("w", other="y"))).result
    assert changed.why == "connection w exists with another other"
    elsewhere = shell.ask(Connect(wire("w", "A.out", "A.in"))).result
    assert elsewhere.why == "connector id w is in use between A.out and B.in"
    assert not shell.calls


@pytest.mark.parametrize(
    ("connector", "kind", "why"),
    [
        (wire("w", "A.out", "C.in"), "not-found", "no component named C"),
        (wire("w", "A.no", "B.in"), "not-found", "Port not found: A.no"),
        (wire("w", "A.out", "B.out"), "refused", "Wrong port type."),
        (wire("w", "A.in", "B.in"), "refused", "Wrong port type."),
        (wire("w", "A.svc", "B.in"), "refused", "Wrong port type."),
        (wire("w", "B.in", "A.out"), "refused", "Wrong port type."),
        (wire("w", "A.out", "B.text"), "refused", "Data types differ"),
        (wire("", "A.out", "B.in"), "malformed", "connector id is empty"),
        (wire("a\nb", "A.out", "B.in"), "malformed", "control characters"),
        (wire("w", dataport__buffer__length="many"), "malformed", "buffer.length=many"),
        (ConnectorProfile("w", "w", ()), "malformed", "joins two ports, not 0"),
        (ConnectorProfile("w", "w", (PortRef("A", "out"),) * 3), "malformed", "not 3"),
    ],
)
def test_what_cannot_be_connected(shell, ends, connector, kind, why):
    result = shell.ask(Connect(connector)).result
    assert result.kind == kind
    assert why in result.why
    assert not shell.calls
    assert not shell.state.connectors
    assert not shell.state.openings


def test_while_it_is_being_made_it_is_neither_there_nor_free(shell, ends):
    asked = shell.ask(Connect(wire("w")))
    again = shell.ask(Connect(wire("w")))
    assert not again.is_answered
    assert not shell.state.snapshot().connectors
    assert shell.ask(Disconnect("w")).result.kind == "not-found"
    shell.serve()
    assert (asked.result.ok, again.result.value) == (True, "w")


# half-way


@pytest.mark.parametrize("failing", ["sink", "source"])
@pytest.mark.parametrize("how", ["refused", "late"])
def test_a_connection_that_fails_half_way_is_taken_off_both_ends(shell, ends, failing, how):
    asked = shell.ask(Connect(wire("w")), timeout_s=1.0)
    call = shell.next("sink")
    if failing == "source":
        shell.reply(call, "unix/b")
        call = shell.next("source")
    if how == "refused":
        shell.refuse(call, Refused("takes no more"))
        assert asked.result.why == "takes no more"
    else:
        shell.wait(1.0)
        assert asked.result.why.startswith("no answer from")
    assert shell.told == [(key, UNLINK) for key in ends]
    assert not shell.state.connectors
    assert not shell.state.openings
    shell.reply(call)  # too late
    assert not shell.state.connectors
    again = shell.ask(Connect(wire("w")))
    shell.serve()
    assert again.result.ok


def test_in_one_process_a_late_link_is_taken_off(shell):
    shell.make("A")
    shell.make("B")
    shell.ask(Connect(wire("w")), timeout_s=1.0)
    shell.next("link")
    shell.wait(1.0)
    assert shell.told == [(OWN, UNLINK)]


@pytest.mark.parametrize("stage", ["sink", "source"])
@pytest.mark.parametrize("dying", ["receiver", "sender"])
def test_an_end_that_dies_half_way(shell, ends, stage, dying):
    a, b = ends
    asked = shell.ask(Connect(wire("w")))
    if stage == "source":
        shell.reply(shell.next("sink"), "unix/b")
    dead, alive = (b, a) if dying == "receiver" else (a, b)
    shell.end(dead)
    for call in list(shell.calls):
        shell.calls.remove(call)
        shell.reply(call, "unix/b")
    assert not asked.result.ok
    assert shell.told == [(alive, UNLINK)]
    assert not shell.state.connectors


def test_an_end_that_is_deleted_half_way(shell, ends):
    a, b = ends
    shell.make("Other", "b")
    asked = shell.ask(Connect(wire("w")))
    sink = shell.next("sink")
    deleted = shell.ask(Delete("B"))
    shell.serve()
    assert deleted.result.ok
    shell.reply(sink, "unix/b")
    shell.serve()
    assert asked.result.why == "an end of connection w ended while it was made"
    assert shell.told == [(a, UNLINK), (b, UNLINK)]


def test_one_on_its_way_out_is_not_connected(shell, ends):
    shell.ask(Delete("B"))
    assert shell.ask(Connect(wire("w"))).result.why == "B is just being deleted"


def test_an_end_in_a_stopped_slave_is_refused_at_once(shell, ends):
    _, b = ends
    shell.feed(ev.SlaveStopped(b, True))
    asked = shell.ask(Connect(wire("w")))
    assert asked.result.why == "slave b does not answer: it is stopped"
    assert not shell.calls


# parting


@pytest.fixture
def wired(shell, ends):
    shell.ask(Connect(wire("w")))
    shell.serve()
    return ends


def test_parting_tells_the_sender_first(shell, wired):
    a, b = wired
    asked = shell.ask(Disconnect("w"))
    assert shell.calls[0].key == a
    shell.reply(shell.next("unlink"))
    assert shell.calls[0].key == b
    shell.reply(shell.next("unlink"))
    assert asked.result.ok
    assert shell.ask(Disconnect("w")).result.kind == "not-found"


def test_parting_in_one_process_tells_it_once(shell):
    shell.make("A")
    shell.ask(Connect(wire("w", "A.out", "A.in")))
    shell.serve()
    asked = shell.ask(Disconnect("w"))
    shell.reply(shell.next("unlink"))
    assert asked.result.ok


def test_an_end_that_dies_while_parting_is_no_obstacle(shell, wired):
    a, _ = wired
    asked = shell.ask(Disconnect("w"))
    shell.end(a)
    shell.serve()
    assert asked.result.ok


def test_an_end_that_does_not_answer_is_told_and_the_other_parted(shell, wired):
    _, b = wired
    asked = shell.ask(Disconnect("w"), timeout_s=1.0)
    shell.next("unlink")
    shell.wait(1.0)
    assert asked.result.why == "no answer from a in time"
    assert shell.told == [(b, UNLINK)]
    assert not shell.state.connectors


def test_a_stopped_end_hears_of_it_when_it_goes_on(shell, wired):
    _, b = wired
    shell.feed(ev.SlaveStopped(b, True))
    asked = shell.ask(Disconnect("w"))
    shell.reply(shell.next("unlink"))
    assert asked.result.ok
    assert shell.told == [(b, UNLINK)]


def test_deleting_an_end_parts_it_even_if_the_other_is_silent(shell, wired):
    a, b = wired
    asked = shell.ask(Delete("B"), timeout_s=5.0)
    assert shell.state.connectors  # all or nothing, should the manager be killed now
    shell.reply(shell.next("delete"))
    assert shell.told == [(a, UNLINK), (b, UNLINK)]
    shell.serve()
    shell.end(b, "exit status 0")
    assert asked.result.ok
    assert not shell.state.connectors


@pytest.mark.parametrize("dying", [0, 1])
def test_a_dead_end_is_taken_off_the_other(shell, wired, dying):
    shell.end(wired[dying])
    assert shell.told == [(wired[1 - dying], UNLINK)]
    assert not shell.state.connectors


def test_one_that_ends_by_itself_is_taken_off_its_connectors(shell, wired):
    a, b = wired
    shell.say(b, gone="B")
    assert shell.told == [(a, UNLINK), (b, UNLINK)]
    assert not shell.state.connectors


def test_a_port_that_is_no_longer_reported_loses_its_connectors(shell, wired):
    a, b = wired
    shell.say(b, facts=facts("B", [port for port in PORTS if port.name != "in"]))
    assert not shell.state.connectors
    assert shell.told == [(a, UNLINK), (b, UNLINK)]


def test_a_holder_that_has_no_such_component_is_believed(shell, ends):
    asked = shell.ask(Connect(wire("w")))
    shell.refuse(shell.next("sink"), NotFound("no component named B"))
    assert asked.result.kind == "not-found"


# interface types


def test_direct_joins_ports_of_one_process_only(shell, ends):
    result = shell.ask(Connect(wire("w", dataport__interface_type="Direct"))).result
    why = "interface type direct joins ports of one process: A.out is in a, B.in in b"
    assert (result.kind, result.why) == ("refused", why)
    assert not shell.state.openings


def test_direct_in_one_process(shell):
    shell.make("A")
    shell.make("B")
    asked = shell.ask(Connect(wire("w", dataport__interface_type="direct")))
    shell.reply(shell.next("link"))
    assert asked.result.ok


def test_a_connection_is_the_same_by_any_name_of_its_interface_type(shell):
    shell.make("A")
    shell.make("B")
    shell.ask(Connect(wire("w", dataport__interface_type="corba_cdr")))
    shell.reply(shell.next("link"))
    assert shell.ask(Connect(wire("w", dataport__interface_type="zenoh"))).result.ok
    other = shell.ask(Connect(wire("w", dataport__interface_type="direct"))).result
    assert other.why == "connection w exists with another dataport.interface_type"
