"""``rtnew``: begin the project of a component, with a test and a system to run it in."""

from __future__ import annotations

import keyword
import os
import sys

from rtkit.cli.shared import json_records
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag, option
from rtkit.cli.shared.terminal import printable, write
from rtkit.errors import Malformed, Refused

_CODE = {
    "on_execute": """        for value in self.in_.read_all():
            self.out.write(rt.TimedLong(value.tm, self.factor * value.data))
""",
    "tests": """

def test_it_multiplies(trial: Trial[Subject]) -> None:
    trial.activate()
    trial.send("in", NAME.rt.TimedLong(data=21))
    trial.tick()
    assert [value.data for value in trial.received("out")] == [42]


""",
}
"""Code of regions that rtbuild leaves to users: in the component, and in its test."""


@command(
    "rtnew",
    is_local=True,
    json=("built-file",),
    examples=(
        ("rtnew Scale", "Begin a project in the new folder Scale."),
        ("rtnew Gain --vendor me -o gain", "Choose who makes it, and the folder."),
    ),
    arguments=("anything",),
)
def main(
    app: App,
    output: str | None = option("-o --output DIR", "The folder, which must not be there yet."),
    vendor: str = option("--vendor", "Who makes it (default Me).", default="Me"),
    is_json: bool = json_flag("A JSON object for each file."),
    names: tuple[str, ...] = arguments("NAME"),
) -> None:
    r"""Begin the project of a component, with a test and a system.

    NAME is the type of the component, and the folder unless -o says another. Files that are there
    are never written over.

    \b
    NAME.py             the component: multiplies what arrives by a parameter
    RTC.xml             its profile; rtbuild RTC.xml makes the code anew after changes
    tests/test_NAME.py  tests, which pass: pytest
    system.xml          a system with it: rtdev system.xml
    README.md  pyproject.toml  for pip install .
    """
    import tempfile

    if len(names) != 1:
        raise WrongArguments("takes the name of the component")
    name = names[0]
    is_name = name.isidentifier() and not keyword.iskeyword(name)
    if not is_name or name.lower() in sys.stdlib_module_names:
        why = "a module of Python has it" if is_name else "it is no name in Python"
        raise Malformed(f"a component cannot be called {name!r}: {why}")
    folder = os.path.normpath(output or name)
    if os.path.lexists(folder):
        raise Refused(f"{folder} is there already; -o DIR makes another folder")
    try:
        with tempfile.TemporaryDirectory(dir=os.path.dirname(folder) or ".") as draft:
            written = _write(name, vendor, os.path.join(draft, "project"))
            os.rename(os.path.join(draft, "project"), folder)
    except OSError as error:
        raise Refused(f"cannot make {folder}: {error.strerror}") from error
    paths = [os.path.join(folder, each) for each in written]
    if is_json:
        write(json_records.lines("built-file", map(json_records.written_file, paths)))
    else:
        write(printable(f"written    {each}") for each in paths)
    app.report(f"next: cd {folder}; pytest; rtdev system.xml")


def _write(name: str, vendor: str, folder: str) -> list[str]:
    """Write the project into a new folder; return its files."""
    from rtkit.cli.profiles import generated_project, project_changes
    from rtkit.profile.write import write_profile
    from rtkit.profile_tools import new_component as new

    ports = [new.data_port("in:TimedLong", "DataInPort")]
    ports.append(new.data_port("out:TimedLong", "DataOutPort"))
    parameters = [new.parameter("factor:int=2")]
    heading = new.ComponentHeading(name, _now(), vendor, description=f"Component {name}", rate=10.0)
    profile = new.new_component(heading, ports, (), parameters, ("onExecute",))
    os.mkdir(folder)
    path = os.path.join(folder, "RTC.xml")
    with open(path, "wb") as file:
        file.write(write_profile(profile))
    project = generated_project.read([path], None, [])
    changes = project_changes.compare(project)
    project_changes.write(changes, is_forced=False)
    files = [os.path.relpath(each.path, folder) for each in changes]
    for each in files:
        if each.endswith(".py"):
            _fill(os.path.join(folder, each), name)
    return sorted({*files, "RTC.xml"})


def _now() -> str:
    from datetime import datetime

    return datetime.now().astimezone().replace(microsecond=0).isoformat()


def _fill(path: str, name: str) -> None:
    """Write what is to stand in the regions of a file of the component NAME."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for region, code in _CODE.items():
        mark = f"# <user code {region}>\n"
        text = text.replace(mark, mark + code.replace("NAME", name))
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
