"""Finds in the last events of a manager those about one component, as its users know them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from rtkit.deployment import actions as act
from rtkit.deployment.delta import Delta
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.user_events import COMPONENT_PROFILE, user_events
from rtkit.errors import Malformed
from rtkit.manager.core import events as ev
from rtkit.manager.core.event_ring import Item
from rtkit.rtc.serde import decode

_MOST_TEXT = 200
TimedItem = tuple[float, Item]
"""An item of the ring, with its monotonic time [s]."""


class PastEvent(NamedTuple):
    """An event about a component.

    Attributes:
        at: When it was, monotonic [s].
        event: In the words of `rtkit.deployment.user_events`; ``ASKED`` for a request of a user.
        subject: Execution context, port, configuration set; empty for the component.
        detail: More about it.
    """

    at: float
    event: str
    subject: str = ""
    detail: str = ""


def to_text(history: Iterable[PastEvent], now: float, time_s: float) -> str:
    """Return events as JSON, dated [s since 1970]: `time_s` is the time at monotonic `now` [s]."""
    rows = ((round(time_s - now + each.at, 6), *each[1:]) for each in history)
    return json.dumps([*rows], separators=(",", ":"))


def history(items: Iterable[TimedItem], instance: str) -> Iterator[PastEvent]:
    """Yield the events about an instance, in order; what happened earlier is not known."""
    facts: ComponentFacts | None = None
    key: int | None = None
    for at, item in items:
        match item:
            case ev.ContainerReported(reporter, message) if "facts" in message:
                new = _facts(message["facts"], instance)
                if new is not None:
                    before = facts if reporter == key else None
                    key, facts = reporter, new
                    yield from _changes(at, before, new)
            case ev.ContainerReported(reporter, message) if message.get("gone") == instance:
                yield PastEvent(at, "VANISHED")
            case ev.SlaveEnded() if item.key == key:
                key = None
                yield PastEvent(at, "ZOMBIE", "", item.reason)
            case ev.SlaveStopped(stopped, is_halted) if stopped == key:
                yield PastEvent(at, "NOT_ANSWERING" if is_halted else "ANSWERS", "", "stopped")
            case ev.CallbackStuck() if item.instance == instance and item.is_all:
                event = "NOT_ANSWERING" if item.text else "ANSWERS"
                yield PastEvent(at, event, "", item.text)
            case ev.BatchRequested():
                asked = (_asked(each, instance) for each in item.batch.actions)
                yield from (PastEvent(at, "ASKED", "", text) for text in asked if text)


def _facts(reported: Any, instance: str) -> ComponentFacts | None:
    if not isinstance(reported, dict) or reported.get("instance") != instance:
        return None
    try:
        return decode(ComponentFacts, reported)
    except Malformed:
        return None


def _changes(
    at: float, before: ComponentFacts | None, after: ComponentFacts
) -> Iterator[PastEvent]:
    known = (before,) if before is not None else ()
    snapshot = Snapshot("", "", 0, "", components=known)
    for each in user_events(snapshot, Delta("", 0, components=(after,))):
        if each.kind == COMPONENT_PROFILE:  # its event says which parts changed
            detail = after.composite if "composite" in each.event else ""
            yield PastEvent(at, each.kind, each.event, detail)
        else:
            yield PastEvent(at, each.event, each.subject, each.detail[:_MOST_TEXT])


def _asked(action: act.Action, instance: str) -> str:
    """Return what was asked of an instance in a few words; empty if nothing was."""
    match action:
        case act.Connect(connector):
            ends = [f"{each.instance}:{each.port}" for each in connector.ports]
            is_own = any(each.instance == instance for each in connector.ports)
            return f"connect {' '.join(ends)}" if is_own else ""
        case act.Create(create):
            is_own = f"instance_name={instance}" in create.replace("?", "&").split("&")
            return f"create {create}"[:_MOST_TEXT] if is_own else ""
    if getattr(action, "instance", None) != instance or isinstance(action, act.Tick):
        return ""  # a world asks for so many ticks that nothing else would be seen
    match action:
        case act.ChangeState():
            return f"{action.transition.value} in {action.context}"
        case act.SetParameters():
            values = " ".join(f"{key}={value}" for key, value in action.values.items())
            return f"set {action.set_id}: {values}"[:_MOST_TEXT]
        case act.ActivateSet():
            return f"activate set {action.set_id}"
        case act.SetRate():
            return f"rate {action.rate:g} Hz in {action.context}"
        case act.SetContext():
            values = " ".join(f"{key}={value}" for key, value in action.settings.items())
            return f"context {action.context}: {values}"[:_MOST_TEXT]
        case act.Delete():
            return "exit"
    return type(action).__name__
