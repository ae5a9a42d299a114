"""Manual pages: one for each command, as the command is now, and examples that can be typed."""

from __future__ import annotations

import importlib
import shlex
import shutil
import subprocess
from pathlib import Path

import click
import pytest

from rtkit.cli import COMMANDS, load
from rtkit.cli.help.examples import EXAMPLES
from rtkit.cli.help.man import pages
from rtkit.cli.help.verbs import WORDS
from rtkit.cli.shared.app import App
from rtkit.cli.shared.group import CommandGroup, Subcommand

FOLDER = Path(__file__).parents[2] / "man"
PAGES = pages()
LINES = [line for name in EXAMPLES for line, _ in EXAMPLES[name]]


def test_each_command_has_a_page_and_no_page_is_left_over() -> None:
    names = {f"{name}.1" for name in (*COMMANDS.values(), "rtkit")}
    assert {file.name for file in FOLDER.iterdir()} == names


@pytest.mark.parametrize("name", PAGES)
def test_pages_are_up_to_date(name: str) -> None:
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert text == PAGES[name], "stale, write it anew with: make man"


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


def words_of(command: click.Command) -> dict[str, Subcommand]:
    return command.words if isinstance(command, CommandGroup) else {}


def test_every_option_of_a_word_is_on_the_page() -> None:
    for name in COMMANDS.values():
        for word in words_of(load(name).command).values():
            main = importlib.import_module(word.module).main
            assert " ".join(main.command.help.split()).startswith(word.summary.rstrip("."))
            options = [option for each in main.command.params for option in each.opts]
            for option in filter(lambda text: text.startswith("-"), options):
                assert option.replace("-", "\\-") in PAGES[f"{name}.1"], (word, option)


@pytest.mark.parametrize("line", LINES)
def test_examples_can_be_typed(line: str) -> None:
    name, *arguments = shlex.split(line)
    if name == "rtkit" and arguments[0] in WORDS:
        return
    if name == "rtkit":
        name, *arguments = [COMMANDS[arguments[0]], *arguments[1:]]
    if "-h" in arguments:
        return
    command = load(name).command
    words = words_of(command)
    if words:
        name, *arguments = arguments
        command = importlib.import_module(words[name].module).main.command
    command.make_context(name, arguments, obj=App(name)).close()
