"""Every real system profile: wanted, planned, brought up in a fake world, checked, saved alike."""

from __future__ import annotations

import os.path
from collections.abc import Mapping

import pytest
from corpus import CORPUS, corpus, needs_corpus
from fake_manager import FakeManager
from stated import Stated, stated

from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.deviations import deviations
from rtkit.deployment.layered_plan import merged
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.wanted import wanted
from rtkit.deployment.wiring import wiring_plan
from rtkit.profile.parameters import GivenValue
from rtkit.profile.parameters.resolve import SourceProfile, resolve
from rtkit.profile.read import read_rts
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_rts
from rtkit.rtc.enums import LifeCycleState

FOLDER = CORPUS / "rts"
FILES = [file.name for file in corpus("rts/*")]
HEADING = SystemHeading("2025-01-01T00:00:00")


def read(name: str) -> RtsProfile:
    with open(os.path.join(FOLDER, name), "rb") as stream:
        return read_rts(stream.read(), name).profile


def bring_up(world: FakeManager, profile: RtsProfile, **how: bool) -> None:
    system = wanted(profile, world.host, **how)
    for plan_for in (creation_plan, wiring_plan):
        plan = plan_for(system, LiveIndex(world.snapshot(), system))
        for action, _ in merged(plan.steps):
            assert world.perform(action).ok, action
        assert not [step.blocked for step in plan.steps if step.blocked]


def without_silence(first: Stated, second: Stated) -> Mapping[str, Mapping[str, str]]:
    """Return the data types that the second one adds where the first states none."""
    return {
        instance: {
            port: data_type
            for port, data_type in component.data_ports.items()
            if not first.components[instance].data_ports[port]
        }
        for instance, component in second.components.items()
    }


@needs_corpus
def test_the_corpus_is_there():
    assert len(FILES) >= 22


@needs_corpus
@pytest.mark.parametrize("name", FILES or ["none"])
def test_from_file_to_world_and_back(name):
    profile = read(name)
    world = FakeManager()
    bring_up(world, profile, stand_in=True)
    system = wanted(profile, world.host)
    for plan_for, state in ((start_plan, "ACTIVE"), (stop_plan, "INACTIVE")):
        plan = plan_for(system, LiveIndex(world.snapshot(), system))
        assert not any(check.failure for check in plan.checks)
        for action, _ in merged(plan.steps):
            assert world.perform(action).ok, action
        live = LiveIndex(world.snapshot(), system)
        assert list(deviations(system, live, LifeCycleState[state])) == []
    saved = capture(world.snapshot(), HEADING, takes_all=True)
    first, second = stated(profile), stated(saved)
    added = without_silence(first, second)
    for instance, component in second.components.items():
        ports = {**component.data_ports, **dict.fromkeys(added[instance], "")}
        assert component._replace(data_ports=ports) == first.components[instance]
    assert first.components.keys() == second.components.keys()
    assert first.connectors == second.connectors
    assert list(creation_plan(system, LiveIndex(world.snapshot(), system)).steps) == []
    plan = teardown_plan(system, LiveIndex(world.snapshot(), system), ends_components=True)
    for action, _ in merged(plan.steps):
        assert world.perform(action).ok, action
    assert world.snapshot() == FakeManager().snapshot()


@needs_corpus
@pytest.mark.parametrize("name", FILES or ["none"])
def test_what_was_saved_resurrects_by_itself(name):
    world, again = FakeManager(), FakeManager()
    bring_up(world, read(name), stand_in=True)
    saved = capture(world.snapshot(), HEADING, takes_all=True)
    reading = read_rts(write_rts(saved), name, strict=True)
    assert reading.profile == saved
    assert reading.notes == ()
    bring_up(again, reading.profile)
    assert capture(again.snapshot(), HEADING, takes_all=True) == saved


@needs_corpus
@pytest.mark.parametrize("name", FILES or ["none"])
def test_a_system_lives_twice_with_values_of_its_own(name):
    """Two prefixes in one manager: each is as wanted, saved as it was, and taken down alone."""
    world, plain = FakeManager(), read(name)
    ones = [each.instance_name for each in plain.components[:1]]  # one profile is empty
    profiles = {
        prefix: resolve(
            SourceProfile(name, name, plain),
            [GivenValue(f"{one}.added", prefix, "") for one in ones],
            prefix,
        ).profile
        for prefix in ("a.", "b.")
    }
    for profile in profiles.values():
        bring_up(world, profile, stand_in=True)
    saved = stated(capture(world.snapshot(), HEADING, takes_all=True))
    for prefix, profile in profiles.items():
        system = wanted(profile, world.host, stand_in=True)
        assert (
            list(deviations(system, LiveIndex(world.snapshot(), system), LifeCycleState.INACTIVE))
            == []
        )
        first = stated(profile)
        assert first.connectors.items() <= saved.connectors.items()
        sets = {each: saved.components[each].parameters for each in first.components}
        assert sets == {each: told.parameters for each, told in first.components.items()}
        for one in ones:
            assert prefix in str(sets[prefix + one])
    for profile in profiles.values():
        system = wanted(profile, world.host, stand_in=True)
        plan = teardown_plan(system, LiveIndex(world.snapshot(), system), ends_components=True)
        for action, _ in merged(plan.steps):
            assert world.perform(action).ok, action
        left = {each.instance_name for each in profiles["b."].components}
        gone = profile is profiles["b."]
        assert {c.instance for c in world.snapshot().components} == (set() if gone else left)
    assert world.snapshot() == FakeManager().snapshot()
