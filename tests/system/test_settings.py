"""Configuration sets in and out of files, direct addresses and watching, on real processes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rtkit.deployment.actions import SetParameters
from rtkit.errors import Malformed
from rtkit.tree.connect import connect

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
SAMPLE = "/localhost/ConfigSample0.rtc"


def test_a_value_that_does_not_fit_changes_nothing(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConfigSample {MANAGER}")
    for change, why in (
        ("int_param0=5 double_param0=x", "double_param0 cannot be 'x': it is no number"),
        ("int_param0=101", "int_param0 cannot be '101': it is to be 0<=x<=100"),
        ("str_param0=four", "str_param0 cannot be 'four': it is to be (one,two,three)"),
        ("vector_param0=1,b", "vector_param0 cannot be '1,b': 'b' is no number"),
    ):
        assert manager.run(f"rtconf {SAMPLE} set {change}") == (1, "", f"rtconf: {why}\n")
    assert manager.ok(f"rtconf {SAMPLE} get int_param0") == "0\n"
    manager.ok(f"rtconf {SAMPLE} set int_param0=100 bool_param0=yes vector_param0=1,2")
    assert manager.ok(f"rtconf {SAMPLE} get int_param0") == "100\n"


@pytest.mark.parametrize("slave", ["", "&manager_name=s1"])
def test_create_strings_and_sets_that_do_not_fit_make_nothing(manager: Any, slave: str) -> None:
    for options, why in (
        ("conf.default.int_param0=101", "conf.default: int_param0 cannot be '101': it is to be"),
        ("conf.fast.double_param0=x", "conf.fast: double_param0 cannot be 'x': it is no number"),
    ):
        status, out, err = manager.run(f"rtmgr -c 'ConfigSample?{options}{slave}' {MANAGER}")
        assert (status, out) == (1, "")
        assert f"(ConfigSample0: {why}" in err
    assert manager.ok("rtls /localhost") == "manager.mgr/\n"
    manager.ok(f"rtmgr -c 'ConfigSample?conf.fast.str_param0=two{slave}' {MANAGER}")
    manager.ok(f"rtconf -a -s __constraints__ {SAMPLE} set str_param0 '(one,three)'")
    assert manager.run(f"rtconf -s fast {SAMPLE} act") == (
        1,
        "",
        "rtconf: configuration set fast cannot be activated:"
        " str_param0 cannot be 'two': it is to be (one,three)\n",
    )
    assert manager.ok(f"rtconf {SAMPLE} list") == "+default*\n+fast \n"
    manager.ok(f"rtconf -s fast {SAMPLE} set str_param0 three")
    manager.ok(f"rtconf -s fast {SAMPLE} act")


LIMITED = """
from rtkit.component import Component, Parameter


class Limited(Component):
    vendor, category, version = "me", "x", "1.0"
    gain = Parameter(1.0)


def LimitedInit(manager):
    manager.register_factory(Limited)
