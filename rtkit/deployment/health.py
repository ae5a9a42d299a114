"""Health rules: judge a component from its metrics; pure code.

``rtkit.health.stuck`` detects callbacks that do not return in time (1 s unless it states another
time), ``rtkit.health.overrun`` cycles that exceed a number of seconds, ``rtkit.health.missed``
contexts that miss more than a number of periods a second, ``rtkit.health.rate.PORT`` ports that
carry less or more than ``MIN-MAX`` values a second, ``rtkit.health.value.PARAMETER`` a parameter
that violates a condition (``<5``, ``>=0``, ``=on``). The value of each rule ends, after a colon,
with the reaction to a violation.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from enum import StrEnum
from functools import lru_cache
from math import inf
from typing import NamedTuple

from rtkit.deployment.extension import HEALTH
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.supervision import RestartPolicy, RestartRule, read_policy, restart_of
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.connector_properties import finite

STUCK = f"{HEALTH}stuck"
IN_DEBUGGER = "in a debugger"
"""Begins the text of a callback that is late because a debugger has stopped it."""

COMPARE: Mapping[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}


class Reaction(StrEnum):
    """Reaction to a component that is not well."""

    LOG = "log"
    DEGRADE = "degrade"
    RESTART = "restart"
    STOP = "stop"


class HealthRule(NamedTuple):
    """A health rule of a component.

    Attributes:
        kind: ``stuck``, ``overrun``, ``missed``, ``rate`` or ``value``.
        name: Of the port or parameter; empty for the others.
        least: Lowest rate [Hz].
        most: Highest rate [Hz], most missed periods [1/s], the longest cycle, or the deadline of a
            callback [s].
        condition: Condition on a parameter: an operator and a value.
    """

    kind: str
    reaction: Reaction
    name: str = ""
    least: float = 0.0
    most: float = inf
    condition: tuple[str, str] = ("", "")


@dataclass(frozen=True, slots=True)
class Sample:
    """State and metrics of a component at one moment, as rules judge them.

    Attributes:
        at_s: When it was counted, monotonic [s].
        is_active: Whether it is Active; rates and cycles mean nothing otherwise.
        values: Its parameters in use.
        stuck: Callback that does not come back; empty for none.
    """

    at_s: float
    is_active: bool
    metrics: ComponentMetrics
    values: Mapping[str, str]
    stuck: str = ""


def read_rules(options: Mapping[str, str]) -> tuple[HealthRule, ...]:
    """Return the rules that the properties of a component state.

    Raises:
        Malformed: One makes no sense; names it.
    """
    stated = tuple(sorted((k, v) for k, v in options.items() if k.startswith(HEALTH)))
    return _read(stated) if stated else ()


@lru_cache(maxsize=256)
def _read(stated: tuple[tuple[str, str], ...]) -> tuple[HealthRule, ...]:
    return tuple(_rule(key, *_parts(key, text)) for key, text in stated)


def _parts(key: str, text: str) -> tuple[str, Reaction]:
    bound, colon, word = text.rpartition(":")
    if not colon:
        is_word = key == STUCK and finite(text) is None
        bound, word = ("", text) if is_word else (text, Reaction.LOG)
    try:
        return bound.strip(), Reaction(word.strip().lower())
    except ValueError:
        raise Malformed(f"{key}: not one of {', '.join(Reaction)}: {word.strip()}") from None


def _rule(key: str, bound: str, reaction: Reaction) -> HealthRule:
    kind, _, name = key.removeprefix(HEALTH).partition(".")
    if key == STUCK:
        within_s = _number(key, bound, "s") if bound else inf
        if not within_s:
            raise Malformed(f"{key}: a callback cannot come back within 0 s")
        return HealthRule(kind, reaction, most=within_s)
    if kind == "overrun" and not name:
        return HealthRule(kind, reaction, most=_number(key, bound, "s"))
    if kind == "missed" and not name:
        return HealthRule(kind, reaction, most=_number(key, bound, "1/s"))
    if kind == "rate" and name:
        least, dash, most = bound.partition("-")
        if not dash:
            raise Malformed(f"{key}: not MIN-MAX [Hz]: {bound}")
        rule = HealthRule(kind, reaction, name, _number(key, least, "Hz"), _number(key, most, "Hz"))
        if rule.least > rule.most:
            raise Malformed(f"{key}: the lowest rate is above the highest: {bound}")
        return rule
    if kind == "value" and name:
        sign = next((each for each in (*COMPARE, "=") if bound.startswith(each)), "")
        value = bound.removeprefix(sign).strip()
        if not sign or (sign != "=" and finite(value) is None):
            raise Malformed(f"{key}: not <, <=, >, >= and a number, or = and a value: {bound}")
        return HealthRule(kind, reaction, name, condition=(sign, value))
    known = "stuck, overrun, missed, rate.PORT, value.PARAMETER"
    raise Malformed(f"unknown rule of health: {key} (one of {known})")


def _number(key: str, text: str, unit: str) -> float:
    value = finite(text)
    if value is None or value < 0:
        raise Malformed(f"{key}: not a number of 0 or more [{unit}]: {text.strip()}")
    return value


def broken(
    rules: tuple[HealthRule, ...], before: Sample | None, now: Sample
) -> Iterator[tuple[HealthRule, str]]:
    """Yield the rules that a component breaks, and how."""
    for rule in rules:
        why = _JUDGES[rule.kind](rule, before, now)
        if why:
            yield rule, why


def _overrun(rule: HealthRule, _before: Sample | None, now: Sample) -> str:
    longest_s = max((each.longest_s for each in now.metrics.contexts), default=0.0)
    if not now.is_active or longest_s <= rule.most:
        return ""
    return f"a cycle took {longest_s:.3g} s, more than {rule.most:g} s"


def _missed(rule: HealthRule, before: Sample | None, now: Sample) -> str:
    if before is None or not now.is_active or now.at_s <= before.at_s:
        return ""
    earlier = {each.id: each.missed for each in before.metrics.contexts}
    for each in now.metrics.contexts:
        missed = (each.missed - earlier.get(each.id, each.missed)) / (now.at_s - before.at_s)
        if missed > rule.most:
            return f"context {each.id} misses {missed:.3g} periods a second, above {rule.most:g}"
    return ""


def _rate(rule: HealthRule, before: Sample | None, now: Sample) -> str:
    if before is None or not (before.is_active and now.is_active) or now.at_s <= before.at_s:
        return ""
    counts = [{**each.metrics.read, **each.metrics.written} for each in (before, now)]
    if any(rule.name not in each for each in counts):
        return f"no port {rule.name}"
    rate = (counts[1][rule.name] - counts[0][rule.name]) / (now.at_s - before.at_s)
    if rule.least <= rate <= rule.most:
        return ""
    side = f"less than {rule.least:g}" if rate < rule.least else f"more than {rule.most:g}"
    return f"{rule.name} carries {rate:.3g} values a second, {side}"


def _value(rule: HealthRule, _before: Sample | None, now: Sample) -> str:
    sign, wanted = rule.condition
    value = now.values.get(rule.name)
    if value is None:
        return f"no parameter {rule.name}"
    if sign == "=":
        is_so = value == wanted
    else:
        is_so = finite(value) is not None and COMPARE[sign](float(value), float(wanted))
    return "" if is_so else f"{rule.name} is {value}, not {sign}{wanted}"


_JUDGES: Mapping[str, Callable[[HealthRule, Sample | None, Sample], str]] = {
    "stuck": lambda _rule, _before, now: now.stuck,
    "overrun": _overrun,
    "missed": _missed,
    "rate": _rate,
    "value": _value,
}


DEFAULT = "manager.restart"
"""Property of the manager; with the name of a slave added, of what that holds."""


def policy_in(
    options: Mapping[str, str], process: str, setting: Callable[[str], str]
) -> RestartPolicy:
    """Return the policy that a component states, else that of its process, else of its manager.

    Args:
        options: Of its create string.
        process: Name of the slave, or manager, that holds it.
        setting: Returns a property of the manager, "" for none.

    Raises:
        Malformed: It makes no sense.
    """
    rules = read_rules(options)
    default = restart_of(DEFAULT, setting(DEFAULT))
    of_process = f"{DEFAULT}.{process}"
    default = restart_of(of_process, setting(of_process), default)
    # A rule that says restart is the component's own word, which counts more than that of its slave
    # or manager; without it the rule could do nothing. Its own ``rtkit.restart`` counts most.
    if any(rule.reaction is Reaction.RESTART for rule in rules) and default is RestartRule.NEVER:
        default = RestartRule.ON_FAILURE
    return read_policy(options, default)
