"""Old components: Python 2 is named when it is loaded, and runs once it is migrated."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from openrtm_corpus import COMPONENTS, needs_components, sources
from waiting import until

from rtkit.openrtm.migrate.files import migrate, plan_migration
from rtkit.openrtm.migrate.to_python3 import converted

KEEPS_MANAGER = True
OLD = """#!/usr/bin/env python
# -*- coding: euc-jp -*-
import sys
import OpenRTM_aist
import RTC
from beside import ask

old_spec = ["implementation_id", "Old",
            "type_name", "Old",
            "description", "\u53e4\u3044",
            "version", "1.0",
            "vendor", "sample",
            "category", "example",
            "language", "Python",
            "lang_type", "script",
            ""]


class Old(OpenRTM_aist.DataFlowComponentBase):
\tdef __init__(self, manager):
\t\tOpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
\t\targ = [None] * ((len(RTC._d_TimedPose2D) - 4) / 2)
\t\tself._pose = RTC.TimedPose2D(*arg)

        def onExecute(self, ec_id):
\t\tanswer = long(ask())
\t\tcount = 3
\t\tprint "a third is", answer / count, 7 / count
\t\treturn RTC.RTC_OK


def OldInit(manager):
    profile = OpenRTM_aist.Properties(defaults_str=old_spec)
    manager.registerFactory(profile, Old, OpenRTM_aist.Delete)
"""


MAKE = """
import sys
from rtkit.modules.loader import Loader
from rtkit.rtc.create import parse_create
loader = Loader(["."])
module = loader.load(sys.argv[1])
loader.make(parse_create(f"{module.types[0].type_name}?instance_name=A0")).initialize()
"""
LACKS_ITS_SETTINGS = {"MultiTypeConsoleIn.py"}  # a file that was not published with it


def python_2_components() -> list[str]:
    """Return the existing components that are Python 2, by themselves or by what they import."""
    manifest = (COMPONENTS / "MANIFEST.tsv").read_text(encoding="utf-8").splitlines()
    rows = [line.split("\t") for line in manifest]
    old = {str(file.relative_to(COMPONENTS)) for file in sources() if _is_old(file)}
    components = [row[0] for row in rows if row[1] == "component"]
    return [each for each in components if old.intersection(_looked_at(each))]


def _is_old(file: Path) -> bool:
    return converted(file.read_bytes(), str(file)) is not None


def _looked_at(component: str) -> set[str]:
    plan = plan_migration([str(COMPONENTS / component)])
    return {str(Path(each).relative_to(COMPONENTS)) for each in plan.looked_at}


@needs_components
@pytest.mark.timeout(120)  # a process for each, on a busy machine
def test_existing_components_are_migrated_and_made(tmp_path: Path) -> None:
    outcomes = {}
    for component in python_2_components():
        folder = tmp_path / Path(component).parent
        if not folder.exists():
            shutil.copytree(COMPONENTS / Path(component).parent, folder)
        file = tmp_path / component
        migrate(plan_migration([str(file)]))
        assert plan_migration([str(file)]).files == ()
        made = subprocess.run(
            [sys.executable, "-c", MAKE, str(file)],
            cwd=folder, capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
        outcomes[file.name] = made.stderr if made.returncode else ""
    assert len(outcomes) >= 11
    assert {name for name, why in outcomes.items() if why} == LACKS_ITS_SETTINGS, outcomes


def test_python_2_is_named_and_runs_once_it_is_migrated(manager: Any) -> None:
    (manager.modules / "Old.py").write_text(OLD, encoding="euc_jp")
    (manager.modules / "beside.py").write_text("def ask():\n    return raw_input('n: ')\n")
    load = "rtmgr /localhost/manager.mgr -l Old.py:OldInit"
    refused = manager.run(load)
    assert refused.status == 1
    assert "Old.py:28 is Python 2 (print as a statement): rtkit openrtm migrate" in refused.err
    manager.run(f"rtopenrtm migrate {manager.modules}/Old.py")
    assert "raw_input" in (manager.modules / "beside.py.orig").read_text()
    manager.ok(load)
    manager.ok("rtmgr /localhost/manager.mgr -c 'Old?manager_name=s'")
    manager.ok("rtact /localhost/Old0.rtc")
    manager.ok("rtattach --send 6 -t 20 /localhost/Old0.rtc")
    shown = lambda: manager.run("rtattach --show /localhost/Old0.rtc").out  # noqa: E731
    until(lambda: "a third is 2 2" in shown(), "it never answered")


def test_an_error_of_python_2_while_it_is_loaded_names_the_command(manager: Any) -> None:
    (manager.modules / "Conf.py").write_text("import OpenRTM_aist\nimport ConfigParser\n")
    outcome = manager.run("rtmgr /localhost/manager.mgr -l Conf.py:ConfInit")
    assert "module ConfigParser is Python 2, which rtkit openrtm migrate " in outcome.err
