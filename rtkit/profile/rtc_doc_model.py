"""The documentation elements (``rtcDoc:Doc``) of RTC profiles, one class per place."""

from __future__ import annotations

from rtkit.fast_dataclass import dataclass
from rtkit.profile.common import NO_FOREIGN, Foreign


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
