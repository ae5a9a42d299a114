"""Settings of all commands and defaults of options: which layer counts, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

from rtkit.cli.shared.commands import TABLE, load
from rtkit.cli.shared.defaults import settable, variable_of
from rtkit.errors import Unreachable
from rtkit.resources import resource
from rtkit.settings.layer_file import SETTINGS
from rtkit.tree.connect import connect

LAYERS = ("flag", "environment", "project", "user", "system")
Write = Callable[[str, str], Path]


@pytest.fixture
def write(shell: Any) -> Write:
    """What writes the file of a layer."""
    places = {
        "project": shell.folder / "rtkit.toml",
        "user": shell.folder / "user" / "rtkit" / "config.toml",
        "system": shell.folder / "system" / "rtkit" / "config.toml",
    }

    def written(origin: str, text: str) -> Path:
        place: Path = places[origin]
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)
        return place

    return written


@pytest.fixture
def shown(shell: Any) -> Callable[..., dict[str, tuple[str, str]]]:
    def show(*keys: str) -> dict[str, tuple[str, str]]:
        """Return value and origin of settings by key."""
        records = jsonrecords.checked(shell.ok(f"rtconfig show --json {' '.join(keys)}"))
        assert {each["schema"] for each in records} == {"rtkit.setting/1"}
        return {each["key"]: (each["value"], each["origin"]) for each in records}

    return show


@pytest.mark.parametrize("strongest", range(1, len(LAYERS)))
def test_each_layer_counts_more_than_those_behind_it(
    shell: Any, write: Write, shown: Any, strongest: int
) -> None:
    for layer in LAYERS[strongest:]:
        if layer == "environment":
            shell.environment |= {"RTKIT_MANAGER": layer, "RTKIT_RTWAIT_TIMEOUT": "1"}
        else:
            seconds = LAYERS.index(layer)
            write(layer, f'manager = "{layer}"\n[rtwait]\ntimeout = {seconds}\n')
    counts = LAYERS[strongest]
    found = shown("manager", "rtwait.timeout")
    assert found == {"manager": (counts, counts), "rtwait.timeout": (str(strongest), counts)}
    assert f"manager '{counts}' is not running" in shell.run("rtls /").err


def test_a_flag_counts_more_than_all(shell: Any, write: Write) -> None:
    write("project", "[rtget]\ntimeout = 'x'\n")
    shell.environment |= {"RTKIT_RTGET_TIMEOUT": "0.5"}
    assert "RTKIT" not in shell.run("rtget --timeout 3 robot.speed").err


def test_the_time_of_one_command_counts_more_than_that_of_all(write: Write, shown: Any) -> None:
    write("user", "timeout = 5\n")
    write("system", "[rtls]\ntimeout = 3\n")
    assert shown("timeout", "rtls.timeout") == {
        "timeout": ("5", "user"),
        "rtls.timeout": ("3", "system"),
    }


def test_defaults_reach_the_words_of_a_group_and_flags_can_be_taken_back(
    shell: Any, write: Write
) -> None:
    write("project", "[rtprofile.show]\njson = true\n")
    profile = resource("profiles", "systems", "sensor-controller-motor.xml")
    assert json.loads(shell.ok(f"rtprofile show {profile}"))
    shell.environment |= {"RTKIT_RTPROFILE_SHOW_JSON": "0"}
    assert not shell.ok(f"rtprofile show {profile}").startswith("{")


def test_folders_are_taken_from_that_of_the_file_and_a_project_is_found_above(
    shell: Any, write: Write, shown: Any
) -> None:
    path = write("project", 'profile_path = ["profiles", "/p"]\n')
    del shell.environment["RTKIT_MODULE_PATH"]
    folder = shell.folder / "below" / "it"
    folder.mkdir(parents=True)
    whole = shown("profile_path")["profile_path"]
    assert whole == (f"{path.parent}/profiles:/p", "project")
    files = jsonrecords.checked(shell.ok("rtconfig files --json"))
    assert [each["exists"] for each in files] == [True, False, False]
    assert {each["schema"] for each in files} == {"rtkit.settings-file/1"}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('manger = "x"', "unknown key: manger (did you mean manager?)"),
        ("[rtlss]", "unknown key: rtlss (did you mean rtls?)"),
        ("[rtls]\njsno = true", "[rtls]: unknown option: jsno (did you mean json?)"),
        ("[rtls]\njson = 3", "[rtls] json: true or false are wanted"),
        ("[rtls]\ntimeout = 0", "[rtls] timeout: "),
        ("timeout = -1", "timeout: not a number above 0"),
        ("manager = true", "manager: not a text"),
        ("module_path = [1]", "module_path: not a list of texts"),
        ("x = [", "Invalid value (at end of document)"),
        ("\xff", "Invalid statement (at line 1, column 1)"),
    ],
)
def test_what_is_wrong_is_named_with_its_file(
    shell: Any, write: Write, text: str, why: str
) -> None:
    path = write("user", text)
    found = shell.run("rtls")
    assert found.err.startswith(f"rtls: {path}: {why}")
    assert (found.status, found.out) == (1, "")


def test_a_project_that_strangers_can_write_is_left_out_and_named(shell: Any, write: Write) -> None:
    write("project", 'manager = "theirs"').chmod(0o666)
    found = shell.run("rtconfig show manager")
    assert found.out.split() == ["manager", "manager"]
    assert "rtconfig: warning: file may be written by everybody, refused: " in found.err
    write("user", 'manager = "theirs"').chmod(0o666)
    assert shell.run("rtconfig files").status == 1


def test_each_setting_has_its_variable_in_the_manual() -> None:
    page = (Path(__file__).parents[3] / "man" / "rtkit.1").read_text()
    for setting in SETTINGS:
        assert variable_of(setting.key) in page.replace("\\", "")


def test_options_that_act_are_given_by_hand_alone() -> None:
    assert "create" not in settable(load("rtmgr").command)
    assert all("help" not in settable(load(name).command) for name in TABLE)


def test_an_option_without_a_default_of_the_user_s_has_that_of_the_command(
    shell: Any, shown: Any
) -> None:
    assert shown("rtls.json", "rtvlog.number") == {
        "rtls.json": ("false", "default"),
        "rtvlog.number": ("", "default"),
    }
    assert "did you mean rtls.json" in shell.run("rtconfig show rtls.jsn").err


def test_scripts_heed_the_files_too(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(write("project", 'manager = "of-the-project"').parent)
    monkeypatch.setenv("RTKIT_MANAGER", "")
    monkeypatch.delenv("RTKIT_MANAGER")
    with pytest.raises(Unreachable, match="'of-the-project' is not running"):
        connect()
