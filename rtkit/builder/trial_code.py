"""Generates the test of a component: its ports, its life cycle, a run in a manager."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.builder.regions import CODE_STAMP, region
from rtkit.builder.source_layout import Node, assigned, mapping
from rtkit.builder.source_text import docstring, one_line
from rtkit.builder.subject import GeneratedComponent, GeneratedInterface
from rtkit.component.configuration.kinds import kind_of
from rtkit.rtc.enums import PortType

_HEAD = """
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from rtkit.testing import Trial, own_manager

import MODULE

# isort: split
"""
_FIXTURE = """
@pytest.fixture
def trial() -> Iterator[Trial[Subject]]:
    with Trial(Subject) as trial:
        yield trial


def test_it_has_the_ports_of_its_profile(trial: Trial[Subject]) -> None:
    found = {}
    for name, port in trial.component.ports.items():
        profile = port.profile
        interfaces = [f"{each.type_name} {each.polarity}" for each in profile.interfaces]
        types = [profile.data_type] if profile.data_type else interfaces
        found[name] = (profile.port_type.value, *types)
    assert found == PORTS
"""
_PARAMETERS = """
def test_its_parameters_have_the_defaults_of_its_profile(trial: Trial[Subject]) -> None:
    assert trial.component.configuration.sets["default"] == PARAMETERS
"""
_LIFE_CYCLE = """
def test_it_goes_through_its_life_cycle(trial: Trial[Subject]) -> None:
    trial.activate()
    trial.tick(2)
    assert trial.state == "Active", trial.component.cause
    trial.deactivate()
    assert trial.state == "Inactive"
"""
_VALUES = """
@pytest.mark.parametrize("port", IN_PORTS)
def test_it_takes_a_value(trial: Trial[Subject], port: str) -> None:
    trial.activate()
    trial.send(port)
    trial.tick()
    assert trial.state == "Active", trial.component.cause
"""
_EVENTS = """
@pytest.mark.parametrize("event", Subject.events)
def test_it_takes_an_event(trial: Trial[Subject], event: str) -> None:
    trial.activate()
    trial.send(Subject.event_port, event=event)
    trial.tick()
    assert trial.state == "Active", trial.component.cause
"""
_STATES = """
def test_each_state_has_its_class(trial: Trial[Subject]) -> None:
    assert set(trial.component.state_classes) == set(trial.component.machine.table)
"""
_MANAGER = """
def test_a_manager_runs_it() -> None:
    folder = Path(__file__).parents[1]
    with own_manager(folder) as tree:
        tree.load(str(folder / "MODULE.py"))
        path = tree.create(TYPE_NAME)
        tree.activate(path)
        assert tree.component(path).state == "Active"
        tree.deactivate(path)
        assert tree.component(path).state == "Inactive"
"""


def trial_code(subject: GeneratedComponent) -> str:
    """Return the source of the test, not yet stamped."""
    blocks = [_FIXTURE, _PARAMETERS if subject.settings else "", _LIFE_CYCLE]
    blocks.append(_VALUES if _in_ports(subject) else "")
    blocks.append(_EVENTS if subject.machine and subject.machine.events else "")
    blocks.append(_STATES if subject.machine else "")
    blocks.append(_MANAGER)
    title = f"Tests of component type {one_line(subject.type_name)}"
    found = [*docstring("Tests of a component type.", title), "", CODE_STAMP]
    found += [_HEAD.rstrip().replace("MODULE", subject.module), *region("imports", "")]
    found += ["", *_constants(subject)]
    found += [f"\n{block.rstrip()}".replace("MODULE", subject.module) for block in blocks if block]
    return "\n".join([*found, "", "", *region("tests", ""), ""])


def _constants(subject: GeneratedComponent) -> Iterator[str]:
    yield f"Subject = {subject.module}.{subject.class_name}"
    yield from assigned("TYPE_NAME", subject.type_name, "")
    ports: dict[str, Node] = {}
    for port in subject.ports:
        kind = PortType.OUT if port.kind == "OutPort" else PortType.IN
        ports[port.name] = (kind.value, port.type_name)
    ports |= {each.name: _service(each.offers) for each in subject.services}
    if subject.machine:
        ports[subject.machine.port] = (PortType.IN.value, "any")
    if ports:
        yield from mapping("PORTS", ports, "")
    else:
        yield "PORTS: dict[str, tuple[str, ...]] = {}"
    if _in_ports(subject):
        yield from assigned("IN_PORTS", tuple(_in_ports(subject)), "")
    if subject.settings:
        values = {each.name: kind_of(each.default).write(each.default) for each in subject.settings}
        yield from mapping("PARAMETERS", values, "")


def _in_ports(subject: GeneratedComponent) -> list[str]:
    return [port.name for port in subject.ports if port.kind == "InPort"]


def _service(offers: tuple[GeneratedInterface, ...]) -> Node:
    # Interfaces that are only described come first.
    known = sorted(offers, key=lambda offer: bool(offer.protocol))
    interfaces = [
        f"{each.type_name} {'Provided' if each.is_provided else 'Required'}" for each in known
    ]
    return (PortType.SERVICE.value, *interfaces)
