"""Logs of another host, read by questions: what is sent twice, lost, or no sense."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from datetime import datetime

import pytest

from rtkit.errors import Malformed, NotFound, Unreachable
from rtkit.link.transport import Link
from rtkit.logs.logbook import LogEntry
from rtkit.logs.selection import About, Selection, selection_from_text, selection_to_text
from rtkit.property.exchange import Reply
from rtkit.tree import clock
from rtkit.tree.client import Tree
from rtkit.tree.far_logs import FarLogbook

AHEAD_S = 30.0


def _row(second: int, text: str = "said", level: str = "INFO") -> list[object]:
    moment = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(1_800_000_000 + AHEAD_S + second))
    return [f"{moment}.000000Z", "manager", level, "manager", 7, "A", "A", text, ""]


def _second(entry: LogEntry) -> int:
    """Return when it was logged by the clock here, as exactly as that can be found in a test."""
    return round(datetime.fromisoformat(entry.time).timestamp()) - 1_800_000_000


class FarHost(Link):
    """A host whose manager answers as a test says, with its clock ahead."""

    def __init__(self) -> None:
        self.rows: list[object] = []
        self.text = ""
        self.marks = True
        self.asked = 0
        self.say: Callable[[str], object] = lambda _text: None

    def send(self, key: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        if key.endswith("@x/clock"):
            return lambda: Reply(repr(time.time() + AHEAD_S))
        self.asked += 1
        _, _, mark = selection_from_text(payload or "")
        if self.marks:
            self.say(json.dumps({"mark": mark}))
        whole = {"entries": self.rows, "left_out": 0, "unreadable": 0}
        text = self.text or json.dumps(whole)
        return lambda: Reply(text)

    def listen(self, key: str, on_text: Callable[[str], object]) -> Callable[[], object]:
        self.say = on_text
        return lambda: None

    def tell(self, number: int, *rows: object, run: str = "r") -> None:
        self.say(json.dumps({"run": run, "number": number, "entries": rows}))


@pytest.fixture
def host() -> FarHost:
    return FarHost()


@pytest.fixture
def book(host: FarHost) -> FarLogbook:
    tree = Tree(host, "robot1", "manager")
    tree.place = "robot1"
    return FarLogbook(tree, Selection())


def test_what_comes_again_on_the_topic_is_told_once(host: FarHost, book: FarLogbook) -> None:
    host.rows = [_row(1), _row(1), _row(2)]
    assert len(book.there()) == 3
    host.tell(1, _row(1), _row(2), _row(1), _row(1), _row(3))
    assert [_second(entry) for entry in book.delta()] == [1, 3]
    assert book.lost == 0


def test_times_are_put_right_and_say_how_exact_that_is(host: FarHost, book: FarLogbook) -> None:
    host.rows = [_row(5)]
    (entry,) = book.there()
    assert (entry.host, _second(entry)) == ("robot1", 5)
    assert entry.offset_s == pytest.approx(AHEAD_S, abs=0.1)
    age_s = abs(time.time() - 1_800_000_000)
    assert entry.bound_s == pytest.approx(clock.DRIFT * age_s, rel=0.01)


def test_messages_that_lack_are_counted(host: FarHost, book: FarLogbook) -> None:
    book.there()
    host.tell(1, _row(1))
    host.tell(4, _row(2))
    host.tell(9, _row(3), run="another")
    assert len(book.delta()) == 3
    assert book.lost == 2


def test_what_is_no_record_is_counted_and_not_shown(host: FarHost, book: FarLogbook) -> None:
    host.rows = [_row(1), [], None, "x", 7, {}, _row(2)[:8], [*_row(2), 1], _row(2, level="LOUD")]
    host.rows.append(["9999999", *_row(2)[1:]])
    host.rows.append([f"\x1b[31m{_row(2)[0]}", *_row(2)[1:]])
    host.rows.append(["9999-99-99T99:99:99.000000Z", *_row(2)[1:]])
    assert len(book.there()) == 2  # the last one has no time that exists, and keeps what it says
    assert book.unreadable == 10
    for text in ("", "[", "[]", "7", '{"run": 1}', "[" * 9000):
        host.say(text)
    assert book.delta() == []
    assert book.unreadable == 16


@pytest.mark.parametrize("text", ["[", "[]", "7", '{"entries": 1}', "[" * 9000])
def test_an_answer_of_no_sense_is_an_error(host: FarHost, book: FarLogbook, text: str) -> None:
    host.text = text
    with pytest.raises(Malformed, match="no sense"):
        book.there()


def test_nothing_is_shown_until_what_comes_arrives(
    host: FarHost, book: FarLogbook, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.tree.far_logs._MARK_S", 0.0)
    host.marks = False
    with pytest.raises(Unreachable, match="does not arrive"):
        book.there()
    assert host.asked > 1
    assert book.there(is_followed=False) == []


def test_a_selection_is_the_same_on_the_other_side() -> None:
    chosen = Selection("WARN", ("a",), "é\n", 5.5, (About(), About("m.s", True, ("A", "B"))))
    assert selection_from_text(selection_to_text(chosen, 3, "x")) == (chosen, 3, "x")
    assert selection_from_text(selection_to_text(Selection(), None, "")) == (Selection(), None, "")


def test_the_shortest_question_decides_about_a_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    now, took = [1000.0], iter([0.4, 0.2, 1.0])
    monkeypatch.setattr(time, "time", lambda: now[0])
    monkeypatch.setattr(time, "monotonic", lambda: now[0])

    def ask() -> float:
        way_s = next(took)
        now[0] += way_s  # all of it on the way there: as uneven as can be
        return now[0] + 30.0

    found = clock.estimated(ask, 3)
    assert (found.offset_s, found.bound_s) == (pytest.approx(30.1), pytest.approx(0.1))
    assert abs(found.offset_s - 30.0) <= found.bound_s + 1e-9
    assert found.bound_at(found.found_s - 100.0) == pytest.approx(0.1 + 100 * clock.DRIFT)


@pytest.mark.parametrize("answer", ["nan", "inf", "soon", ""])
def test_an_answer_that_is_no_time_is_an_error(host: FarHost, answer: str) -> None:
    tree = Tree(host, "robot1", "manager")
    host.send = lambda *_args: lambda: Reply(answer)  # type: ignore[method-assign]
    with pytest.raises(Malformed, match="does not tell the time"):
        clock.compare(tree)
    host.send = lambda *_args: lambda: Reply("no such view", NotFound.kind)  # type: ignore[method-assign]
    with pytest.raises(NotFound):
        clock.compare(tree)
