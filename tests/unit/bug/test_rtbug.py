"""What rtbug says before anything runs: words, files, folders; and what it lists."""

from __future__ import annotations

import json
from pathlib import Path

import jsonrecords
import pytest
from bug import running

from rtkit.cli.examples.rtbug import main

KINDS = ("variant", "sensors", "world")
ONE = ["run", "--world", "one-box", "--variant", "bug2", "--sensors", "laser"]


def _said(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    status = main(arguments)
    out, err = capsys.readouterr()
    assert out == ""
    return status, err.splitlines()[-1]


@pytest.mark.parametrize(
    ("typed", "status", "why"),
    [
        ([], 1, "No word specified."),
        (["rum"], 1, "no such word: rum (did you mean run?)"),
        (["run", "it"], 1, "takes one word, not also: it"),
        (["run"], 2, "no --world given: name one, or --all"),
        (["run", "--world", "closed"], 2, "no --variant given: name one, or --all"),
        (
            [*ONE, "--world", "oen-box"],
            2,
            "no such world: oen-box (did you mean one-box?)",
        ),
        ([*ONE, "--variant", "bug11"], 2, "--variant: no such variant: bug11 (did you mean bug1?)"),
        ([*ONE, "--variant", "Bug1"], 2, "--variant: no such variant: Bug1 (did you mean bug1?)"),
        ([*ONE, "--sensors", "lasr"], 2, "--sensors: no such sensors: lasr (did you mean laser?)"),
        ([*ONE, "--direction", "up"], 2, "no such direction: up (one of left, right)"),
        ([*ONE, "--speedup", "-1"], 2, "-1"),
        ([*ONE, "--watch"], 1, "--watch draws in a terminal, and stdout is none"),
        ([*ONE, "--out", "/proc/none"], 1, "/proc/none: nothing can be written there: "),
        ([*ONE, "--environments", "none.json"], 1, "none.json: No such file or directory"),
    ],
)
def test_what_cannot_be_run_is_refused_before_anything_runs(
    typed: list[str],
    status: int,
    why: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rtkit.cli.examples.rtbug._manager", None)
    found, text = _said(typed, capsys)
    assert found == status
    assert why in text


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"{", "worlds.json: Expecting property name"),
        (b"\xff", "worlds.json: it is no UTF-8"),
        (b"[]", "worlds.json: an object of environments by their names is needed"),
        (b'{"a": {"start": [0, 0], "goal": [1, "x"], "obstacles": []}}', "worlds.json: a.goal: "),
        (
            b'{"../a": {"start": [0, 0], "goal": [1, 1], "obstacles": []}}',
            "'../a': a world's name has",
        ),
        (
            b'{"\\u001b[2J": {"start": [0, 0], "goal": [1, 1], "obstacles": []}}',
            "a world's name has",
        ),
    ],
)
def test_a_file_that_does_not_fit_is_refused_with_its_place(
    content: bytes,
    why: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "worlds.json").write_bytes(content)
    monkeypatch.chdir(tmp_path)
    status, text = _said([*ONE, "--environments", "worlds.json", "--out", "out"], capsys)
    assert status == 1
    assert why in text
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ('{"x": {"leave": "m-line"}}', "x: leave and motion are both m-line or neither"),
        ('{"x": {"laeve": "m-line"}}', "x: no key 'laeve'; did you mean leave?"),
        ('{"a/b": {}}', "'a/b': a variant's name has"),
        ("[]", "an object of assemblies by their names is needed"),
    ],
)
def test_a_variant_that_cannot_work_is_refused(
    content: str, why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own.json").write_text(content)
    status, text = _said([*ONE, "--variants", str(tmp_path / "own.json")], capsys)
    assert status == 1
    assert why in text


def test_what_it_takes_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--json"]) == 0
    words = jsonrecords.checked(capsys.readouterr().out)
    assert {"schema": "rtkit.bug-word/1"}.items() <= words[0].items()
    by_kind = {
        kind: [w["name"] for w in words if w["kind"] == kind] for kind in ("variant", "world")
    }
    assert by_kind["variant"][:7] == [
        "bug1",
        "bug2",
        "alg1",
        "alg2",
        "distbug",
        "tangentbug",
        "rev1",
    ]
    assert by_kind["world"][:3] == ["closed", "one-box", "visited"]


def test_the_list_says_what_each_does_and_which_all_runs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    assert "Algorithmica" not in out
    assert all(len(line) <= 110 for line in out.splitlines())
    marked = [line.split()[1] for line in out.splitlines() if line.split()[2] == "--all"]
    assert marked == [*running.PAPER[1], *running.PAPER[2], *running.PAPER[0]]
    assert main(["list", "--json"]) == 0
    words = jsonrecords.checked(capsys.readouterr().out)
    assert [each["name"] for each in words if each["is_of_all"]] == marked
    assert main(["list", "-v"]) == 0
    assert "Algorithmica" in capsys.readouterr().out


def test_a_variant_of_a_file_without_summary_is_listed_by_its_source(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own.json").write_text('{"own": {"source": "an exercise"}}')
    assert main(["list", "--variants", str(tmp_path / "own.json")]) == 0
    assert "an exercise" in capsys.readouterr().out


def test_worlds_of_a_file_are_listed_and_win(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    world = {"start": [0, 0], "goal": [1, 1], "obstacles": [], "note": "mine"}
    file = tmp_path / "w.json"
    file.write_text(json.dumps({"closed": world, "new": world}))
    assert main(["list", "--environments", str(file)]) == 0
    out = capsys.readouterr().out
    assert out.count("mine") == 2
    assert "square ring" not in out


def test_the_folder_of_the_example_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["where"]) == 0
    assert (Path(capsys.readouterr().out.strip()) / "system.yaml").is_file()


def test_all_is_what_the_paper_has() -> None:
    found = running.combinations(*running.PAPER, ("left",), 0)
    assert len(found) == len(set(found)) == 42
    twice = running.combinations(("a", "a"), ("b",), ("laser",), ("left", "right", "left"), 0)
    assert len(twice) == 2


PROFILES = sorted(file.stem for file in running.FOLDER.glob("[A-Z]*.yaml"))


@pytest.mark.parametrize("name", PROFILES)
def test_the_profile_of_a_component_is_that_of_its_code(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Make it anew with: rtprofile from NAME.py -o NAME.yaml"""
    from rtkit.cli.profiles.words.diff import main as diff
    from rtkit.cli.profiles.words.from_ import main as from_

    new = str(tmp_path / f"{name}.yaml")
    assert from_([str(running.FOLDER / f"{name}.py"), "-o", new]) == 0
    capsys.readouterr()
    diff([str(running.FOLDER / f"{name}.yaml"), new])
    found = capsys.readouterr().out.splitlines()
    assert [each for each in found if "date" not in each.lower()] == []
