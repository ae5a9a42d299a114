"""Reads the execution contexts that a component is to own from its create string's options."""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.component.configuration.kinds import read_float
from rtkit.component.contexts.period import check_rate
from rtkit.errors import Malformed, Refused
from rtkit.rtc.context_settings import SETTINGS, check_settings
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.pattern import ContextPattern

PERIODIC = "PeriodicExecutionContext"
_KINDS = {
    PERIODIC: ExecutionKind.PERIODIC,
    "EventDrivenExecutionContext": ExecutionKind.EVENT_DRIVEN,
    "ExtTrigExecutionContext": ExecutionKind.OTHER,
    "SimulatorExecutionContext": ExecutionKind.OTHER,
    "OpenHRPExecutionContext": ExecutionKind.OTHER,
}
_BY_WORD = {name.lower(): kind for name, kind in _KINDS.items()}
_BY_WORD.update({name.removesuffix("executioncontext"): k for name, k in _BY_WORD.items()})
_BY_WORD.update(periodicec=ExecutionKind.PERIODIC, event_driven=ExecutionKind.EVENT_DRIVEN)
_NONE = "none"


def kind_named(name: str) -> ExecutionKind:
    """Return the kind of a type of execution contexts.

    ``EventDrivenExecutionContext`` has a cycle when something happens; those that a simulator or
    a test drives (``ExtTrigExecutionContext`` …) have one for each tick that is asked for.

    Raises:
        Refused: No such type; says what is known.
    """
    kind = _BY_WORD.get(name.strip().lower())
    if kind is None:
        raise Refused(f"execution context type {name} is not known; known: {', '.join(_KINDS)}")
    return kind


def wanted_contexts(
    options: Mapping[str, str], rate: float, default_type: str = PERIODIC
) -> tuple[ContextPattern, ...]:
    """Return the contexts that the options ask for; without any, one of `default_type`.

    A periodic one has `rate` [Hz] unless an option says another.

    Raises:
        Refused: A type that is not known, or a name that is used twice.
        Malformed: A rate or a setting that cannot be read.
    """
    check_settings(options)
    text = options.get("execution_contexts", "").strip()
    if text.lower() == _NONE:
        return ()
    items = [item.strip() for item in text.split(",") if item.strip()]
    if not items:
        items = [options.get("exec_cxt.periodic.type", "").strip() or default_type]
    wanted = tuple(_wanted(item, index, options, rate) for index, item in enumerate(items))
    ids = [context.id for context in wanted]
    for id in ids:
        if ids.count(id) > 1:
            raise Refused(f"execution context {id} is named twice: {text}")
    return wanted


def _wanted(item: str, index: int, options: Mapping[str, str], rate: float) -> ContextPattern:
    kind, opening, tail = item.partition("(")
    kind, name = kind.strip(), tail.rstrip().removesuffix(")").strip()
    if opening and not tail.rstrip().endswith(")"):
        raise Malformed(f"execution_contexts is not TYPE(NAME),…: {item}")
    found = kind_named(kind)
    is_periodic = found is ExecutionKind.PERIODIC
    rate = rate if is_periodic else 0.0
    keys = [f"ec.{name}.rate"] if name else []
    keys.append(f"ec.{kind}.rate")
    if is_periodic:
        keys.append("exec_cxt.periodic.rate")
    for key in keys:
        if options.get(key, "").strip():
            rate = _rate(key, options[key])
            break
    properties = _properties(kind, name or str(index), options)
    rate = check_rate(rate) if is_periodic else rate
    return ContextPattern(name or str(index), found, rate, properties)


def _properties(kind: str, name: str, options: Mapping[str, str]) -> dict[str, str]:
    """Return the properties of one context besides its rate; its name precedes its type."""
    every = {key: options.get(f"exec_cxt.{key}", "").strip() for key in SETTINGS}
    found = {key: text for key, text in every.items() if text}
    for prefix in (f"ec.{kind}.", f"ec.{name}."):
        own = {k.removeprefix(prefix): v for k, v in options.items() if k.startswith(prefix)}
        found.update((key, value) for key, value in own.items() if key != "rate")
    return found


def _rate(key: str, text: str) -> float:
    try:
        return check_rate(read_float(text))
    except Malformed as error:
        raise Malformed(f"{key}: {error}") from None
