"""Notes which devices components require: those whose end ends them."""

from __future__ import annotations

from functools import lru_cache

from rtkit.deployment.extension import PLACE_DEVICE
from rtkit.deployment.placement.requirements import DevicePolicy, read_requirements
from rtkit.manager.core.state import ManagerState
from rtkit.rtc.create import readable_create


@lru_cache(maxsize=256)
def devices_of(create: str) -> tuple[str, ...]:
    """Return the devices whose end ends a component that is made so."""
    if PLACE_DEVICE not in create:
        return ()
    required = read_requirements(readable_create(create).options)
    return required.devices if required.device_policy is DevicePolicy.END else ()


def note_devices(state: ManagerState, instance: str, create: str) -> None:
    """Note which devices a component requires, as it is made now."""
    devices = devices_of(create)
    if devices != state.bound.get(instance, ()):
        others = {name: each for name, each in state.bound.items() if name != instance}
        state.bound = {**others, instance: devices} if devices else others


def note_made(state: ManagerState, instance: str, create: str) -> None:
    """Note the same of one that was made: a device that it needs may have come since the last look.

    It is looked at again before the component is judged by it.
    """
    note_devices(state, instance, create)
    if not state.absent.isdisjoint(state.bound.get(instance, ())):
        state.unjudged.add(instance)
        state.bound = dict(state.bound)
