"""``rtkit help``, and what is told to who mistypes a name."""

from __future__ import annotations

import re
from typing import Any

import pytest
from make_commands import pages

from rtkit.cli.help.topics import DETAILS, STATUSES, TOPICS, text
from rtkit.cli.shared.commands import COMMANDS
from rtkit.cli.unified import run as rtkit
from rtkit.component.ports.options import parse_options
from rtkit.errors import BUG_EXIT, RtkitError


def test_topics_are_listed_and_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert rtkit(["help"]) == 0
    listed = capsys.readouterr().out
    for topic in TOPICS:
        assert f"\n  {topic} " in listed
        assert rtkit(["help", topic]) == 0
        told = capsys.readouterr().out
        assert told.startswith(topic.capitalize())
        assert max(map(len, told.splitlines())) <= 80


def test_help_about_a_verb_is_that_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert rtkit(["help", "ls"]) == 0
    assert "List directories" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "status", "why"),
    [
        (["path"], 2, "no such topic: path (did you mean paths?)"),
        (["xyzzy"], 2, f"no such topic: xyzzy (one of {', '.join(TOPICS)})"),
        (["paths", "plans"], 1, "takes one topic, not also: plans"),
    ],
)
def test_no_such_topic(
    arguments: list[str], status: int, why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert rtkit(["help", *arguments]) == status
    assert capsys.readouterr().err.splitlines()[1] == f"rtkit help: {why}"


def test_topics_speak_of_commands_that_there_are() -> None:
    for topic in TOPICS:
        named = set(re.findall(r"\brt(?!c\b|s\b)[a-z]+\b", text(topic)))
        assert named <= {*COMMANDS.values(), "rtkit", "rtmanager", "rtport", "rtsystem"}, topic


def test_connector_properties_are_those_that_are_read() -> None:
    named = re.findall(r"^  (dataport\.publisher\.\S+) +(.*)$", text("connectors"), re.MULTILINE)
    assert [key for key, _ in named]
    plain = parse_options({})
    values = {"push_policy": "all", "skip_count": "3", "push_rate": "10"}
    for key, _ in named:
        assert parse_options({key: values[key.rpartition(".")[2]]}) != plain, key
    for tail in re.findall(r"^  ((?:read|write)\.\w+|length) ", text("connectors"), re.MULTILINE):
        value = {"length": "3"}.get(tail, "7" if tail.endswith("timeout") else "block")
        assert parse_options({f"dataport.inport.buffer.{tail}": value}) != plain, tail


def test_the_table_of_statuses_is_that_of_the_errors_and_on_each_page() -> None:
    kinds = {error.exit_code for error in [RtkitError, *RtkitError.__subclasses__()]}
    assert kinds <= set(map(int, STATUSES))
    details = {error.detail for error in [RtkitError, *RtkitError.__subclasses__()]} | {BUG_EXIT}
    assert {str(each) for each in details} == set(DETAILS)
    for name, page in pages().items():
        table = page.partition(".SH EXIT STATUS")[2].partition(".SH ENVIRONMENT")[0]
        assert all(f"\\fB{status}\\fR" in table for status in STATUSES), name
        assert all(f"{status} {meaning}" in table for status, meaning in DETAILS.items()), name
        assert all(f" {detail} " in table for detail in DETAILS), name


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("rtls /localhost/Stdd0.rtc", "/localhost/Stdd0.rtc (did you mean /localhost/Std0.rtc?)"),
        ("rtact /localhost/Outptu0.rtc", "/localhost/Outptu0.rtc"),
        ("rtact /localhost/Std0", "/localhost/Std0 (did you mean /localhost/Std0.rtc?)"),
        ("rtls /locahost/Std0.rtc", "/locahost/Std0.rtc (did you mean /localhost/Std0.rtc?)"),
        ("rtact /localhost/Std1.rtc", "/localhost/Std1.rtc"),
        ("rtcat /localhost/Std0.rtc:inn", "/localhost/Std0.rtc:inn (did you mean in?)"),
        (
            "rtcon /localhost/Std0.rtc:ot /localhost/Input0.rtc:in",
            "/localhost/Std0.rtc:ot (did you mean out?)",
        ),
        ("rtconf /localhost/Std0.rtc get parm", "parm (did you mean param?)"),
        ("rtconf -s sett1 /localhost/Std0.rtc list", "sett1 (did you mean set1?)"),
    ],
)
def test_what_may_have_been_meant(run: Any, line: str, told: str) -> None:
    outcome = run(line)
    assert outcome.status == 1
    assert outcome.err.endswith(f": {told}\n")


def test_an_option_that_is_nearly_right(run: Any) -> None:
    outcome = run("rtls --recurze")
    assert outcome.status == 2
    assert "--recurse" in outcome.err.splitlines()[-1]
