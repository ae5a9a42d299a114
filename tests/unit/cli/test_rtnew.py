"""``rtnew``: a project, whole or not at all, and never over what is there."""

from __future__ import annotations

from pathlib import Path

import jsonrecords
import pytest

from rtkit.cli.profiles.rtnew import main

FILES = ["RTC.xml", "README.md", "Scale.py", "pyproject.toml", "system.xml", "tests/test_Scale.py"]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files(folder: Path) -> list[str]:
    return sorted(str(each.relative_to(folder)) for each in folder.rglob("*") if each.is_file())


def test_a_project_is_made_in_a_new_folder(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["Scale"]) == 0
    out, err = capsys.readouterr()
    assert files(place / "Scale") == sorted(FILES)
    assert sorted(out.split()) == sorted(["written"] * 6 + [f"Scale/{each}" for each in FILES])
    assert err == "next: cd Scale; pytest; rtdev system.xml\n"
    assert [each.name for each in place.iterdir()] == ["Scale"]
    code = (place / "Scale" / "Scale.py").read_text()
    assert "self.factor * value.data" in code
    assert code.endswith("    rtkit.run(Scale)\n")
    assert "Scale.rt.TimedLong(data=21)" in (place / "Scale/tests/test_Scale.py").read_text()


def test_what_is_made_is_rtbuild_s(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from rtkit.cli.profiles.rtbuild import main as rtbuild

    assert main(["Scale", "-o", "scale", "--vendor", "me"]) == 0
    before = {each: (place / "scale" / each).read_text() for each in FILES}
    assert 'vendor = "me"' in before["Scale.py"]
    capsys.readouterr()
    assert rtbuild([str(place / "scale" / "RTC.xml")]) == 0
    assert capsys.readouterr().out == ""  # nothing has changed
    assert {each: (place / "scale" / each).read_text() for each in FILES} == before


def test_files_are_told_as_records(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["Scale", "--json"]) == 0
    records = jsonrecords.checked(capsys.readouterr().out)
    assert {jsonrecords.kind_of(each) for each in records} == {"built-file"}
    assert {(each["path"], each["fate"]) for each in records} == {
        (f"Scale/{file}", "written") for file in FILES
    }


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ([], "takes the name of the component"),
        (["A", "B"], "takes the name of the component"),
        (["my-scale"], "it is no name in Python"),
        (["3d"], "it is no name in Python"),
        (["../Scale"], "it is no name in Python"),
        (["class"], "it is no name in Python"),
        (["Json"], "a module of Python has it"),
        (["Scale", "-o", "there"], "there is there already"),
        (["Scale", "-o", "nowhere/Scale"], "cannot make nowhere/Scale: No such file"),
    ],
)
def test_what_cannot_be_made_leaves_nothing(
    place: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], why: str
) -> None:
    (place / "there").mkdir()
    assert main(arguments) != 0
    assert why in capsys.readouterr().err
    assert [each.name for each in place.iterdir()] == ["there"]
