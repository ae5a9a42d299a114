"""Managers with their components, as the page gets to know them."""

from __future__ import annotations

from collections.abc import Sequence

from rtkit.api.live_records import KnownManager
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, PortType
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    PortProfile,
    TypeProfile,
)

LONG = {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}


def component(name: str, state: LifeCycleState = LifeCycleState.ACTIVE) -> ComponentFacts:
    return ComponentFacts(
        name,
        TypeProfile("Any"),
        "manager",
        (PortProfile("in", PortType.IN, LONG), PortProfile("out", PortType.OUT, LONG)),
        {"default": {"a": "1"}, "__widget__": {"a": "spin"}, "__constraints__": {"a": "x<2"}},
        "default",
        (ExecutionContextProfile("0", ExecutionKind.PERIODIC, 10.0, name, state=state),),
        (f"host/{name}.rtc",),
    )


def manager(
    *components: ComponentFacts,
    name: str = "manager",
    connectors: Sequence[ConnectorProfile] = (),
    why: str = "",
) -> KnownManager:
    processes = (ProcessFacts(name, False, 7, "up"),)
    facts = Snapshot("host", name, 7, "1", processes, components, tuple(connectors))
    return KnownManager(name, "localhost", name == "manager", facts, why)
