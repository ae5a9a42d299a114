"""The RTS profile: a system of components, connectors, groups and orders, as plain data.

Field names are the XML names in snake case; repeated elements are tuples. An absent optional is
None, which is not the same as empty. Dates stay text (``xs:dateTime``).
"""

from __future__ import annotations

from rtkit.fast_dataclass import dataclass
from rtkit.profile.common import NO_FOREIGN, ExtensionProperty, Foreign

RTS_VERSION = "0.2"
"""The profile format that rtkit writes for new systems."""


@dataclass(frozen=True, slots=True)
class ComponentRef:
    """A component named by another part of the profile: participant, group member.

    Attributes:
        around: Further content of ``rts:Participants``, the element around a participant.
    """

    component_id: str
    instance_name: str
    foreign: Foreign = NO_FOREIGN
    around: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class InstancePort:
    """A data port or service port of a component; `name` may carry the prefix ``<instance>.``."""

    name: str
    visible: bool | None = None
    comment: str | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ConfigurationData:
    """One parameter of a configuration set."""

    name: str
    data: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ConfigurationSet:
    """A configuration set; an `id` that begins with ``__`` marks a hidden one."""

    id: str
    data: tuple[ConfigurationData, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class OwnedContext:
    """An execution context that the component owns.

    Attributes:
        kind: ``PERIODIC``, ``EVENT_DRIVEN``, ``OTHER`` or a context type's name.
        rate: [Hz].
    """

    id: str
    kind: str
    rate: float | None = None
    participants: tuple[ComponentRef, ...] = ()
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Location:
    """Position of the component in an editor [pixel]; `direction` is DOWN, RIGHT, UP or LEFT."""

    x: int
    y: int
    height: int
    width: int
    direction: str
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ComponentInstance:
    """A component instance of the system.

    Attributes:
        path_uri: Where it is registered, ``host/…/name.rtc``.
        composite_type: None, PeriodicECShared, PeriodicStateShared, Grouping, FsmECShared or
            FsmStateShared.
        participants: Members of a composite component.
    """

    id: str
    path_uri: str
    instance_name: str
    is_required: bool = True
    active_configuration_set: str | None = None
    composite_type: str | None = None
    visible: bool | None = None
    comment: str | None = None
    data_ports: tuple[InstancePort, ...] = ()
    service_ports: tuple[InstancePort, ...] = ()
    configuration_sets: tuple[ConfigurationSet, ...] = ()
    execution_contexts: tuple[OwnedContext, ...] = ()
    participants: tuple[ComponentRef, ...] = ()
    location: Location | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ComponentGroup:
    """A named group of components."""

    group_id: str
    members: tuple[ComponentRef, ...] = ()
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class TargetPort:
    """One end of a connector."""

    component_id: str
    instance_name: str
    port_name: str
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class DataPortConnector:
    """A connector of data ports, from an out port (`source`) to an in port (`target`).

    Attributes:
        push_interval: [s].
    """

    connector_id: str
    name: str
    data_type: str
    interface_type: str
    dataflow_type: str
    source: TargetPort
    target: TargetPort
    subscription_type: str | None = None
    push_interval: float | None = None
    visible: bool | None = None
    comment: str | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ServicePortConnector:
    """A connector of service ports; which end provides is not given by the order."""

    connector_id: str
    name: str
    source: TargetPort
    target: TargetPort
    trans_method: str | None = None
    visible: bool | None = None
    comment: str | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class TargetComponent:
    """A component in one of its execution contexts (`id`), as orders name it."""

    component_id: str
    instance_name: str
    id: str
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class WaitTime:
    """Precondition: wait `wait_time` [ms] before acting."""

    wait_time: int
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Preceding:
    """Precondition: act only after other components.

    Attributes:
        timeout: [ms]; None means 0.
        sending_timing: SYNC (wait until they reached the state; also what None means), ASYNC or
            NO_SYNC (wait only until they were told).
    """

    preceding_components: tuple[TargetComponent, ...] = ()
    timeout: int | None = None
    sending_timing: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class OrderStep:
    """One step of an order: the target, and exactly one of `wait_time` and `preceding`."""

    sequence: int
    target_component: TargetComponent
    wait_time: WaitTime | None = None
    preceding: Preceding | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Order:
    """In which order components are told to start up, shut down, activate and so on."""

    targets: tuple[OrderStep, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class NestedSystem:
    """A nested system, by the path of its profile."""

    path: str
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class SystemVariable:
    """A variable of a system profile, ``${name}`` in its texts.

    Attributes:
        default: Its value where none is given; None where one must be.
    """

    name: str
    default: str | None = None
    description: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class IncludedValue:
    """A value for an included system: of a variable, or ``INSTANCE.PARAMETER``."""

    name: str
    value: str
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class IncludedSystem:
    """A system profile that is part of this one, all its names behind a prefix.

    Attributes:
        file: Its path from the folder of this profile, or from one of the profile path.
        prefix: Taken literally: ``left.`` or ``left_``; None for names as they are.
    """

    file: str
    prefix: str | None = None
    values: tuple[IncludedValue, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class RtsProfile:
    """A system profile."""

    id: str
    version: str
    creation_date: str
    update_date: str
    abstract: str | None = None
    comment: str | None = None
    components: tuple[ComponentInstance, ...] = ()
    groups: tuple[ComponentGroup, ...] = ()
    data_port_connectors: tuple[DataPortConnector, ...] = ()
    service_port_connectors: tuple[ServicePortConnector, ...] = ()
    start_up: Order | None = None
    shut_down: Order | None = None
    activation: Order | None = None
    deactivation: Order | None = None
    resetting: Order | None = None
    initializing: Order | None = None
    finalizing: Order | None = None
    version_up_logs: tuple[str, ...] = ()
    properties: tuple[ExtensionProperty, ...] = ()
    systems: tuple[NestedSystem, ...] = ()
    variables: tuple[SystemVariable, ...] = ()
    includes: tuple[IncludedSystem, ...] = ()
    foreign: Foreign = NO_FOREIGN
