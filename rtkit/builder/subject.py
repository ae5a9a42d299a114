"""Model of a component to generate: its RTC profile with names and values of Python."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from rtkit.builder.methods import GeneratedMethod
from rtkit.profile.rtc_model import (
    ActionStatus,
    BasicInfo,
    DataPortDeclaration,
    RtcProfile,
    ServicePortDeclaration,
)


class Callback(NamedTuple):
    """A callback to generate."""

    name: str
    status: ActionStatus


class GeneratedPort(NamedTuple):
    """A data port.

    Attributes:
        attribute: Name of its attribute in the class.
        kind: ``InPort``, ``OutPort`` or ``EventPort``.
        type: Expression of its data type.
        type_name: Name of that type in connectors, ``IDL:Robot/State:1.0`` or ``any``.
    """

    attribute: str
    name: str
    kind: str
    type: str
    type_name: str
    profile: DataPortDeclaration


class GeneratedInterface(NamedTuple):
    """An interface of a service port.

    Attributes:
        protocol: Expression of its protocol class; empty where its definition is not known.
        methods: Its methods, in case it is provided.
        servant: Class that implements it; empty where the component itself does.
    """

    name: str
    type_name: str
    is_provided: bool
    protocol: str = ""
    methods: tuple[GeneratedMethod, ...] = ()
    servant: str = ""


class GeneratedServicePort(NamedTuple):
    """A service port."""

    attribute: str
    name: str
    offers: tuple[GeneratedInterface, ...]
    profile: ServicePortDeclaration


class GeneratedParameter(NamedTuple):
    """A configuration parameter."""

    attribute: str
    name: str
    default: bool | int | float | str | tuple[float, ...] | tuple[int, ...]
    unit: str
    doc: str
    constraint: str
    widget: str
    sets: Mapping[str, bool | int | float | str | tuple[float, ...] | tuple[int, ...]]


class GeneratedEvent(NamedTuple):
    """An event of the state machine; `type` is an expression."""

    name: str
    type: str


class StateClass(NamedTuple):
    """The class of a state.

    Attributes:
        name: Name of the class.
        moves: Method, event, and the next state by the table.
    """

    state: str
    name: str
    moves: tuple[tuple[str, str, str], ...]


class GeneratedStateMachine(NamedTuple):
    """A state machine.

    Attributes:
        port: Name of its event port.
        states: State, event, next state.
        conditions: Conditions of transitions by the profile, a line for each.
        classes: A class for each state, outer ones first.
    """

    port: str
    states: dict[str, dict[str, str]]
    events: tuple[GeneratedEvent, ...]
    conditions: tuple[str, ...]
    classes: tuple[StateClass, ...] = ()


@dataclass(frozen=True, slots=True)
class GeneratedComponent:
    """A component type to generate.

    Attributes:
        type_name: As the profile has it.
        module: Name of its file.
        class_name: Name of its class.
        description: One line, if there is one.
        rate: Of a periodic execution context [Hz]; 0 where none is given.
        has_types: Whether a module of interface definitions goes with it.
        notes: Elements that could not be taken over as they are.
        working: Code that does the work of a period in the beginning.
    """

    profile: RtcProfile
    info: BasicInfo
    type_name: str
    module: str
    class_name: str
    description: str
    execution_type: str
    rate: float
    ports: tuple[GeneratedPort, ...]
    services: tuple[GeneratedServicePort, ...]
    settings: tuple[GeneratedParameter, ...]
    callbacks: tuple[Callback, ...]
    machine: GeneratedStateMachine | None
    has_types: bool
    notes: tuple[str, ...]
    working: tuple[str, ...] = ()

    @property
    def types_module(self) -> str:
        """Name of the module generated from its interface definitions."""
        return f"{self.module}_idl"

    @property
    def init(self) -> str:
        """Name of its init function."""
        return f"{self.module}Init"
