"""The small device of the examples, in C, on a terminal: built, asked, listened to, fed rubbish."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from conformance import check_answers
from oneline import BOUND_S, OneLine
from serialkit import EMBEDDED, Cable, build_device, noise
from small_profile import LEFT_OUT, check_small_events, small_rows

from rtkit.property.messages import Answer
from rtkit.wires.serial.client import SerialClient, connect_serial

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the example, built."""
    return build_device(tmp_path_factory.mktemp("embedded"))


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    cable = Cable(str(tmp_path))
    yield cable
    cable.close()


@contextmanager
def device(built: Path, cable: Cable) -> Iterator[subprocess.Popen[bytes]]:
    end = os.open(cable.far, os.O_RDWR | os.O_NOCTTY)
    process = subprocess.Popen([built / "device"], stdin=end, stdout=end)
    os.close(end)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


Asked = Callable[[str], SerialClient]


@pytest.fixture
def ask(built: Path, cable: Cable) -> Iterator[Asked]:
    """Connects to the device, which runs."""
    with device(built, cable):
        yield lambda check: connect_serial(f"serial:{cable.near}?check={check}", BOUND_S)


@pytest.mark.parametrize("check", ["auto", "0"])
def test_it_answers_as_far_as_its_profile_goes(ask: Asked, check: str) -> None:
    with ask(check) as client:
        assert client.has_checks is (check == "auto")
        check_answers(OneLine(client), small_rows())


@pytest.mark.parametrize("check", ["auto", "0"])
def test_it_tells_events(ask: Asked, check: str) -> None:
    with ask(check) as client:
        check_small_events(OneLine(client))


def test_it_answers_alike_where_lines_are_damaged(ask: Asked, cable: Cable) -> None:
    cable.noise = noise(5, one_in=6)
    rows = tuple(row for row in small_rows() if len(row[1] or "") < 1000)
    with ask("1") as client:
        check_answers(OneLine(client), rows)
        client.listen("count?lease=60")
        client.ask("count", "123").value()
        assert client.ask("count").payload == "123"


def test_what_is_asked_again_acts_once(ask: Asked, cable: Cable) -> None:
    cable.noise = noise(11, one_in=4)
    with ask("1") as client:
        for _ in range(40):
            assert client.ask("button.press", "true").error == ""
        assert client.ask("button.presses").payload == "40"


def test_what_it_was_too_busy_for_can_be_asked_again(ask: Asked) -> None:
    with ask("1") as client:
        assert client.ask("grip", "true", same_as="the same").error == "busy"
        assert client.ask("grip", "true", same_as="the same").error == ""


def test_a_repetition_is_answered_as_the_first_was(ask: Asked) -> None:
    with ask("1") as client:
        for _ in range(2):
            assert client.ask("count?echo=false", "5", same_as="one") == Answer("")
            assert client.ask("count?echo", "5", same_as="two") == Answer("5")


@pytest.mark.parametrize(
    ("given", "told"),
    [("0.2994", "0.299"), ("0.2996", "0.3"), ("-.29951", "-0.3"), ("2995e-4", "0.3"),
     ("4e-4", "0.0"), ("5e-4", "0.001"), ("0.9999", "1.0"), ("-0.9999", "-1.0")],
)  # fmt: skip
def test_decimals_are_rounded(ask: Asked, given: str, told: str) -> None:
    with ask("1") as client:
        assert client.ask("speed?echo", given) == Answer(told)
        for outside in ("1.0001", "-1.0001", "1e9"):
            assert client.ask("speed", outside).error == "bad-value"
        assert client.ask("count", "2.5").error == "bad-value"


def test_a_string_needs_no_quotes_whatever_it_looks_like(ask: Asked) -> None:
    with ask("1") as client:
        for text in ("-x", ".x", "2x", "+", "1.50", "true"):
            assert client.ask("name?echo", text) == Answer(f'"{text}"')
        assert client.ask("name", "(x)").error == "bad-value"


@pytest.mark.parametrize(
    "macro", ["PS_LINE_BYTES=256", "PS_VALUE_BYTES=256", "PS_ID_BYTES=200", "PS_LISTENERS=256"]
)
def test_sizes_that_it_cannot_count_are_refused_by_the_compiler(built: Path, macro: str) -> None:
    command = ["cc", "-fsyntax-only", f"-D{macro}", "ps_line.c"]
    done = subprocess.run(command, cwd=built, capture_output=True, text=True, timeout=BOUND_S)
    assert done.returncode != 0
    assert f'#error "{macro.partition("=")[0]} is ' in done.stderr


def test_each_thing_left_out_is_about_something_and_is_said() -> None:
    assert len(small_rows()) > 65
    told = (EMBEDDED / "README.md").read_text(encoding="utf-8")
    for name in LEFT_OUT:
        assert f"| {name} |" in told


def test_a_device_that_restarts_is_listened_to_again(
    built: Path, cable: Cable, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.wires.serial.client.LEASE_S", 0.6)
    with device(built, cable):
        client = connect_serial(cable.near, BOUND_S)
        client.listen("count")
        event = client.event(BOUND_S)
        assert event is not None
        client.ask("count", "8").value()
        while (event := client.event(BOUND_S)) is not None and event.payload != "8":
            pass
    with device(built, cable), client:
        event = client.event(BOUND_S)
        assert event is not None
        assert event.payload == "7"


def test_its_size_is_as_the_readme_says(built: Path) -> None:
    done = subprocess.run(
        ["make", "-s", "size"], cwd=built, check=True, capture_output=True, text=True, timeout=60
    )
    found = [int(each) for each in re.findall(r"(\d+) bytes", done.stdout)]
    told = (EMBEDDED / "README.md").read_text(encoding="utf-8")
    stated = [int(each.replace(",", "")) for each in re.findall(r"([\d,]+) bytes", told)][:4]
    # Compilers differ; what is said is to hold within a fifth.
    assert len(found) == len(stated) == 4
    for size, said in zip(found, stated, strict=True):
        assert size <= said * 1.2, done.stdout


def test_rubbish_breaks_nothing(built: Path) -> None:
    """Of the sanitizers' own making: whatever they find ends it with a report."""
    subprocess.run(["make", "-s", "fuzzer"], cwd=built, check=True, timeout=BOUND_S * 2)
    count = os.environ.get("RTKIT_FUZZ", "20000")
    done = subprocess.run([built / "fuzzer", "1", count], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
