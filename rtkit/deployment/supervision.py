"""Restart policy: decides when a lost component or slave restarts; pure code, time is an argument.

The first restart comes after 0.1 s, each further one after twice as long, up to 10 s, with a
jitter of a tenth. After five restarts within 60 s the policy gives up. Health for 30 s resets it.

See decision 36.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from rtkit.deployment.extension import (
    CRITICAL,
    HEALTH,
    LIMIT,
    PLACE,
    RESTART,
    RESTART_DELAY,
    RESTART_LIMIT,
    is_policy,
)
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, replace
from rtkit.rtc.connector_properties import finite

_KEYS = (RESTART, RESTART_DELAY, RESTART_LIMIT, CRITICAL)

WINDOW_S = 60.0
"""Restarts within this time are counted [s]."""
HEALTHY_S = 30.0
"""How long it must be well until restarts are forgotten [s]."""
LONGEST_S = 10.0
"""The longest wait before a restart [s]."""
MOST = 5
"""The highest limit: no more restarts within `WINDOW_S`, whatever is asked for."""
JITTER = 0.1
"""By how much of itself a wait may be shorter or longer."""
_YES, _NO = ("yes", "true", "on", "1"), ("no", "false", "off", "0", "")


class RestartRule(StrEnum):
    """Restart rule: the kinds of ends that lead to a restart."""

    NEVER = "never"
    ON_FAILURE = "on-failure"
    ALWAYS = "always"


@dataclass(frozen=True, slots=True)
class RestartPolicy:
    """Policy for the end of a component, or of the slave that contains it.

    Attributes:
        delay_s: How long the first restart waits [s].
        limit: Restarts within `WINDOW_S` before it is given up.
        is_critical: Its loss stops the system, in reverse order.
    """

    restart: RestartRule = RestartRule.NEVER
    delay_s: float = 0.1
    limit: int = MOST
    is_critical: bool = False

    def wants(self, is_failure: bool) -> bool:
        """Return whether such an end is answered by a restart."""
        return self.restart is RestartRule.ALWAYS or (
            is_failure and self.restart is RestartRule.ON_FAILURE
        )


def read_policy(
    options: Mapping[str, str], default: RestartRule = RestartRule.NEVER
) -> RestartPolicy:
    """Return the policy that the properties of a component state.

    Raises:
        Malformed: One makes no sense; names it.
    """
    for key in options:
        if is_policy(key) and not key.startswith((HEALTH, LIMIT, PLACE)) and key not in _KEYS:
            raise Malformed(f"unknown property of supervision: {key} (one of {', '.join(_KEYS)})")
    restart = restart_of(RESTART, options.get(RESTART, ""), default)
    delay_s = _number(RESTART_DELAY, options.get(RESTART_DELAY, "0.1"), 0.0, LONGEST_S, "s")
    limit = _number(RESTART_LIMIT, options.get(RESTART_LIMIT, str(MOST)), 1, MOST, "restarts")
    if limit != int(limit):
        raise Malformed(f"{RESTART_LIMIT}: not a whole number: {options[RESTART_LIMIT]}")
    word = options.get(CRITICAL, "").strip().lower()
    if word not in _YES + _NO:
        raise Malformed(f"{CRITICAL}: neither yes nor no: {options[CRITICAL]}")
    return RestartPolicy(restart, delay_s, int(limit), word in _YES)


def restart_of(key: str, text: str, default: RestartRule = RestartRule.NEVER) -> RestartRule:
    """Return the meaning of a word.

    Raises:
        Malformed: It is none of the three.
    """
    word = text.strip().lower()
    if not word:
        return default
    try:
        return RestartRule(word)
    except ValueError:
        raise Malformed(f"{key}: not one of {', '.join(RestartRule)}: {text}") from None


def _number(key: str, text: str, least: float, most: float, unit: str) -> float:
    value = finite(text)
    if value is None or not least <= value <= most:
        raise Malformed(f"{key}: not a number from {least:g} to {most:g} [{unit}]: {text}")
    return value


@dataclass(frozen=True, slots=True)
class Ledger:
    """Record of the restarts of one component or slave so far.

    Attributes:
        count: Restarts of which none is forgotten.
        times: When those of the last `WINDOW_S` were made [s].
        wait_s: How long the last one waited [s].
        well_since: Since when it is well [s]; None while it is not.
        is_given_up: It is not restarted any more until a user asks for it.
    """

    count: int = 0
    times: tuple[float, ...] = ()
    wait_s: float = 0.0
    well_since: float | None = None
    is_given_up: bool = False


def at_end(
    ledger: Ledger, policy: RestartPolicy, now: float, spread: float
) -> tuple[Ledger, float | None]:
    """Return how long to wait for a restart [s], None if there is to be none, and the new ledger.

    Args:
        ledger: Record of the reactions so far.
        policy: Its policy of restarts.
        now: When it ended, monotonic [s].
        spread: A number from -1 to 1 by which the wait differs from the usual one.
    """
    if ledger.is_given_up:
        return ledger, None
    if ledger.well_since is not None and now - ledger.well_since >= HEALTHY_S:
        ledger = replace(ledger, count=0, wait_s=0.0)
    usual = min(policy.delay_s * 2.0**ledger.count, LONGEST_S)
    wait_s = max(ledger.wait_s, usual * (1.0 + JITTER * spread))
    start = now + wait_s
    recent = tuple(time for time in ledger.times if time > start - WINDOW_S)
    if len(recent) >= policy.limit:
        return replace(ledger, well_since=None, is_given_up=True), None
    made = Ledger(ledger.count + 1, (*recent, start), wait_s)
    return made, wait_s


def at_health(ledger: Ledger, now: float, *, is_well: bool) -> Ledger:
    """Note that it is well, or is not, at monotonic time `now` [s]."""
    if not is_well:
        return replace(ledger, well_since=None)
    return ledger if ledger.well_since is not None else replace(ledger, well_since=now)
