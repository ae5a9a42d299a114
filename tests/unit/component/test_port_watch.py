"""Watches of ports: what they note, and that a port without one is as it was."""

from __future__ import annotations

import pytest

from rtkit.component import InPort, OutPort, TimedLong
from rtkit.component.ports import port_watch
from rtkit.rtc.profiles import ConnectorProfile


def long(data: int) -> TimedLong:
    return TimedLong(data=data)


def joined(**properties: str) -> tuple[OutPort[TimedLong], InPort[TimedLong]]:
    """Return two ports with a connector, as the wiring of a process joins them."""
    out, into = OutPort(TimedLong, "out"), InPort(TimedLong, "in")
    given = {f"dataport.inport.buffer.{k.replace('__', '.')}": v for k, v in properties.items()}
    connector = ConnectorProfile("c0", "c0", (), given)
    out.attach("c0", into.open(connector, lambda sink: out.replace("c0", sink)))
    return out, into


def test_both_ends_note_the_last_value_from_the_first_look_on() -> None:
    out, into = joined()
    out.write(long(1))
    assert out.watch().last is None
    assert into.watch().last is None
    out.write(long(2))
    for port in (out, into):
        last = port.watch().last
        assert last is not None
        assert last[1] == long(2)
    assert (out.written, [into.read(), into.read()]) == (2, [long(1), long(2)])


def test_an_out_port_that_nobody_is_connected_to_is_watched() -> None:
    out = OutPort(TimedLong, "out")
    watch = out.watch()
    out.write(long(7))
    assert watch.last is not None
    assert watch.last[1] == long(7)


def test_a_watch_ends_with_the_first_value_after_nobody_looks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(port_watch, "monotonic", lambda: now[0])
    out, into = joined()
    first = out.watch(), into.watch()
    now[0] = port_watch.WATCHED_S - 1
    assert (out.watch(), into.watch()) == first
    now[0] += port_watch.WATCHED_S + 1
    out.write(long(1))
    assert (out.watch(), into.watch()) != first
    assert into.read() == long(1)


def test_fill_and_loss_of_each_buffer_are_told() -> None:
    out, into = joined(length="2")
    into.watch()
    for number in range(5):
        out.write(long(number))
    assert into.fills() == {"c0": (2, 2, 3)}
    assert into.read_all() == [long(3), long(4)]
    assert into.fills() == {"c0": (0, 2, 3)}


def test_a_buffer_that_refuses_counts_that_itself() -> None:
    out, into = joined(length="2", write__full_policy="do_nothing")
    for number in range(4):
        out.write(long(number))
    assert into.fills() == {"c0": (2, 2, 2)}
    into.watch()
    out.write(long(4))
    assert into.fills() == {"c0": (2, 2, 3)}
