"""Configuration sets: descriptions, checks before anything is sent, files."""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

from rtkit.deployment import actions as act
from rtkit.manager.core.manager_properties import table as table_of

Run = Callable[[str], Any]
STD = "/localhost/Std0.rtc"


def test_a_set_s_description_stands_in_brackets(world: FakeManager, run: Run) -> None:
    slow = {"param": "1", "description": "slow and\nsafe"}
    fast = {"param": "2", "description": "fast"}
    world.update("Std0", sets={"default": slow, "fast": fast})
    assert run(f"rtconf {STD}").out == "+default* (slow and\\nsafe)\n+fast  (fast)\n"
    assert run(f"rtconf -l -s fast {STD}").out == (
        "-fast (fast)\n  description  fast\n  param        2\n"
    )


@pytest.fixture
def hinted(world: FakeManager) -> FakeManager:
    world.update(
        "Std0",
        sets={
            "default": {"gain": "1", "mode": "a"},
            "fast": {"gain": "5", "mode": "b"},
            "__type__": {"gain": "double", "mode": "string"},
            "__constraints__": {"gain": "0<=x<=9", "mode": "(a,b)"},
        },
    )
    return world


def test_a_value_that_does_not_fit_is_not_sent(hinted: FakeManager, run: Run) -> None:
    told = "rtconf: gain cannot be 'x': it is no number\n"
    assert run(f"rtconf {STD} set gain x") == (1, "", told)
    told = "rtconf: gain cannot be '10': it is to be 0<=x<=9\n"
    assert run(f"rtconf -s fast {STD} set gain=10 mode=a") == (1, "", told)
    assert run(f"rtconf {STD} set gain=-1 mode=c") == (
        1,
        "",
        "rtconf: gain cannot be '-1': it is to be 0<=x<=9\n"
        "rtconf: mode cannot be 'c': it is to be (a,b)\n"
        "rtconf: nothing was changed\n",
    )
    assert hinted.performed == []


def test_hints_themselves_are_not_checked(hinted: FakeManager, run: Run) -> None:
    assert run(f"rtconf -a -s __constraints__ {STD} set gain x<99").status == 0
    assert run(f"rtconf {STD} set gain 50").status == 0


def test_a_property_of_a_manager_is_set(world: FakeManager, run: Run) -> None:
    line = "set logger.log_level=DEBUG naming.formats=%h/%n.rtc"
    assert run(f"rtconf /localhost/manager.mgr {line}") == (0, "", "")
    settings = world.shell.state.settings
    assert settings.text("logger.log_level") == "DEBUG"
    assert settings.text("naming.formats") == "%h/%n.rtc"


@pytest.mark.parametrize(("command", "colon"), [("rtconf", ""), ("rtmgr -g", ":")])
def test_properties_of_a_manager_are_listed(
    world: FakeManager, run: Run, command: str, colon: str
) -> None:
    table = table_of(world.shell.state)
    width = max(map(len, table)) + len(colon) + 2
    lines = [f"{key}{colon}".ljust(width) + table[key] for key in sorted(table)]
    assert run(f"{command} /localhost/manager.mgr").out.splitlines() == list(map(str.rstrip, lines))


def exported(run: Run, line: str, tmp_path: Path) -> Path:
    file = tmp_path / "sets.json"
    assert run(f"rtconf {line} export {file}") == (0, "", "")
    return file


def test_what_was_exported_is_no_difference(run: Run, tmp_path: Path) -> None:
    for line in (STD, f"-a {STD}", f"-s set1 {STD}"):
        file = exported(run, line, tmp_path)
        assert run(f"rtconf {line} diff {file}") == (0, "", ""), line


def test_hidden_sets_are_exported_on_demand(run: Run, tmp_path: Path) -> None:
    document = json.loads(exported(run, STD, tmp_path).read_text())
    assert document["schema"] == "rtkit.configuration/1"
    assert sorted(document["sets"]) == ["default", "set1", "set2"]
    document = json.loads(exported(run, f"-a {STD}", tmp_path).read_text())
    assert sorted(document["sets"]) == ["__hidden__", "default", "set1", "set2"]


