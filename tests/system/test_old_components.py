"""Old components: Python 2 is named when it is loaded, and runs once it is migrated."""

from __future__ import annotations

from typing import Any

from waiting import until

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
