"""Finds the traces of a failed plan by comparing two snapshots, and the actions that undo them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.extension import policy_in
from rtkit.deployment.facts import Snapshot
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.create import parse_create


@dataclass(frozen=True, slots=True)
class Trace:
    """One thing that a plan made or changed, and the action that takes it back."""

    what: str
    undo: Action


def traces(attempted: Iterable[Action], before: Snapshot, now: Snapshot) -> list[Trace]:
    """Return what the attempted actions left behind, in the order in which it is to be undone."""
    tried = tuple(attempted)
    made = {
        instance
        for action in tried
        if isinstance(action, act.Create)
        if _is_new(instance := parse_create(action.create).instance_name, before, now)
    }
    found = [
        *_connectors(tried, before, now, made),
        # A set that is active cannot be removed: the one of before comes first.
        *sorted(
            _settings(tried, before, now, made), key=lambda each: type(each.undo) is act.RemoveSet
        ),
        *(Trace(name, act.Delete(name)) for name in sorted(made)),
        *_modules(tried, before, now),
    ]
    return found


def _is_new(instance: str, before: Snapshot, now: Snapshot) -> bool:
    was, is_now = before.component(instance), now.component(instance)
    if is_now is None:
        return False
    return was is None or bool(was.zombie and not is_now.zombie)


def _connectors(
    tried: Iterable[Action], before: Snapshot, now: Snapshot, made: set[str]
) -> Iterator[Trace]:
    known = {connector.connector_id for connector in before.connectors}
    connectors = {connector.connector_id: connector for connector in now.connectors}
    for action in tried:
        if isinstance(action, act.Connect):
            id = action.connector.connector_id
            is_left = id in connectors and id not in known
            # Deleting a component takes its connections along.
            if is_left and not made & {end.instance for end in connectors[id].ports}:
                yield Trace(f"connection {id}", act.Disconnect(id))


def _settings(
    tried: Iterable[Action], before: Snapshot, now: Snapshot, made: set[str]
) -> Iterator[Trace]:
    for action in tried:
        if not isinstance(action, (act.SetParameters, act.ActivateSet, act.SetRate, act.SetPolicy)):
            continue
        instance = action.instance
        was, is_now = before.component(instance), now.component(instance)
        if was is None or is_now is None or instance in made or is_now.zombie:
            continue
        match action:
            case act.ActivateSet():
                if was.active_set and was.active_set != is_now.active_set:
                    undo = act.ActivateSet(instance, was.active_set)
                    yield Trace(f"active set of {instance}", undo)
            case act.SetRate():
                for rate in (c.rate for c in was.contexts if c.id == action.context):
                    undo_rate = act.SetRate(instance, action.context, rate)
                    yield Trace(f"rate of {instance}", undo_rate)
            case act.SetPolicy():
                yield Trace(f"policy of {instance}", act.SetPolicy(instance, policy_in(was.create)))
            case act.SetParameters(_, set_id, values):
                if set_id in is_now.sets and set_id not in was.sets:
                    yield Trace(f"set {set_id} of {instance}", act.RemoveSet(instance, set_id))
                    continue
                old, new = was.sets.get(set_id, {}), is_now.sets.get(set_id, {})
                changed = {n: old[n] for n in values if n in old and old[n] != new.get(n)}
                if changed:
                    undo_set = act.SetParameters(instance, set_id, changed)
                    yield Trace(f"parameters {', '.join(changed)} of {instance}", undo_set)


def _modules(tried: Iterable[Action], before: Snapshot, now: Snapshot) -> Iterator[Trace]:
    known, loaded = _loaded(before), _loaded(now)
    for action in tried:
        if not isinstance(action, act.Load):
            continue
        module = (action.manager or now.manager, action.path)
        if module in loaded and module not in known:
            yield Trace(f"module {action.path}", act.Unload(action.path, action.manager))


def _loaded(snapshot: Snapshot) -> set[tuple[str, str]]:
    """Return which manager has which module."""
    managers = (snapshot, *snapshot.others)
    return {(each.manager, module.path) for each in managers for module in each.modules}
