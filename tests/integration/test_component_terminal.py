"""A real pseudo-terminal of a component, without a manager."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from waiting import until

from rtkit.component.contexts.input_wait import InputEnded, allow_input, leave_input, wait_of
from rtkit.container.terminal import ComponentTerminal


@pytest.fixture
def terminal() -> Iterator[ComponentTerminal]:
    made = ComponentTerminal("A", lambda: None, lambda: None)
    yield made
    made.close()


def reading(terminal: ComponentTerminal) -> tuple[threading.Thread, list[object]]:
    got: list[object] = []

    def read() -> None:
        try:
            got.append(terminal.stdin.readline())
        except BaseException as error:
            got.append(type(error))

    thread = threading.Thread(target=read)
    thread.start()
    return thread, got


def test_a_line_is_read_when_it_is_typed(terminal: ComponentTerminal) -> None:
    thread, got = reading(terminal)
    until(lambda: wait_of("A"), "it never waited")
    assert terminal.take("grüße\n".encode())
    thread.join()
    assert got == ["grüße\n"]
    assert (wait_of("A"), terminal.unread) == ("", 0)


def test_what_is_rubbed_out_is_a_whole_character(terminal: ComponentTerminal) -> None:
    terminal.take("aü\x7fb\n".encode())
    assert terminal.stdin.readline() == "ab\n"


def test_ctrl_s_holds_nothing(terminal: ComponentTerminal) -> None:
    terminal.take(b"\x13a\n")
    assert terminal.stdin.readline() == "\x13a\n"
    terminal.show_text("after")
    assert terminal.since(0) == b"^Sa\r\nafter"


def test_ctrl_d_is_the_end_of_one_read(terminal: ComponentTerminal) -> None:
    terminal.take(b"\x04")
    assert terminal.stdin.readline() == ""
    terminal.take(b"more\n")
    assert terminal.stdin.readline() == "more\n"


def test_what_it_shows_is_known_by_its_place(terminal: ComponentTerminal) -> None:
    terminal.show_text("one\ntwo")
    place = terminal.end
    assert terminal.since(-1) == b"one\r\ntwo"
    terminal.show_text("\nthree")
    assert terminal.since(place) == b"\r\nthree"
    assert terminal.since(terminal.end) == b""
    assert terminal.since(0) == b"one\r\ntwo\r\nthree"
    assert terminal.since(5000) == terminal.since(-1), "a place of an earlier terminal"


def test_much_is_forgotten_and_whoever_attaches_sees_whole_lines(
    terminal: ComponentTerminal,
) -> None:
    for number in range(20_000):
        terminal.show_text(f"line {number}\n")
    tail = terminal.since(-1)
    assert len(tail) <= 2048
    assert tail.startswith(b"line ")
    assert tail.endswith(b"line 19999\r\n")
    assert len(terminal.since(0)) == 1 << 16


def test_no_more_is_taken_than_may_wait(terminal: ComponentTerminal) -> None:
    while terminal.take(b"x" * 1000 + b"\n"):
        pass
    before = terminal.unread
    assert before > 60_000
    assert len(terminal.stdin.readline()) == 1001
    until(lambda: terminal.unread < before, "nothing moved on")


def test_a_wait_ends_for_who_is_to_leave_and_can_begin_again(terminal: ComponentTerminal) -> None:
    thread, got = reading(terminal)
    until(lambda: wait_of("A"), "it never waited")
    leave_input("A")
    thread.join()
    assert got == [InputEnded]
    allow_input("A")
    terminal.take(b"again\n")
    assert terminal.stdin.readline() == "again\n"


def test_its_end_ends_all_waits_and_leaves_no_descriptor() -> None:
    terminal = ComponentTerminal("B", lambda: None, lambda: None)
    waits = [reading(terminal), reading(terminal)]
    until(lambda: wait_of("B"), "it never waited")
    terminal.close()
    for thread, got in waits:
        thread.join()
        assert got == [InputEnded]
    with pytest.raises(InputEnded):
        terminal.stdin.readline()
    assert not terminal.take(b"x")
