"""The orderly end: components in reverse order of their creation, then the slaves."""

from __future__ import annotations

from rtkit.deployment.actions import Result
from rtkit.errors import RtkitError
from rtkit.manager.procedures import Ask, Procedure, end_slaves
from rtkit.manager.state import State

FINALISE_S = 5.0
"""Grace that a component has to finalise [s]; a process that exceeds it is not asked again."""


def stop_everything(state: State) -> Procedure:
    """End all components, then all slaves; never fails, never waits longer than its graces."""
    silent: set[int] = set()
    for instance in reversed(list(state.components)):
        process = state.process_of(instance)
        facts = state.components.get(instance)
        if facts is None or process is None or facts.zombie or process.key in silent:
            continue
        try:
            yield Ask(process, {"op": "delete", "instance": instance}, FINALISE_S)
            state.forget(instance)
        except RtkitError:
            silent.add(process.key)
    yield from end_slaves([p for p in state.processes.values() if p.is_slave and p.is_alive])
    return Result()
