"""Every RTC profile of the corpus: built twice alike, as the linter wants it, and working."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from corpus import ROOT, corpus, needs_corpus

from rtkit.builder.component_files import build
from rtkit.builder.prepare import Sources
from rtkit.builder.regions import stamped
from rtkit.profile.read import read_rtc, read_rts

FILES = corpus("rtc/*")

pytestmark = needs_corpus


def project(file: Path) -> dict[str, str]:
    profile = read_rtc(file.read_bytes(), file.name).profile
    built = build(profile, Sources(file.name.rpartition("__")[2].partition(".")[0]))
    return {
        name: stamped(each.text, has_regions=each.has_regions) for name, each in built.files.items()
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.mktemp("corpus")
    for number, file in enumerate(FILES):
        for name, text in project(file).items():
            place = base / str(number) / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(text, encoding="utf-8")
    return base


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_it_compiles_and_is_the_same_twice(file: Path) -> None:
    files = project(file)
    assert files == project(file)
    for name, text in files.items():
        if name.endswith(".py"):
            compile(text, name, "exec")
    tomllib.loads(files["pyproject.toml"])
    profile = read_rtc(file.read_bytes(), file.name).profile
    assert read_rtc(files["RTC.xml"].encode()).profile == profile
    assert len(read_rts(files["system.xml"].encode(), strict=True).profile.components) == 1


def ruff(*arguments: str) -> str:
    command = [sys.executable, "-m", "ruff", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def test_the_linter_finds_nothing(folder: Path) -> None:
    assert ruff("check", "--no-cache", "--output-format", "concise", str(folder)) == ""


def test_the_formatter_would_change_nothing(folder: Path) -> None:
    assert ruff("format", "--no-cache", "--diff", str(folder)) == ""


def test_its_rules_are_those_of_rtkit(folder: Path) -> None:
    def rules(file: Path) -> list[str]:
        found: list[str] = tomllib.loads(file.read_text())["tool"]["ruff"]["lint"]["select"]
        return found

    assert rules(folder / "0" / "pyproject.toml") == rules(ROOT / "pyproject.toml")


@pytest.mark.timeout(300)  # mypy looks at all components of the corpus
def test_types_are_right(folder: Path, tmp_path: Path) -> None:
    """Strictly typed users can use what is generated: a state machine, many ports, bytes."""
    wanted = ("eventType", "ActArray", "PointCloudViewer", "testConfiguration")
    for number in (n for n, file in enumerate(FILES) if any(w in file.name for w in wanted)):
        place = folder / str(number)
        command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--cache-dir"]
        done = subprocess.run(
            [*command, str(tmp_path / "cache"), *map(str, place.rglob("*.py"))],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "MYPYPATH": f"{ROOT}{os.pathsep}{place}"},
        )
        assert done.returncode == 0, done.stdout
