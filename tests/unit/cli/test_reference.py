"""The index of the command reference: each row names a case, or a test, that there is."""

from __future__ import annotations

import importlib
import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

from rtkit.cli.shared.commands import load

INDEX = Path(__file__).parent / "reference.txt"
CASES = Path(__file__).parent / "cases"
TESTS = Path(__file__).parents[2]


def rows() -> list[tuple[str, str]]:
    lines = INDEX.read_text(encoding="utf-8").splitlines()
    # A row may speak of = itself; what it is covered by begins with a command or a path.
    pattern = re.compile(r"(.+?) = ((?:rt|[A-Z]+_?[A-Z]*=|unit/|laws/|integration/|system/).*)")
    found = []
    for line in lines:
        if line and not line.startswith("#"):
            match = pattern.fullmatch(line)
            assert match is not None, line
            found.append((match[1], match[2]))
    return found


def test_what_a_row_names_is_there() -> None:
    texts = [file.read_text(encoding="utf-8") for file in CASES.glob("*.txt")]
    typed = {line[2:] for text in texts for line in text.splitlines() if line.startswith("$ ")}
    missing = []
    for row, covered_by in rows():
        file, colons, test = covered_by.partition("::")
        if not colons or " " in file:
            is_there = covered_by in typed
        else:
            path = TESTS / file
            is_there = path.is_file() and f"def {test}(" in path.read_text(encoding="utf-8")
        if not is_there:
            missing.append(f"{row} = {covered_by}")
    assert missing == []


def test_each_section_has_rows_of_its_own() -> None:
    sections = INDEX.read_text(encoding="utf-8").split("\n## ")[1:]
    for section in sections:
        named = [line.partition(" = ")[0] for line in section.splitlines()[1:] if line]
        assert named, section
        assert len(named) == len(set(named)), section


OPTIONS = {
    "rtact rtdeact rtreset": "-e --exec_context",
    "rtcat": "-l",
    "rtcheck": "--dry-run -s --state -x --xml -y --yaml",
    "rtcomp": "-a --add -o --options -r --remove -t --type",
    "rtcon": "-d --no-duplicates -i --id -n --name -p --property",
    "rtconf": "-a --all -l -s --set",
    "rtcryo": "-a --abstract -n --system-name -o --output -v --system-version -e --vendor -x -y",
    "rtdel": "-z --zombies",
    "rtdis": "-i --id",
    "rtdoc": "-f --format -g --graph",
    "rtexit rtcwd rtpwd rtfsm": "",
    "rtfind": "-i --iname -m --maxdepth -n --name -t --type",
    "rtinject": "-c --const -m --mod -n --number -p --path -r --rate -t --timeout",
    "rtls": "-l -R --recurse",
    "rtmgr": "-c --create -d --delete -l --load -u --unload -m --modules -r --rtcs -g --config"
    " -s --setconfig",
    "rtprint": "-m --mod -n --number -p --path -r --rate -t --timeout",
    "rtresurrect": "--dry-run -x -y --strict-path",
    "rtstart rtstop rtteardown": "--dry-run -x -y",
    "rtstodot": "-x -y",
    "rtvlog": "-f --filter -l --level",
    "rtwatch": "-n --number -f --filter",
}
COMMON = "-h --help --version --verbose"
PATHS = (
    "rtact rtcat rtcomp rtcon rtconf rtdeact rtdel rtdis rtdoc rtexit rtfind rtfsm rtls rtmgr"
    " rtreset"
)
ON_COMPONENTS = "rtact rtcat rtcomp rtcon rtconf rtdeact rtdis rtdoc rtexit rtfsm rtreset"
RAISED = {
    "No such object: ": PATHS,
    "Not a component: ": ON_COMPONENTS,
    "Zombie object: ": f"{ON_COMPONENTS} rtmgr",
    "Not a manager: ": "rtmgr",
    "Not a component or manager: ": "rtcomp",
    "Not a composite component: ": "rtcomp",
    "Not a directory: ": "rtcwd rtfind",
    "Parent not a directory: ": "rtdel",
    "Undeletable object: ": "rtdel",
    "Not a zombie object: ": "rtdel",
    "Cannot list ports.": "rtls",
    "Port not found: ": "rtcat rtcomp rtcon rtdis",
    "Not a port: ": "rtdis",
    "No source port specified.": "rtcon",
    "No destination port specified.": "rtcon",
    "Wrong port type.": "rtcon",
    "Incompatible connection properties.": "rtcon",
    "Interfaces do not match.": "rtcon",
    "Polarities do not match.": "rtcon",
    "Failed to make connection: ": "rtcon",
    "No connection found involving the specified ports.": "rtdis",
    "No connection from ": "rtdis",
    "An identical connection already exists": "rtcon",
    "A connection with ID ": "rtcon",
    "A connection with name ": "rtcon",
    "No such configuration set: ": "rtconf",
    "No such configuration parameter: ": "rtconf",
    "Failed to load module: ": "rtmgr",
    "Failed to unload module: ": "rtmgr",
    "Failed to create component: ": "rtmgr",
    "Failed to delete component: ": "rtmgr",
    "Bad execution context index: ": "rtact",
    "Bad path: ": "rtls",
}


def cases() -> list[Any]:
    spec = importlib.util.spec_from_file_location("cases", Path(__file__).parent / "test_cases.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return [case for file in CASES.glob("*.txt") for case in module.read_cases(file)]


@pytest.mark.parametrize(
    ("name", "options"),
    [(name, options) for names, options in OPTIONS.items() for name in names.split()],
)
def test_every_option_of_the_table_is_there(name: str, options: str) -> None:
    command = load(name).command
    known = {word for each in command.params for word in each.opts} | {"-h", "--help"}
    assert {*options.split(), *COMMON.split()} <= known


def test_every_message_of_the_catalogue_is_raised_by_whom_it_says() -> None:
    told = {(line.split()[0], case.err) for case in cases() for line in case.line.split(" && ")}
    missing = [
        f"{name}: {stem}"
        for stem, names in RAISED.items()
        for name in names.split()
        if not any(who == name and f"{name}: {stem}" in err for who, err in told)
    ]
    assert missing == []
