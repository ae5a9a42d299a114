"""Names in the tree: aliases of components and of the manager itself.

See decision 4.
"""

from __future__ import annotations

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.message import Message
from rtkit.errors import NotFound, Refused
from rtkit.manager.core.effects import Procedure, Send
from rtkit.manager.core.registration import check_free
from rtkit.manager.core.state import ManagerState


def unregister(state: ManagerState, action: act.Unregister) -> Procedure:
    """Remove a name; a component lives on without it, a zombie is forgotten with its last one."""
    name = action.name
    facts = next((c for c in state.components.values() if name in c.names), None)
    if facts is None and name not in state.names:
        raise NotFound(f"nothing is registered as /{name}")
    if action.is_zombie and (facts is None or not facts.zombie):
        raise Refused(f"no zombie is registered as /{name}")
    if facts is None:
        state.names = tuple(each for each in state.names if each != name)
        return Result()
    left = tuple(each for each in facts.names if each != name)
    state.update(facts.instance, names=left)
    state.kept.named(facts.instance, left)
    process = state.process_of(facts.instance)
    if facts.zombie and not left and facts.instance not in state.ending:
        state.forget(facts.instance)
        state.kept.forget(facts.instance)
    elif process is not None and process.is_ready:
        yield Send(process, remember(state, facts.instance))
    return Result()


def register(state: ManagerState, action: act.Register) -> Procedure:
    """Give a component a further name, which no other may have.

    Raises:
        NotFound: There is no such component.
        Refused: The name is not free.
    """
    facts = state.components.get(action.instance)
    if facts is None:
        raise NotFound(f"no component named {action.instance}")
    if action.name in facts.names:
        return Result()
    check_free(state, (action.name,), action.instance)
    names = (*facts.names, action.name)
    state.update(action.instance, names=names)
    state.kept.named(action.instance, names)
    process = state.process_of(action.instance)
    if process is not None and process.is_ready:
        yield Send(process, remember(state, action.instance))
    return Result()


def remember(state: ManagerState, instance: str) -> Message:
    """Return the message that has a process remember names and origin of a component."""
    facts = state.components[instance]
    kept = {"names": list(facts.names), "create": facts.create}
    return {"op": "remember", "instance": instance, "kept": kept}
