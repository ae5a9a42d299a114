"""A fault in each duty of the manager's loop: the daemon lives, and leaves a dump that replays.

The duties are taken from the code: one that is new is tried too, or fails here.
"""

from __future__ import annotations

import ast
import json
import os
import re
import signal
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest
from faultkit import PATIENCE_S, Order, Site
from notifykit import ServiceManager

from rtkit.deployment.actions import Create, Delete
from rtkit.errors import RtkitError
from rtkit.manager import loop
from rtkit.manager.store import writer

MANAGER = "/localhost/manager.mgr"
HELD = Create(
    "ConsoleIn?instance_name=Held&manager_name=held&rtkit.limit.memory=2G"
    "&rtkit.health.overrun=9:log&rtkit.place.device=null"
)
SOURCES = [Path(module.__file__).read_text(encoding="utf-8") for module in (loop, writer)]
POINTS = sorted({name for text in SOURCES for name in re.findall(r'point\("duty\.(\w+)"', text)})
DUTIES = sorted(set(re.findall(r'\bDuty\(\s*"(\w+)"', SOURCES[0])))


def test_all_that_the_loop_does_is_guarded() -> None:
    """Every call in its turn is one of the guard, or chooses what that is to call."""
    (run,) = (
        node
        for node in ast.walk(ast.parse(SOURCES[0]))
        if isinstance(node, ast.FunctionDef) and node.name == "run"
    )
    calls = {ast.unparse(node.func) for node in ast.walk(run) if isinstance(node, ast.Call)}
    assert calls == {"self._guard.run"}
    assert DUTIES
    assert POINTS


def slave_pid(site: Site) -> int:
    with site.tree() as tree:
        return next(p.pid for p in tree.snapshot().processes if p.name == "held")


def zygote_pid(site: Site) -> int:
    """Return the parent of the slave, which forked it."""
    status = Path(f"/proc/{slave_pid(site)}/status").read_text(encoding="utf-8")
    return int(re.findall(r"PPid:\t(\d+)", status)[0])


def kill_slave(site: Site) -> None:
    os.kill(slave_pid(site), signal.SIGKILL)


def kill_zygote(site: Site) -> None:
    os.kill(zygote_pid(site), signal.SIGKILL)


def look_at_port(site: Site) -> None:
    """Ask for a sample, of which the slave does not answer in time."""
    with site.tree() as tree:
        tree.port_samples([("Held", "out")])


def look_at_terminal(site: Site) -> None:
    """Ask a terminal that shows nothing for news, until the time is up."""
    with site.tree() as tree:
        tree.ask_terminal({"instance": "Held", "after": 0, "wait_s": 0.1})


FAULT = Order("duty.aftermath", 1, "raise", "EIO")
CAUSES: dict[str, Callable[[Site], object]] = {
    "samples": look_at_port,
    "sweeping": kill_slave,
    "terminals": look_at_terminal,
    "zygote": kill_zygote,
}
"""What has the manager pass a point, where work does not."""
NEEDS = {"samples": [Order("holder.asked", 1, "delay", "1")]}
"""What happens in other processes, so that it has that effect."""


@pytest.mark.timeout(300)
def test_a_fault_in_each_duty_leaves_the_daemon_alive_and_a_dump(shell: Any) -> None:
    site = Site(shell)
    with closing(ServiceManager(shell.folder / "notify", 0.3)) as service_manager:
        shell.environment.update(service_manager.environment)  # else no heart beats
        site.start()
        site.apply(HELD)
        fail_in_each_duty(shell, site)
        shell.ok("rtmgr stop")


def fail_in_each_duty(shell: Any, site: Site) -> None:
    state = shell.folder / "state"
    for name in [*DUTIES, *(point for point in POINTS if point not in DUTIES)]:
        for file in state.glob("*.dump"):
            file.unlink()
        pid = site.manager_pid()
        needs = NEEDS.get(name, [])
        # Some are passed all the time, perhaps before the first order is read.
        faults = (Order(f"duty.{name}", n, "raise", "EIO") for n in range(1, 6))
        site.points.arm(*needs, *faults)
        CAUSES.get(name, tried)(site)
        assert site.points.has_struck(len(needs) + 1), f"not passed: {name}"
        site.points.disarm()
        found = dumps(state, name)
        assert found, f"no dump of {name}"
        status, out, err = shell.run(f"rtmgr replay {found[0]}")
        assert (status, err) == (0, ""), (name, out[-2000:])
        assert "Input/output error" in out
        assert site.manager_pid() == pid, f"{name}: {shell.log()}"
        site.apply(HELD)
        assert not shell.run("rtls -l").err


