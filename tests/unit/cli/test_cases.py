"""The case tables of the command reference as transcripts: stdout, stderr and status exactly.

In ``cases/*.txt``: ``$`` a command line, or several with ``&&`` between, then what stdout shows
(``␠`` is a blank at the end of a line), ``!`` a line of stderr, ``?`` the exit status where it is
not 0, ``=`` the connections left. ``@`` in the first lines names what a file's world needs more.
``⟨WIRES⟩`` stands for the schemes of all wires, ``⟨WIRES:⟩`` for them with colons.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import jsonrecords
import pytest
from fake_manager import FakeManager

from rtkit.deployment.actions import Connect
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.wires import table

FOLDER = Path(__file__).parent / "cases"
WIRES = {"a": ("Std0", "Std0"), "b": ("Std0", "Input0"), "c": ("Output0", "Input0")}


def give_machine(world: FakeManager, _place: Path, _patch: pytest.MonkeyPatch) -> None:
    """Make Std0 a component with a state machine."""
    states = {"Off": {"toggle": "On"}, "On": {"toggle": "Off"}, "On.Dim": {}}
    events = {"toggle": "RTC::TimedShort", "more": "Mine::Event"}
    world.update("Std0", fsm_state="On.Dim", fsm_states=states, fsm_events=events)


def give_files(_world: FakeManager, place: Path, patch: pytest.MonkeyPatch) -> None:
    """Stand in a folder with copies of the files."""
    shutil.copytree(FOLDER.parent / "files", place, dirs_exist_ok=True)
    patch.chdir(place)


NEEDS = {"machine": give_machine, "files": give_files}


class Case(NamedTuple):
    needs: str
    line: str
    out: str
    err: str
    status: int
    wires: str | None


def read_cases(file: Path) -> list[Case]:
    cases: list[Case] = []
    needs = ""
    whole = file.read_text(encoding="utf-8").replace("⟨WIRES⟩", " ".join(table.WIRES))
    whole = whole.replace("⟨WIRES:⟩", " ".join(f"{each}:" for each in table.WIRES))
    for text in whole.splitlines():
        mark, rest = text[:2], text[2:]
        if mark == "# ":
            continue
        if mark == "$ ":
            cases.append(Case(needs, rest, "", "", 0, None))
            continue
        if mark == "@ ":
            needs = rest
            continue
        case = cases.pop()
        if mark == "! ":
            case = case._replace(err=f"{case.err}{rest}\n")
        elif mark == "? ":
            case = case._replace(status=int(rest))
        elif mark == "= ":
            case = case._replace(wires=rest)
        else:
            case = case._replace(out=f"{case.out}{text.replace('␠', ' ')}\n")
        cases.append(case)
    return cases


def records_of(case: Case) -> list[str]:
    """Return the lines of stdout that are records of ``--json``."""
    return [line for line in case.out.splitlines() if line.startswith('{"schema":')]


CASES = [case for file in sorted(FOLDER.glob("*.txt")) for case in read_cases(file)]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.line)
def test_case(
    run: Callable[[str], Any],
    world: FakeManager,
    case: Case,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if case.needs:
        NEEDS[case.needs](world, tmp_path, monkeypatch)
    if case.wires is not None:
        for name, (source, sink) in WIRES.items():
            ends = (PortRef(source, "out"), PortRef(sink, "in"))
            assert world.perform(Connect(ConnectorProfile(name, name, ends))).ok
    assert run(case.line) == (case.status, case.out, case.err)
    jsonrecords.checked("\n".join(records_of(case)))
    if case.wires is not None:
        assert sorted(world.connectors) == case.wires.split()
