"""Limits as users write them, when they are reached, and what a host has."""

from __future__ import annotations

import pytest

from rtkit.deployment.limits import (
    NO_LIMITS,
    Capacity,
    SlaveLimits,
    TreeUsage,
    exhausted,
    limits_in,
    overbooked,
    reached,
    read_limits,
)
from rtkit.errors import Malformed

MIB = 1 << 20


@pytest.mark.parametrize(
    ("key", "text", "limits"),
    [
        ("memory", "200M", SlaveLimits(memory=200 * MIB)),
        ("memory", "200MiB", SlaveLimits(memory=200 * MIB)),
        ("memory", "200mb", SlaveLimits(memory=200 * MIB)),
        ("memory", "1.5G", SlaveLimits(memory=1536 * MIB)),
        ("memory", "2048K", SlaveLimits(memory=2 * MIB)),
        ("memory", "209715200", SlaveLimits(memory=200 * MIB)),
        ("processes", "4", SlaveLimits(processes=4)),
        ("descriptors", "100", SlaveLimits(descriptors=100)),
        ("processor", "0.5", SlaveLimits(processor=0.5)),
        ("processor", "50%", SlaveLimits(processor=0.5)),
        ("processor", "2", SlaveLimits(processor=2.0)),
        ("memory", "", NO_LIMITS),
    ],
)
def test_limits_are_read(key: str, text: str, limits: SlaveLimits) -> None:
    assert read_limits({f"rtkit.limit.{key}": text, "gain": "1"}) == limits


@pytest.mark.parametrize(
    ("key", "text", "why"),
    [
        ("memory", "200X", "rtkit.limit.memory: not an amount of memory from 1M on, such as"),
        ("memory", "200iB", "not an amount of memory"),
        ("memory", "-1G", "not an amount of memory"),
        ("memory", "nan", "not an amount of memory"),
        ("memory", "1e9", "not an amount of memory"),
        ("memory", "0", "not an amount of memory"),
        ("memory", "M", "not an amount of memory"),
        ("memory", "²M", "not an amount of memory"),
        ("memory", "9" * 400, "not an amount of memory"),
        ("processes", "0", r"rtkit.limit.processes: not a whole number from 1 to 1048576: 0"),
        ("processes", "2.5", "not a whole number"),
        ("descriptors", "many", "rtkit.limit.descriptors: not a whole number"),
        ("processor", "0", "rtkit.limit.processor: not a share of a processor"),
        ("processor", "-50%", "not a share of a processor"),
        ("processor", "half", "not a share of a processor"),
        ("memry", "1G", r"unknown limit: rtkit.limit.memry \(did you mean rtkit.limit.memory\?\)"),
        ("x", "1", r"unknown limit: rtkit.limit.x \(one of rtkit.limit.memory, rtkit.limit.proc"),
    ],
)
def test_what_makes_no_sense_is_refused(key: str, text: str, why: str) -> None:
    with pytest.raises(Malformed, match=why):
        read_limits({f"rtkit.limit.{key}": text})


def test_limits_of_one_slave_add_up() -> None:
    both = limits_in("A?rtkit.limit.memory=1G&rtkit.limit.processor=10%") + limits_in(
        "B?rtkit.limit.memory=512M&rtkit.limit.processor=20%"
    )
    assert both == SlaveLimits(memory=1536 * MIB, processor=0.3)
    assert both.text == "memory 1.5 GiB, processor 0.3"
    assert not limits_in("A?gain=1")
    assert not limits_in("A?rtkit.limit.memory=much")


@pytest.mark.parametrize(
    ("used", "why"),
    [
        (TreeUsage(199 * MIB, 4, 99, 0.5), ""),
        (TreeUsage(212 * MIB, 1, 1), "memory limit of 200 MiB reached (212 MiB)"),
        (TreeUsage(1, 5, 1), "limit of 4 processes reached (5)"),
        (TreeUsage(1, 1, 100), "limit of 100 descriptors reached (100)"),
        (TreeUsage(1, 1, 1, 0.98), "processor limit of 0.5 reached (0.98 over 5 s)"),
    ],
)
def test_a_limit_that_is_reached_is_told_with_what_is_used(used: TreeUsage, why: str) -> None:
    assert reached(SlaveLimits(200 * MIB, 4, 100, 0.5), used) == why
    assert reached(NO_LIMITS, used) == ""


def test_a_failure_for_want_of_something_limited_is_known_as_that() -> None:
    no_files = "OSError: [Errno 24] Too many open files: '/x' (a.py:3 in on_execute)"
    assert exhausted(SlaveLimits(memory=MIB), "MemoryError (a.py:3 in on_execute)") == (
        "memory limit of 1 MiB reached (MemoryError (a.py:3 in on_execute))"
    )
    assert exhausted(SlaveLimits(descriptors=9), no_files) == (
        f"limit of 9 descriptors reached ({no_files})"
    )
    assert exhausted(SlaveLimits(memory=MIB), no_files) == ""
    assert exhausted(SlaveLimits(memory=MIB), "ValueError: no (a.py:3)") == ""


def test_more_than_a_host_has_is_told_with_who_may_use_most() -> None:
    said = {f"C{n}": SlaveLimits(memory=n * 1024 * MIB, processor=0.5) for n in range(1, 7)}
    assert overbooked(said, Capacity(21 * 1024 * MIB, 3.0)) == ""
    assert overbooked(said, Capacity(20 * 1024 * MIB, 3.0)) == (
        "rtkit.limit.memory: 21 GiB in all (C6 6 GiB, C5 5 GiB, C4 4 GiB, C3 3 GiB, 2 more),"
        " but this host has 20 GiB"
    )
    assert "rtkit.limit.processor: 3 in all" in overbooked(said, Capacity(processors=2.0))