"""


def test_the_profile_beside_a_module_binds_who_has_it(manager: Any) -> None:
    (manager.folder / "Limited.py").write_text(LIMITED)
    manager.ok(f"rtmgr -l {manager.folder}/Limited.py:LimitedInit -c Limited {MANAGER}")
    path = "/localhost/Limited0.rtc"
    manager.ok(f"rtconf {path} set gain 99")
    profile = Path(__file__).parents[2] / "profiles" / "ConfigSample.xml"
    text = profile.read_text().replace("rtkit:example:ConfigSample", "me:x:Limited")
    for old, new in (("ConfigSample", "Limited"), ('"rtkit"', '"me"'), ('"example"', '"x"')):
        text = text.replace(old, new)
    (manager.folder / "RTC.xml").write_text(text.replace('"double_param0"', '"gain"'))
    why = "rtconf: gain cannot be '99': it is to be -10<=x<=10\n"
    assert manager.run(f"rtconf {path} set gain 99") == (1, "", why)
    manager.ok(f"rtconf {path} set gain 9")


def test_whoever_sets_it_the_component_refuses_what_does_not_fit(
    manager: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    manager.ok(f"rtmgr -c ConfigSample?manager_name=s1 {MANAGER}")
    for key, value in manager.environment.items():
        if key.startswith("RTKIT_"):
            monkeypatch.setenv(key, value)
    bad = {"int_param0": "5", "double_param0": "10.5"}
    with connect("") as tree:
        (result,) = tree.apply([SetParameters("ConfigSample0", "default", bad)])
    with pytest.raises(Malformed, match=r"double_param0 cannot be '10\.5': it is to be -10<=x<=10"):
        result.raise_for_error()
    assert manager.ok(f"rtconf {SAMPLE} get int_param0") == "0\n"


def test_an_rtc_conf_that_does_not_fit_is_told_at_the_start(shell: Any) -> None:
    (shell.folder / "rtc.conf").write_text(
        "manager.components.precreate: ConfigSample, ConsoleOut\n"
        "example.ConfigSample.config_file: sample.conf\n"
    )
    (shell.folder / "sample.conf").write_text("conf.default.int_param0: -1\n")
    status, _, err = shell.run("rtmgr start")
    assert status == 1
    assert err.splitlines()[0] == (
        "rtmgr: manager.components.precreate: ConfigSample (ConfigSample0: conf.default:"
        " int_param0 cannot be '-1': it is to be 0<=x<=100)"
    )
    assert shell.ok("rtls /localhost").split() == ["ConsoleOut0.rtc", "manager.mgr/"]


def test_a_system_that_does_not_fit_is_not_brought_up_in_silence(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConfigSample {MANAGER}")
    manager.ok("rtcryo --all -o good.xml")
    text = (manager.folder / "good.xml").read_text()
    old = 'rts:name="int_param0" rts:data="0"'
    assert old in text
    (manager.folder / "bad.xml").write_text(text.replace(old, old.replace('"0"', '"300"')))
    err = manager.run("rtresurrect bad.xml").err
    assert "Action failed: " in err
    assert "int_param0 cannot be '300': it is to be 0<=x<=100" in err
    assert manager.ok(f"rtconf {SAMPLE} get int_param0") == "0\n"


@pytest.mark.parametrize("place", ["", "?manager_name=s1"])
def test_sets_go_from_one_component_to_another(manager: Any, place: str) -> None:
    manager.ok(f"rtmgr -c ConfigSample -c ConfigSample{place} {MANAGER}")
    other = "/localhost/ConfigSample1.rtc"
    manager.ok(f"rtact {other}")
    manager.ok(f"rtconf {SAMPLE} set str_param0=three double_param0=-1.5")
    manager.ok(f"rtconf -a {SAMPLE} export saved.json")
    assert manager.run(f"rtconf {other} diff saved.json") == (
        1,
        "-default.double_param0  0.11\n+default.double_param0  -1.5\n"
        "-default.str_param0  one\n+default.str_param0  three\n",
        "",
    )
    manager.ok(f"rtconf -a --wait {other} import saved.json")
    assert manager.ok(f"rtconf {other} diff saved.json") == ""
    assert manager.ok(f"rtconf {other} get str_param0") == "three\n"


def test_a_stand_in_has_the_hints_of_its_profile(manager: Any) -> None:
    profile = Path(__file__).parents[2] / "profiles" / "ConfigSample.xml"
    manager.ok(f"rtmgr -c {profile} corbaloc::localhost")
    why = "rtconf: int_param0 cannot be '101': it is to be 0<=x<=100\n"
    assert manager.run(f"rtconf {SAMPLE} set int_param0 101") == (1, "", why)
    manager.ok(f"rtconf {SAMPLE} set int_param0 99")


@pytest.mark.parametrize(
    "address",
    [
        "corbaloc::localhost",
        "corbaloc::localhost/manager",
        "corbaloc::localhost:2810",
        "corbaloc::localhost:2810/manager",
        "corbaloc:iiop:127.0.0.1:2810/manager",
    ],
)
def test_a_direct_address_needs_no_name(manager: Any, address: str) -> None:
    manager.ok(f"rtdel {MANAGER}")
    assert manager.ok(f"rtmgr -c ConsoleOut --print {address}") == "/localhost/ConsoleOut0.rtc\n"
    manager.ok(f"rtmgr -d ConsoleOut0 {address}")
    status, out, err = manager.run(f"rtmgr -d ConsoleOut0 {address}")
    assert (status, out) == (1, "")
    assert err.startswith("rtmgr: Failed to delete component: ConsoleOut0 (")


def test_a_direct_address_of_a_slave_and_of_other_managers(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleOut?manager_address=localhost:2899 {MANAGER}")
    manager.ok("rtmgr -c ConsoleOut corbaloc::localhost:2899")
    assert manager.ok(f"rtls {MANAGER}/manager_2899.mgr").split() == [
        "ConsoleOut0.rtc",
        "ConsoleOut1.rtc",
    ]
    manager.ok("rtmgr start two")
    manager.ok("rtmgr -c ConsoleOut corbaloc::localhost/two")
    manager.environment["RTKIT_MANAGER"] = "two"
    assert manager.ok("rtls /localhost").split() == ["ConsoleOut0.rtc", "manager.mgr/", "two.mgr/"]
    status, _, err = manager.run("rtmgr -c ConsoleOut corbaloc::localhost/three")
    assert status == 1
    assert err.startswith("rtmgr: no manager named three answers at localhost:2810: corbaloc:")


def test_a_listing_is_watched(manager: Any) -> None:
    with manager.open("rtls --json --watch=0.05 /localhost") as process:
        try:
            assert json.loads(process.stdout.readline())["path"] == MANAGER
            manager.ok(f"rtmgr -c ConsoleOut {MANAGER}")
            assert json.loads(process.stdout.readline())["path"] == "/localhost/ConsoleOut0.rtc"
        finally:
            process.kill()
