"""Rules of health: what can be said, what makes no sense, and when one is broken."""

from __future__ import annotations

import pytest

from rtkit.deployment.health import Reaction, Sample, broken, read_rules
from rtkit.deployment.metrics import ComponentMetrics, ContextMetrics
from rtkit.errors import Malformed


def sample(
    at_s: float, count: int = 0, longest_s: float = 0.0, missed: int = 0, **more: object
) -> Sample:
    """Return a component that has written and read so much."""
    context = ContextMetrics("0", True, True, count, 0.0, longest_s, missed)
    metrics = ComponentMetrics("A", (context,), {"out": count}, {"in": 2 * count})
    told = {"is_active": True, "values": {"gain": "2.5", "mode": "on"}, **more}
    return Sample(at_s, metrics=metrics, **told)  # type: ignore[arg-type]


BEFORE = sample(10.0, 100)


@pytest.mark.parametrize(
    ("key", "rule", "now", "why"),
    [
        ("stuck", "restart", sample(11.0, stuck="stuck in f"), "stuck in f"),
        ("stuck", "log", sample(11.0), ""),
        ("stuck", "0.2:restart", sample(11.0, stuck="stuck in f"), "stuck in f"),
        (
            "overrun",
            "0.1:log",
            sample(11.0, longest_s=0.25),
            "a cycle took 0.25 s, more than 0.1 s",
        ),
        ("overrun", "0.3:log", sample(11.0, longest_s=0.25), ""),
        ("overrun", "0.1:log", sample(11.0, longest_s=0.25, is_active=False), ""),
        ("missed", "10:log", sample(12.0, missed=20), ""),
        (
            "missed",
            "10:log",
            sample(12.0, missed=21),
            "context 0 misses 10.5 periods a second, above 10",
        ),
        ("missed", "10:log", sample(12.0, missed=21, is_active=False), ""),
        ("rate.out", "5-50:log", sample(12.0, 120), ""),
        (
            "rate.out",
            "5-50:log",
            sample(12.0, 104),
            "out carries 2 values a second, less than 5",
        ),
        ("rate.in", "0-5", sample(12.0, 120), "in carries 20 values a second, more than 5"),
        ("rate.none", "0-5", sample(12.0, 120), "no port none"),
        ("rate.out", "5-50", sample(12.0, 100, is_active=False), ""),
        ("value.gain", "<3:stop", sample(11.0), ""),
        ("value.gain", "<2:stop", sample(11.0), "gain is 2.5, not <2"),
        ("value.mode", "=on", sample(11.0), ""),
        ("value.mode", "= off", sample(11.0), "mode is on, not =off"),
        ("value.mode", ">1", sample(11.0), "mode is on, not >1"),
        ("value.none", ">1", sample(11.0), "no parameter none"),
    ],
)
def test_when_a_rule_is_broken(key: str, rule: str, now: Sample, why: str) -> None:
    rules = read_rules({f"rtkit.health.{key}": rule, "gain": "1"})
    assert [text for _, text in broken(rules, BEFORE, now)] == [why] * bool(why)


def test_a_rate_needs_two_samples() -> None:
    rules = read_rules({"rtkit.health.rate.out": "5-50"})
    assert list(broken(rules, None, BEFORE)) == []
    assert list(broken(rules, BEFORE, BEFORE)) == []


def test_what_is_done_is_said_after_a_colon() -> None:
    rules = read_rules({"rtkit.health.stuck": "stop", "rtkit.health.overrun": "1"})
    assert [rule.reaction for rule in rules] == [Reaction.LOG, Reaction.STOP]


@pytest.mark.parametrize(
    ("key", "text", "why"),
    [
        ("stuck", "panic", "not one of log, degrade, restart, stop: panic"),
        ("overrun", "-1:log", r"not a number of 0 or more \[s\]: -1"),
        ("missed", "-1:log", r"not a number of 0 or more \[1/s\]: -1"),
        ("missed.out", "1", "unknown rule of health: rtkit.health.missed.out"),
        ("overrun", "1:perhaps", "not one of log, degrade, restart, stop: perhaps"),
        ("rate.out", "5", r"not MIN-MAX \[Hz\]: 5"),
        ("rate.out", "5-1", "the lowest rate is above the highest: 5-1"),
        ("rate.out", "a-b", "not a number of 0 or more"),
        ("rate", "1-2", "unknown rule of health: rtkit.health.rate"),
        ("value.x", "5", "not <, <=, >, >= and a number, or = and a value: 5"),
        ("value.x", "<a", "not <, <=, >, >= and a number"),
        ("pulse", "1", "unknown rule of health: rtkit.health.pulse"),
    ],
)
def test_nonsense_is_refused(key: str, text: str, why: str) -> None:
    with pytest.raises(Malformed, match=why):
        read_rules({f"rtkit.health.{key}": text})
