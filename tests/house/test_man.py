"""Manual pages: one for each command, as the command is now, and examples that can be typed."""

from __future__ import annotations

import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from make_commands import examples, pages

from rtkit.cli.shared.app import App
from rtkit.cli.shared.commands import COMMANDS, TABLE, WORDS, load

FOLDER = Path(__file__).parents[2] / "man"
PAGES = pages()
LINES = [line for name in examples() for line, _ in examples()[name]]


def test_each_command_has_a_page_and_no_page_is_left_over() -> None:
    names = {f"{name}.1" for name in (*COMMANDS.values(), "rtkit")}
    assert {file.name for file in FOLDER.iterdir()} == names


@pytest.mark.parametrize("name", PAGES)
def test_pages_are_up_to_date(name: str) -> None:
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert text == PAGES[name], "stale, write it anew with: make commands"


@pytest.mark.skipif(shutil.which("groff") is None, reason="groff absent")
@pytest.mark.parametrize("name", PAGES)
def test_pages_are_well_formed(name: str) -> None:
    done = subprocess.run(
        ["groff", "-man", "-ww", "-z", "-Tutf8", str(FOLDER / name)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_every_option_is_on_its_page() -> None:
    for name in COMMANDS.values():
        command = load(name).command
        for parameter in command.params:
            for option in parameter.opts:
                if option.startswith("-"):
                    assert option.replace("-", "\\-") in PAGES[f"{name}.1"], (name, option)


def test_every_option_of_a_word_is_on_the_page() -> None:
    for name in filter(lambda each: " " in each, TABLE):
        for option in (text for each in load(name).command.params for text in each.opts):
            if option.startswith("-"):
                page = PAGES[f"{name.partition(' ')[0]}.1"]
                assert option.replace("-", "\\-") in page, (name, option)


@pytest.mark.parametrize("line", LINES)
def test_examples_can_be_typed(line: str) -> None:
    name, *arguments = shlex.split(line)
    if name == "rtkit" and arguments[0] in WORDS:
        return
    if name == "rtkit":
        name, *arguments = [COMMANDS[arguments[0]], *arguments[1:]]
    if "-h" in arguments:
        return
    if f"{name} {arguments[0] if arguments else ''}" in TABLE:
        name, *arguments = [f"{name} {arguments[0]}", *arguments[1:]]
    command = load(name).command
    command.make_context(name, arguments, obj=App(name)).close()
