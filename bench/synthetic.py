"""Generates synthetic systems, to see how reading scales: components in rings, all parts filled."""

from __future__ import annotations

from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty

_TYPES = 50
_DATE = "2025-01-01T00:00:00"
_DATA_TYPE = "IDL:RTC/TimedLong:1.0"


def system(components: int, connectors: int) -> rts.RtsProfile:
    """Return a system of so many parts, as an editor would save it."""
    parts = tuple(_component(number) for number in range(components))
    wires = tuple(
        _connector(number, parts[number % components], parts[(number * 7 + 1) % components])
        for number in range(connectors)
    )
    return rts.RtsProfile(
        "RTSystem:rtkit:Synthetic:1.0",
        rts.RTS_VERSION,
        _DATE,
        _DATE,
        components=parts,
        data_port_connectors=wires,
    )


def _component(number: int) -> rts.ComponentInstance:
    kind = f"Type{number % _TYPES}"
    name = f"{kind}_{number}"
    ends = [("in0", "DataInPort"), ("in1", "DataInPort")]
    ends += [("out0", "DataOutPort"), ("out1", "DataOutPort")]
    return rts.ComponentInstance(
        f"RTC:rtkit:synthetic:{kind}:1.0",
        f"localhost/{name}.rtc",
        name,
        active_configuration_set="default",
        composite_type="None",
        visible=True,
        data_ports=tuple(_port(f"{name}.{port}", direction) for port, direction in ends),
        service_ports=(rts.InstancePort(f"{name}.service", True),),
        configuration_sets=(
            rts.ConfigurationSet(
                "default",
                (rts.ConfigurationData("gain", "1.0"), rts.ConfigurationData("offset", "0")),
            ),
        ),
        execution_contexts=(rts.OwnedContext("0", "PERIODIC", 1000.0),),
        location=rts.Location(number % 40 * 120, number // 40 * 120, -1, -1, "RIGHT"),
        properties=(ExtensionProperty("implementation_id", kind),),
    )


def _port(name: str, direction: str) -> rts.InstancePort:
    properties = (
        ExtensionProperty("port.port_type", direction),
        ExtensionProperty("dataport.data_type", _DATA_TYPE),
    )
    return rts.InstancePort(name, True, None, properties)


def _connector(
    number: int, source: rts.ComponentInstance, target: rts.ComponentInstance
) -> rts.DataPortConnector:
    port = number % 2
    return rts.DataPortConnector(
        f"{number:08x}",
        f"{source.instance_name}.out{port}_{target.instance_name}.in{port}",
        _DATA_TYPE,
        "corba_cdr",
        "push",
        _end(source, f"out{port}"),
        _end(target, f"in{port}"),
        "flush",
        visible=True,
        properties=(ExtensionProperty("dataport.serializer.cdr.endian", "little,big"),),
    )


def _end(component: rts.ComponentInstance, port: str) -> rts.TargetPort:
    return rts.TargetPort(
        component.id,
        component.instance_name,
        f"{component.instance_name}.{port}",
        (ExtensionProperty("COMPONENT_PATH_ID", component.path_uri),),
    )
