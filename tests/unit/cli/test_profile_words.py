"""rtprofile where a transcript does not reach: stdin, terminals, files that it writes, imports."""

from __future__ import annotations

import io
import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from lxml import etree

from rtkit.cli.profiles.rtprofile import main
from rtkit.profile.rules import RULES

FILES = Path(__file__).parent / "files"
ROOT = Path(__file__).parents[3]


@pytest.fixture
def stdin(monkeypatch: pytest.MonkeyPatch) -> None:
    data = (FILES / "sensor.xml").read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))


@pytest.mark.usefixtures("stdin")
@pytest.mark.parametrize(
    ("line", "shown"),
    [
        (["validate"], "<stdin>: valid (RTC profile)\n"),
        (["validate", "-"], "<stdin>: valid (RTC profile)\n"),
        (["show"], "Range 1.0  component type, RTC profile 0.3\n"),
        (["show", "-"], "Range 1.0  component type, RTC profile 0.3\n"),
        (["convert", "-", "--to", "json"], "{\n"),
        (["normalise"], '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'),
        (["doc"], "<!DOCTYPE html>\n"),
        (["graph"], "<svg "),
    ],
)
def test_stdin_is_read(line: list[str], shown: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(line) == 0
    assert capsys.readouterr().out.startswith(shown)


@pytest.mark.usefixtures("stdin")
def test_one_side_of_a_comparison_may_be_stdin() -> None:
    assert main(["diff", "-", str(FILES / "sensor.xml")]) == 0


@pytest.mark.parametrize("word", ["validate", "show", "doc", "graph", "normalise"])
def test_nobody_waits_for_a_terminal(
    word: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stdin", Terminal())
    assert main([word]) == 1
    assert capsys.readouterr().err.endswith(f"rtprofile {word}: No file specified.\n")


def script(line: list[str]) -> list[str]:
    code = (
        "import sys\nfrom rtkit.cli.profiles.rtprofile import main\n"
        f"status = main({line!r})\nprint('rich' in sys.modules, file=sys.stderr)\nsys.exit(status)"
    )
    return [sys.executable, "-c", code]


def test_a_pipe_gets_lines_and_no_rich() -> None:
    line = ["show", str(FILES / "sensor.xml")]
    done = subprocess.run(script(line), capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stderr == "False\n"
    assert "\n    in   trigger   RTC::TimedBoolean\n" in done.stdout


def test_a_terminal_gets_a_tree() -> None:
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    environment.pop("NO_COLOR", None)
    with subprocess.Popen(
        script(["show", str(FILES / "sensor.xml")]),
        stdout=theirs,
        stderr=subprocess.PIPE,
        cwd=ROOT,
        env=environment,
    ) as child:
        os.close(theirs)
        parts = []
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:
                break
            if not part:
                break
            parts.append(part)
        assert child.stderr is not None
        assert child.stderr.read() == b"True\n"
    os.close(ours)
    assert child.returncode == 0
    shown = b"".join(parts).decode()
    assert "\u251c\u2500\u2500 " in shown
    assert "\x1b[1m" in shown
    assert "trigger   RTC::TimedBoolean" in shown


def test_the_rules_can_be_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "--rules"]) == 0
    listed = dict(line.split(None, 1) for line in capsys.readouterr().out.splitlines())
    assert RULES.items() <= listed.items()


def test_a_report_is_one_document(capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(FILES / name) for name in ("odd.xml", "wrong.xml", "sensor.xml", "nix.xml")]
    assert main(["validate", "--format", "sarif", *files]) == 1
    results = json.loads(capsys.readouterr().out)["runs"][0]["results"]
    assert {result["level"] for result in results} == {"note", "error"}
    assert main(["validate", "--format", "junit", *files]) == 1
    root = etree.fromstring(capsys.readouterr().out.encode())
    cases = {case.get("name"): len(case) for case in root.iter("testcase")}
    assert list(cases.values()) == [0, 1, 0, 1]
    assert main(["validate", "--json", *files]) == 1
    verdicts = [json.loads(line)["valid"] for line in capsys.readouterr().out.splitlines()]
    assert verdicts == [True, False, True, False]


def test_files_are_converted_and_drawn(tmp_path: Path) -> None:
    source = str(FILES / "pair.xml")
    for name in ("a.yaml", "b.json", "c.xml"):
        assert main(["convert", source, str(tmp_path / name)]) == 0
        assert main(["diff", "--all", source, str(tmp_path / name)]) == 0
    assert main(["doc", source, "-o", str(tmp_path / "page.md")]) == 0
    assert main(["doc", source, "-o", str(tmp_path / "page.html")]) == 0
    assert main(["graph", source, "-o", str(tmp_path / "pair.svg"), "--title", "A & B"]) == 0
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == ["a.yaml", "b.json", "c.xml", "page.html", "page.md", "page.svg", "pair.svg"]
    assert (
        "![The components and connectors of Pair](page.svg)" in (tmp_path / "page.md").read_text()
    )
    assert etree.parse(tmp_path / "pair.svg").getroot()[0].text == "A & B"
    assert etree.parse(tmp_path / "page.svg").getroot().tag.endswith("svg")


def test_in_place_keeps_what_needs_no_repair(tmp_path: Path) -> None:
    good, odd = tmp_path / "good.xml", tmp_path / "odd.xml"
    good.write_bytes((FILES / "sensor.xml").read_bytes())
    odd.write_bytes((FILES / "odd.xml").read_bytes())
    before = good.stat()
    assert main(["normalise", "-qi", str(good), str(odd)]) == 0
    assert (good.stat().st_ino, good.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)
    assert main(["validate", "--strict", str(odd)]) == 0


def test_a_comment_that_is_lost_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (FILES / "sensor.xml").read_text()
    Path("a.xml").write_text(text.replace("<rtc:Actions>", "<!-- mine --><rtc:Actions>"))
    assert main(["convert", "a.xml", "a.yaml"]) == 0
    assert capsys.readouterr().err == (
        "a.xml:6: warning: comment 'mine' is no part of the profile and left out"
        " [comment-dropped]\n"
    )
