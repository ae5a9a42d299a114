"""Short ways to write system profiles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from fake_manager import FakeManager
from worlds import LONG, pattern, source_and_sink

from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.wanted import wanted
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty

NO_SETS: Mapping[str, Mapping[str, str]] = {}


def properties(table: Mapping[str, str]) -> tuple[ExtensionProperty, ...]:
    return tuple(ExtensionProperty(name, value) for name, value in table.items())


def port(name: str, told: Mapping[str, str] | None = None) -> rts.InstancePort:
    return rts.InstancePort(name, properties=properties(told or {}))


def component(instance: str, **told: Any) -> rts.ComponentInstance:
    """Return a component ``Source0`` of type ``Source`` whose ports are called in… and out…."""
    kind = instance.rstrip("0123456789")
    names = told.get("ports", ("out",) if kind == "Source" else ("in",))
    sets = told.get("sets", NO_SETS)
    contexts = told.get("contexts", (("0", "PERIODIC", 1000.0),))
    return rts.ComponentInstance(
        id=told.get("id", f"RTC:Me:test:{kind}:1.0"),
        path_uri=told.get("uri", f"localhost/{instance}.rtc"),
        instance_name=instance,
        is_required=told.get("required", True),
        active_configuration_set=told.get("active"),
        data_ports=tuple(p if isinstance(p, rts.InstancePort) else port(p) for p in names),
        service_ports=tuple(port(p) for p in told.get("services", ())),
        configuration_sets=tuple(
            rts.ConfigurationSet(
                name, tuple(rts.ConfigurationData(key, value) for key, value in values.items())
            )
            for name, values in sets.items()
        ),
        execution_contexts=tuple(rts.OwnedContext(*each) for each in contexts),
        properties=properties(told.get("properties", {})),
    )


def end(text: str) -> rts.TargetPort:
    instance, name = text.split(".", 1)
    return rts.TargetPort(f"RTC:Me:test:{instance.rstrip('0123456789')}:1.0", instance, name)


def data(id: str, source: str, target: str, **told: Any) -> rts.DataPortConnector:
    return rts.DataPortConnector(
        id,
        told.get("name", id),
        told.get("data_type", LONG),
        told.get("interface_type", "corba_cdr"),
        "push",
        end(source),
        end(target),
        told.get("subscription", "new"),
        told.get("interval"),
        properties=properties(told.get("properties", {})),
    )


def service(id: str, source: str, target: str, told: Any = None) -> rts.ServicePortConnector:
    return rts.ServicePortConnector(
        id, id, end(source), end(target), properties=properties(told or {})
    )


def profile(*items: Any) -> rts.RtsProfile:
    def of(kind: type) -> tuple[Any, ...]:
        return tuple(item for item in items if isinstance(item, kind))

    return rts.RtsProfile(
        "RTSystem:Me:Test:1.0",
        "0.2",
        "2025-01-01T00:00:00",
        "2025-01-01T00:00:00",
        components=of(rts.ComponentInstance),
        data_port_connectors=of(rts.DataPortConnector),
        service_port_connectors=of(rts.ServicePortConnector),
    )


def entry(instance: str, sequence: int = 1, **told: Any) -> rts.OrderStep:
    """Return one entry of an order: at most one of `wait` [ms] and `after` (instances)."""
    after = told.get("after", "").split()
    preceding = rts.Preceding(
        tuple(_target(*each.split("/")) for each in after), told.get("timeout"), told.get("timing")
    )
    return rts.OrderStep(
        sequence,
        _target(instance, told.get("context", "0")),
        None if after else rts.WaitTime(told.get("wait", 0)),
        preceding if after else None,
    )


def _target(instance: str, context: str = "0") -> rts.TargetComponent:
    return rts.TargetComponent(f"RTC:Me:test:{instance[:-1]}:1.0", instance, context)


def ordered(
    rts_profile: rts.RtsProfile, *entries: rts.OrderStep, stop: bool = False
) -> rts.RtsProfile:
    """Return a profile with these entries as its Activation, or its Deactivation."""
    order = rts.Order(entries)
    if stop:
        return replace(rts_profile, deactivation=order)
    return replace(rts_profile, activation=order)


def sinks(count: int, optional: str = "") -> rts.RtsProfile:
    """Return components Sink0, Sink1 …; those named in `optional` are not required."""
    names = [f"Sink{number}" for number in range(count)]
    return profile(*(component(name, required=name not in optional.split()) for name in names))


def pair(**told: Any) -> rts.RtsProfile:
    """Return a source connected to a sink, both made in slaves of their own."""
    parts = [
        component(
            instance,
            sets={"default": {"gain": "2", "mode": "a"}, "fast": {"gain": "9"}},
            active="fast",
            properties={"rtkit.create": f"{instance[:-1]}?manager_name=slave{instance}"},
            required=told.get("required", True),
        )
        for instance in ("Source0", "Sink0")
    ]
    return profile(*parts, data("wire", "Source0.out", "Sink0.in"))


def live(rts_profile: rts.RtsProfile, world: FakeManager, **how: Any) -> tuple[Any, LiveIndex]:
    system = wanted(rts_profile, world.host, **how)
    return system, LiveIndex(world.snapshot(), system)


@pytest.fixture
def make() -> SimpleNamespace:
    """Return the functions above."""
    functions: tuple[Callable[..., Any], ...] = (
        port,
        component,
        data,
        service,
        profile,
        pair,
        live,
        source_and_sink,
        pattern,
        entry,
        ordered,
        sinks,
    )
    return SimpleNamespace(**{function.__name__: function for function in functions})


@pytest.fixture
def world() -> FakeManager:
    return source_and_sink()
