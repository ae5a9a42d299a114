"""Measures components written for OpenRTM-aist-Python beside native ones that do the same."""

from __future__ import annotations

import os
import tempfile
import timeit
from collections.abc import Callable, Sequence
from typing import Any

from bench import ports
from bench.harness import Lines, Row, create, manager, remove, timed, until_listed
from bench.pairs import Measured, paired
from bench.placement import pin
from rtkit.component.geometry import Pose2D, TimedPose2D
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.types import Time
from rtkit.deployment.actions import Load
from rtkit.modules.loader import Loader
from rtkit.rtc.create import parse_create
from rtkit.rtc.profiles import ConnectorProfile, PortRef

_COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_TRIP = ports.SMALL._replace(module="OrtmPing", ping="OrtmPing", echo="OrtmEcho")
_CALLS = 5_000


def _launch() -> Lines:
    with manager(_COMPONENTS) as tree:
        for module in ("OrtmPing", "Echo"):
            tree.perform(Load(f"{module}.py", f"{module}Init"))

        def launch(kind: str) -> float:
            def call() -> None:
                create(tree, [f"{kind}?instance_name=N0&manager_name=n0"])
                until_listed(tree, 1)

            elapsed_ms = timed(call)
            remove(tree, 1)
            return elapsed_ms

        measured = paired(lambda: launch("OrtmEcho"), lambda: launch("Echo"))
        what = "launch of a component of OpenRTM-aist, own slave"
        yield Row(what, "ms", measured, 1.5, True, "a native component with the same ports")


def _trip() -> Lines:
    what = "round trip of a TimedPose2D between components of OpenRTM-aist"
    yield from ports.on_each_placement(what, _both, "native components, the same values", 1.5)


def _both(processors: Sequence[int]) -> Measured:
    with tempfile.TemporaryDirectory(prefix="rtb") as folder, manager(_COMPONENTS) as tree:
        theirs = ports.ping(tree, _TRIP, os.path.join(folder, "theirs"))
        native = ports.ping(tree, ports.SMALL, os.path.join(folder, "native"), "n")
        theirs(), native()  # all threads are there now
        pids = {process.name: process.pid for process in tree.snapshot().processes}
        for ends in ("p", "e"), ("pn", "en"):
            for end, to in zip(ends, processors, strict=True):
                pin(pids[end], to)
        return paired(theirs, native)


def _hop() -> Lines:
    loader = Loader([_COMPONENTS])
    loader.load("OrtmPing.py")
    component: Any = loader.make(parse_create("OrtmPing?instance_name=P"))
    component.initialize()
    _wire(component.ports["out"], component.ports["back"])
    servant, out, into = component.servant, OutPort(TimedPose2D, "o"), InPort(TimedPose2D, "i")
    _wire(out, into)

    def theirs() -> None:
        servant._outOut.write()  # noqa: SLF001 - as its author calls it
        servant._backIn.read()  # noqa: SLF001

    def native() -> None:
        out.write(TimedPose2D(Time(), Pose2D()))
        into.read()

    measured = paired(lambda: _each_us(theirs), lambda: _each_us(native))
    what = "write and read of a TimedPose2D, components of OpenRTM-aist in one process"
    yield Row(what, "us", measured, 10.0, False, "native ports, the same values")


def _wire(out: OutPort[Any], into: InPort[Any]) -> None:
    wire = ConnectorProfile("c", "c", (PortRef("A", "out"), PortRef("B", "in")), {})
    out.attach("c", into.open(wire))


def _each_us(hop: Callable[[], object]) -> float:
    return timeit.timeit(hop, number=_CALLS) / _CALLS * 1e6


PARTS = {"launch": _launch, "trip": _trip, "hop": _hop}
