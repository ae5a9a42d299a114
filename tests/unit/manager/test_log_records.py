"""Log records as lines: nothing that was logged breaks a line or reaches a terminal raw."""

from __future__ import annotations

import json
import logging
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.logs.records import LEVELS, MAX_TEXT, JsonLines, Readable, level_word

MOMENT = 1_700_000_000.25


def record(message, *args, level=logging.INFO, name="Arm0", error=None):
    made = logging.LogRecord(
        name, level, __file__, 1, message, args, error and (type(error), error, error.__traceback__)
    )
    made.created, made.msecs, made.process = MOMENT, 250.0, 42
    return made


def raised(error):
    try:
        raise error
    except type(error) as caught:
        return caught


def test_a_record_is_one_object():
    line = JsonLines("s1", {"Arm0"}).format(record("at %d m", 3))
    assert line == (
        '{"time": "2023-11-14T22:13:20.250000Z", "level": "INFO", "process": "s1", "pid": 42,'
        ' "component": "Arm0", "message": "at 3 m"}'
    )


def test_what_is_no_component_is_a_logger():
    made = json.loads(JsonLines("s1", {"Arm0"}).format(record("x", name="rtkit.manager.loop")))
    assert made["logger"] == "rtkit.manager.loop"
    assert "component" not in made


def test_an_exception_is_one_field():
    made = json.loads(JsonLines("m").format(record("it failed", error=raised(ValueError("bad")))))
    assert made["message"] == "it failed"
    assert made["exception"].startswith("Traceback (most recent call last):\n")
    assert made["exception"].endswith("\nValueError: bad")


class Unspeakable(Exception):
    def __str__(self):
        raise RuntimeError("no")

    __repr__ = __str__


@pytest.mark.parametrize(
    ("message", "args", "said"),
    [
        ("%d", ("x",), "'%d' % ('x',) (TypeError: %d format: a real number is required, not str)"),
        ("%s %s", ("x",), "'%s %s' % ('x',) (TypeError: not enough arguments for format string)"),
        ("%s", (Unspeakable(),), "(a message that cannot be shown, from "),
        (Unspeakable(), (), "(a message that cannot be shown, from "),
    ],
)
def test_a_message_that_cannot_be_made_is_told_all_the_same(message, args, said):
    made = json.loads(JsonLines("m").format(record(message, *args)))
    assert made["message"].startswith(said)
    assert said in Readable().format(record(message, *args))


def test_an_exception_without_text_is_told_all_the_same():
    made = json.loads(JsonLines("m").format(record("x", error=raised(Unspeakable()))))
    assert "Unspeakable" in made["exception"]


@pytest.mark.parametrize("formatter", [JsonLines("m", {"Arm0"}), Readable("m")])
def test_a_record_has_a_bounded_length(formatter):
    error = raised(ValueError("y" * 1_000_000))
    assert len(formatter.format(record("x" * 1_000_000, error=error))) < 2 * MAX_TEXT + 1000


@given(st.text(), st.text(min_size=1))
def test_any_text_survives_and_none_steers_a_terminal(text, name):
    line = JsonLines("m").format(record("%s", text, name=name))
    assert line.isprintable()
    made = json.loads(line)
    assert (made["message"], made["logger"]) == (text, name)
    for each in Readable(text).format(record("%s", text, name=name)).split("\n"):
        assert each.isprintable()


def test_text_of_other_scripts_stays_readable():
    assert '"腕が動いた é"' in JsonLines("m").format(record("腕が動いた é"))


def test_a_readable_record():
    text = Readable().format(record("one\ntwo", level=logging.WARNING))
    assert re.fullmatch(r"\d\d:\d\d:20\.250 WARN  Arm0: one\n    two", text)
    text = Readable("s1", "%Y").format(record("x", error=raised(ValueError("bad"))))
    first, *_, last = text.split("\n")
    assert (first, last) == ("2023 INFO  s1/Arm0: x", "    ValueError: bad")


def test_levels_have_the_words_of_the_property():
    from rtkit.settings import properties

    assert tuple(LEVELS) == properties.LEVELS
    assert [level_word(number) for word, number in LEVELS.items() if word != "SILENT"] == [
        word for word in LEVELS if word != "SILENT"
    ]
    assert [level_word(n) for n in (1000, 35, 15, 9, 7, 1)] == [
        "FATAL",
        "WARN",
        "DEBUG",
        "TRACE",
        "VERBOSE",
        "PARANOID",
    ]
    assert max(LEVELS.values()) == LEVELS["SILENT"]


def test_a_stack_is_told_with_the_exception():
    made = record("x")
    made.stack_info = "Stack (most recent call last):\n  here"
    assert json.loads(JsonLines("m").format(made))["exception"].endswith("  here")