def tried(site: Site) -> None:
    """Do something that the fault may make fail: then its client is told."""
    with suppress(RtkitError), site.tree() as tree:
        tree.apply([Create("ConsoleIn?instance_name=Other"), Delete("Other")], timeout_s=1.0)


def dumps(state: Path, name: str) -> list[Path]:
    """Return the dumps of a duty, as soon as there are any."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        for file in state.glob("*.dump"):
            why = json.loads(file.read_text(encoding="utf-8").partition("\n")[0])["why"]
            if re.match(rf"fault in {name}\b", why):
                assert file.stat().st_mode & 0o777 == 0o600
                return [file]
        time.sleep(0.02)
    return []


def test_a_dump_that_is_asked_for(shell: Any) -> None:
    """It is a new file, or stdout, that only this user can read; it replays as it was."""
    shell.ok("rtmgr start")
    shell.ok("rtmgr -c 'ConsoleIn?instance_name=A&manager_name=s&x=mqtt://u:geheim@h' " + MANAGER)
    shell.ok(f"rtmgr -s 'port.password=geheim' {MANAGER}")
    assert shell.run("rtmgr dump") == (0, "", "")
    file = shell.folder / "manager.dump"
    assert file.stat().st_mode & 0o777 == 0o600
    assert "geheim" not in file.read_text(encoding="utf-8")
    assert shell.run("rtmgr dump") == (1, "", "rtmgr: manager.dump is there already\n")
    shell.ok("rtmgr dump manager other.dump")
    assert shell.run("rtmgr dump manager -").out.startswith('{"rtkit-dump":1,"manager":"manager"')
    shown = shell.ok("rtmgr replay other.dump")
    assert "Create(create='ConsoleIn?instance_name=A" in shown
    assert shown.endswith("2 processes, 1 component, 0 connectors, as in the manager\n")
    status, _, err = shell.run("rtmgr dump manager no/such/folder")
    assert (status, "cannot write no/such/folder" in err) == (1, True)
    shell.ok("rtmgr stop")
    assert "is not running" in shell.run("rtmgr dump manager late.dump").err
    assert not (shell.folder / "late.dump").exists()


@pytest.mark.parametrize("strike", ["kill", "raise ENOSPC"])
def test_a_dump_that_fails_leaves_nothing_half(shell: Any, strike: str) -> None:
    site = Site(shell)
    site.start()
    site.points.arm(FAULT, Order("dump.written", 1, *strike.split()))
    with suppress(RtkitError):
        site.apply(HELD)
    assert site.points.has_struck(2)
    site.points.disarm()
    site.start()
    assert not list((shell.folder / "state").glob("*.dump"))
    site.points.arm(FAULT)
    site.apply(HELD)
    if strike == "kill":
        assert dumps(shell.folder / "state", "aftermath")
    else:
        assert "the dump cannot be written" in shell.log()
    assert not list((shell.folder / "state").glob("*.new"))


PLANTED = """
from rtkit.manager.core.batches import Batches

take = Batches.take


def failing(self, asked):
    if "Planted" in str(asked.batch.actions):
        self._jobs["left behind"] = {}["planted"]
    take(self, asked)


Batches.take = failing
"""


def test_a_fault_of_the_core_is_told_and_comes_again_in_its_replay(shell: Any) -> None:
    folder = shell.folder / "planted"
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(PLANTED)
    usual = shell.environment["PYTHONPATH"]
    shell.environment["PYTHONPATH"] = f"{folder}{os.pathsep}{usual}"
    shell.ok("rtmgr start")
    shell.ok(f"rtmgr -c 'ConsoleIn?instance_name=A&manager_name=s' {MANAGER}")
    status, _, err = shell.run(f"rtmgr -c 'ConsoleIn?instance_name=Planted' {MANAGER}")
    assert (status, err) == (
        1,
        "rtmgr: fault of the manager (KeyError('planted')); whether it is done is not known\n",
    )
    shell.ok(f"rtmgr -c 'ConsoleIn?instance_name=B&manager_name=s' {MANAGER}")
    (file,) = dumps(shell.folder / "state", "core")
    shown = shell.ok(f"rtmgr replay {file}")
    assert "            FAULT: KeyError: 'planted'\n" in shown
    assert shown.endswith("as in the manager\n")
    shell.environment["PYTHONPATH"] = usual
    status, out, _ = shell.run(f"rtmgr replay {file}")
    assert status == 1
    assert "BatchRequested: raises nothing, raised KeyError: 'planted'" in out
