"""Every operation, broken off at every named point that it passes, in whichever process."""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from typing import Any

import pytest
from faultkit import Operation, Order, Site, State, counted, tried

from rtkit.cli.rtresurrect import main as rtresurrect
from rtkit.cli.rtstart import main as rtstart
from rtkit.deployment.actions import Connect, Create
from rtkit.resources import resource
from rtkit.rtc.profiles import ConnectorProfile, PortRef

SYSTEM = resource("profiles", "systems", "sensor-controller-motor.xml")
MANAGER = "rtmgr /localhost/manager.mgr"
WIRE = "rtcon /localhost/Sensor0.rtc:distance /localhost/Controller0.rtc:distance -i wire"
SLAVES = {"Sensor": "sensor", "Controller": "controller", "Motor": "motor"}
TEN = " ".join(f"-c 'Sensor?instance_name=S{n}&manager_name=s{n % 2}'" for n in range(10))

Shells = Callable[[], AbstractContextManager[Any]]


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
    """Have slaves whose manager was killed, and who have noticed."""
    wired(site)
    site.points.disarm()
    os.kill(site.manager_pid(), signal.SIGKILL)
    deadline = time.monotonic() + 10.0
    wanted = Counter({"slave.alone": len(SLAVES), "zygote.listening": 1})
    while not wanted <= site.points.passed():
        assert time.monotonic() < deadline, site.points.passed()
        time.sleep(0.01)


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
    "start plan": Operation(f"rtstart {SYSTEM}", system, is_gradual=True),
    "stop plan": Operation(f"rtstop {SYSTEM}", active, is_gradual=True),
    "teardown": Operation(f"rtteardown --exit {SYSTEM}", system, is_gradual=True),
    "cryo": Operation("rtcryo -o out.xml", saved, is_gradual=True),
    "import": Operation("rtconf /localhost/Controller0.rtc import sets.json", exported),
    "stop": Operation(
        "rtmgr stop", wired, again="is not running", is_gradual=True, ends_manager=True
    ),
}


def try_all(
    shells: Shells, trials: Iterable[tuple[Operation, State, State, Sequence[Order]]]
) -> None:
    """Try things one beside the other, as many as there are processors."""

    def one(trial: tuple[Operation, State, State, Sequence[Order]]) -> None:
        operation, before, after, orders = trial
        with shells() as shell:
            tried(Site(shell), operation, before, after, *orders)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for outcome in [pool.submit(one, trial) for trial in trials]:
            outcome.result()


MANY_STEPS = ("resurrect", "start plan", "stop plan", "teardown", "cryo", "import", "configure")
"""What commands do in several steps, or to files; the others ask the manager once."""

DAEMONS = ("manager", "zygote", "slave", "holder")


def is_usual(name: str, point: str) -> bool:
    """Whether to try a point at each commit: it says something that no other one says."""
    is_daemon = point.partition(".")[0] in DAEMONS
    is_single = name not in MANY_STEPS
    return is_single if is_daemon else not (is_single and point.startswith("command."))


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.timeout(600)
def test_killed_at_points(shells: Shells, name: str) -> None:
    operation = OPERATIONS[name]
    with shells() as shell:
        before, after, passed = counted(Site(shell), operation)
    points = [point for point in passed if is_usual(name, point)]
    assert points
    try_all(shells, [(operation, before, after, [Order(point, 1)]) for point in points])


@pytest.mark.campaign
@pytest.mark.parametrize("action", ["kill", "raise EIO", "raise ENOSPC", "delay 0.5", "stop"])
@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.timeout(3600)
def test_everything_at_every_pass(shells: Shells, name: str, action: str) -> None:
    operation = OPERATIONS[name]
    with shells() as shell:
        before, after, passed = counted(Site(shell), operation)
    orders = [
        Order(point, number, *action.split())
        for point, count in passed.items()
        for number in range(1, count + 1)
    ]
    try_all(shells, [(operation, before, after, [order]) for order in orders])


def test_who_may_be_broken_off(shell: Any) -> None:
    """A manager of root, only when it is told so; nobody whose orders others could write."""
    site = Site(shell)
    site.points.arm(Order("manager.locked", 1))
    if os.geteuid() == 0:
        why = "rtmgr: RTKIT_FAULT is set: a manager of root wants --allow-faults, too\n"
        assert shell.run("rtmgr start") == (1, "", why)
        assert shell.run("rtmgr start -o rtkit.allow_faults:NO") == (1, "", why)
    folder = shell.folder / "points"
    folder.chmod(0o750)
    status, _, err = shell.run("rtmgr start --allow-faults")
    assert (status, "of others, or open to them" in err) == (1, True)
    folder.chmod(0o700)
    assert "ended at once" in shell.run("rtmgr start -o rtkit.allow_faults:YES").err
    shell.ok("rtmgr start --allow-faults")
