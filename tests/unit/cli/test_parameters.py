"""Parameters of system profiles, in every command that reads one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

from rtkit.cli.shared.commands import TABLE, load
from rtkit.deployment.facts import ComponentFacts

Run = Callable[[str], Any]
FILE = Path(__file__).parent / "files" / "systems" / "pairs.yaml"
GIVEN = "--prefix x. --set right=no --set left.Range0.limit=7"
READERS = {
    "rtapply",
    "rtcheck",
    "rtdev",
    "rtpkg bundle",
    "rtplan",
    "rtprofile check",
    "rtprofile doc",
    "rtprofile graph",
    "rtprofile resolve",
    "rtprofile show",
    "rtresurrect",
    "rtstart",
    "rtstate",
    "rtstodot",
    "rtstop",
    "rtteardown",
    "rtwatch",
}
"""Commands that read a system profile and do something with the system that it describes."""


def test_every_reader_of_systems_takes_them() -> None:
    takes = {
        name
        for name in TABLE
        if {"sets", "values", "prefix"} <= {each.name for each in load(name).command.params}
    }
    assert takes == READERS


def facts(world: FakeManager) -> ComponentFacts:
    found = world.snapshot().component("x.left.Range0")
    assert found is not None
    return found


@pytest.fixture
def up(run: Run, world: FakeManager) -> FakeManager:
    """Return a world in which the system lives, as stand-ins under a prefix."""
    assert run(f"rtresurrect --stand-in {GIVEN} {FILE}").status == 0
    return world


def test_a_system_is_brought_up_under_its_prefix(up: FakeManager) -> None:
    made = {name: each for name, each in up.components.items() if name.startswith("x.")}
    assert made.keys() == {"x.left.Range0", "x.left.Motor0"}
    assert facts(up).sets["default"]["limit"] == "7"


@pytest.mark.parametrize(
    ("line", "status"),
    [
        ("rtcheck -s inactive", 0),
        ("rtplan -s inactive --stand-in --detailed-exitcode", 0),
        ("rtapply -s inactive --stand-in", 0),
        ("rtstart --dry-run", 0),
        ("rtstop --dry-run", 0),
        ("rtstodot", 0),
        ("rtprofile check", 0),
        ("rtprofile doc", 0),
        ("rtprofile graph", 0),
        ("rtprofile show", 0),
        ("rtprofile resolve", 0),
        ("rtcheck --static", 0),
    ],
)
def test_all_see_the_same_system(up: FakeManager, run: Run, line: str, status: int) -> None:
    done = run(f"{line} {GIVEN} {FILE}")
    assert done.status == status, done.err
    if "rtcheck -s" not in line and "apply" not in line and "rtplan" not in line:
        assert "x.left.Motor0" in done.out
        assert "right" not in done.out


def test_it_is_taken_down_alone(up: FakeManager, run: Run) -> None:
    before = {name for name in up.components if not name.startswith("x.")}
    assert run(f"rtteardown --exit {GIVEN} {FILE}").status == 0
    assert set(up.components) == before


def test_other_values_deviate(up: FakeManager, run: Run) -> None:
    other = GIVEN.replace("limit=7", "limit=8")
    done = run(f"rtcheck -s inactive {other} {FILE}")
    assert done.status == 1
    assert "parameter limit in set default on component" in done.err


def test_a_saved_plan_holds_its_values(run: Run, tmp_path: Path, world: FakeManager) -> None:
    plan = tmp_path / "plan.json"
    assert run(f"rtplan --stand-in -s inactive --out {plan} {GIVEN} {FILE}").status == 0
    done = run(f"rtapply --set limit=3 {plan}")
    assert (done.status, done.err) == (
        2,
        "rtapply: --set: settled already where the plan is a saved one\n",
    )
    assert run(f"rtapply {plan}").status == 0
    assert facts(world).sets["default"]["limit"] == "7"


def test_an_error_of_a_component_names_the_file_of_the_include(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = (FILE.parent / "parts" / "pair.xml").read_text()
    bad = '<rtsExt:Properties rtsExt:name="rtkit.cost" rtsExt:value="none"/></rts:Components>'
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "pair.xml").write_text(pair.replace("</rts:Components>", bad, 1))
    (tmp_path / "pairs.yaml").write_bytes(FILE.read_bytes())
    monkeypatch.chdir(tmp_path)
    done = run("rtplan --stand-in pairs.yaml")
    assert done.status == 1
    assert "rtplan: parts/pair.xml:3: left.Range0: rtkit.cost: not a number" in done.err