def test_differences_from_a_file(world: FakeManager, run: Run, tmp_path: Path) -> None:
    file = exported(run, f"-a {STD}", tmp_path)
    world.update("Std0", active_set="set1", sets={"default": {"new": "0"}, "set1": {"param": "7"}})
    assert run(f"rtconf {STD} diff {file}") == (
        1,
        "-active set  set1\n"
        "+active set  default\n"
        "-default.new  0\n"
        "+default.param  0\n"
        "-set1.param  7\n"
        "+set1.param  1\n"
        "+set2.param  2\n",
        "",
    )
    assert "+__hidden__.param  3\n" in run(f"rtconf -a {STD} diff {file}").out
    assert run(f"rtconf -s set1 {STD} diff {file}").out == "-set1.param  7\n+set1.param  1\n"
    records = run(f"rtconf --json -s set1 {STD} diff {file}").out.splitlines()
    assert [json.loads(each)["value_there"] for each in records] == ["1"]


def test_only_what_differs_is_imported(world: FakeManager, run: Run, tmp_path: Path) -> None:
    file = exported(run, STD, tmp_path)
    assert run(f"rtconf {STD} import {file}") == (0, "", "")
    assert world.performed == []
    run(f"rtconf -s set2 {STD} set param 9")
    run(f"rtconf -s set1 {STD} act")
    world.performed.clear()
    assert run(f"rtconf {STD} import {file}") == (0, "", "")
    assert world.performed == [
        act.SetParameters("Std0", "set2", {"param": "2"}),
        act.ActivateSet("Std0", "default"),
    ]


def test_a_change_of_the_active_set_is_seen_at_once(
    world: FakeManager, run: Run, tmp_path: Path
) -> None:
    file = exported(run, STD, tmp_path)
    run(f"rtconf {STD} set param 9")
    world.performed.clear()
    run(f"rtconf {STD} import {file}")
    assert world.performed == [
        act.SetParameters("Std0", "default", {"param": "0"}),
        act.ActivateSet("Std0", "default"),
    ]


def test_one_set_of_a_file_is_imported(world: FakeManager, run: Run, tmp_path: Path) -> None:
    file = exported(run, STD, tmp_path)
    for name in ("set1", "set2"):
        run(f"rtconf -s {name} {STD} set param 9")
    assert run(f"rtconf -s set1 {STD} import {file}").status == 0
    sets = world.components["Std0"].sets
    assert (sets["set1"]["param"], sets["set2"]["param"]) == ("1", "9")
    file.write_text('{"sets": {}}')
    told = f"rtconf: No configuration set set1 in {file}\n"
    assert run(f"rtconf -s set1 {STD} import {file}") == (1, "", told)


def test_stdin_is_imported(world: FakeManager, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    document = {"sets": {"default": {"param": 2.5}, "set1": {"param": True}}}
    text = io.TextIOWrapper(io.BytesIO(json.dumps(document).encode()))
    monkeypatch.setattr(sys, "stdin", text)
    assert run(f"rtconf {STD} import").status == 0
    sets = world.components["Std0"].sets
    assert (sets["default"]["param"], sets["set1"]["param"]) == ("2.5", "true")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{", "{file}: not JSON: "),
        ("[]", "{file}: no configuration sets: "),
        ('{"sets": 1}', "{file}: no configuration sets: "),
        ('{"sets": {"default": 1}}', "{file}: configuration set default is no table"),
        ('{"sets": {"default": {"param": []}}}', "{file}: default.param is neither text nor"),
        ('{"sets": {}, "active": 1}', "{file}: active is no name of a set"),
        ('{"sets": {"no": {}}}', "No such configuration set: no"),
        ('{"sets": {"__hidden__": {"param": "1"}}}', "No such configuration set: __hidden__"),
        ('{"sets": {}, "active": "no"}', "No such configuration set: no"),
        (
            '{"sets": {"set1": {"param": "5"}, "default": {"no": "1"}}}',
            "No such configuration parameter: no",
        ),
        ('{"sets": {}, "active": "__hidden__"}', "No such configuration set: __hidden__"),
        ("[" * 100_000, "{file}: not JSON: "),
    ],
)
def test_nothing_of_a_bad_file_is_imported(
    world: FakeManager, run: Run, tmp_path: Path, text: str, why: str
) -> None:
    file = tmp_path / "bad.json"
    file.write_text(text)
    status, out, err = run(f"rtconf {STD} import {file}")
    assert (status, out) == (1, "")
    assert err.startswith(f"rtconf: {why.format(file=file)}")
    assert world.performed == []


