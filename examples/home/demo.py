"""Runs the home from its system profile, and shows what came of it: ``make demo-home``.

Deploys ``system.yaml``, follows the state machine to its end, compares what the environment model
has with the world, keeps plan and photograph in the folder that is named, else ``build/home``; the
exit status is 0 only when everything was as it must be and nothing is left. With ``--there HOST``
the robot that enters and the lights are on that host, which `rthost` knows: it gets rtkit and the
package of the light, and a manager of its own.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Any

import rtkit
from rtkit.container.orphans import began_at
from rtkit.errors import RtkitError
from rtkit.hosts import inventory
from rtkit.link import places
from rtkit.manager.child_process import ENDS_WITH
from rtkit.packages.building import build
from rtkit.settings import inventory_files

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from home.pictures import Outcome, plan  # noqa: E402

ROBOTS = ("r1", "r2")
MANAGER_THERE = "demo-home"
PATIENCE_S = 50.0
NEAR_M = 0.05
"""How far off the truth the model may be."""


class NotAsExpected(Exception):
    """The demonstration did not go as it must."""


class Watched:
    """Follows a run by live properties.

    Args:
        client: Asks the services.
        there: Host of the robot that enters.

    Attributes:
        states: Of the machine, one after the other.
        paths: Of each robot [m].
        sightings: Where each robot saw the ball [m].
    """

    def __init__(self, client: rtkit.Client, there: str) -> None:
        self.states: list[str] = []
        self.paths: dict[str, list[tuple[float, float]]] = {each: [] for each in ROBOTS}
        self.sightings: dict[str, list[tuple[float, float]]] = {each: [] for each in ROBOTS}
        self.is_over = threading.Event()
        self._client = client
        self._services = {"r1": f"/{there}/robots/r1", "r2": "robots/r2"}
        client.listen("home/butler.state", self._entered, queue=100)
        for robot, service in self._services.items():
            client.listen(f"{service}.location", partial(self._moved, robot), every=0.05)

    def _entered(self, change: rtkit.PropertyChange) -> None:
        if change.code:
            return
        self.states.append(str(change.value))
        print(f"  {change.value}", flush=True)
        if change.value in ("end", "stuck"):
            self.is_over.set()

    def _moved(self, robot: str, change: rtkit.PropertyChange) -> None:
        if not change.code:
            self.paths[robot].append(tuple(change.value[:2]))

    def look(self) -> None:
        """Note where the robots see the ball now."""
        for robot, service in self._services.items():
            for each in self._client.get(f"{service}.sensors.eye.markers", frame="world"):
                if each.type == "ball":
                    self.sightings[robot].append(tuple(each.location[:2]))


def run(values: Mapping[str, str], folder: Path, out: Path) -> None:
    """Deploy, follow, compare, draw, take down."""
    files = folder / "files"
    files.mkdir()
    shutil.copy(HERE / "butler.ttl", files)
    given = {"home": str(HERE / "home.json"), "files": str(files), **values}
    there = given.setdefault("there", "localhost")
    began = time.monotonic()
    with ExitStack() as stack:
        tree = stack.enter_context(rtkit.connect(start=True))
        stack.callback(tree.stop_manager)
        given.setdefault("here", tree.host)
        client = stack.enter_context(rtkit.Client())
        home = rtkit.load(HERE / "system.yaml", values=given)
        tree.apply_profile(home, rollback=True)
        stack.callback(tree.teardown, home, end=True, uninstall=True)
        seconds = time.monotonic() - began
        print(f"deployed in {seconds:.1f} s: {' '.join(tree.ls())}")
        if there != "localhost":
            print(f"on {there}: {' '.join(map(str, client.get(f'/{there}.services')))}")
        watched = Watched(client, there)
        if not watched.is_over.wait(PATIENCE_S) or watched.states[-1] == "stuck":
            rows = client.get("home/butler.log", n=5)
            raise NotAsExpected("\n".join(" ".join(map(str, row)) for row in rows))
        for _ in range(5):
            watched.look()
        outcome = _outcome(client, watched, there)
        pictures = {
            "home.svg": plan(outcome).encode(),
            "butler.svg": client.get_bytes("home/butler.graph"),
            **{name: client.get_bytes(f"home/files.{name}") for name in ("dark.png", "ball.png")},
        }
    _check(watched, outcome, pictures["ball.png"])
    out.mkdir(parents=True, exist_ok=True)
    for name, picture in pictures.items():
        (out / name).write_bytes(picture)
    print(f"{', '.join(pictures)} in {out}; {time.monotonic() - began:.0f} s in all")


def _outcome(client: rtkit.Client, watched: Watched, there: str) -> Outcome:
    truth = client.get("home/world.objects.ball").location
    seen = client.get("home/environment.markers", type="ball")
    if len(seen) != 1:
        raise NotAsExpected(f"one ball is there, the model has {len(seen)}")
    (ball,) = seen
    off = math.dist(ball.location[:2], truth[:2])
    print(f"ball: at {truth[:2]}, in the model at {ball.location[:2]}, {1000 * off:.0f} mm off")
    home = json.loads((HERE / "home.json").read_text("utf-8"))
    walls = [ring for each in home["walls"] for ring in (each["outer"], *each["holes"])]
    lights = {
        name: tuple(
            client.get(f"/{there}/home/lights/{name}.{each}") for each in ("on", "location")
        )
        for name in ("hall", "kitchen")
    }
    return Outcome(home["rooms"], walls, lights, watched.paths, truth, watched.sightings,
                   ball.location, _covariance(ball))  # fmt: skip


def _covariance(marker: rtkit.Marker) -> Any:
    if marker.covariance is not None:
        return marker.covariance
    variance = marker.variance or 0.0
    return ((variance, 0.0), (0.0, variance))


def _check(watched: Watched, outcome: Outcome, photo: bytes) -> None:
    off = math.dist(outcome.fused[:2], outcome.truth[:2])
    promises = {
        f"it ended as it should, not in {watched.states[-1]}": watched.states[-1] == "end",
        "the light of the kitchen is on, that of the hall is off":
            [on for on, _ in outcome.lights.values()] == [False, True],
        "there is a photograph": photo.startswith(b"\x89PNG"),
        "both robots saw the ball": all(watched.sightings.values()),
        f"the model has it within {NEAR_M} m": off <= NEAR_M,
    }  # fmt: skip
    broken = [promise for promise, is_kept in promises.items() if not is_kept]
    if broken:
        raise NotAsExpected("; ".join(broken))


def make_ready(there: str, folder: Path) -> None:
    """Have a host's manager be one of this run alone, and the light a package for it.

    Raises:
        RtkitError: The host is not known.
    """
    host = inventory.host(there)
    table = {"address": str(host), "python": host.python, "manager": MANAGER_THERE,
             "extras": [*host.extras]}  # fmt: skip
    lines = [f"[{there}]", *(f"{key} = {json.dumps(value)}" for key, value in table.items()), ""]
    (folder / places.INVENTORY).write_text("\n".join(lines))
    inventory_files.heed(str(folder))
    build(str(HERE), str(folder / "wheels"))
    os.environ["RTKIT_REPOSITORIES"] = str(folder / "wheels")


def clear(there: str, folder: Path) -> int:
    """End the manager of a host, and remove the folder; return an exit status."""
    status = 0
    if (folder / places.INVENTORY).exists():
        stop = Path(sys.executable).with_name("rtmgr")
        status = subprocess.run([stop, "stop", "--host", there], cwd=folder).returncode
    shutil.rmtree(folder)
    return status


def clear_after(there: str, folder: Path) -> None:
    """Have a process clear when this one was killed, and its manager has ended."""
    this = os.pidfd_open(os.getpid())
    if os.fork():
        os.close(this)
        return
    os.setsid()  # what interrupts this one from the keyboard is not for it
    for number, mode in enumerate((os.O_RDONLY, os.O_WRONLY, os.O_WRONLY)):
        os.dup2(os.open(os.devnull, mode), number)
    select.select([this], [], [])
    manager = places.owner("manager")
    with suppress(ProcessLookupError):  # it has ended meanwhile
        if manager is not None:
            select.select([os.pidfd_open(manager)], [], [])
    if folder.exists():
        clear(there, folder)
    os._exit(0)


def main() -> None:
    """Run it with folders of its own."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("out", nargs="?", default="build/home", type=Path)
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--there", metavar="HOST", help="where a robot and the lights are")
    given = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="home-"))
    this = os.getpid()
    os.environ |= {
        ENDS_WITH: f"{this}:{began_at(this)}",  # the manager ends with this, also if that is killed
        "RTKIT_RUNTIME_DIR": str(folder / "run"), "RTKIT_STATE_DIR": str(folder / "state"),
        "RTKIT_MODULE_PATH": str(HERE.parent), "RTKIT_PORT": "none", "RTKIT_MANAGER": "manager",
    }  # fmt: skip
    for ending in (signal.SIGINT, signal.SIGTERM):  # what was started is taken down, too
        signal.signal(ending, lambda number, _: sys.exit(128 + number))
    clear_after(given.there, folder)
    values = dict(each.split("=", 1) for each in given.set)
    try:
        if given.there:
            make_ready(given.there, folder)
            values["there"] = given.there
        run(values, folder, given.out)
    except (NotAsExpected, RtkitError) as error:
        sys.exit(f"demo-home: {error}")
    finally:
        status = clear(given.there, folder)
    sys.exit(status)


if __name__ == "__main__":
    main()
