"""Buffers and ports against a list that does the same in the obvious way."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rtkit.component import TimedLong
from rtkit.component.ports.buffer import make_ring, select
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.options import (
    BufferOptions,
    EmptyPolicy,
    FullPolicy,
    PortStatus,
    PushPolicy,
)
from rtkit.component.ports.out_port import OutPort
from rtkit.rtc.profiles import ConnectorProfile

STEPS = st.lists(st.sampled_from(["write", "write", "read", "all"]), max_size=60)
ANSWER = {
    FullPolicy.OVERWRITE: None,
    FullPolicy.DO_NOTHING: PortStatus.FULL,
    FullPolicy.BLOCK: PortStatus.TIMEOUT,
}


def write_model(model, number, length, policy):
    if len(model) < length:
        model.append(number)
        return None
    if policy is FullPolicy.OVERWRITE:
        model.pop(0)
        model.append(number)
    return ANSWER[policy]


@given(
    length=st.integers(2, 5),
    full=st.sampled_from(FullPolicy),
    empty=st.sampled_from(EmptyPolicy),
    steps=STEPS,
)
def test_a_ring_does_what_the_list_does(length, full, empty, steps):
    ring = make_ring(BufferOptions(length, full, 0.0, empty, 0.0))
    model = []
    for number, step in enumerate(steps):
        if step == "write":
            assert ring.write(number) is write_model(model, number, length, full)
        else:
            assert ring.take() == (model.pop(0) if model else None)
        assert len(ring) == len(model)


@given(
    length=st.integers(1, 5),
    full=st.sampled_from(FullPolicy),
    empty=st.sampled_from(EmptyPolicy),
    steps=STEPS,
)
def test_a_hop_does_what_the_list_does(length, full, empty, steps):
    out, into = OutPort(TimedLong, "out"), InPort(TimedLong, "in")
    into_keys = {
        "length": str(length),
        "write.full_policy": full.upper(),
        "write.timeout": "0",
        "read.empty_policy": empty.value,
        "read.timeout": "0",
    }
    properties = {f"dataport.inport.buffer.{key}": value for key, value in into_keys.items()}
    out.attach("c", into.open(ConnectorProfile("c", "c", (), properties)))
    model, last = [], None
    for number, step in enumerate(steps):
        assert into.is_new() == bool(model)
        if step == "write":
            refused = write_model(model, number, max(length, 2), full)
            assert out.write(TimedLong(data=number)) is (refused or PortStatus.OK)
        elif step == "all":
            assert [value.data for value in into.read_all()] == model
            last = model[-1] if model else last
            model.clear()
        else:
            value = into.read()
            got = None if value is None else value.data
            if model:
                last = model.pop(0)
                assert got == last
            else:
                assert got == (last if empty is EmptyPolicy.READBACK else None)


@given(writes=st.lists(st.integers(0, 2), max_size=60))
def test_connectors_of_one_port_keep_their_own_order_and_share_fairly(writes):
    into = InPort(TimedLong, "in")
    outs = [OutPort(TimedLong, f"out{index}") for index in range(3)]
    for index, out in enumerate(outs):
        id = f"c{index}"
        keys = {"dataport.inport.buffer.length": "100"}
        out.attach(id, into.open(ConnectorProfile(id, id, (), keys)))
    for number, index in enumerate(writes):
        outs[index].write(TimedLong(data=number * 3 + index))
    read = []
    while into.is_new():
        read.append(into.read().data)
    for index in range(3):
        own = [number * 3 + index for number, which in enumerate(writes) if which == index]
        assert [number for number in read if number % 3 == index] == own
    least = min(writes.count(index) for index in range(3))
    assert sorted(number % 3 for number in read[: 3 * least]) == sorted([0, 1, 2] * least)


@given(
    policy=st.sampled_from(PushPolicy),
    skip=st.integers(0, 4),
    batches=st.lists(st.integers(0, 7), max_size=20),
)
def test_a_publisher_sends_in_order_and_nothing_twice(policy, skip, batches):
    ring = make_ring(BufferOptions(200))
    written, sent = 0, []
    for count in batches:
        for _ in range(count):
            ring.write(written)
            written += 1
        chosen = select(policy, ring, skip)
        if policy is PushPolicy.NEW:
            assert chosen == ([written - 1] if count else [])
        sent += chosen
    assert sent == sorted(set(sent))
    if policy is PushPolicy.ALL:
        assert sent == list(range(written))
    if policy is PushPolicy.FIFO:
        assert sent == list(range(len(sent)))
    if policy is PushPolicy.SKIP:
        assert sent == list(range(skip, written, skip + 1))
