"""Listeners and state machines of components written for OpenRTM-aist, live."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from openrtm_corpus import COMPONENTS, needs_components
from openrtm_files import EXAMPLES, MOTOR, SENSOR
from waiting import until

PLACE = "/localhost/manager.mgr"
STATIC_FSM = EXAMPLES / "StaticFsm"
COMPOSITE = (
    COMPONENTS / "Nobu19800__SettingRTSystem/Composite/ECandStateSharedCompositePy"
    "/ECandStateSharedComposite.py"
)
BUTTONS = """
from rtkit.component import Component, InPort, OutPort, TimedLong, TimedString

class Buttons(Component):
    press = InPort(TimedString)
    open = OutPort(TimedLong)
    close = OutPort(TimedLong)
    minute = OutPort(TimedLong)
    start = OutPort(TimedLong)

    def on_execute(self, context):
        for each in self.press.read_all():
            name, _, number = each.data.partition(" ")
            self.ports[name].write(TimedLong(data=int(number or 0)))

def ButtonsInit(manager):
    manager.register_factory(Buttons)
"""


def lines(manager: Any, component: str, part: str, count: int) -> list[str]:
    """Return what a component has printed with a text in it, once there are so many lines."""

    def found() -> list[str]:
        logged = manager.ok(f"rtvlog --no-follow -n 1000 -g {part} /localhost/{component}.rtc")
        all_lines = [line.split("> ", 1)[1] for line in logged.splitlines()]
        return all_lines if len(all_lines) >= count else []

    return until(found, f"{count} lines with {part} of {component}")


@needs_components
def test_a_component_hears_of_values_from_another_process(manager: Any) -> None:
    manager.ok(f"rtmgr -l {STATIC_FSM / 'Display.py'}:DisplayInit -c Display {PLACE}")
    manager.ok("rtact /localhost/Display0.rtc")
    manager.ok("rtinject -c 21 /localhost/Display0.rtc:in")
    heard = [line.split()[-1] for line in lines(manager, "Display0", "Listener", 5)]
    assert heard[:3] == ["ON_CONNECT", "ON_RECEIVED", "ON_BUFFER_WRITE"]
    # It reads once a period, before or after who has sent is gone.
    assert sorted(heard[3:]) == ["ON_BUFFER_READ", "ON_DISCONNECT"]
    assert [line.split()[-1] for line in lines(manager, "Display0", "Data", 3)] == ["21"] * 3


@needs_components
def test_a_microwave_cooks_and_remembers_that_when_it_is_opened(
    manager: Any, tmp_path: Path
) -> None:
    (tmp_path / "Buttons.py").write_text(BUTTONS)
    manager.ok(f"rtmgr -l {tmp_path / 'Buttons.py'}:ButtonsInit -c Buttons {PLACE}")
    manager.ok(f"rtmgr -l {STATIC_FSM / 'Microwave.py'}:MicrowaveInit -c Microwave {PLACE}")
    for event in ("open", "close", "minute", "start"):
        manager.ok(f"rtcon /localhost/Buttons0.rtc:{event} /localhost/Microwave0.rtc:event")
    manager.ok("rtact /localhost/Buttons0.rtc /localhost/Microwave0.rtc")
    for press in ("minute 2", "start", "open", "close"):
        manager.ok(f"rtinject -c '{press}' /localhost/Buttons0.rtc:press")
    cooking = lines(manager, "Microwave0", "Heating", 3)
    assert [line.strip() for line in cooking] == ["Heating on", "Heating off", "Heating on"]


@needs_components
def test_a_composite_of_an_author_drives_existing_components(manager: Any) -> None:
    manager.ok(f"rtmgr -l {MOTOR}:MotorInit -c Motor {PLACE}")
    manager.ok(f"rtmgr -l {SENSOR}:SensorInit -c Sensor {PLACE}")
    options = "members=Motor0,Sensor0&exported_ports=Motor0.in,Sensor0.out"
    name = "ECandStateSharedComposite"
    manager.ok(f"rtmgr -l {COMPOSITE}:{name}Init -c '{name}?{options}' {PLACE}")
    manager.ok(f"rtact /localhost/{name}0.rtc")
    assert manager.ok(f"rtls -l {PLACE}").splitlines() == [
        f"Active  2/0  1/0  1/0  0/0  {name}0.rtc",
        "Active  2/0  1/0  1/0  0/0  Motor0.rtc",
        "Active  2/0  1/0  1/0  0/0  Sensor0.rtc",
    ]
    manager.ok(f"rtconf /localhost/{name}0.rtc set members=Sensor0 exported_ports=Sensor0.out")
    assert manager.ok(f"rtls -l {PLACE}").splitlines() == [
        f"Active    1/0  0/0  1/0  0/0  {name}0.rtc",
        "Inactive  2/0  1/0  1/0  0/0  Motor0.rtc",
        "Active    2/0  1/0  1/0  0/0  Sensor0.rtc",
    ]


@needs_components
def test_a_composite_sample_of_openrtm_starts_from_its_own_rtc_conf(shell: Any) -> None:
    there = f"import os; os.chdir({str(EXAMPLES / 'Composite')!r}); "
    assert shell.end_of(shell.open("rtmgr start -f rtc.conf", there)) == (0, "", "")
    assert shell.ok(f"rtls -l {PLACE}").splitlines() == [
        "Inactive  2/0  1/0  1/0  0/0  Controller0.rtc",
        "Inactive  2/0  1/0  1/0  0/0  Motor0.rtc",
        "Inactive  2/0  1/0  1/0  0/0  PeriodicECSharedComposite0.rtc",
        "Inactive  2/0  1/0  1/0  0/0  Sensor0.rtc",
    ]
    shell.ok("rtact /localhost/PeriodicECSharedComposite0.rtc")
    assert shell.ok(f"rtls -l {PLACE}").count("Active") == 4
    shell.ok("rtmgr stop")
