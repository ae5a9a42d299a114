"""Checks the execution contexts of a system against those of the types."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.deployment.described import kind_of
from rtkit.profile.rts_model import OwnedContext
from rtkit.report.finding import ERROR, WARNING
from rtkit.rtc.enums import ExecutionKind
from rtkit.static_check.blueprint import Blueprint
from rtkit.static_check.finding import ProfileLocation, StaticFinding
from rtkit.static_check.view import CheckedComponent, View


def context_findings(view: View) -> Iterator[StaticFinding]:
    """Yield contexts of another kind than the type's, and rates that cannot be or differ."""
    for part in view.parts:
        for number, context in enumerate(part.component.execution_contexts):
            place = part.place.below("execution_contexts", number)
            yield from _rate(part, context, place)
            if part.blueprint is not None and number == 0:
                yield from _declared(part, part.blueprint, context, place)


def _rate(
    part: CheckedComponent, context: OwnedContext, place: ProfileLocation
) -> Iterator[StaticFinding]:
    rate = context.rate
    if rate is None or rate > 0 or kind_of(context.kind) is not ExecutionKind.PERIODIC:
        return
    text = f"execution context {context.id} of {part.name} has a rate of {rate:g} Hz"
    yield StaticFinding(
        ERROR, "context-rate", text, place.at("rate"), f"{rate:g}", "more than 0 Hz"
    )


def _declared(
    part: CheckedComponent, blueprint: Blueprint, context: OwnedContext, place: ProfileLocation
) -> Iterator[StaticFinding]:
    """Compare the first context, which is the one that profiles of types speak of."""
    which = f"execution context {context.id} of {part.name}"
    kind = kind_of(context.kind)
    if blueprint.kind is not None and kind is not blueprint.kind:
        text = f"{which} is {context.kind}, its type's is {blueprint.kind}"
        yield StaticFinding(
            ERROR, "context-kind", text, place.at("kind"), context.kind, blueprint.kind.value
        )
        return
    rate, declared = context.rate, blueprint.rate
    is_periodic = kind is ExecutionKind.PERIODIC and blueprint.kind is ExecutionKind.PERIODIC
    if is_periodic and rate is not None and rate > 0 and declared > 0 and rate != declared:
        text = f"{which} has a rate of {rate:g} Hz, its type's is {declared:g} Hz"
        where = place.at("rate")
        yield StaticFinding(WARNING, "context-rate", text, where, f"{rate:g}", f"{declared:g}")
