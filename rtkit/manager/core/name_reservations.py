"""Reserves the name of a component, given or generated, until the component exists."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Generator
from typing import Any

from rtkit.deployment import actions as act
from rtkit.errors import RtkitError
from rtkit.manager.core.effects import Call, WaitUntil
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.registration import check_free, early_names, is_own_place
from rtkit.manager.core.state import ManagerState, NameReservation
from rtkit.rtc.create import CreateString
from rtkit.rtc.names import check_instance_name
from rtkit.settings.values import PROCESS_UNIQUE

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
    names = (f"{base}{n}" for n in itertools.count())
    return next(
        name
        for name in names
        if name not in state.components
        and name not in state.claims
        and name not in taken
        and (action.names or not any(map(state.name_owner, early_names(state, create, name))))
    )
