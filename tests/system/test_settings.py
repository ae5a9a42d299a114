"""Configuration sets in and out of files, direct addresses and watching, on real processes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

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
