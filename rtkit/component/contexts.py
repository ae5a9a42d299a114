"""Which execution contexts a component is to own: the options of its create string."""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.component.parameter import read_float
from rtkit.component.period import check_rate
from rtkit.errors import Malformed, Refused
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.pattern import ContextPattern

_PERIODIC = ("periodicexecutioncontext", "periodic", "periodicec")
_NONE = "none"


def wanted_contexts(options: Mapping[str, str], rate: float) -> tuple[ContextPattern, ...]:
    """Return the contexts that the options ask for; without any, one of `rate` [Hz].

    Raises:
        Refused: A type that is not periodic, or a name that is used twice.
        Malformed: A rate that cannot be read.
    """
    text = options.get("execution_contexts", "").strip()
    if text.lower() == _NONE:
        return ()
    items = [item.strip() for item in text.split(",") if item.strip()]
    if not items:
        items = [options.get("exec_cxt.periodic.type", "").strip() or "PeriodicExecutionContext"]
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
    if kind.lower() not in _PERIODIC:
        raise Refused(
            f"execution context type {kind} is not known; known: PeriodicExecutionContext"
        )
    keys = [f"ec.{name}.rate"] if name else []
    keys += [f"ec.{kind}.rate", "exec_cxt.periodic.rate"]
    for key in keys:
        if options.get(key, "").strip():
            rate = _rate(key, options[key])
            break
    return ContextPattern(name or str(index), ExecutionKind.PERIODIC, check_rate(rate))


def _rate(key: str, text: str) -> float:
    try:
        return check_rate(read_float(text))
    except Malformed as error:
        raise Malformed(f"{key}: {error}") from None
