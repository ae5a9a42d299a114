"""Makes fake managers of few words: what they can make, and what they have made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from fake_manager import FakeManager

from rtkit.deployment import actions as act
from rtkit.rtc.enums import PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile

LONG = "IDL:RTC/TimedLong:1.0"
Sets = Mapping[str, Mapping[str, str]]
SETS: Sets = {
    "default": {"gain": "1", "mode": "a"},
    "fast": {"gain": "9", "mode": "b"},
}


def owned_type(kind: str) -> TypeProfile:
    """Return the profile of the type ``RTC:Me:test:KIND:1.0``."""
    return TypeProfile(kind, "Me", "test", "1.0")


def pattern(
    kind: str, port: str, way: PortType, data_type: str = LONG, sets: Sets = SETS
) -> ComponentPattern:
    """Return a type with one port."""
    told = {"port.port_type": way.value, "dataport.data_type": data_type}
    return ComponentPattern(owned_type(kind), (PortProfile(port, way, told),), sets)


def source_and_sink(sink_type: str = LONG, sets: Sets = SETS) -> FakeManager:
    """Return a manager that can make a Source, and a Sink, which takes values of a type."""
    sink = pattern("Sink", "in", PortType.IN, sink_type, sets)
    return FakeManager([pattern("Source", "out", PortType.OUT, sets=sets), sink])


def made(world: FakeManager, *creates: str) -> FakeManager:
    """Have components made, which does not count as performed; return the manager."""
    for create in creates:
        world.perform(act.Create(create)).raise_for_error()
    world.performed.clear()
    return world


def things(names: Iterable[str]) -> FakeManager:
    """Return a manager with components of the type Thing, each in a slave of its own: A in sA."""
    creates = (f"Thing?instance_name={each}&manager_name=s{each}" for each in names)
    return made(FakeManager([ComponentPattern(owned_type("Thing"))]), *creates)
