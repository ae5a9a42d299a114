"""Builds the mirror of a component: reverses each port, to try a component without its system."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.builder.sample_system import data_connector, end_of, system_of
from rtkit.builder.subject import GeneratedComponent, GeneratedPort
from rtkit.component.contexts.owned_contexts import PERIODIC
from rtkit.fast_dataclass import replace
from rtkit.profile.rtc_model import Actions, ActionStatus, DataPortDeclaration, RtcProfile
from rtkit.profile.rts_model import DataPortConnector, ServicePortConnector

FOLDER = "mirror"
_RATE_HZ = 10.0
_REVERSED = {
    "DataInPort": "DataOutPort",
    "DataOutPort": "DataInPort",
    "Provided": "Required",
    "Required": "Provided",
}


def mirrored(profile: RtcProfile, subject: GeneratedComponent) -> RtcProfile:
    """Return the profile of the mirror of a component; it has an out port for each event."""
    name, info = f"{subject.type_name}Mirror", subject.info
    ports = [
        replace(each, port_type=_REVERSED[each.port_type], constraint=None, doc=None)
        for each in profile.data_ports
        if each.port_type in _REVERSED
    ]
    machine = subject.machine
    types = {each.name: each.type or "" for port in profile.data_ports for each in port.events}
    for event in machine.events if machine else ():
        ports.append(
            DataPortDeclaration("DataOutPort", event.name, types.get(event.name, ""), "RIGHT")
        )
    services = tuple(
        replace(
            port,
            doc=None,
            service_interfaces=tuple(
                replace(each, direction=_REVERSED.get(each.direction, each.direction))
                for each in port.service_interfaces
            ),
        )
        for port in profile.service_ports
    )
    return RtcProfile(
        id=f"RTC:{info.vendor}:{info.category}:{name}:{info.version}",
        version=profile.version,
        basic_info=replace(
            info,
            name=name,
            description=f"Stand at the other end of each port of {info.name}",
            execution_type=PERIODIC,
            execution_rate=_RATE_HZ,
            doc=None,
        ),
        actions=Actions(on_execute=ActionStatus(True)),
        data_ports=tuple(ports),
        service_ports=services,
        language=profile.language,
    )


def listening(ports: tuple[GeneratedPort, ...]) -> list[str]:
    """Return code that logs what arrives at in ports."""
    lines = []
    for port in ports:
        if port.kind == "InPort":
            lines.append(f"for value in self.{port.attribute}.read_all():")
            lines.append(f'    self.logger.info("{port.attribute}: %s", value)')
    return lines


def mirror_system(subject: GeneratedComponent, mirror: GeneratedComponent) -> str:
    """Return a system profile that connects a component with its mirror, not yet stamped."""
    return system_of(
        [(subject, ""), (mirror, f"{FOLDER}/")],
        f"Component type {subject.type_name} and its mirror",
        tuple(_data_connectors(subject, mirror)),
        tuple(_service_connectors(subject, mirror)),
    )


def _data_connectors(
    subject: GeneratedComponent, mirror: GeneratedComponent
) -> Iterator[DataPortConnector]:
    own = [port for port in subject.ports if port.kind != "EventPort"]
    machine = subject.machine
    ends = [(port.name, port.name, port.type_name, port.kind == "OutPort", "") for port in own]
    events = [each.name for each in machine.events] if machine else []
    outs = mirror.ports[len(own) :]
    for event, port in zip(events, outs, strict=True):
        ends.append((machine.port if machine else "", port.name, port.type_name, False, event))
    for number, (name, other, type_name, is_out, event) in enumerate(ends, 1):
        here, there = end_of(subject, name), end_of(mirror, other)
        source, target = (here, there) if is_out else (there, here)
        text = f"{name}_{other}" if event else name
        yield data_connector(f"mirror-data-{number}", text, type_name, source, target, event)


def _service_connectors(
    subject: GeneratedComponent, mirror: GeneratedComponent
) -> Iterator[ServicePortConnector]:
    pairs = zip(subject.services, mirror.services, strict=True)
    for number, (own, other) in enumerate(pairs, 1):
        if any(offer.protocol for offer in own.offers):
            ends = end_of(subject, own.name), end_of(mirror, other.name)
            yield ServicePortConnector(f"mirror-service-{number}", own.name, *ends)
