"""What becomes a record: what is logged, printed, raised; at the end everything is as before."""

from __future__ import annotations

import json
import logging
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest

from rtkit.component.current import current
from rtkit.errors import Malformed, Refused
from rtkit.link.threads import start_thread
from rtkit.logs.logs import LEVEL_KEY, Log, begin_component, level_of


@pytest.fixture
def path(tmp_path):
    return tmp_path / "m.log"


@contextmanager
def opened(path):
    # Not a fixture: pytest puts streams of its own in place between a fixture and its test.
    log = Log("m", str(path))
    log.open()
    try:
        yield
    finally:
        log.close()


def records(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def said(path):
    return [(each.get("component", each.get("logger")), each["message"]) for each in records(path)]


def test_what_is_printed_becomes_records_line_by_line(path):
    with opened(path):
        print("one", 2)
        print("three\n\nfour", end="")
        print(file=sys.stderr)
        print("five", file=sys.stderr)
        sys.stdout.flush()
    assert said(path) == [
        ("stdout", "one 2"),
        ("stdout", "three"),
        ("stderr", "five"),
        ("stdout", "four"),
    ]
    assert [each["level"] for each in records(path)] == ["INFO", "INFO", "WARN", "INFO"]


def test_what_a_component_prints_bears_its_name(path):
    with opened(path):
        thread = threading.Thread(target=lambda: print("on a thread of its own"))
        before = current.set("Arm0")
        print("moves")
        logging.getLogger("library").warning("slips")
        thread.start()
        thread.join()
        current.reset(before)
        print("nobody's")
    assert [(each.get("component"), each["logger"]) for each in records(path)] == [
        ("Arm0", "stdout"),
        ("Arm0", "library"),
        ("Arm0", "stdout"),
        (None, "stdout"),
    ]


def test_threads_that_a_component_starts_bear_its_name_and_those_of_rtkit_do_not(path):
    def deeper():
        with ThreadPoolExecutor(1) as pool:
            pool.submit(print, "pool").result()
        raise ValueError("bad")

    with opened(path):
        before = current.set("Arm0")
        start_thread(lambda: print("pacer"), "p").join()
        current.reset(before)
        started = threading.Thread(target=deeper)
        before = current.set("Arm1")
        started.start()
        current.reset(before)
        started.join()
        after = threading.Thread(target=print, args=("after",))
        after.start()
        after.join()
    assert [(each.get("component"), each["message"][:6]) for each in records(path)] == [
        (None, "pacer"),
        ("Arm1", "pool"),
        ("Arm1", "thread"),
        (None, "after"),
    ]
    assert threading.Thread.start.__name__ == "start"


def test_lines_of_threads_do_not_mix(path):
    with opened(path):

        def say():
            print("a thread's ", end="")
            sys.stdout.write("line\n")

        print("my ", end="")
        thread = threading.Thread(target=say)
        thread.start()
        thread.join()
        print("line")
    assert said(path) == [("stdout", "a thread's line"), ("stdout", "my line")]


def test_a_line_without_end_is_cut_in_pieces(path):
    with opened(path):
        sys.stdout.write("x" * 20_000)
        print()
    assert [len(text) for _, text in said(path)] == [8192, 8192, 3616]


def test_a_print_is_as_it_was_before_afterwards(path):
    before = (
        sys.stdout,
        sys.stderr,
        sys.excepthook,
        sys.unraisablehook,
        threading.excepthook,
        warnings.showwarning,
        logging.getLogger().level,
        list(logging.getLogger().handlers),
    )
    log = Log("m", str(path))
    log.open()
    print("no end of line", end="")
    log.close()
    assert before == (
        sys.stdout,
        sys.stderr,
        sys.excepthook,
        sys.unraisablehook,
        threading.excepthook,
        warnings.showwarning,
        logging.getLogger().level,
        list(logging.getLogger().handlers),
    )
    assert said(path) == [("stdout", "no end of line")]


def test_a_handler_that_prints_does_not_call_itself(path):
    with opened(path):
        handler = logging.StreamHandler(sys.stderr)
        logging.getLogger().addHandler(handler)
        try:
            logging.getLogger("x").info("once")
        finally:
            logging.getLogger().removeHandler(handler)
    assert sorted(said(path)) == [("stderr", "once"), ("x", "once")]


def test_a_thread_that_fails_is_one_record(path):
    with opened(path):

        def fail():
            raise ValueError("bad")

        thread = threading.Thread(target=fail, name="worker")
        thread.start()
        thread.join()
    (made,) = records(path)
    assert (made["level"], made["message"]) == ("ERROR", "thread worker failed")
    assert made["exception"].endswith("\nValueError: bad")


def test_a_process_that_fails_is_one_record(path):
    with opened(path):
        try:
            raise ValueError("bad")
        except ValueError as error:
            sys.excepthook(ValueError, error, error.__traceback__)
    (made,) = records(path)
    assert (made["level"], made["message"]) == ("FATAL", "the process failed")
    assert "ValueError: bad" in made["exception"]


class Fragile:
    def __del__(self):
        raise ValueError("not now")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_exception_that_nobody_can_take_is_one_record(path):
    with opened(path):
        Fragile()
    (made,) = records(path)
    assert made["level"] == "ERROR"
    assert "ValueError: not now" in made["exception"]


def test_a_warning_is_a_record(path):
    with opened(path), warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.warn("old", DeprecationWarning, stacklevel=1)
    (made,) = records(path)
    assert made["logger"] == "py.warnings"
    assert "DeprecationWarning: old" in made["message"]


@pytest.mark.parametrize(
    ("error", "has_trace"), [(Refused("it runs already"), False), (ValueError("a bug"), True)]
)
def test_what_ends_the_process_is_told(path, error, has_trace):
    log = Log("m", str(path))
    log.open()
    with pytest.raises(type(error)), log:
        raise error
    (made,) = records(path)
    assert (made["level"], made["message"]) == ("FATAL", f"ends: {error}")
    assert ("exception" in made) is has_trace


def test_a_component_logs_under_its_name(path):
    with opened(path):
        begin_component("Arm7", {}, {})
        logging.getLogger("Arm7").info("moved")
        logging.getLogger("Arm7").debug("exactly")
    assert [(each["component"], each["message"]) for each in records(path)] == [("Arm7", "moved")]


def test_a_component_has_a_level_of_its_own(path):
    with opened(path):
        begin_component("Arm8", {LEVEL_KEY: "trace"}, {})
        logging.getLogger("Arm8").log(8, "exactly")
        begin_component("Arm8", {LEVEL_KEY: "SILENT"}, {})
        logging.getLogger("Arm8").critical("nobody hears")
        begin_component("Arm8", {}, {})
        logging.getLogger("Arm8").debug("exactly")
        logging.getLogger("Arm8").info("again")
    assert [text for _, text in said(path)] == ["exactly", "again"]


def test_a_level_that_is_inherited_is_that_of_the_process(path):
    with opened(path):
        begin_component("Arm9", {LEVEL_KEY: "DEBUG"}, {LEVEL_KEY: "DEBUG"})
        logging.getLogger("Arm9").debug("no more")
        logging.getLogger().setLevel(logging.DEBUG)
        logging.getLogger("Arm9").debug("yes")
    assert [text for _, text in said(path)] == ["yes"]


def test_a_level_that_there_is_not():
    with pytest.raises(Malformed, match="unknown log level 'LOUD'; known: SILENT, FATAL"):
        begin_component("Arm9", {LEVEL_KEY: "LOUD"}, {})
    assert level_of(" warn ") == logging.WARNING


def test_prints_are_silent_where_the_process_is(path):
    with opened(path):
        logging.getLogger().setLevel(logging.ERROR)
        print("x")
        print("y", file=sys.stderr)
    assert not path.exists()


def test_streams_look_like_files(path):
    with opened(path):
        assert (sys.stdout.fileno(), sys.stderr.fileno()) == (1, 2)
        assert sys.stdout.writable()
        assert not sys.stdout.isatty()
        assert sys.stdout.encoding == "utf-8"
        sys.stdout.buffer.write(b"")


def test_a_log_is_handed_over_to_a_fork_and_lent(path, tmp_path):
    log = Log("zygote", str(path))
    log.open()
    try:
        print("one")
        with log.lent("other", str(tmp_path / "other.log")):
            print("two")
        print("three")
        log.hand_over("slave", str(tmp_path / "slave.log"))
        print("four")
    finally:
        log.close()
    written = {
        name: [(each["process"], each["message"]) for each in records(tmp_path / name)]
        for name in ("m.log", "other.log", "slave.log")
    }
    assert written == {
        "m.log": [("zygote", "one"), ("zygote", "three")],
        "other.log": [("other", "two")],
        "slave.log": [("slave", "four")],
    }
