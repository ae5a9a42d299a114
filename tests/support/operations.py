"""Operations to interrupt: the state before each, and its command."""

from __future__ import annotations

import os
import signal

from faultkit import Operation, Site
from waiting import until

from rtkit.cli.system.rtresurrect import main as rtresurrect
from rtkit.cli.system.rtstart import main as rtstart
from rtkit.deployment.actions import Connect, Create
from rtkit.resources import resource
from rtkit.rtc.profiles import ConnectorProfile, PortRef

SYSTEM = resource("profiles", "systems", "sensor-controller-motor.xml")
MANAGER = "rtmgr /localhost/manager.mgr"
WIRE = "rtcon /localhost/Sensor0.rtc:distance /localhost/Controller0.rtc:distance -i wire"
SLAVES = {"Sensor": "sensor", "Controller": "controller", "Motor": "motor"}
TEN = " ".join(f"-c 'Sensor?instance_name=S{n}&manager_name=s{n % 2}'" for n in range(10))


def nothing(site: Site) -> None:
    """Have no manager."""


def manager(site: Site) -> None:
    """Have a manager that holds nothing."""
    site.start()


def robot(site: Site) -> None:
    """Have three components in three slaves."""
    site.start()
    site.apply(
        *(
            Create(f"{kind}?instance_name={kind}0&manager_name={slave}")
            for kind, slave in SLAVES.items()
        )
    )


def wired(site: Site) -> None:
    """Have two of them connected."""
    robot(site)
    ends = (PortRef("Sensor0", "distance"), PortRef("Controller0", "distance"))
    site.apply(Connect(ConnectorProfile("wire", "wire", ends)))


def system(site: Site) -> None:
    """Have the whole system, at rest."""
    site.start()
    site.type(rtresurrect, SYSTEM)


def active(site: Site) -> None:
    """Have the whole system at work."""
    system(site)
    site.type(rtstart, SYSTEM)


def orphaned(site: Site) -> None:
    """Have slaves whose manager was killed; they have noticed, and so have zygotes that tell it."""
    wired(site)
    site.points.disarm()  # it counts anew
    os.kill(site.manager_pid(), signal.SIGKILL)
    zygotes = len(list((site.shell.folder / "run").glob("*.zygote")))

    def have_noticed() -> bool:
        if site.shell.log().count("the manager is gone") < len(SLAVES):
            return False
        return not site.has_points or site.points.passed()["zygote.listening"] >= zygotes

    until(have_noticed, "the end of the manager is noticed")


def saved(site: Site) -> None:
    """Have the system, and a file where it is to be saved."""
    system(site)
    (site.shell.folder / "out.xml").write_text("what was there")


def exported(site: Site) -> None:
    """Have configuration sets in a file."""
    robot(site)
    text = '{"sets": {"default": {"gain": "3.0", "max_speed": "0.25"}}, "active": "default"}'
    (site.shell.folder / "sets.json").write_text(text)


OPERATIONS = {
    "start": Operation("rtmgr start --allow-faults", nothing, again="is running already"),
    "find again": Operation(
        "rtmgr start --allow-faults", orphaned, again="is running already", is_blind=True
    ),
    "load": Operation(f"{MANAGER} -l Sensor.py:SensorInit", manager),
    "create here": Operation(f"{MANAGER} -c Sensor?instance_name=A", manager),
    "create": Operation(f"{MANAGER} -c 'Sensor?instance_name=A&manager_name=a'", manager),
    "batch": Operation(f"{MANAGER} {TEN}", manager, is_gradual=True),
    "connect": Operation(WIRE, robot),
    "disconnect": Operation(
        "rtdis /localhost/Sensor0.rtc:distance", wired, again="Port not connected|No connection"
    ),
    "configure": Operation("rtconf /localhost/Controller0.rtc set gain 2.0", robot),
    "activate": Operation("rtact /localhost/Motor0.rtc", robot),
    "delete": Operation(f"{MANAGER} -d Sensor0", wired, again="no component named Sensor0"),
    "resurrect": Operation(f"rtresurrect {SYSTEM}", manager, is_gradual=True),
    "apply": Operation(f"rtapply --parallel 2 {SYSTEM}", manager, is_gradual=True),
    "start plan": Operation(f"rtstart {SYSTEM}", system, is_gradual=True),
    "stop plan": Operation(f"rtstop {SYSTEM}", active, is_gradual=True),
    "teardown": Operation(f"rtteardown --exit {SYSTEM}", system, is_gradual=True),
    "cryo": Operation("rtcryo -o out.xml", saved, is_gradual=True),
    "import": Operation("rtconf /localhost/Controller0.rtc import sets.json", exported),
    "stop": Operation(
        "rtmgr stop", wired, again="is not running", is_gradual=True, ends_manager=True
    ),
}
