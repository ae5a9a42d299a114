"""Generates a sample system profile: one of each component, connected as their types fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtkit.builder.regions import XML_STAMP
from rtkit.builder.subject import GeneratedComponent
from rtkit.component.configuration.kinds import kind_of
from rtkit.component.contexts.owned_contexts import kind_named
from rtkit.component.fsm import EVENT_NAME
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import (
    RTS_VERSION,
    ComponentInstance,
    ConfigurationData,
    ConfigurationSet,
    DataPortConnector,
    InstancePort,
    Location,
    OwnedContext,
    RtsProfile,
    ServicePortConnector,
    TargetPort,
)
from rtkit.profile.write import write_rts
from rtkit.rtc.create import CreateString
from rtkit.rtc.data_types import ANY
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.profiles import TypeProfile

CREATE, MODULE = "rtkit.create", "rtkit.module"
"""Properties by which rtkit knows how to make a component."""

_EPOCH = "1970-01-01T00:00:00"
_DEFAULT_RATE = 1000.0


def sample_system(subjects: Sequence[GeneratedComponent]) -> str:
    """Return a system profile of these components, one of each, not yet stamped.

    An in port is connected with the out port of its type on the nearest component before it, where
    each of the two has only one port that fits.
    """
    names = " and ".join(each.type_name for each in subjects)
    kind = "component type" if len(subjects) == 1 else "component types"
    text = f"A sample of {kind} {names}"
    return system_of([(each, "") for each in subjects], text, tuple(_fitting(subjects)))


def _fitting(subjects: Sequence[GeneratedComponent]) -> Iterator[DataPortConnector]:
    sources: dict[str, list[TargetPort]] = {}
    for subject in subjects:
        for type_name, (end, *others) in _ends(subject, "InPort").items():
            found = sources.get(type_name, ())
            if len(found) == 1 and not others:
                both = f"{found[0].port_name}-{end.port_name}"
                yield data_connector(both, both, type_name, found[0], end)
        sources |= _ends(subject, "OutPort")


def _ends(subject: GeneratedComponent, kind: str) -> dict[str, list[TargetPort]]:
    """Return the ports of a kind by their data types."""
    found: dict[str, list[TargetPort]] = {}
    for port in subject.ports:
        if port.kind == kind and port.type_name != ANY:
            found.setdefault(port.type_name, []).append(end_of(subject, port.name))
    return found


def data_connector(
    id: str, name: str, type_name: str, source: TargetPort, target: TargetPort, event: str = ""
) -> DataPortConnector:
    """Return a connector of data ports; `event` names what it brings to a state machine."""
    properties = (ExtensionProperty(EVENT_NAME, event),) if event else ()
    ways = ("corba_cdr", "push", source, target, "flush")
    return DataPortConnector(id, name, type_name, *ways, properties=properties)


def end_of(subject: GeneratedComponent, port: str) -> TargetPort:
    """Return a port of a component as connectors name it."""
    info, instance = subject.info, f"{subject.type_name}0"
    type = TypeProfile(subject.type_name, info.vendor, info.category, info.version)
    return TargetPort(type.id, instance, f"{instance}.{port}")


def system_of(
    subjects: Sequence[tuple[GeneratedComponent, str]],
    abstract: str,
    data: tuple[DataPortConnector, ...] = (),
    services: tuple[ServicePortConnector, ...] = (),
) -> str:
    """Return a system profile of components and their connectors, not yet stamped.

    Args:
        subjects: Each component, and the folder of its module, which ends in a slash.
        abstract: Description of the system.
        data: Connectors of data ports.
        services: Connectors of service ports.
    """
    first, _ = subjects[0]
    info = first.info
    profile = RtsProfile(
        id=f"RTSystem:{info.vendor}:{first.type_name}:{info.version or '1.0'}",
        version=RTS_VERSION,
        creation_date=info.creation_date or _EPOCH,
        update_date=info.update_date or info.creation_date or _EPOCH,
        abstract=abstract,
        components=tuple(
            _component(subject, folder, place) for place, (subject, folder) in enumerate(subjects)
        ),
        data_port_connectors=data,
        service_port_connectors=services,
    )
    head, _, body = write_rts(profile).decode().partition("\n")
    return f"{head}\n{XML_STAMP}\n{body}"


def _options(subject: GeneratedComponent) -> dict[str, str]:
    return {"instance_name": f"{subject.type_name}0", "manager_name": subject.module}


def _component(subject: GeneratedComponent, folder: str, place: int) -> ComponentInstance:
    info, instance = subject.info, f"{subject.type_name}0"
    id = TypeProfile(subject.type_name, info.vendor, info.category, info.version).id
    data = [port.name for port in subject.ports]
    if subject.machine:
        data.append(subject.machine.port)
    kind = kind_named(subject.execution_type)
    is_periodic = kind is ExecutionKind.PERIODIC
    rate = (subject.rate or _DEFAULT_RATE) if is_periodic else None
    values = tuple(
        ConfigurationData(each.name, kind_of(each.default).write(each.default))
        for each in subject.settings
    )
    return ComponentInstance(
        id=id,
        path_uri=f"localhost/{instance}.rtc",
        instance_name=instance,
        active_configuration_set="default" if values else None,
        composite_type="None",
        visible=True,
        data_ports=tuple(InstancePort(f"{instance}.{name}", visible=True) for name in data),
        service_ports=tuple(
            InstancePort(f"{instance}.{each.name}", visible=True) for each in subject.services
        ),
        configuration_sets=(ConfigurationSet("default", values),) if values else (),
        execution_contexts=(OwnedContext("0", kind.value, rate),),
        location=Location(100 + 300 * place, 100, 50, 100, "RIGHT"),
        properties=(
            ExtensionProperty(
                CREATE, str(CreateString(subject.type_name, options=_options(subject)))
            ),
            ExtensionProperty(MODULE, f"{folder}{subject.module}.py:{subject.init}"),
        ),
    )
