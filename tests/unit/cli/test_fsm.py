"""Structures of state machines in and out of files."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

Run = Callable[[str], Any]
STD = "/localhost/Std0.rtc"
CHART = """<?xml version="1.0"?>
<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" initial="B">
  <state id="A"><onentry><log expr="'x'"/></onentry><transition event="go" target="B"/></state>
  <state id="B"/>
</scxml>
"""


@pytest.fixture
def machine(world: FakeManager) -> FakeManager:
    world.update("Std0", fsm_state="Off", fsm_states={"Off": {}}, fsm_events={})
    return world


def test_a_structure_is_taken_from_a_file(machine: FakeManager, run: Run, tmp_path: Path) -> None:
    file = tmp_path / "chart.scxml"
    file.write_text(CHART)
    assert run(f"rtfsm {STD} setstructure {file}") == (0, "", "")
    assert machine.components["Std0"].fsm_states == {"B": {}, "A": {"go": "B"}}
    outcome = run(f"rtfsm -v {STD} setstructure {file}")
    assert (outcome.status, outcome.out) == (0, "")
    assert f"{file}:3: onentry is left out\n" in outcome.err


def test_what_was_printed_can_be_read_again(
    machine: FakeManager, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    states = {"On": {"toggle": "Off"}, "On.Dim": {"up": "On.Full"}, "On.Full": {}, "Off": {}}
    machine.update("Std0", fsm_states=states)
    text = run(f"rtfsm {STD} getstructure").out
    assert text.startswith("<scxml")
    machine.update("Std0", fsm_states={"Off": {}})
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert run(f"rtfsm {STD} setstructure -") == (0, "", "")
    assert machine.components["Std0"].fsm_states == states


def test_a_file_that_cannot_be_used_changes_nothing(
    machine: FakeManager, run: Run, tmp_path: Path
) -> None:
    file = tmp_path / "bad.scxml"
    for text, why in (("<scxml", ":1: "), (CHART.replace('target="B"', 'target="C"'), ":3: no st")):
        file.write_text(text)
        status, out, err = run(f"rtfsm {STD} setstructure {file}")
        assert (status, out) == (1, "")
        assert err.startswith(f"rtfsm: {file}{why}")
        assert machine.performed == []
    assert run(f"rtfsm --exit-detail {STD} setstructure {file}").status == 3
