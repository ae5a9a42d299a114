"""Settings of components beside parameters, as keys of a model: name, rates, policy, making."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rtkit.deployment import drift
from rtkit.deployment.drift import rate_text
from rtkit.deployment.extension import policy_in
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.planning.model import UNKNOWN, ParameterVariable
from rtkit.deployment.system import HIDDEN, WantedComponent
from rtkit.rtc.enums import ExecutionKind

DEFAULT = "default"
"""The set that is the active one in a component just made."""
ACTIVE_SET = "@"
"""Stands for the active configuration set where a parameter is named."""
RATE, NAME, POLICY, MADE = "@rate:", "@name:", "@policy", "@made"
"""Stand for these likewise; the first two with the id of a context, or the name, behind it."""
NAMELESS = "none"
AS_WANTED = "as the profile says"


class ComponentSetting(NamedTuple):
    """A setting of a component.

    Attributes:
        parameter: Its name among the parameters of its component.
        live: Its value now; None where the component does not live.
    """

    parameter: str
    key: ParameterVariable
    wanted: str
    live: str | None = None


def settings(
    component: WantedComponent, facts: ComponentFacts | None, was: ComponentFacts | None
) -> Iterator[ComponentSetting]:
    """Yield rates and policy of a component: as wanted, else as they were when it began.

    Args:
        component: The wanted component.
        facts: As it lives, if it does.
        was: As it lived when a plan began, if it did; who moves keeps the rates of then.
    """
    yield from _rates(component, facts, was)
    if component.policy is None:
        return
    wanted = drift.policy_text(component.policy)
    live = None
    if facts is not None:
        drifted = drift.policy_difference(component, facts)
        live = drifted.found if drifted is not None else drift.policy_text(policy_in(facts.create))
    default = wanted if component.create else UNKNOWN  # who is made so has it from the beginning
    yield ComponentSetting(
        POLICY,
        ParameterVariable(default, True, f"set policy of {component.instance}="),
        wanted,
        live,
    )


def _rates(
    component: WantedComponent, facts: ComponentFacts | None, was: ComponentFacts | None
) -> Iterator[ComponentSetting]:
    now = dict(_own_rates(facts)) if facts is not None else {}
    # A component that is not where it was gets its rates again.
    has_left = (
        was is not None and not was.zombie and (facts is None or facts.process != was.process)
    )
    wished = dict(_own_rates(was)) if was is not None and has_left else {}
    if facts is not None:
        wished.update((each.context, each.wanted) for each in drift.rates(component, facts))
    else:
        rates = zip(component.contexts, component.rates, strict=False)
        wished.update((context.id, rate) for context, rate in rates if rate)
    is_alone = len(component.contexts) < 2
    for context, rate in wished.items():
        if facts is not None and context not in now:
            continue
        default = rate_text(rate) if component.pattern is not None else UNKNOWN
        where = "" if is_alone else f" in {context}"
        text = f"set rate of {component.instance}{where}="
        live = rate_text(now[context]) if context in now else None
        yield ComponentSetting(
            f"{RATE}{context}", ParameterVariable(default, True, text), rate_text(rate), live
        )


def _own_rates(facts: ComponentFacts) -> Iterator[tuple[str, float]]:
    for context in facts.contexts:
        if context.owner == facts.instance and context.kind is ExecutionKind.PERIODIC:
            yield context.id, context.rate


def kept(facts: ComponentFacts) -> Iterator[ComponentSetting]:
    """Yield the configuration and the rates of a component of which nothing is wanted."""
    for set_id, values in facts.sets.items():
        for parameter, value in () if set_id.startswith(HIDDEN) else values.items():
            text = f"set {facts.instance}.{set_id}.{parameter}="
            yield ComponentSetting(
                f"{set_id}.{parameter}", ParameterVariable(text=text), value, value
            )
    if facts.active_set:
        key = ParameterVariable(DEFAULT, text=f"use set of {facts.instance}: ")
        yield ComponentSetting(ACTIVE_SET, key, facts.active_set, facts.active_set)
    for context, rate in _own_rates(facts):
        text = f"set rate of {facts.instance} in {context}="
        present = rate_text(rate)
        yield ComponentSetting(
            f"{RATE}{context}", ParameterVariable(UNKNOWN, True, text), present, present
        )


def name(component: WantedComponent, live: bool | None) -> ComponentSetting:
    """Return the name of a component, and whether what lives is to be found under it."""
    path = f"/{component.name}"
    key = ParameterVariable(path, True, f"register {component.instance} as ")
    now = None if live is None else path if live else NAMELESS
    return ComponentSetting(f"{NAME}{component.name}", key, path, now)


def making(
    component: WantedComponent, facts: ComponentFacts | None, reasons: Sequence[str]
) -> ComponentSetting:
    """Return that a component is, or was when a plan began, made otherwise for these reasons."""
    key = ParameterVariable(AS_WANTED, text=f"{component.instance} made ", is_fixed=True)
    live = "; ".join(reasons) or AS_WANTED
    return ComponentSetting(MADE, key, AS_WANTED, live if facts is not None else None)


def unlike(component: WantedComponent, facts: ComponentFacts | None) -> list[str]:
    """Return in what a component is another than wanted because of its code."""
    if facts is None or facts.is_stand_in:
        return []
    found = drift.data_types(component, facts)
    return [
        f"{component.path}: {each}; only other code in its place changes that" for each in found
    ]


def reasons(component: WantedComponent, facts: ComponentFacts) -> Iterable[str]:
    """Return why nothing but making a component again makes it what is wanted."""
    return map(str, drift.otherwise_made(component, facts))
