"""What keeps components from being made is told without running anything."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from rtkit.errors import Malformed
from rtkit.modules.creatable import lacking
from rtkit.modules.search import Search
from rtkit.rtc.profiles import ModuleProfile, TypeProfile

MODULE = """
raise SystemExit("it was run")
from rtkit.component import Component
class Arm(Component):
    vendor = "me"
def ArmInit(manager):
    manager.register_factory(Arm)
"""
Ask = Callable[..., str]


@pytest.fixture
def ask(tmp_path: Path) -> Ask:
    (tmp_path / "Arm.py").write_text(MODULE)
    (tmp_path / "Bad.py").write_text("def BadInit(manager:\n")
    (tmp_path / "Riddle.py").write_text(
        "def RiddleInit(m):\n    m.register_factory(globals()['x'])\n"
    )
    (tmp_path / "Star.py").write_text("from elsewhere import *\n")
    loaded = [ModuleProfile("/x/Leg.py", "LegInit", (TypeProfile("Leg", "me"),))]

    def ask(module: str, create: str, **how: bool) -> str:
        search = Search([str(tmp_path)], is_absolute_allowed=how.get("is_absolute_allowed", True))
        may = how.get("is_search_allowed", True)
        asked = json.dumps([[module, create]])
        (told,) = json.loads(lacking(asked, loaded, search, is_search_allowed=may))
        return str(told)

    return ask


@pytest.mark.parametrize(
    ("module", "create"),
    [
        ("Arm.py:ArmInit", "Arm?instance_name=A"),
        ("Arm", "RTC:me::Arm::"),
        ("", "Arm"),
        ("", "Leg"),
        ("/x/Leg.py:LegInit", "RTC:me::Leg::"),
        ("", "PeriodicECSharedComposite?members=A"),
        ("Riddle.py:RiddleInit", "Whatever"),  # shows only when it runs
        ("Star.py:AnyInit", "Whatever"),
        ("Arm.py:ArmInit", "Leg"),
    ],
)
def test_what_may_be_made(ask: Ask, module: str, create: str) -> None:
    assert ask(module, create) == ""


@pytest.mark.parametrize(
    ("module", "create", "told"),
    [
        ("Arn.py:ArnInit", "Arn", "no module Arn.py (did you mean Arm?) (looked in .*)"),
        ("../Arm.py", "Arm", "module path leaves the load paths: ../Arm.py"),
        ("Arm.py:LegInit", "Arm", "no init function LegInit in module Arm.py"),
        ("Bad.py:BadInit", "Bad", "module does not import: SyntaxError: .*Bad.py:1"),
        ("Arm.py:ArmInit", "Hand", "component type Hand is not known; module Arm.py offers Arm"),
        ("", "Arn", "component type Arn is not known (looked in .*did you mean Arm"),
        ("", "RTC:you::Arm::", "no.*Arm"),
        ("", "RTC:you::Leg::", "component type Leg is not known so; there is RTC:me::Leg:Python:"),
    ],
)
def test_what_speaks_against_it(ask: Ask, module: str, create: str, told: str) -> None:
    import re

    pattern = re.escape(told).replace(r"\.\*", ".*")
    assert re.search(pattern, ask(module, create))


def test_the_rules_of_the_manager_count(ask: Ask, tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    far = tmp_path.parent / f"{tmp_path.name}-far.py"
    far.write_text(MODULE)
    assert ask(f"{far}:ArmInit", "Arm") == ""
    assert "not allowed" in ask(f"{far}:ArmInit", "Arm", is_absolute_allowed=False)
    assert ask("", "Arm", is_search_allowed=False).startswith("component type Arm is not known")


def test_what_is_no_question_is_refused() -> None:
    for bad in ("", "x", "[1]", '[["a"]]', "{}x"):
        with pytest.raises(Malformed):
            lacking(bad, (), Search([]), is_search_allowed=True)
