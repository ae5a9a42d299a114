"""The enumerations of the OMG RTC 1.0 specification, with the words that rtkit prints."""

from __future__ import annotations

from enum import StrEnum


class ReturnCode(StrEnum):
    """Outcome of an operation (``RTC::ReturnCode_t``)."""

    OK = "RTC_OK"
    ERROR = "RTC_ERROR"
    BAD_PARAMETER = "BAD_PARAMETER"
    UNSUPPORTED = "UNSUPPORTED"
    OUT_OF_RESOURCES = "OUT_OF_RESOURCES"
    PRECONDITION_NOT_MET = "PRECONDITION_NOT_MET"


class LifeCycleState(StrEnum):
    """State of a component in one execution context (``RTC::LifeCycleState``)."""

    CREATED = "Created"
    INACTIVE = "Inactive"
    ACTIVE = "Active"
    ERROR = "Error"


UNKNOWN_STATE = "Unknown"
"""Merged state of a component that takes part in no execution context."""


class ExecutionKind(StrEnum):
    """Kind of an execution context, by its driver (``RTC::ExecutionKind``)."""

    PERIODIC = "PERIODIC"
    EVENT_DRIVEN = "EVENT_DRIVEN"
    OTHER = "OTHER"


class PortType(StrEnum):
    """Type of a port; the value is the ``port.port_type`` property."""

    IN = "DataInPort"
    OUT = "DataOutPort"
    SERVICE = "CorbaPort"


class Polarity(StrEnum):
    """Polarity of a service interface: offered or needed (``RTC::PortInterfacePolarity``)."""

    PROVIDED = "Provided"
    REQUIRED = "Required"


class Transition(StrEnum):
    """A change of life-cycle state that a client may ask an execution context for."""

    ACTIVATE = "activate"
    DEACTIVATE = "deactivate"
    RESET = "reset"


def merged_state(states: list[LifeCycleState]) -> str:
    """Fold the states over all contexts: Error over Active over Inactive over Created."""
    for state in (
        LifeCycleState.ERROR,
        LifeCycleState.ACTIVE,
        LifeCycleState.INACTIVE,
        LifeCycleState.CREATED,
    ):
        if state in states:
            return state.value
    return UNKNOWN_STATE
