"""A look at states: what is seen."""

from rtkit.deployment import actions as act
from rtkit.deployment.start_schedule import WatchedComponent, look, seen
from rtkit.rtc.enums import LifeCycleState


def test_what_is_seen(world):
    world.perform(act.Create("Sink?instance_name=A&manager_name=s"))

    def now(context="0", instance="A"):
        return seen(world.components.get(instance), context)

    assert now() == "Inactive"
    world.set_state("A", LifeCycleState.ERROR)
    assert now() == "Error"
    world.set_state("A", LifeCycleState.ACTIVE)
    world.update("A", trouble="stopped")
    assert now() == "Active (stopped)"
    assert now("9") == "without execution context 9"
    world.kill("s", "signal 11")
    assert now() == "zombie (signal 11)"
    assert now(instance="B") == "missing"
    assert look([WatchedComponent("B", "0"), WatchedComponent("A", "0")], world.components.get) == (
        "missing",
        "zombie (signal 11)",
    )
