"""Edits the orders of a system profile: in which order components are told, and what each awaits.

A step is a text: ``Motor0``, ``Motor0@1`` (execution context 1), with what it awaits behind a
colon: ``Motor0:at=2,wait=500`` (place 2, 500 ms), ``Motor0:after=Sensor0,timeout=1000``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rtkit.errors import Malformed, NotFound
from rtkit.fast_dataclass import replace
from rtkit.profile.rts_model import (
    Order,
    OrderStep,
    Preceding,
    RtsProfile,
    TargetComponent,
    WaitTime,
)
from rtkit.profile.rts_spec import ORDERS
from rtkit.rtc.nearest import did_you_mean

NAMES = {field.replace("_", "-"): field for field, _ in ORDERS}
"""Orders as users name them, and their fields in the profile."""
SENT = "sent"
"""The condition that what comes before need only have been told, not done."""
_FIRST_CONTEXT = "0"


def steps_in(profile: RtsProfile, name: str) -> list[str]:
    """Return the steps of an order as texts, by their places; none where it has no such order."""
    order: Order | None = getattr(profile, NAMES[name])
    steps = sorted(order.targets, key=lambda step: step.sequence) if order is not None else []
    return [_text(step, place) for place, step in enumerate(steps, 1)]


def with_steps(profile: RtsProfile, name: str, steps: Sequence[str]) -> RtsProfile:
    """Return a profile with an order made of steps; without steps it has no such order.

    Raises:
        Malformed: A step cannot be read.
        NotFound: There is no such component.
    """
    field = NAMES[name]
    old: Order | None = getattr(profile, field)
    known = {_target_text(step.target_component): step for step in old.targets} if old else {}
    made = tuple(_step(text, place, profile, known) for place, text in enumerate(steps, 1))
    order = replace(old or Order(), targets=made) if made else None
    changes: dict[str, Any] = {field: order}
    return replace(profile, **changes)


def _text(step: OrderStep, place: int) -> str:
    conditions = [] if step.sequence == place else [f"at={step.sequence}"]
    if step.wait_time is not None and step.wait_time.wait_time:
        conditions.append(f"wait={step.wait_time.wait_time}")
    if step.preceding is not None:
        preceding = step.preceding
        conditions += [f"after={_target_text(each)}" for each in preceding.preceding_components]
        conditions += [f"timeout={preceding.timeout}"] if preceding.timeout else []
        conditions += [SENT] if preceding.sending_timing not in (None, "SYNC") else []
    return ":".join([_target_text(step.target_component), *filter(None, [",".join(conditions)])])


def _target_text(target: TargetComponent) -> str:
    context = "" if target.id == _FIRST_CONTEXT else f"@{target.id}"
    return f"{target.instance_name}{context}"


def _step(text: str, place: int, profile: RtsProfile, known: dict[str, OrderStep]) -> OrderStep:
    name, _, conditions = text.partition(":")
    sequence, wait_ms, timeout_ms = place, 0, 0
    before: list[TargetComponent] = []
    timing = "SYNC"
    for each in filter(None, conditions.split(",")):
        key, _, value = each.partition("=")
        if key == "after":
            before.append(_target(value, profile))
        elif key == "at":
            sequence = _number(text, value)
        elif key == "wait":
            wait_ms = _number(text, value)
        elif key == "timeout":
            timeout_ms = _number(text, value)
        elif each == SENT:
            timing = "ASYNC"
        else:
            raise Malformed(f"{text}: {each} is none of at=N, wait=MS, after=X, timeout=MS, {SENT}")
    if before and wait_ms:
        raise Malformed(f"{text}: a step has wait or after, not both")
    if not before and (timeout_ms or timing != "SYNC"):
        raise Malformed(f"{text}: timeout and {SENT} go with after")
    old = known.get(name)
    made = old or OrderStep(sequence, _target(name, profile))
    return replace(
        made,
        sequence=sequence,
        wait_time=None if before else WaitTime(wait_ms),
        preceding=_preceding(old, before, timeout_ms, timing) if before else None,
    )


def _preceding(
    old: OrderStep | None, before: Iterable[TargetComponent], timeout_ms: int, timing: str
) -> Preceding:
    made = (old.preceding if old is not None else None) or Preceding()
    is_kept = timing == "ASYNC" and made.sending_timing == "NO_SYNC"
    return replace(
        made,
        preceding_components=tuple(before),
        timeout=timeout_ms or (0 if made.timeout is not None else None),
        sending_timing=made.sending_timing if is_kept else timing,
    )


def _target(text: str, profile: RtsProfile) -> TargetComponent:
    name, _, context = text.partition("@")
    for each in profile.components:
        if each.instance_name == name:
            return TargetComponent(each.id, name, context or _FIRST_CONTEXT)
    names = [each.instance_name for each in profile.components]
    hint = did_you_mean(name, names) or f" (components: {', '.join(names) or 'none'})"
    raise NotFound(f"no component named {name}{hint}")


def _number(text: str, value: str) -> int:
    if not (value.isascii() and value.isdigit() and len(value) < 9):
        raise Malformed(f"{text}: a whole number is wanted, not {value!r}")
    return int(value)
