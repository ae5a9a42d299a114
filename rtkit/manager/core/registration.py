"""Names of components: chosen, reserved until the component exists, registered in the tree.

Given ones are taken as they are; others come from templates.

See decision 4.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Generator, Iterable, Iterator
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.manager.core.effects import Call, Procedure, Send, WaitUntil
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.state import ManagerState, NameReservation, no_component
from rtkit.rtc.create import CreateString
from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX, check_instance_name
from rtkit.settings import formats
from rtkit.settings.values import PROCESS_UNIQUE


def early_names(state: ManagerState, create: CreateString, instance: str) -> tuple[str, ...]:
    """Return the names of a component that is to be made, as far as they are known.

    Raises:
        Malformed: A template cannot be read.
    """
    templates = [each for each in _templates(state, create) if formats.is_early(each)]
    return formats.expand(templates, instance=instance, host=state.host, manager=state.name)


def late_names(state: ManagerState, create: CreateString, instance: str) -> tuple[str, ...]:
    """Return the further names of a component that was made.

    Raises:
        Refused: One is taken.
        Malformed: One has an empty element.
    """
    templates = [each for each in _templates(state, create) if not formats.is_early(each)]
    names = _expanded(state, templates, instance)
    check_free(state, names, instance)
    return names


def free_names(state: ManagerState, instance: str) -> tuple[str, ...]:
    """Return the names that the templates give a component that came by itself, if nobody has them.

    Raises:
        Malformed: A template cannot be read.
    """
    create = CreateString(state.components[instance].type.type_name)
    names = _expanded(state, _templates(state, create), instance)
    return tuple(name for name in names if state.name_owner(name) in ("", instance))


def _expanded(state: ManagerState, templates: Iterable[str], instance: str) -> tuple[str, ...]:
    process = state.process_of(instance)
    return formats.expand(
        templates,
        instance=instance,
        host=state.host,
        manager=state.name,
        type=state.components[instance].type,
        pid=process.pid if process is not None else 0,
    )


def check_free(state: ManagerState, names: Iterable[str], instance: str) -> None:
    """Refuse names that somebody else has, or that would be in the way of others.

    Raises:
        Refused: Names the first, and who has it.
    """
    for name in names:
        owner = state.name_owner(name)
        if owner and owner != instance:
            raise Refused(f"name /{name} is taken by {owner}")
        for above in _above(name):
            if state.name_owner(above):
                raise Refused(f"name /{name} is below /{above}, which is no directory of names")
        below = state.name_below(name)
        if below:
            raise Refused(f"name /{name} is a directory: it has /{below}")


def is_own_place(state: ManagerState, name: str, instance: str) -> bool:
    """Return whether a component is found by that name anyway, below its manager or its slave."""
    *folders, leaf = name.split("/")
    while folders and "/".join(folders) not in state.names:
        if not folders.pop().endswith(MANAGER_SUFFIX):
            return False
    return bool(folders) and leaf == f"{instance}{COMPONENT_SUFFIX}"


def _above(name: str) -> Iterator[str]:
    """Yield the directories in which a name is, but for the host."""
    parts = name.split("/")
    return ("/".join(parts[:length]) for length in range(2, len(parts)))


def _templates(state: ManagerState, create: CreateString) -> tuple[str, ...]:
    if not state.settings.flag("naming.enable"):
        return ()
    own = create.options.get("naming.formats", "")
    return formats.check(own or state.settings.text("naming.formats"))


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
    state.kept.change(facts.instance, names=left)
    if facts.zombie and not left and facts.instance not in state.ending:
        state.forget(facts.instance)
        state.kept.forget(facts.instance)
        return Result()
    return (yield from remember(state, facts.instance))


def register(state: ManagerState, action: act.Register) -> Procedure:
    """Give a component a further name, which no other may have.

    Raises:
        NotFound: There is no such component.
        Refused: The name is not free.
    """
    facts = state.components.get(action.instance)
    if facts is None:
        raise no_component(state, action.instance)
    if action.name in facts.names:
        return Result()
    check_free(state, (action.name,), action.instance)
    names = (*facts.names, action.name)
    state.update(action.instance, names=names)
    state.kept.change(action.instance, names=names)
    return (yield from remember(state, action.instance))


def remember(state: ManagerState, instance: str) -> Procedure:
    """Have the process of a component remember its names and its origin."""
    facts, process = state.components[instance], state.process_of(instance)
    if process is not None and process.is_ready:
        kept = {"names": list(facts.names), "create": facts.create}
        yield Send(process, {"op": "remember", "instance": instance, "kept": kept})
    return Result()


_POLICY = "manager.components.naming_policy"
_PATIENCE_S = 3.0
"""How long other managers have to report their names [s]."""


def names_elsewhere(
    state: ManagerState, create: CreateString
) -> Generator[Call, Any, Collection[str]]:
    """Return the names that a chosen one is to differ from besides those of this manager."""
    if create.instance_name or state.settings.text(_POLICY) == PROCESS_UNIQUE:
        return ()
    message = {"op": "neighbours", "manager": state.name}
    try:
        names: list[str] = yield Call(state.processes[OWN_PROCESS], message, _PATIENCE_S)
    except RtkitError:
        return ()  # a silent manager is left out: it delays no creation
    return frozenset(names)


def at_rest(state: ManagerState, instance: str) -> Generator[WaitUntil, Any, None]:
    """Wait until nobody makes or ends a component of that name any more."""
    while instance in state.ending or instance in state.claims:
        yield WaitUntil(lambda: instance not in state.ending, f"{instance} is just being deleted")
        yield WaitUntil(lambda: instance not in state.claims, f"{instance} is just being made")


def claim_name(
    state: ManagerState, action: act.Create, create: CreateString, taken: Collection[str] = ()
) -> tuple[str, NameReservation]:
    """Choose the instance name, ``<type><n>`` unless one is given, and reserve it.

    Raises:
        Refused: It, or a path at which it would be listed, is not free.
        Malformed: No component may bear it.
    """
    instance = create.instance_name or _free_name(state, action, create, taken)
    check_instance_name(instance)
    known = state.components.get(instance)
    asked = action.names or (known.names if known is not None else ())
    names = asked or early_names(state, create, instance)
    names = tuple(n for n in dict.fromkeys(names) if not is_own_place(state, n, instance))
    check_free(state, names, instance)
    claim = state.claims[instance] = NameReservation(names, is_by_template=not asked)
    return instance, claim


def _free_name(
    state: ManagerState, action: act.Create, create: CreateString, taken: Collection[str]
) -> str:
    pattern = action.pattern
    base = pattern.type.type_name if pattern is not None else create.implementation_id
    names = (f"{base}{n}" for n in itertools.count(state.first_free(base)))
    return next(
        name
        for name in names
        if name not in state.components
        and name not in state.claims
        and name not in taken
        and (action.names or not any(map(state.name_owner, early_names(state, create, name))))
    )
