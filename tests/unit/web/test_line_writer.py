"""Lines of the page's log are written aside."""

from __future__ import annotations

import threading

from rtkit.web.audit.line_writer import written_aside

BOUND_S = 10.0


def test_lines_are_written_in_order_before_the_end() -> None:
    lines: list[str] = []
    with written_aside(lines.append) as put:
        for number in range(100):
            put(str(number))
    assert lines == [str(number) for number in range(100)]


def test_nobody_waits_for_a_reader_that_does_not_read() -> None:
    may_read = threading.Event()
    lines: list[str] = []
    is_full = threading.Event()

    def write(line: str) -> None:
        is_full.set()
        assert may_read.wait(BOUND_S)
        lines.append(line)

    with written_aside(write) as put:
        put("first")
        assert is_full.wait(BOUND_S)
        for number in range(1500):
            put(str(number))
        may_read.set()
        while len(lines) < 1001:
            may_read.wait(0.001)
        put("last")
    assert lines[:3] == ["first", "0", "1"]
    assert lines[-2:] == ["500 lines were lost: nobody read them", "last"]
