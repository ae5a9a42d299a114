"""Components written for OpenRTM-aist-Python, as they lie, driven by commands."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from openrtm_corpus import needs_components
from openrtm_files import MOTOR, SENSOR

PLACE = "/localhost/manager.mgr"
WITNESS = """
import json, sys
from rtkit.component import Component
from pathlib import Path

class Witness(Component):
    def on_initialize(self):
        found = [name for name in ("OpenRTM" "_aist", "RTC", "rtkit.openrtm.ahead")
                 if name in sys.modules]
        Path(__file__).with_name(self.instance).write_text(json.dumps(found))

def WitnessInit(manager):
    manager.register_factory(Witness)
"""
"""Native component, since it names no module of OpenRTM-aist, that tells what its process has."""


@needs_components
def test_two_of_them_are_loaded_connected_saved_and_restored(manager: Any) -> None:
    manager.ok(f"rtmgr -l {MOTOR}:MotorInit -c Motor {PLACE}")
    manager.ok(f"rtmgr -l {SENSOR}:SensorInit -c Sensor {PLACE}")
    assert manager.ok("rtls -l /localhost/manager.mgr").splitlines() == [
        "Inactive  2/0  1/0  1/0  0/0  Motor0.rtc",
        "Inactive  2/0  1/0  1/0  0/0  Sensor0.rtc",
    ]
    manager.ok("rtcon /localhost/Sensor0.rtc:out /localhost/Motor0.rtc:in")
    manager.ok("rtconf /localhost/Motor0.rtc set motor_id 4")
    manager.ok("rtcryo -o system.rtsys")
    manager.ok("rtexit /localhost/Sensor0.rtc")
    manager.ok("rtresurrect system.rtsys")
    manager.ok("rtact /localhost/Motor0.rtc /localhost/Sensor0.rtc")
    printing = manager.open("rtprint -v -f data -n 1 /localhost/Motor0.rtc:out")
    assert "is connected" in printing.stderr.readline()
    assert manager.run("rtinject -c 21 /localhost/Sensor0.rtc:in") == (0, "", "")
    assert printing.communicate(timeout=30)[0] == "84\n"
    assert "motor_id  4" in manager.ok("rtconf -l /localhost/Motor0.rtc list")


@needs_components
def test_slaves_share_its_imports_and_no_name_of_it(manager: Any, tmp_path: Path) -> None:
    module = tmp_path / "Witness.py"
    module.write_text(WITNESS)
    manager.ok(f"rtmgr -l {module}:WitnessInit {PLACE}")

    def known(slave: str) -> list[str]:
        create = f"Witness?instance_name={slave}&manager_name={slave}"
        manager.ok(f"rtmgr -c '{create}' {PLACE}")
        found: list[str] = json.loads((tmp_path / slave).read_text())
        return found

    assert known("before") == []
    manager.ok(f"rtmgr -l {MOTOR}:MotorInit {PLACE}")
    assert known("after") == ["rtkit.openrtm.ahead"]
