"""What is told of what is not as it was, after a way back."""

from __future__ import annotations

from fake_manager import FakeManager

from rtkit.deployment.actions import Create
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.planning.model import Model
from rtkit.deployment.planning.model_builder import ModelBuilder, WantedDeployment
from rtkit.deployment.planning.rollback import Rollback
from rtkit.deployment.system import WantedSystem
from rtkit.fast_dataclass import replace
from rtkit.rtc.enums import LifeCycleState

ACTIVE, INACTIVE = LifeCycleState.ACTIVE, LifeCycleState.INACTIVE


def with_states(snapshot: Snapshot, *states: LifeCycleState) -> Snapshot:
    facts = snapshot.component("Source0")
    assert facts is not None
    contexts = tuple(
        replace(facts.contexts[0], id=str(number), state=state)
        for number, state in enumerate(states)
    )
    return replace(snapshot, components=(replace(facts, contexts=contexts),))


def test_contexts_that_are_not_as_they_were_are_told(world: FakeManager) -> None:
    assert world.perform(Create("Source?instance_name=Source0")).ok
    snapshot = world.snapshot()

    def look(now: Snapshot) -> Model:
        nothing = WantedDeployment(WantedSystem())
        live = LiveIndex(now, nothing.system)
        return ModelBuilder(nothing, live, is_back=True).run().model

    before = with_states(snapshot, ACTIVE, INACTIVE)
    way = Rollback(look, before)
    assert list(way.unlike(before)) == []
    told = "Source0 is Active in execution context 1 (was Inactive)"
    assert list(way.unlike(with_states(snapshot, ACTIVE, ACTIVE))) == [told]
    same = Rollback(look, with_states(snapshot, ACTIVE, ACTIVE))
    assert list(same.unlike(with_states(snapshot, ACTIVE, ACTIVE))) == []
