"""Small functions and classes that components call by name."""

from __future__ import annotations

import io
from pathlib import Path
from threading import Event
from typing import Any

import pytest
from openrtm_files import made, write_component

from rtkit.openrtm.api import name_values, sequence_util, string_util
from rtkit.openrtm.api.clock import Time, TimeMeasure, TimeValue, setTimestamp
from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.api.ring_buffer import BufferStatus, RingBuffer
from rtkit.openrtm.api.tasks import Async_tInvoker, PeriodicTask
from rtkit.openrtm.corba.standard_types import rtc_value
from rtkit.openrtm.corba.twins import default_of


def test_properties_are_a_tree_of_values_and_defaults() -> None:
    tree = Properties(defaults_str=["conf.default.a", "1", "conf.default.b", " 2 ", "", "c", "3"])
    tree.setProperty("conf.default.a", "9")
    node = tree.getNode("conf.default")
    assert [each.getName() for each in node.getLeaf()] == ["a", "b"]
    assert (tree.getProperty("conf.default.a"), tree.getDefault("conf.default.a")) == ("9", "1")
    assert (node.getProperty("b"), tree.getProperty("x", "none")) == ("2", "none")
    assert tree.hasKey("conf") is not None
    assert tree.hasKey("c") is None
    other = Properties(prop=tree)
    other.setProperty("conf.default.a", "7")
    assert (tree.mergeProperties(other).getProperty("conf.default.a"), tree.size()) == ("7", 2)
    out = io.StringIO()
    tree.store(out, "all")
    assert out.getvalue() == "#all\nconf.default.a: 7\nconf.default.b: 2\n"
    again = Properties()
    again.load(out.getvalue().splitlines())
    assert again.texts() == tree.texts()
    assert node.removeNode("a") is not None
    assert tree.propertyNames() == ["conf.default.b"]


@pytest.mark.parametrize(
    ("former", "text", "expected"),
    [
        (0, "5", (True, 5)),
        (0, "5.0", (False, 0)),
        (0.0, "5", (True, 5.0)),
        ("a", "b", (True, "b")),
        ("a", "", (False, "a")),
        ([0], "1, 2,3", (True, [1, 2, 3])),
        ([0.0, 1.0], "4", (True, [4.0])),
        ([0], "1,x", (False, [0])),
        (None, "x", (False, None)),
    ],
)
def test_texts_become_values_of_the_kind_that_was_there(
    former: Any, text: str, expected: Any
) -> None:
    assert string_util.stringTo(former, text) == expected


def test_functions_on_texts() -> None:
    assert string_util.eraseBlank(" a\tb ") == "ab"
    assert string_util.split("a, b,,c", ",") == ["a", "b", "c"]
    assert string_util.unescape(string_util.escape("a\tb\n\\")) == "a\tb\n\\"
    assert string_util.includes("a,B", "b") is True
    assert string_util.toBool("YES", "yes", "no") is True
    assert string_util.urlparam2map("x?a=1&b") == {"a": "1", "b": ""}
    assert string_util.isURL("http://x") is True
    assert string_util.isAbsolutePath("C:\\x") is True


def test_functions_on_lists() -> None:
    items = [1]
    sequence_util.push_back(items, 2)
    sequence_util.insert(items, 0, 0)
    sequence_util.erase_if(items, lambda each: each == 1)
    assert (items, sequence_util.find(items, lambda each: each == 2)) == ([0, 2], 1)
    pairs: list[Any] = [name_values.newNV("a", "x")]
    name_values.appendStringValue(pairs, "a", "y")
    assert name_values.toString(pairs, "a") == "x,y"
    assert name_values.toProperties(pairs).getProperty("a") == "x,y"


def test_spans_of_time_are_differences() -> None:
    span = TimeValue(1, 200_000) - TimeValue(2.5)
    assert (span.sec(), span.usec(), span.toDouble(), span.sign()) == (-1, -300_000, -1.3, -1)
    first = Time()
    assert (Time() - first).getTime().toDouble() >= 0.0
    measured = TimeMeasure()
    measured.tick()
    measured.tack()
    assert (measured.count(), measured.getStatistics()[0]) == (1, True)
    data = default_of(rtc_value("TimedLong"))
    setTimestamp(data)
    assert data.tm.sec > 1_700_000_000


def test_a_ring_buffer_drops_its_oldest_value() -> None:
    buffer = RingBuffer(2)
    for value in range(3):
        buffer.write(value)
    assert (buffer.full(), buffer.read(), buffer.readable()) == (True, (0, 1), 1)
    assert buffer.read() == (BufferStatus.BUFFER_OK, 2)
    assert buffer.read() == (BufferStatus.EMPTY, 2)


def test_tasks_run_on_threads_of_their_own() -> None:
    called = Event()
    task = Async_tInvoker(called, Event.set)
    task.invoke()
    task.wait()
    assert task.finished() is True
    assert called.is_set()
    again, twice = PeriodicTask(), Event()
    counts: list[int] = []

    def count() -> None:
        counts.append(1)
        if len(counts) == 2:
            twice.set()

    again.setTask(count)
    again.activate()
    assert twice.wait(10)
    again.finalize()
    again.wait()


def test_components_of_a_process_find_each_other(tmp_path: Path) -> None:
    body = """
def onExecute(self, ec_id):
    manager = OpenRTM_aist.Manager.instance()
    self.found = (
        manager.getComponent("It0").getInstanceName(), manager.getComponent("Nobody"),
        self in manager.getComponents(),
    )
    self.long = (long("3"), unicode("x"), list(xrange(2)))
    return RTC.RTC_OK
"""
    one = made(write_component(tmp_path, "One", body))
    one.contexts["0"].activate_component(one)
    one.contexts["0"].tick()
    assert one.servant.found == ("It0", None, True)
    assert one.servant.long == (3, "x", [0, 1])
    assert hasattr(one.servant._manager, "getNaming") is False
