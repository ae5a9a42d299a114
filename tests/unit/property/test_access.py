"""Who may do what: rules as text, the order of them, what they cover, what cannot be read."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed
from rtkit.property.access import Access, EndpointLimits, read_policy
from rtkit.serving.quota import RateLimit
from rtkit.wires.table import WIRES

RULES = """
# who      may what
allow http rtkit-0 SET arm.*
allow serial nobody SET arm.angle
deny  *    *       *   secret     # in all its parts
deny  http *       SET *
allow *    *       SET notes
"""


@pytest.mark.parametrize(("endpoint", "identity", "method", "name", "may"), [
    ("unix", "uid-0", "GET", "speed", True),
    ("unix", "uid-0", "SET", "speed", True),
    ("unix", "", "GET", "speed", True),
    ("unix", "", "SET", "speed", False),
    ("unix", "", "SET", "notes", False),  # it says *, not nobody
    ("serial", "", "SET", "arm.angle", True),
    ("serial", "", "SET", "arm.angle.x", True),
    ("serial", "", "SET", "arm", False),
    ("serial", "", "SET", "arm.anglex", False),
    ("unix", "uid-0", "GET", "secret", False),
    ("unix", "uid-0", "GET", "secret.0", False),
    ("unix", "uid-0", "GET", "secret.meta.type", False),
    ("unix", "uid-0", "GET", "secret.history", False),
    ("unix", "", "GET", "secret", False),
    ("unix", "uid-0", "GET", "secrets", True),
    ("http", "rtkit-0", "SET", "arm.angle", True),
    ("http", "rtkit-1", "SET", "arm.angle", False),
    ("http", "rtkit-0", "SET", "arm", False),
    ("http", "rtkit-0", "SET", "notes", False),  # an earlier one fits
    ("tcp", "rtkit-0", "SET", "notes", True),
])  # fmt: skip
def test_the_first_that_fits_decides(
    endpoint: str, identity: str, method: str, name: str, may: bool
) -> None:
    access = read_policy(RULES).access(endpoint)
    assert access.may(identity, method, name) is may
    assert access.may(identity, method, name) is may, "remembered"


def test_without_rules_who_is_known_may_set() -> None:
    access = Access()
    assert [access.may(who, what, "x") for who in ("", "a") for what in ("GET", "SET")] == [
        True, False, True, True]  # fmt: skip


def test_what_is_remembered_is_bounded() -> None:
    access = read_policy(RULES).access("unix")
    for index in range(10_000):
        access.may("a", "GET", f"p{index}")
    assert len(access._known) <= 4096


def test_limits_are_of_a_door_or_of_all() -> None:
    policy = read_policy("limit tcp rate 5\nlimit * rate 9\nlimit * listeners 2\nlimit tcp rate 7")
    assert policy.limits("tcp") == EndpointLimits(rate=5, listeners=2)
    assert policy.limits("unix") == EndpointLimits(rate=9, listeners=2)
    fewer = EndpointLimits(connections=8, rate=1)
    assert policy.limits("tcp", fewer) == EndpointLimits(connections=8, listeners=2, rate=5)
    both = read_policy("deny * * SET *") + read_policy("allow * * SET *\nlimit tcp rate 3")
    assert both.limits("tcp").rate == 3
    assert not both.access("tcp").may("a", "SET", "x")


@pytest.mark.parametrize(("text", "says"), [
    ("permit * * GET *", "file:1: expected allow, deny or limit, found permit"),
    ("\n\nallow * * GET", "file:3: expected allow ENDPOINT IDENTITY METHOD TARGET"),
    ("deny ftp * GET *", f"expected an endpoint ({' '.join(WIRES)} or *),"),
    ("deny * * get *", "file:1: expected GET, SET or *, found get"),
    ("deny * * GET a/b", "file:1: not a pattern of names: a/b"),
    ("deny * * GET " + "x" * 256, "not a pattern of names"),
    ("limit * speed 3", "found speed"), ("limit * rate fast", "expected a number, found fast"),
    ("limit * rate -1", "expected a number"), ("limit * listeners 0", "listeners is at least 1"),
    ("limit * size 99999999", "size is at most"),
    ("limit * rate", "expected limit ENDPOINT WHAT NUMBER"),
    ("deny * * GET *\n" * 1001, "file:1001: more than 1000 rules"),
])  # fmt: skip
def test_what_cannot_be_read_is_told_with_its_line(text: str, says: str) -> None:
    with pytest.raises(Malformed) as refused:
        read_policy(text, "file", WIRES)
    assert says in str(refused.value)


def test_a_pace_is_kept() -> None:
    pace = RateLimit(10, 0.0)
    assert [pace.takes(0.0) for _ in range(11)] == [True] * 10 + [False]
    assert [pace.takes(0.25) for _ in range(3)] == [True, True, False]
    assert sum(pace.takes(100.0) for _ in range(99)) == 10
