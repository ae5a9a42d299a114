"""Write the profiles that ship with rtkit from its sample components: RTC and system profiles.

Usage: ``python tools/make_profiles.py [FOLDER]``; a test checks that ``profiles/`` is what this
makes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from rtkit.builder.profile_of import profile_of
from rtkit.component.base import Component
from rtkit.component.contexts.owned_contexts import kind_named
from rtkit.component.describe import describe
from rtkit.component.fsm import EVENT_NAME
from rtkit.deployment import actions as act
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.extension import MODULE
from rtkit.modules.loader import Loader
from rtkit.profile import rts_model as rts
from rtkit.profile.common import Foreign
from rtkit.profile.write import write_rtc, write_rts
from rtkit.profile.xmlnames import clark
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import ConnectorProfile, PortRef

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "support"))
DATE = "2025-01-01T00:00:00"
TYPES = (
    "ConsoleIn",
    "ConsoleOut",
    "SeqIn",
    "SeqOut",
    "ConfigSample",
    "Sensor",
    "Controller",
    "Motor",
    "MyServiceProvider",
    "MyServiceConsumer",
    "Microwave",
    "MicrowaveKeys",
    "Doubler",
)
_OPTIONS = {
    "dataport.interface_type": "corba_cdr",
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "new",
}
System = tuple[str, str, Sequence[str], Iterable[tuple[str, str]]]


def systems() -> Iterator[System]:
    """Yield name, abstract, create strings and connections of each system."""
    yield (
        "sensor-controller-motor",
        "A robot that stops in front of a wall: three components, a process each.",
        (
            "Sensor?manager_name=sensor&instance_name=Sensor0",
            "Controller?manager_name=controller&instance_name=Controller0",
            "Motor?manager_name=motor&instance_name=Motor0",
        ),
        (
            ("Sensor0.distance", "Controller0.distance"),
            ("Controller0.velocity", "Motor0.velocity"),
            ("Motor0.pose", "Sensor0.pose"),
        ),
    )
    yield (
        "console",
        "Numbers written by one component and shown by another.",
        (
            "ConsoleIn?manager_name=source&instance_name=ConsoleIn0",
            "ConsoleOut?manager_name=sink&instance_name=ConsoleOut0",
        ),
        (("ConsoleIn0.out", "ConsoleOut0.in"),),
    )
    yield (
        "my-service",
        "One component that uses a service of another.",
        (
            "MyServiceProvider?manager_name=provider&instance_name=MyServiceProvider0",
            "MyServiceConsumer?manager_name=consumer&instance_name=MyServiceConsumer0",
        ),
        (("MyServiceConsumer0.myservice", "MyServiceProvider0.myservice"),),
    )
    keys = ("open", "close", "minute", "start", "stop", "tick")
    yield (
        "microwave",
        "A state machine and the keys that move it, by events over one port.",
        (
            "MicrowaveKeys?manager_name=keys&instance_name=MicrowaveKeys0",
            "Microwave?manager_name=oven&instance_name=Microwave0",
        ),
        tuple((f"MicrowaveKeys0.{key}", "Microwave0.event") for key in keys),
    )
    basic = ("Boolean", "Char", "Octet", "Short", "Long", "Float", "Double", "String")
    ports = (*basic, *(f"{name}Seq" for name in basic))
    yield (
        "seq",
        "A port of each basic type, and of a sequence of each.",
        (
            "SeqOut?manager_name=source&instance_name=SeqOut0",
            "SeqIn?manager_name=sink&instance_name=SeqIn0",
        ),
        tuple((f"SeqOut0.{name}", f"SeqIn0.{name}") for name in ports),
    )


def write(folder: Path) -> None:
    """Write every profile below `folder`."""
    samples = {name: sample(name) for name in TYPES}
    (folder / "systems").mkdir(parents=True, exist_ok=True)
    for name, component in samples.items():
        profile = profile_of(component, DATE, {MODULE: f"{name}.py:{name}Init"})
        (folder / f"{name}.xml").write_bytes(write_rtc(profile))
    patterns = [pattern(component) for component in samples.values()]
    for system in systems():
        (folder / "systems" / f"{system[0]}.xml").write_bytes(rts_document(system, patterns))
    (folder / "systems" / "two-robots.xml").write_bytes(write_rts(two_robots()))


def two_robots() -> rts.RtsProfile:
    """Return a system that includes another one twice, with values of its own for each."""
    file = "sensor-controller-motor.xml"
    right = {"Sensor0.wall": "8.0", "Controller0.max_speed": "0.25"}
    condition = Foreign(((clark("rtkit:if"), "${right}"),))
    return rts.RtsProfile(
        SystemHeading("", "two-robots", "1.0", "rtkit").id,
        rts.RTS_VERSION,
        DATE,
        DATE,
        "The robot of sensor-controller-motor.xml twice, each in front of a wall of its own.",
        variables=(
            rts.SystemVariable("wall", "5.0", "Where the wall of the left robot is [m]"),
            rts.SystemVariable("right", "true", "Whether there is a right robot"),
        ),
        includes=(
            rts.IncludedSystem(file, "left.", (rts.IncludedValue("Sensor0.wall", "${wall}"),)),
            rts.IncludedSystem(
                file, "right.", tuple(map(rts.IncludedValue, right, right.values())), condition
            ),
        ),
    )


def sample(name: str) -> Component:
    """Return an instance of a sample component that has made the ports it makes itself."""
    loader = Loader([str(ROOT / "examples" / "basic")])
    component = loader.make(parse_create(f"{name}?instance_name={name}0"))
    component.on_initialize()
    return component


def pattern(component: Component) -> ComponentPattern:
    """Return what a component is like, as data."""
    described = describe(component)
    kind = kind_named(component.execution_type)
    rate = component.rate if kind is ExecutionKind.PERIODIC else 0.0
    contexts = (ContextPattern(kind=kind, rate=rate),)
    return ComponentPattern(component.type, described.ports, described.sets, "default", contexts)


def rts_document(system: System, patterns: Iterable[ComponentPattern]) -> bytes:
    """Return the profile of a system of samples, as if it lived and had been saved."""
    name, abstract, creates, wires = system
    from fake_manager import FakeManager

    world = FakeManager(patterns)
    for create in creates:
        world.perform(act.Create(create)).raise_for_error()
    for source, target in wires:
        ends = tuple(PortRef(*end.split(".")) for end in (source, target))
        out = world.components[ends[0].instance].port(ends[0].port)
        assert out is not None
        options = {"dataport.data_type": out.data_type, **_OPTIONS} if out.data_type else {}
        id = f"{source}-{target}"
        if f"{ends[1]}" == "Microwave0.event":
            options[EVENT_NAME] = ends[0].port
        made = ConnectorProfile(id, f"{ends[0].port}_{ends[1].port}", ends, options)
        world.perform(act.Connect(made)).raise_for_error()
    heading = SystemHeading(DATE, name, "1.0", "rtkit", abstract)
    return write_rts(capture(world.snapshot(), heading))


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "profiles")
