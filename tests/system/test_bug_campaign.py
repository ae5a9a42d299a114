"""All deployments of Bug navigation, each to its end: the answers, the lengths, the pages."""

from __future__ import annotations

from pathlib import Path

import jsonrecords
import pytest
from shells import ROOT, Shell

pytestmark = [pytest.mark.campaign, pytest.mark.timeout(1800)]

IDEAL = {
    "closed": {"bug1 bug2 alg1 alg2 rev1 distbug": (25.1, 25.1)},
    "one-box": {"bug1": (25.0, 25.0), "bug2 alg1 rev1": (11.6, 14.6), "alg2 distbug": (10.6, 12.9)},
    "visited": {
        "bug1": (90.5, 90.5),
        "bug2": (68.9, 29.2),
        "alg1": (56.6, 29.2),
        "alg2": (53.1, 27.3),
        "rev1": (14.6, 29.2),
    },
    "spiral": {
        "bug1": (122.7, 124.9),
        "bug2": (33.6, 140.6),
        "alg1": (33.6, 104.6),
        "alg2": (32.1, 92.6),
        "rev1": (33.6, 65.4),
    },
    "comb": {
        "bug1": (96.8, 96.8),
        "bug2 alg1": (35.6, 21.2),
        "alg2 distbug": (17.9, 19.7),
        "rev1": (98.6, 21.2),
    },
}
"""Lengths of an ideal walker 0.3 m off the walls [m], turning left, and turning right first."""
MOST = {"laser": 1.25, "ir": 1.40}
LEAST = 0.85


def _ideal(record: dict) -> float | None:
    for names, lengths in IDEAL[record["environment"]].items():
        if record["variant"] in names.split():
            return lengths[record["direction"] == "right"]
    return None


def _hold(records: list[dict]) -> None:
    wrong = []
    for record in records:
        ideal = _ideal(record)
        low, high = (ideal or 0) * LEAST, (ideal or 1e9) * MOST[record["sensors"]]
        answer = "unreachable" if record["environment"] == "closed" else "reached"
        if record["status"] != answer or record["collisions"] or record["min_clearance"] < 0.0999:
            wrong.append(record)
        elif not low <= record["path_length"] <= high:
            wrong.append((ideal, record))
    assert wrong == []


def test_all_of_the_paper_are_right_and_the_pages_show_them(shell: Shell) -> None:
    outcome = shell.end_of(shell.open("rtbug run --all --out runs --json"), 1200.0)
    assert outcome.status == 0, outcome.err
    records = jsonrecords.checked(outcome.out)
    assert len(records) == 42
    _hold(records)
    pages = {file.name: file for file in (ROOT / "docs" / "bug").iterdir()}
    made = {file.name: file for file in (shell.folder / "runs").iterdir() if file.is_file()}
    assert made.keys() == pages.keys() - {"index.md"}
    assert [n for n in made if made[n].read_bytes() != pages[n].read_bytes()] == []


@pytest.mark.parametrize("world", ["spiral", "comb"])
def test_harder_worlds_are_right_both_ways(shell: Shell, world: str) -> None:
    names = ["bug1", "bug2", "alg1", "alg2", "distbug", "tangentbug", "rev1"]
    named = " ".join(f"--variant {name}" for name in names)
    line = f"rtbug run --world {world} {named} --sensors laser --sensors ir"
    outcome = shell.end_of(shell.open(f"{line} --direction left --direction right --json"), 1200.0)
    assert outcome.status == 0, outcome.err
    records = jsonrecords.checked(outcome.out)
    assert len(records) == 28
    _hold(records)


def test_other_sensors_are_right_too(shell: Shell) -> None:
    worlds = " ".join(f"--world {world}" for world in ("closed", "one-box", "visited"))
    line = f"rtbug run {worlds} --variant bug1 --variant bug2 --variant alg2 --sensors laser+ir"
    outcome = shell.end_of(shell.open(f"{line} --sensors bumper --json"), 1200.0)
    assert outcome.status == 0, outcome.err
    assert len(jsonrecords.checked(outcome.out)) == 18
    assert Path(shell.folder).is_dir()
