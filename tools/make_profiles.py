"""Write the profiles that ship with rtkit from its sample components: RTC and system profiles.

Usage: ``python tools/make_profiles.py [FOLDER]``; a test checks that ``profiles/`` is what this
makes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from rtkit.component.base import Component
from rtkit.component.callbacks import Callbacks
from rtkit.component.contexts import kind_named
from rtkit.component.describe import describe
from rtkit.component.fsm import EVENT_NAME, FsmComponent
from rtkit.component.kinds import kind_of
from rtkit.component.typenames import scoped_name
from rtkit.deployment import actions as act
from rtkit.deployment.capture import Heading, capture
from rtkit.deployment.extension import MODULE
from rtkit.deployment.world import World
from rtkit.manager.modules.loader import Loader
from rtkit.profile import rtc_model as rtc
from rtkit.profile.common import Property
from rtkit.profile.constraint_text import parse_constraint
from rtkit.profile.write import write_rtc, write_rts
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ExecutionKind, PortType
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef

ROOT = Path(__file__).resolve().parent.parent
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
_ACTIVITIES = {
    ExecutionKind.PERIODIC: "PERIODIC",
    ExecutionKind.EVENT_DRIVEN: "EVENTDRIVEN",
    ExecutionKind.OTHER: "SPORADIC",
}
_CALLBACKS = (
    "on_initialize",
    "on_finalize",
    "on_startup",
    "on_shutdown",
    "on_activated",
    "on_deactivated",
    "on_aborting",
    "on_error",
    "on_reset",
    "on_execute",
    "on_state_update",
    "on_rate_changed",
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
        (folder / f"{name}.xml").write_bytes(write_rtc(rtc_profile(component)))
    patterns = [pattern(component) for component in samples.values()]
    for system in systems():
        (folder / "systems" / f"{system[0]}.xml").write_bytes(rts_document(system, patterns))


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
    world = World(patterns)
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
    heading = Heading(DATE, name, "1.0", "rtkit", abstract)
    return write_rts(capture(world.snapshot(), heading))


def rtc_profile(component: Component) -> rtc.RtcProfile:
    """Return the RTC profile of a component."""
    described = describe(component)
    is_periodic = kind_named(component.execution_type) is ExecutionKind.PERIODIC
    rate = component.rate if is_periodic else None
    events = component.event_port if isinstance(component, FsmComponent) else ""
    kind = component.type
    info = rtc.BasicInfo(
        name=kind.type_name,
        component_type="STATIC",
        activity_type=_ACTIVITIES[kind_named(component.execution_type)],
        component_kind="DataFlowComponent",
        category=kind.category,
        vendor=kind.vendor,
        version=kind.version,
        execution_type=component.execution_type,
        execution_rate=rate,
        max_instances=0,
        creation_date=DATE,
        update_date=DATE,
        description=kind.description,
        properties=(Property(MODULE, f"{kind.type_name}.py:{kind.type_name}Init"),),
    )
    configurations = tuple(_configurations(type(component)))
    return rtc.RtcProfile(
        id=kind.id,
        version="0.3",
        basic_info=info,
        actions=_actions(type(component)),
        configuration_set=rtc.ConfigurationSet(configurations) if configurations else None,
        data_ports=tuple(
            _event_port(component, port) if port.name == events else _data_port(port)
            for port in described.ports
            if port.port_type is not PortType.SERVICE
        ),
        service_ports=tuple(
            _service_port(port) for port in described.ports if port.port_type is PortType.SERVICE
        ),
        language=rtc.Language("Python"),
    )


def _data_port(port: PortProfile) -> rtc.DataPort:
    return rtc.DataPort(
        port_type=port.port_type.value,
        name=port.name,
        type=scoped_name(port.data_type),
        position="LEFT" if port.port_type is PortType.IN else "RIGHT",
        comment=port.properties.get("description"),
    )


def _event_port(component: Component, port: PortProfile) -> rtc.DataPort:
    described = describe(component)
    moves = [
        (state, event, target)
        for state, table in described.fsm_states.items()
        for event, target in table.items()
    ]
    return rtc.DataPort(
        port_type="EventPort",
        name=port.name,
        type="Any",
        position="LEFT",
        events=tuple(
            rtc.Event(event, state, target, type=described.fsm_events.get(event))
            for state, event, target in moves
        ),
    )


def _service_port(port: PortProfile) -> rtc.ServicePort:
    return rtc.ServicePort(
        name=port.name,
        position="RIGHT",
        comment=port.properties.get("description"),
        service_interfaces=tuple(
            rtc.ServiceInterface(
                name=each.instance_name,
                direction=each.polarity.value,
                type=each.type_name,
                instance_name=each.instance_name,
            )
            for each in port.interfaces
        ),
    )


def _actions(cls: type[Component]) -> rtc.Actions:
    told: dict[str, Any] = {
        name: rtc.ActionStatus(getattr(cls, name) is not getattr(Callbacks, name))
        for name in _CALLBACKS
    }
    if issubclass(cls, FsmComponent):
        told["on_action"] = rtc.ActionStatus(cls.on_action is not FsmComponent.on_action)
    return rtc.Actions(**told)


def _configurations(cls: type[Component]) -> Iterator[rtc.Configuration]:
    for parameter in cls._parameters.values():
        kind = kind_of(parameter.default)
        properties = (Property("__widget__", parameter.widget),) if parameter.widget else ()
        yield rtc.Configuration(
            name=parameter.name,
            type=kind.name,
            default_value=kind.write(parameter.default),
            constraint=parse_constraint(parameter.constraint),
            unit=parameter.unit or None,
            comment=parameter.doc or None,
            properties=properties,
        )


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "profiles")
