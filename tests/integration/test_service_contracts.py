"""What each standard service promises, over its own endpoints, over TCP, and behind two proxies.

A row of `CONTRACTS` is a service: how it is made, the types of what it must have, what may be SET,
and what is refused with which code. Every row is tried in the same words through each door.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from bots import Bot

import rtkit
from rtkit.proxy.bridge import bridge
from rtkit.services.camera import Camera
from rtkit.services.chassis import Wheels
from rtkit.services.environment import Environment
from rtkit.services.frames import Frames
from rtkit.services.gps import Gps
from rtkit.services.group import Group
from rtkit.services.gui import GuiService
from rtkit.services.images import encode
from rtkit.services.joystick import Joystick, Pointer
from rtkit.services.legged import LeggedRobot
from rtkit.services.microphone import Microphone
from rtkit.services.mobilerobot import DifferentialRobot
from rtkit.services.mounted import Laser
from rtkit.services.resource import Resource
from rtkit.services.sensor import MIDDLE
from rtkit.services.statemachine import StateMachine
from rtkit.services.storage import Storage
from rtkit.services.vision import Vision
from rtkit.services.world import HomeWorld

_BOUND_S = 20.0


class Contract(NamedTuple):
    """Promises of one service.

    Attributes:
        make: Makes the object that is served, with a folder of its own.
        types: Declared type of each mandatory property; ``action`` for one that is called.
        accepted: Values, as texts, that may be SET; a GET then tells the same.
        refused: For a target, perhaps with parameters: a value, None for a GET, and the code.
    """

    make: Callable[[Path], object]
    types: Mapping[str, str]
    accepted: Mapping[str, str] = {}
    refused: Mapping[str, tuple[str | None, str]] = {}


_TURNSTILE = """@prefix sm: <urn:rtkit:statemachine#> . @prefix : <#> .
:turnstile a sm:Machine ; sm:initial :locked ; sm:variable [ sm:name "n" ; sm:value 0 ] .
:locked a sm:State ; sm:transition [ sm:on "coin" ; sm:to :open ] .
:open a sm:State ; sm:transition [ sm:on "push" ; sm:to :locked ] ."""


class _Lamp:
    """Smallest service: what holds for it holds for all."""

    def __init__(self) -> None:
        self.level: float = 0.5

    def blink(self) -> None:
        """Blink."""


_BALL = "<marker><location>(1 2 0)</location><type>ball</type></marker>"


def _world() -> HomeWorld:
    home = HomeWorld()
    home.objects.set("ball", rtkit.Marker((1.0, 2.0, 0.0), type="ball"))
    return home


class _Swarm(Group):
    """Group whose members are served as long as it is."""

    def __init__(self) -> None:
        self._ends = ExitStack()
        for at in (1, 2):
            self._ends.enter_context(rtkit.serve(Bot(2.0 * at), f"robots/r{at}"))
        super().__init__(robots="robots/r1 robots/r2", deadline=5.0)

    def __exit__(self, *why: object) -> None:
        super().__exit__(*why)
        self._ends.close()


def _robot(make: Callable[[], object], joint: str) -> Contract:
    """Return what each mobile robot promises; of its actuators it has one joint at least."""
    none = "(0.0 0.0 0.0 0.0 0.0 0.0)"
    return Contract(
        lambda folder: make(),
        {
            "type": "list<word>",
            "version": "string",
            "status": "string",
            "location": "vector[6]",
            "velocity": "vector[6]",
            "velocity.timeout": "number",
            "motion": "vector[6]",
            "dimensions": "vector[3]",
            "behaviors.moveto": "any",
            "behaviors.stop": "action",
            f"actuators.{joint}": "number",
            "sensors.laser.ranges": "vector",
            "sensors.eye.markers": "list<marker>",
            "sensors.camera.image": "bytes",
            "plug": "action",
            "unplug": "action",
        },
        {"velocity": none, "velocity.timeout": "0.25"},
        {
            "location": ("(0 0 0 0 0 0)", "read-only"),
            "velocity": ("(1 2)", "bad-value"),
            "location?frame=cellar": (None, "bad-parameter"),
            "location?base=1": (None, "bad-parameter"),
            "behaviors.moveto": ("<ball/>", "bad-value"),
            "behaviors.dance": (None, "unknown"),
            "sensors.eye.markers?frame=cellar": (None, "bad-parameter"),
        },
    )


def _sensor(
    make: Callable[[Path], object],
    types: Mapping[str, str],
    refused: Mapping[str, tuple[str | None, str]] = {},
    accepted: Mapping[str, str] = {},
) -> Contract:
    """Return the promises of a sensor, and its own."""
    return Contract(
        make,
        {"type": "list<word>", "version": "string", "status": "string", "unit": "string",
         "location": "vector[6]", "markers": "list<marker>", "rate": "number", "range": "vector"}
        | types,
        {"location": "(1.0 2.0 0.0 0.0 0.0 0.5)", **accepted},
        {"location": ("(1 2)", "bad-value"), "location?frame=none": (None, "bad-parameter"),
         "markers?frame=none": (None, "bad-parameter"),
         "location?fame=base": (None, "bad-parameter"),
         "status": ("ready", "read-only"), **refused},
    )  # fmt: skip


def _laser() -> Laser:
    chassis = Wheels(home := HomeWorld(), "body", (0.0, 0.0, 0.0), (1.0, 1.0))
    chassis.world = home
    return Laser(chassis, Frames(base=lambda: MIDDLE), MIDDLE)


def _vision(folder: Path) -> Vision:
    vision = Vision(active=("blobs",))
    vision.set_image(encode(np.zeros((8, 8, 3), np.uint8), "png"))
    return vision


EVERY = {"name": "string", "type": "list<word>", "status": "string", "version": "string"}
"""What every service has."""
CONTRACTS: dict[str, Contract] = {
    "differential robot": _robot(DifferentialRobot, "left.angle"),
    "legged robot": _robot(LeggedRobot, "left_front.femur"),
    "home world": Contract(
        lambda folder: _world(),
        {"type": "list<word>", "version": "string", "status": "string", "pace": "number",
         "ranges": "vector", "seen": "list<marker>", "image": "bytes", "room": "string",
         "light": "number", "objects.ball": "any"},
        {},
        {"room": ("x", "read-only"), "image?width=0": (None, "bad-parameter"),
         "ranges?count=1000000": (None, "bad-parameter"),
         "ranges?at=(1 2)": (None, "bad-parameter"), "objects.ball": ("red", "bad-value"),
         "bodies.r1": ("<marker/>", "bad-value"), "objects.none": (None, "unknown")},
    ),
    "lamp": Contract(
        lambda folder: _Lamp(),
        {"level": "number", "blink": "action"},
        {"level": "0.25"},
        {"level": ("bright", "bad-value"), "level?of=1": (None, "bad-parameter"),
         "none": (None, "unknown")},
    ),
    "environment": Contract(
        lambda folder: Environment(),
        {"markers": "list<marker>", "maxage": "number", "frame": "string"},
        {"maxage": "30.0"},
        {"observe": ("7", "bad-value"), "observe?frame=moon": (_BALL, "bad-parameter"),
         "markers?near=1": (None, "bad-parameter"), "markers?frame=moon": (None, "bad-parameter"),
         "maxage": ("-1", "bad-value"), "grids.heat": (None, "unknown"),
         "grids.heat.observe": ("(1 2)", "bad-value"), "merge": ("nobody", "no-service")},
    ),
    "resource": Contract(
        lambda folder: Resource(frames=("kitchen 1 2 0 0 0 0",)),
        {"search": "list", "start": "action", "started": "list<string>", "frames.kitchen": "vector",
         "unanswered": "list<list>"},
        {"frames.kitchen": "(1.0 2.5 0.0 0.0 0.0 0.0)", "frames.hall": "(0.0 0.0 0.0 0.0 0.0 1.0)",
         "far.r1": '<service type="robot"><contact protocol="tcp">a:1</contact></service>'},
        {"far.r2": ("<light/>", "bad-value"), "far.r2?lease=-1": ("<service/>", "bad-parameter"),
         "search?near=(1)": (None, "bad-parameter"), "search?where=x": (None, "bad-parameter"),
         "search?color=red": (None, "bad-parameter"),
         "frames.hall": ("(1 2)", "bad-value"), "unanswered": ("()", "read-only")},
    ),
    "state machine": Contract(
        lambda folder: StateMachine(_TURNSTILE, start=True),
        {"type": "list<word>", "version": "string", "status": "string", "machine": "text",
         "machine.locked": "text", "state": "string", "run": "string", "variables.n": "any",
         "log": "list<list>", "source": "string", "graph": "text", "save": "action"},
        {"machine": _TURNSTILE, "variables.n": "7"},
        {"machine": ("rubbish", "bad-value"), "machine.locked?delete": ("", "bad-value"),
         "machine.none": (None, "unknown"), "run": ("step", "conflict"),
         "state": ("x", "read-only"), "variables.m": ("1", "unknown"),
         "machine?form=json": (None, "bad-parameter"),
         "source": ("nobody/files.x", "no-service"), "event": (None, "write-only")},
    ),
    "storage": Contract(
        lambda folder: Storage(str(folder)),
        {"search": "list<word>", "used": "integer", "quota": "integer", "largest": "integer",
         "left_out": "integer"},
        {"image.jpg": "jpeg", "a%20b": "(1 2", "image.jpg?offset=0&size=2": "12"},
        {"none.jpg": (None, "unknown"), "%2E%2E": ("x", "denied"), "status": ("x", "read-only"),
         "none.jpg?delete=1": ("", "unknown"), "image.jpg?offset=7": ("x", "conflict"),
         "image.jpg?size=x": (None, "bad-parameter"), "search?size=1": (None, "bad-parameter")},
    ),
    "gui": Contract(
        lambda folder: GuiService(),
        {"store": "string", "vector.html": "text", "vector.text": "text", "marker.html": "text",
         "mobilerobot.text": "text"},
        {"lamp.html": "<p>a lamp</p>", "vector.text": '<gui kind="vector"/>'},
        {"lamp.text": ("<p/>", "bad-value"), "lamp.exe": ("x", "unknown"),
         "status": ("x", "read-only"), "lamp.svg": (None, "unknown")},
    ),
    "group": Contract(
        lambda folder: _Swarm(),
        {"type": "list<word>", "version": "string", "status": "string", "location": "vector[6]",
         "velocity": "vector[6]", "behaviors.moveto": "any", "behaviors.stop": "action",
         "robots.r1.location": "vector[6]", "groups.all": "list", "join": "action",
         "leave": "action", "failures": "list<list>", "deadline": "number"},
        {"velocity": "(0.5 0.0 0.0 0.0 0.0 0.0)", "deadline": "4.0", "groups.a": "(r2)",
         "groups.a.velocity": "(0.25 0.0 0.0 0.0 0.0 0.0)",
         "robots.r1.velocity": "(0.125 0.0 0.0 0.0 0.0 0.0)"},
        {"location": ("(0 0 0 0 0 0)", "read-only"), "velocity": ("fast", "bad-value"),
         "location?form=some": (None, "bad-parameter"), "location?of=1": (None, "bad-parameter"),
         "groups.b": ("(r3)", "bad-value"), "groups.b.velocity": (None, "unknown"),
         "none": ("1", "unknown"), "deadline": ("0", "bad-value"),
         "behaviors.moveto": ("<marker><location>(2000 0)</location></marker>", "bad-value"),
         "behaviors.moveto?frame=x": ("1", "bad-parameter"),
         "robots.r1.location": ("(0 0 0 0 0 0)", "read-only")},
    ),
    "joystick": _sensor(
        lambda folder: Joystick(str(folder / "none"), base="none"),
        {"data": "list<list>", "device": "string", "dead": "number"},
        {"dead": ("2", "bad-value"), "device": ("x", "read-only")},
    ),
    "pointer": _sensor(
        lambda folder: Pointer(str(folder / "none")),
        {"data": "list<vector[2]>", "wheel": "integer"}, {"wheel": ("2", "read-only")},
    ),
    "gps": _sensor(
        lambda folder: Gps(str(folder / "none"), base="none"),
        {"data": "string", "position": "vector", "fix": "string", "satellites": "integer",
         "hdop": "number", "velocity": "vector[2]", "refused": "integer"},
        {"position": ("(1 2 3)", "read-only")},
    ),
    "laser": _sensor(
        lambda folder: _laser(),
        {"data": "vector", "ranges": "vector", "bearings": "vector"},
        {"ranges": ("(1 2)", "read-only")},
    ),
    "camera": _sensor(
        lambda folder: Camera(look=lambda: np.zeros((8, 8, 3), np.uint8)),
        {"data": "bytes", "image": "bytes", "field": "number"},
        {"image?format=gif": (None, "bad-parameter"), "image?width=-1": (None, "bad-parameter"),
         "image": ("x", "read-only")},
    ),
    "microphone": _sensor(
        lambda folder: Microphone(str(folder / "none")),
        {"data": "bytes", "format": "string", "channels": "integer", "level": "number"},
        {"rate": ("8000", "read-only")},
    ),
    "vision": _sensor(
        _vision,
        {"image": "bytes", "image.source": "string", "methods.edges.active": "boolean",
         "methods.edges.forms": "list<string>", "methods.blobs.runs": "integer",
         "cameras.camera.source": "string", "cameras.camera.location": "vector[6]"},
        {"image": ("rubbish", "bad-value"), "image?format=gif": (None, "bad-parameter"),
         "methods.edges.result": (None, "conflict"), "methods.none.active": ("true", "unknown"),
         "methods.blobs.result?form=segments": (None, "bad-parameter"),
         "methods.edges.least": ("-1", "bad-value"), "cameras.rear.image": (None, "unknown"),
         "camera": ("rear", "bad-value"),
         "methods.fiducials.dictionary": ("9x9", "bad-value")},
        {"methods.blobs.active": "false", "methods.edges.least": "15.0",
         "cameras.camera.field": "0.9", "methods.fiducials.dictionary": '"5x5_100"'},
    ),
}  # fmt: skip
DOORS = ("unix", "zenoh", "tcp", "chain")


@pytest.fixture
def client() -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        yield client


def _opened(door: str, made: object, ends: ExitStack) -> str:
    """Serve an object; return how its names begin through a door."""
    tcp = {"port": 0} if door == "tcp" else {}
    served = ends.enter_context(
        rtkit.serve(made, "house/it", is_on_zenoh=door == "zenoh", **tcp)  # type: ignore[arg-type]
    )
    if door == "chain":
        first = ends.enter_context(bridge("/localhost/house/it", "tcp:0", allow_set=["*"]))
        ends.enter_context(bridge(f"{first.address}/house/it", "zenoh:far", allow_set=["*"]))
    return {
        "unix": "house/it.",
        "zenoh": "zenoh:house/it.",
        "tcp": f"tcp:localhost:{served.port}/house/it/",
        "chain": "zenoh:far.",
    }[door]


def _code(work: Callable[[], Any]) -> str:
    with pytest.raises(rtkit.PropertyError) as caught:
        work()
    return caught.value.code


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("service", CONTRACTS)
def test_a_service_keeps_its_promises_through_each_door(
    service: str, door: str, place: str, tmp_path: Path, client: rtkit.Client, ends: ExitStack
) -> None:
    contract = CONTRACTS[service]
    at = _opened(door, contract.make(tmp_path), ends)
    for name, kind in {**EVERY, **contract.types}.items():
        meta = client.get(f"{at}{name}.meta")
        declared = {each.name: str(each.leaf) for each in meta.children}
        assert (name, _kind(declared)) == (name, kind)
        value = client.get(f"{at}{name}")
        assert value or name not in EVERY, f"{name} tells nothing"
    for name, text in contract.accepted.items():
        client.set(f"{at}{name}", text)
        assert client.get_bytes(f"{at}{name.partition('?')[0]}") == text.encode()
    for target, (value, code) in contract.refused.items():
        if value is None:
            assert (target, _code(lambda t=target: client.get(at + t))) == (target, code)
        else:
            work = lambda t=target, v=value: client.set(at + t, v)  # noqa: E731
            assert (target, _code(work)) == (target, code)


def _kind(declared: Mapping[str, str]) -> str:
    return "action" if declared.get("functional") == "True" else declared["type"]
