"""Component patterns: types described by data, from which stand-ins are generated.

A stand-in is an ordinary component that has no code of its own (`rtkit.component.standin`).
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.profiles import PortProfile, TypeProfile


@dataclass(frozen=True, slots=True)
class ContextPattern:
    """An execution context that a component is to own; rate [Hz]."""

    id: str = "0"
    kind: ExecutionKind = ExecutionKind.PERIODIC
    rate: float = 1000.0
    properties: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ComponentPattern:
    """A component type described by data instead of code, from which a stand-in is generated.

    Attributes:
        script: Values that each out port transmits one after another while active, as JSON text.
    """

    type: TypeProfile
    ports: tuple[PortProfile, ...] = ()
    sets: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    active_set: str = ""
    contexts: tuple[ContextPattern, ...] = ()
    script: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
