"""``rtprofile from``: the profile of a component, from its code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

from rtkit.profile.read import read_profile, read_rtc
from rtkit.resources import resource

Run = Callable[[str], Any]
SAMPLES = resource("examples", "basic")
CODE = """
from rtkit.component import Component, OutPort, TimedLong


class One(Component):
    '''The first.'''


class Two(Component):
    '''The second.'''

    def __init__(self, *arguments):
        super().__init__(*arguments)
        if self.instance != "Two0":
            raise ValueError(self.instance)

    def on_initialize(self):
        self.add_out_port("late", TimedLong)


class Bad(Component):
    def __init__(self, *arguments):
        raise ValueError("no")


class Refuses(Component):
    def on_initialize(self):
        return "RTC_ERROR"


def both(manager):
    manager.register_factory(One)
    manager.register_factory(Two)


def minesInit(manager):
    manager.register_factory(One)


def fails(manager):
    raise ValueError("never")


def nothing(manager):
    pass


number = 3
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mines.py").write_text(CODE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1735689600")
    monkeypatch.delenv("RTKIT_MODULE_PATH", raising=False)
    return tmp_path


@pytest.mark.parametrize("name", ["ConsoleIn", "ConfigSample", "Microwave", "MyServiceConsumer"])
def test_samples_have_the_profiles_that_ship(place: Path, run: Run, name: str) -> None:
    expected = Path(resource("profiles", f"{name}.xml")).read_text()
    assert run(f"rtprofile from {name}") == (0, expected, "")
    assert run(f"rtprofile from {SAMPLES}/{name}.py:{name}Init") == (0, expected, "")
    assert run(f"rtprofile from {name}.py -o out.xml") == (0, "", "")
    assert (place / "out.xml").read_text() == expected


def test_ports_that_are_made_later_need_initialisation(place: Path, run: Run) -> None:
    expected = Path(resource("profiles", "SeqOut.xml")).read_text()
    assert run("rtprofile from SeqOut").out == expected
    assert "DataPorts" not in run("rtprofile from SeqIn").out
    _, out, err = run("rtprofile from -v SeqIn")
    assert err == "ports that on_initialize makes are not told: --initialize calls it\n"
    assert out.count("<rtc:DataPorts") == 0
    expected = Path(resource("profiles", "SeqIn.xml")).read_text()
    assert run("rtprofile from --initialize SeqIn") == (0, expected, "")


def test_forms(place: Path, run: Run) -> None:
    xml = read_rtc(run("rtprofile from mines.py").out.encode()).profile
    for form in ("yaml", "json"):
        assert run(f"rtprofile from mines.py -o out.{form}").status == 0
        data = (place / f"out.{form}").read_bytes()
        assert read_profile(data, f"out.{form}").profile == xml
        told = run(f"rtprofile from mines.py --to {form}").out.encode()
        assert read_profile(told, "", form=form).profile == xml


def test_a_class_or_one_of_several_types(place: Path, run: Run) -> None:
    for line in ("mines.py:Two", "--type Two mines.py:both", "mines:Two"):
        profile = read_rtc(run(f"rtprofile from {line}").out.encode()).profile
        assert profile.basic_info is not None
        assert (profile.id, profile.basic_info.description) == ("RTC:::Two:", "The second.")
        told = [each.name for each in profile.basic_info.properties]
        assert told == (["rtkit.module"] if "both" in line else [])


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("", "One MODULE:FACTORY has to be given."),
        ("a b", "One MODULE:FACTORY has to be given."),
        ("Nix", f"no module Nix (looked in ., {SAMPLES} and among installed packages)"),
        ("./nix.py", "no module {place}/nix.py (looked in ., "),
        ("mines.py:nix", "no init function nix in module mines.py"),
        ("mines.py:number", "mines.py:number is neither an init function nor a component class"),
        ("mines.py:both", "mines.py:both offers several types; say --type: One, Two"),
        ("--type Three mines.py:both", "mines.py:both offers no type Three; there are: One, Two"),
        ("mines.py:nothing", "mines.py:nothing offers no component type"),
        ("mines.py:fails", "init function fails of mines.py failed: ValueError: never (mines.py:"),
        ("mines.py:Bad", "mines.py:Bad: ValueError: no (mines.py:"),
        ("--initialize mines.py:Refuses", "mines.py:Refuses: on_initialize returned RTC_ERROR"),
        ("mines.py -o out.txt", "no form to write: --to xml|yaml|json, or a FILE that ends so"),
        ("mines.py -o nix/out.xml", "cannot write nix/out.xml: No such file or directory"),
    ],
)
def test_what_cannot_be_done_is_told(place: Path, run: Run, line: str, why: str) -> None:
    status, out, err = run(f"rtprofile from {line}")
    assert status in (1, 2)
    assert out == ""
    assert err.splitlines()[-1].startswith(f"rtprofile from: {why.format(place=place)}")


def test_a_module_that_does_not_import_says_where(place: Path, run: Run) -> None:
    (place / "broken.py").write_text("x = 1\nimport nothing_of_that_name\n")
    status, _, err = run("rtprofile from broken.py")
    assert status == 1
    assert "ModuleNotFoundError" in err
    assert err.endswith("broken.py:2)\n")


def test_names_of_openrtm_that_are_not_there_are_records(place: Path, run: Run) -> None:
    file = place / "Old.py"
    file.write_text("import OpenRTM_aist\n\nraise ValueError(OpenRTM_aist.SdoServiceAdmin)\n")
    done = run("rtprofile from --json Old.py")
    (record,) = jsonrecords.checked(done.out)
    assert (done.status, done.err, jsonrecords.kind_of(record)) == (0, "", "absent-name")
    assert (record["file"], record["line"]) == (str(file), 3)
    assert record["name"] == "OpenRTM_aist.SdoServiceAdmin"
    assert run("rtprofile from --json mines.py") == (0, "", "")
    status, out, err = run("rtprofile from Old.py")
    assert (status, out) == (1, "")
    assert (
        f"warning: {file}:3: OpenRTM_aist.SdoServiceAdmin of OpenRTM-aist is not supported" in err
    )
    assert "ValueError" in err.splitlines()[-1]


def test_an_old_component_in_python_2_is_told_as_one(place: Path, run: Run) -> None:
    (place / "Old.py").write_text("import OpenRTM_aist\nprint 'x'\n")
    for line in ("rtprofile from Old.py", "rtprofile from --json Old.py"):
        status, out, err = run(line)
        assert (status, out) == (1, "")
        assert "Old.py:2 is Python 2 (print as a statement): rtkit openrtm migrate" in err
