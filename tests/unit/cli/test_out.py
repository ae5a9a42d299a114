"""Columns, widths, colours, and what must never reach a terminal."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any

import pytest
from fake_manager import FakeManager

from rtkit.cli.shared import terminal

Run = Callable[[str], Any]


@pytest.fixture
def on_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(terminal, "is_terminal", lambda: True)


def columns(texts: list[str], width: int) -> list[str]:
    return terminal.columns([(text, text) for text in texts], width)


@pytest.mark.parametrize(
    ("texts", "width", "lines"),
    [
        ([], 80, []),
        (["a"], 1, ["a"]),
        (["aa", "b"], 5, ["aa  b"]),
        (["aa", "b"], 4, ["aa", "b"]),
        (["a", "bbb", "cc", "d"], 8, ["a   bbb", "cc  d"]),
        (["a", "b", "c"], 4, ["a  b", "c"]),
        (["longer than the terminal", "b"], 5, ["longer than the terminal", "b"]),
        (["部品", "b"], 7, ["部品  b"]),
        (["部品", "b"], 6, ["部品", "b"]),
    ],
)
def test_columns_are_filled_row_by_row(texts: list[str], width: int, lines: list[str]) -> None:
    assert columns(texts, width) == lines


def test_columns_take_styled_text_for_what_is_seen() -> None:
    cells = [("a", "\x1b[1ma\x1b[0m"), ("bb", "bb"), ("ccc", "ccc"), ("d", "d")]
    assert terminal.columns(cells, 8) == ["\x1b[1ma\x1b[0m    bb", "ccc  d"]


@pytest.mark.usefixtures("on_terminal")
def test_a_terminal_gets_columns(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    assert run("rtls /localhost").out == (
        "Adder0.rtc    Err0.rtc         Input0.rtc    Std0.rtc  Text0.rtc  User0.rtc\n"
        "*Zombie0.rtc  local.host_cxt/  manager.mgr/\n"
    )
    assert run("rtls -1 /localhost/manager.mgr/slave1.mgr").out == "Input0.rtc\n"


@pytest.mark.usefixtures("on_terminal")
@pytest.mark.parametrize(
    ("line", "shown"),
    [
        ("rtls /", "\x1b[34m\x1b[1mlocalhost/\x1b[0m\n"),
        ("rtls /localhost/Zombie0.rtc", "\x1b[37m\x1b[2m*Zombie0.rtc\x1b[0m\n"),
        (
            "rtls -l /localhost/Err0.rtc",
            "\x1b[37m\x1b[41m\x1b[1mError\x1b[0m  2/0  1/0  1/0  0/0  Err0.rtc"
            "  (ValueError: no such speed (robot.py:12))\n",
        ),
        (
            "rtls -l /localhost/Std0.rtc",
            "\x1b[34m\x1b[1mInactive\x1b[0m  2/0  1/0  1/0  0/0  Std0.rtc\n",
        ),
        ("rtcat /localhost/Std0.rtc:in", "+DataInPort: \x1b[1min\x1b[0m\n"),
        (
            "rtconf /localhost/Std0.rtc",
            "+\x1b[32m\x1b[1mdefault\x1b[0m*\n+\x1b[1mset1\x1b[0m \n+\x1b[1mset2\x1b[0m \n",
        ),
    ],
)
def test_colours(run: Run, line: str, shown: str) -> None:
    assert run(line).out == shown


@pytest.mark.parametrize(
    ("environment", "is_coloured"),
    [
        ({}, False),
        ({"FORCE_COLOR": "1"}, True),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
    ],
)
def test_the_environment_decides_on_colour(
    environment: dict[str, str], is_coloured: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert terminal.has_colour() is is_coloured


@pytest.mark.usefixtures("on_terminal")
def test_a_dumb_terminal_gets_no_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    assert terminal.has_colour()
    monkeypatch.setenv("TERM", "dumb")
    assert not terminal.has_colour()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain", "plain"),
        ("größe 部品\u3000x\u00a0y", "größe 部品\u3000x\u00a0y"),
        ("\x1b[2J", "\\x1b[2J"),
        ("\x9b31m\x85", "\\x9b31m\\x85"),
        ("a\tb\r\n", "a\\tb\\r\\n"),
        ("\u202egpj.exe\u2066", "\\u202egpj.exe\\u2066"),
        ("\u2028\u200b", "\\u2028\\u200b"),
        ("\udc80", "\\udc80"),
    ],
)
def test_what_steers_a_terminal_is_escaped(text: str, shown: str) -> None:
    assert terminal.printable(text) == shown


@pytest.mark.usefixtures("on_terminal")
def test_a_value_is_escaped_for_a_terminal_only(
    world: FakeManager, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    world.update("Std0", sets={"default": {"param": "a\x1b[2Jb"}})
    line = shlex.join(["rtconf", "/localhost/Std0.rtc", "get", "param"])
    assert run(line).out == "a\\x1b[2Jb\n"
    monkeypatch.setattr(terminal, "is_terminal", lambda: False)
    assert run(line).out == "a\x1b[2Jb\n"
