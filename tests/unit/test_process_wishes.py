"""What a process is like while its contexts wish so, and a collector that waits for pauses."""

from __future__ import annotations

import gc
import sys
import time
import weakref
from collections.abc import Iterator

import pytest

from rtkit.container.collector_between import CollectorBetween
from rtkit.container.process_wishes import ProcessWishes, Wish
from rtkit.rtc.context_settings import CollectorMode


@pytest.fixture(autouse=True)
def _collector() -> Iterator[None]:
    """Leave the collector as it was."""
    thresholds = gc.get_threshold()
    yield
    gc.set_threshold(*thresholds)
    gc.enable()


def test_the_strictest_wish_counts_and_the_last_one_ends_it() -> None:
    wishes, usual_s = ProcessWishes(), sys.getswitchinterval()
    wishes.state("a", Wish(switch_s=0.002, collector=CollectorMode.FROZEN))
    assert gc.isenabled()
    wishes.state("b", Wish(switch_s=0.001, collector=CollectorMode.OFF))
    assert (sys.getswitchinterval(), gc.isenabled()) == (0.001, False)
    wishes.drop("b")
    assert (sys.getswitchinterval(), gc.isenabled()) == (0.002, True)
    wishes.state("a", Wish(collector=CollectorMode.BETWEEN))
    assert (sys.getswitchinterval(), gc.isenabled()) == (usual_s, False)
    wishes.drop("a")
    wishes.drop("a")
    assert gc.isenabled()


def test_a_collector_that_the_component_stopped_stays_so() -> None:
    wishes = ProcessWishes()
    gc.disable()
    wishes.state("a", Wish(collector=CollectorMode.OFF))
    wishes.drop("a")
    assert not gc.isenabled()


class Node:
    """Something that only the collector can take away."""

    def __init__(self) -> None:
        self.own = self


def garbage() -> weakref.ref[Node]:
    return weakref.ref(Node())


def test_garbage_is_collected_where_there_is_time() -> None:
    gc.collect()
    gc.disable()
    gc.set_threshold(500, 1000, 1000)
    collector = CollectorBetween()
    lost = garbage()
    collector.collect(time.monotonic_ns() + 10**12)
    assert lost() is not None  # it is not yet time
    kept = [Node() for _ in range(1000)]
    collector.collect(0)
    assert lost() is not None  # there is no time
    collector.collect(time.monotonic_ns() + 10**12)
    assert lost() is None
    lost = garbage()
    kept += [Node() for _ in range(1000)]
    collector.collect(0)
    assert lost() is not None
    kept += [Node() for _ in range(50_000)]
    collector.collect(0)
    assert lost() is None  # so much has come together that it waits no longer
