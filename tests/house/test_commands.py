"""One table of commands: files, console scripts, manual pages; and what a listing may import."""

from __future__ import annotations

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from rtkit.cli import COMMANDS
from rtkit.cli._app import Main
from rtkit.cli._verbs import SUMMARIES

ROOT = Path(__file__).parents[2]
MAX_LINES = 500
SHARED = {"rtkit": "rtkit.cli:main"}
FORBIDDEN_ON_THE_WAY = (
    "asyncio",
    "concurrent.futures",
    "http",
    "importlib.metadata",
    "logging",
    "lxml",
    "paramiko",
    "rich",
    "rtkit.component",
    "rtkit.deployment.actions",
    "rtkit.deployment.facts",
    "rtkit.manager",
    "rtkit.planner",
    "rtkit.profile",
    "rtkit.rtc.plain",
    "rtkit.rtc.profiles",
    "shutil",
    "socket",
    "ssl",
    "subprocess",
    "tempfile",
    "xml",
    "xmlschema",
    "yaml",
    "zenoh",
)


def test_files_and_scripts_are_those_of_the_table() -> None:
    files = {file.stem for file in (ROOT / "rtkit" / "cli").glob("rt*.py")}
    with (ROOT / "pyproject.toml").open("rb") as stream:
        scripts = tomllib.load(stream)["project"]["scripts"]
    assert files == set(COMMANDS.values())
    assert scripts == {name: f"rtkit.cli.{name}:main" for name in COMMANDS.values()} | SHARED


def test_the_readme_lists_each_command_once() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = text.partition("## Commands")[2].partition("\n## ")[0].splitlines()
    cells = [row.split(" | ")[0].removeprefix("| ") for row in rows if row.startswith("| `rt")]
    listed = [name.strip("`") for cell in cells for name in cell.split()]
    assert sorted(listed) == sorted(COMMANDS.values())


@pytest.mark.parametrize("verb", COMMANDS)
def test_a_command_s_help_begins_as_the_table_says(verb: str) -> None:
    main = importlib.import_module(f"rtkit.cli.{COMMANDS[verb]}").main
    assert isinstance(main, Main)
    assert main.name == COMMANDS[verb]
    assert f"rt{verb}" == main.name
    help_text = " ".join((main.command.help or "").split())
    assert help_text.startswith(SUMMARIES[verb].removesuffix("."))


def test_a_listing_imports_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from rtkit.cli.rtls import main\n"
        "import rtkit.tree.client\n"
        "from rtkit.deployment.listing import Listing, Row\n"
        "rows = (Row('A', 'Active', 1, 1, 1, 0, 0, 0, 'm', '', '', False, ('localhost/A.rtc',)),)\n"
        "class Tree:\n"
        "    def listing(self): return Listing('box', 'm', 1, (), rows)\n"
        "assert main(['-l', '/localhost'], tree=Tree()) == 0\n"
        f"found = [name for name in {FORBIDDEN_ON_THE_WAY} if name in sys.modules]\n"
        "print(found, file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr == "[]\n"
    assert "A.rtc" in done.stdout


def test_the_verdict_on_a_valid_profile_imports_nothing_heavy() -> None:
    needed = {"lxml", "rtkit.profile", "concurrent.futures", "yaml"}
    script = (
        "import sys\n"
        "from rtkit.cli.rtprofile import main\n"
        f"assert main(['validate', {str(ROOT / 'profiles' / 'Motor.xml')!r}]) == 0\n"
        f"names = {(*FORBIDDEN_ON_THE_WAY, 'elementpath', 'difflib', 'urllib')}\n"
        f"found = [name for name in names if name in sys.modules and name not in {needed}]\n"
        "print(found, file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr == "[]\n"
    assert done.stdout.endswith("Motor.xml: valid (RTC profile)\n")


def test_no_file_is_longer_than_a_reader_can_hold() -> None:
    long = {
        str(file.relative_to(ROOT)): count
        for folder in ("rtkit", "examples", "bench")
        for file in (ROOT / folder).rglob("*.py")
        if (count := len(file.read_text(encoding="utf-8").splitlines())) > MAX_LINES
    }
    assert long == {}


def test_nothing_tells_where_it_was_written() -> None:
    words = ("/" + "work/", "farm" + "-", "." + "library")
    folders = ("rtkit", "tests", "examples", "bench", "docs", "man", "schemas")
    files = [file for folder in folders for file in (ROOT / folder).rglob("*")]
    found = [
        (str(file), word)
        for file in files
        if file.is_file() and file.suffix in (".py", ".md", ".toml", ".txt", ".xsd", ".1")
        for word in words
        if word in file.read_text(encoding="utf-8")
    ]
    assert found == []