def test_sets_are_added_copied_and_removed(hinted: FakeManager, run: Run) -> None:
    hinted.performed.clear()
    assert run(f"rtconf {STD} add race gain=7 description=quick") == (0, "", "")
    assert run(f"rtconf {STD} copy fast near mode=a") == (0, "", "")
    assert run(f"rtconf {STD}").out == "+default* \n+fast \n+near \n+race  (quick)\n".replace(
        "* \n", "*\n"
    )
    assert hinted.components["Std0"].sets["near"] == {"gain": "5", "mode": "a"}
    assert run(f"rtconf {STD} remove near") == (0, "", "")
    assert hinted.performed == [
        act.SetParameters("Std0", "race", {"gain": "7", "description": "quick"}, act.NEW),
        act.SetParameters("Std0", "near", {"gain": "5", "mode": "a"}, act.NEW),
        act.RemoveSet("Std0", "near"),
    ]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("add race gain=10", "gain cannot be '10': it is to be 0<=x<=9"),
        ("add race gian=1", "No such configuration parameter: gian (did you mean gain?)"),
        ("add fast gain=1", "configuration set fast exists already"),
        ("add default gain=1", "configuration set default exists already"),
        ("add __x__ gain=1", "configuration set __x__ could not be activated: it begins with _"),
        ("copy fsat near", "No such configuration set: fsat (did you mean fast?)"),
        ("copy fast near gain=-1", "gain cannot be '-1': it is to be 0<=x<=9"),
        ("remove fsat", "No such configuration set: fsat (did you mean fast?)"),
        ("remove default", "configuration set default is the active one"),
        ("remove __type__", "No such configuration set: __type__"),
    ],
)
def test_what_can_be_no_set_is_refused_before_anything_is_sent(
    hinted: FakeManager, run: Run, words: str, why: str
) -> None:
    before = hinted.components["Std0"]
    assert run(f"rtconf {STD} {words}") == (1, "", f"rtconf: {why}\n")
    assert hinted.components["Std0"] == before


@pytest.mark.parametrize("words", ["add race", "copy fast", "remove", "remove a b", "add a gain"])
def test_the_form_of_words_about_sets_is_told(hinted: FakeManager, run: Run, words: str) -> None:
    status, _, err = run(f"rtconf {STD} {words}")
    assert status in (1, 2)
    assert "expected: " in err or "not PARAM=VALUE" in err


def test_a_manager_has_no_sets_to_add(run: Run) -> None:
    why = "rtconf: a manager has properties, but no configuration sets: /localhost/manager.mgr\n"
    assert run("rtconf /localhost/manager.mgr add race gain=1") == (1, "", why)


def test_an_import_adds_the_sets_that_are_not_there(
    hinted: FakeManager, run: Run, tmp_path: Path
) -> None:
    file = tmp_path / "sets.json"
    file.write_text('{"sets": {"race": {"gain": "8"}}, "active": "race"}')
    assert run(f"rtconf {STD} import {file}") == (0, "", "")
    assert hinted.components["Std0"].sets["race"] == {"gain": "8"}
    assert hinted.components["Std0"].active_set == "race"
    file.write_text('{"sets": {"near": {"gian": "8"}}}')
    assert run(f"rtconf {STD} import {file}").err == (
        "rtconf: No such configuration parameter: gian (did you mean gain?)\n"
    )
    file.write_text('{"sets": {"near": {"gain": "80"}}}')
    assert run(f"rtconf {STD} import {file}").status == 1
    assert "near" not in hinted.components["Std0"].sets
