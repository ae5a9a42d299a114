"""What ``rtdoc`` and ``rtstodot`` write of components that document themselves, and of systems."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager
from lxml import etree

Run = Callable[[str], Any]
FILES = Path(__file__).parent / "files"
EXAMPLES = Path(__file__).parents[3] / "examples" / "basic"
STD = "/localhost/Std0.rtc"
DOC = {
    "changelog": "1.0: begun",
    "usage": "Turn it on.\n\nTurn it off.",
    "tips": "None & <none>",
    "intro": "It is_standard.",
    "__license__": "Apache-2.0",
    "__contact__": "me@example.org",
    "__url__": "https://example.org",
}


@pytest.fixture
def documented(world: FakeManager) -> FakeManager:
    sets = {"default": {"param": "0"}, "__doc__": DOC, "__description__": {"param": "How many"}}
    world.update("Std0", sets=sets)
    return world


def titles(text: str) -> list[str]:
    return [line.removeprefix("## ") for line in text.splitlines() if line.startswith("## ")]


def test_what_a_component_documents_itself(documented: FakeManager, run: Run) -> None:
    text = run(f"rtdoc -f markdown {STD}").out
    assert titles(text) == [
        "Introduction",
        "Usage",
        "Ports",
        "Configuration parameters",
        "Changelog",
        "tips",
    ]
    for word in ("Apache-2.0", "me@example.org", "https://example.org", "How many", "Turn it off."):
        assert word in text


def test_the_order_that_a_component_asks_for(documented: FakeManager, run: Run) -> None:
    doc = {**DOC, "__order__": "config, tips, nothing"}
    documented.update("Std0", sets={"default": {"param": "0"}, "__doc__": doc})
    done = run(f"rtdoc -f markdown {STD}")
    assert titles(done.out)[:3] == ["Configuration parameters", "tips", "Introduction"]
    assert done.err == "rtdoc: warning: __order__ names no section: nothing\n"


@pytest.mark.parametrize("form", ["html", "rst", "latex", "markdown", "text"])
def test_every_form_says_the_same(documented: FakeManager, run: Run, form: str) -> None:
    text = run(f"rtdoc -f {form} {STD}").out
    for word in ("Std", "Apache", "Turn it on.", "Changelog", "How many"):
        assert word in text
    assert "<none>" not in text or form in ("rst", "text")
    assert ("is\\_standard" in text) == (form in ("latex", "markdown"))
    if form == "html":
        etree.fromstring(text.encode())


def test_pictures(documented: FakeManager, run: Run, tmp_path: Path) -> None:
    assert "<svg" in run(f"rtdoc -g {STD}").out
    assert "<svg" not in run(f"rtdoc {STD}").out
    assert "   digraph component {" in run(f"rtdoc -f rst -g {STD}").out
    run(f"rtdoc -f md -g -o {tmp_path / 'a.md'} {STD}")
    assert "(a.svg)" in (tmp_path / "a.md").read_text()
    etree.parse(tmp_path / "a.svg")


def test_a_module_with_its_profile(run: Run) -> None:
    done = run(f"rtdoc -f text {EXAMPLES / 'Motor.py'}")
    assert (done.status, done.err) == (0, "")
    assert "velocity  DataInPort" in done.out
    assert "Callbacks" in done.out


def test_a_graph_of_a_file_and_of_stdin_is_the_same(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = run(f"rtstodot {FILES / 'pair.xml'}").out
    assert text.startswith("digraph rtsprofile {\n  rankdir=LR;\n")
    stdin = io.TextIOWrapper(io.BytesIO((FILES / "pair.xml").read_bytes()))
    monkeypatch.setattr(sys, "stdin", stdin)
    assert run("rtstodot").out == text


def test_a_live_graph_has_colours_for_states(run: Run) -> None:
    lines = run("rtstodot --live").out.splitlines()
    (error,) = [line for line in lines if "Err0" in line]
    assert "fillcolor=tomato" in error
    assert sum("fillcolor=lightblue" in line for line in lines) > 3
    (manager,) = [line for line in lines if "subgraph" in line]  # which holds the slaves
    frames = re.findall(r' pid \d+([^"]*)"; ((?:c\d; )+)', manager)
    assert [each[0] for each in frames] == ["", "", " · lost: signal 9"]
    assert [each[1].count(";") for each in frames] == [6, 1, 1]
