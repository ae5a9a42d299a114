"""Models RTC profiles: one component type, as plain data.

The union of versions 0.1, 0.2 and 0.3. Field names are the XML names in snake case; repeated
elements are tuples. An absent optional is None, which is not the same as empty. Dates stay text.
Documentation (``rtcDoc:Doc``) has one class per place.
"""

from __future__ import annotations

from rtkit.fast_dataclass import dataclass
from rtkit.profile.common import NO_FOREIGN, ExtensionProperty, Foreign
from rtkit.profile.constraint_model import Constraint


@dataclass(frozen=True, slots=True)
class BasicDoc:
    """Documentation of the whole component."""

    description: str | None = None
    inout: str | None = None
    algorithm: str | None = None
    creator: str | None = None
    license: str | None = None
    reference: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ActionDoc:
    """Documentation of a callback."""

    description: str | None = None
    pre_condition: str | None = None
    post_condition: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ConfigurationDoc:
    """Documentation of a configuration parameter."""

    dataname: str | None = None
    default_value: str | None = None
    description: str | None = None
    unit: str | None = None
    range: str | None = None
    constraint: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class DataPortDoc:
    """Documentation of a data port; `occerrence` is spelt as in the documents."""

    description: str | None = None
    type: str | None = None
    number: str | None = None
    semantics: str | None = None
    unit: str | None = None
    occerrence: str | None = None
    operation: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class EventDoc:
    """Documentation of an event."""

    description: str | None = None
    type: str | None = None
    number: str | None = None
    semantics: str | None = None
    unit: str | None = None
    operation: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ServicePortDoc:
    """Documentation of a service port."""

    description: str | None = None
    ifdescription: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ServiceInterfaceDoc:
    """Documentation of a service interface."""

    description: str | None = None
    doc_argument: str | None = None
    doc_return: str | None = None
    doc_exception: str | None = None
    doc_pre_condition: str | None = None
    doc_post_condition: str | None = None
    foreign: Foreign = NO_FOREIGN


RTC_VERSION = "0.3"
"""The profile format that rtkit writes for new components."""


@dataclass(frozen=True, slots=True)
class BasicInfo:
    """Identity and kind of the component type.

    Attributes:
        execution_rate: [Hz]; 0 means none given.
        max_instances: 0 means no limit.
    """

    name: str
    component_type: str
    activity_type: str
    component_kind: str
    category: str
    vendor: str
    version: str
    execution_type: str
    creation_date: str
    update_date: str
    rtc_type: str | None = None
    description: str | None = None
    abstract: str | None = None
    hardware_profile: str | None = None
    execution_rate: float | None = None
    max_instances: int | None = None
    comment: str | None = None
    save_project: str | None = None
    doc: BasicDoc | None = None
    version_up_logs: tuple[str, ...] = ()
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ActionStatus:
    """Status of a callback: whether the component implements it."""

    implemented: bool
    doc: ActionDoc | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Actions:
    """The callbacks; None where the profile does not speak of one."""

    on_initialize: ActionStatus | None = None
    on_finalize: ActionStatus | None = None
    on_startup: ActionStatus | None = None
    on_shutdown: ActionStatus | None = None
    on_activated: ActionStatus | None = None
    on_deactivated: ActionStatus | None = None
    on_aborting: ActionStatus | None = None
    on_error: ActionStatus | None = None
    on_reset: ActionStatus | None = None
    on_execute: ActionStatus | None = None
    on_state_update: ActionStatus | None = None
    on_rate_changed: ActionStatus | None = None
    on_action: ActionStatus | None = None
    on_mode_changed: ActionStatus | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ConfigurationParameter:
    """A configuration parameter; `type` is free text."""

    name: str
    type: str
    default_value: str
    unit: str | None = None
    variable_name: str | None = None
    comment: str | None = None
    constraint: Constraint | None = None
    doc: ConfigurationDoc | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class DeclaredParameters:
    """The configuration parameters of the component type."""

    configurations: tuple[ConfigurationParameter, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class SystemParameter:
    """A system parameter (versions 0.1 and 0.2 only)."""

    name: str
    default_value: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class FsmTransition:
    """A transition of a finite state machine that an event port carries."""

    name: str
    source: str
    target: str
    condition: str | None = None
    type: str | None = None
    doc: EventDoc | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class DataPortDeclaration:
    """A data port; `port_type` is DataInPort, DataOutPort or EventPort."""

    port_type: str
    name: str
    type: str
    position: str
    idl_file: str | None = None
    interface_type: str | None = None
    dataflow_type: str | None = None
    subscription_type: str | None = None
    unit: str | None = None
    variable_name: str | None = None
    comment: str | None = None
    constraint: Constraint | None = None
    events: tuple[FsmTransition, ...] = ()
    doc: DataPortDoc | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ServiceInterface:
    """An interface of a service port; `direction` is Provided or Required."""

    name: str
    direction: str
    type: str
    instance_name: str | None = None
    idl_file: str | None = None
    path: str | None = None
    variable_name: str | None = None
    comment: str | None = None
    doc: ServiceInterfaceDoc | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class TransMethod:
    """A way of transport that a service port offers."""

    kind: str
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ServicePortDeclaration:
    """A service port."""

    name: str
    position: str
    comment: str | None = None
    service_interfaces: tuple[ServiceInterface, ...] = ()
    trans_methods: tuple[TransMethod, ...] = ()
    doc: ServicePortDoc | None = None
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Library:
    """A library that a target environment needs."""

    name: str
    version: str | None = None
    other: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class TargetEnvironment:
    """An environment that the component is made for."""

    lang_version: str | None = None
    os: str | None = None
    other: str | None = None
    cpu_other: str | None = None
    os_versions: tuple[str, ...] = ()
    cpus: tuple[str, ...] = ()
    libraries: tuple[Library, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Language:
    """The language that the component is written in."""

    kind: str
    targets: tuple[TargetEnvironment, ...] = ()
    properties: tuple[ExtensionProperty, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class RtcProfile:
    """A component profile; a fragment without `basic_info` and `actions` is accepted."""

    id: str
    version: str
    basic_info: BasicInfo | None = None
    actions: Actions | None = None
    configuration_set: DeclaredParameters | None = None
    parameters: tuple[SystemParameter, ...] = ()
    data_ports: tuple[DataPortDeclaration, ...] = ()
    service_ports: tuple[ServicePortDeclaration, ...] = ()
    language: Language | None = None
    foreign: Foreign = NO_FOREIGN
