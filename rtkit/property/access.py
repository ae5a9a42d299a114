"""Access policy: rules in an order, the first that fits decides, and limits of each endpoint.

One rule or limit a line; ``#`` begins a comment::

    allow  http  rtkit-0  SET  arm.*
    deny   http  *        SET  *
    deny   *     *        GET  diary
    limit  tcp   rate     100

A rule names an endpoint (the scheme of its wire, or ``*``), who asks (a pattern;
``nobody`` is who has not shown who it is), ``GET``, ``SET`` or ``*``, and a pattern of names: it
holds for what lies below them too, and for all that is asked about them. Listening is a GET. Where
no rule fits, GET is for all that the endpoint lets in, SET for who is known. What a property itself
refuses stays refused.

See decision 32.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from fnmatch import fnmatchcase
from typing import NamedTuple

from rtkit.errors import Malformed

METHODS = ("GET", "SET")
NOBODY = "nobody"
_ANY = "*"
_PATTERN = r"[A-Za-z0-9_+~\-%.*?\[\]!]+"
_LONGEST = 255
_MOST_RULES = 1000
_MOST_KNOWN = 4096


class AccessRule(NamedTuple):
    """One rule of an access policy: a line of its text."""

    allows: bool
    endpoint: str
    identity: str
    method: str
    target: str

    def concerns(self, identity: str, method: str, name: str) -> bool:
        """Return whether it is about a request; a SET by a stranger needs a rule for them."""
        if self.method not in (_ANY, method):
            return False
        if self.allows and method == "SET" and not identity and self.identity != NOBODY:
            return False
        if not fnmatchcase(identity or NOBODY, self.identity):
            return False
        segments = name.split(".")
        return any(
            fnmatchcase(".".join(segments[:end]), self.target)
            for end in range(1, len(segments) + 1)
        )


class Access:
    """Rules that hold at one endpoint."""

    def __init__(self, rules: Iterable[AccessRule] = ()) -> None:
        self._rules = tuple(rules)
        self._known: dict[tuple[str, str, str], bool] = {}

    @property
    def lets_all_get(self) -> bool:
        """Return whether there is nothing that somebody may not get."""
        return not self._rules

    def may(self, identity: str, method: str, name: str) -> bool:
        """Return whether somebody may GET or SET a property, or whatever is asked about it."""
        if not self._rules:
            return method == "GET" or bool(identity)
        key = (identity, method, name)
        known = self._known.get(key)
        if known is None:
            known = self._decided(*key)
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[key] = known
        return known

    def allows(self, identity: str, method: str, name: str) -> bool:
        """Return whether a rule says so; without one that fits nothing is allowed."""
        fitting = (rule for rule in self._rules if rule.concerns(identity, method, name))
        rule = next(fitting, None)
        return rule is not None and rule.allows

    @property
    def rules(self) -> tuple[AccessRule, ...]:
        """Return the rules, in their order."""
        return self._rules

    def _decided(self, identity: str, method: str, name: str) -> bool:
        for rule in self._rules:
            if rule.concerns(identity, method, name):
                return rule.allows
        return method == "GET" or bool(identity)


class EndpointLimits(NamedTuple):
    """Limits of one endpoint.

    Attributes:
        connections: Clients at a time.
        listeners: Number of properties that one client may listen to.
        door_listeners: Number of properties that all its clients together may listen to.
        rate: Requests of one client in a second, as many at once; 0 for any number.
        size: Bytes of a request.
    """

    connections: int = 512
    listeners: int = 1024
    door_listeners: int = 8192
    rate: int = 0
    size: int = (1 << 20) + 1024


DEFAULT_LIMITS = EndpointLimits()


class AccessPolicy:
    """Rules and limits of all endpoints of a service."""

    def __init__(
        self, rules: Iterable[AccessRule] = (), limits: Iterable[tuple[str, str, int]] = ()
    ) -> None:
        self.rules = tuple(rules)
        self._limits = tuple(limits)

    def access(self, endpoint: str, last: Iterable[AccessRule] = ()) -> Access:
        """Return the rules of an endpoint; `last` are rules of its own, behind the others."""
        ours = [each for each in self.rules if each.endpoint in (_ANY, endpoint)]
        return Access([*ours, *last])

    def limits(self, endpoint: str, limits: EndpointLimits = DEFAULT_LIMITS) -> EndpointLimits:
        """Return the limits of an endpoint; the first of two lines about one limit counts."""
        for where, what, number in reversed(self._limits):
            if where in (_ANY, endpoint):
                limits = limits._replace(**{what: number})
        return limits

    def __add__(self, other: AccessPolicy) -> AccessPolicy:
        return AccessPolicy(self.rules + other.rules, self._limits + other._limits)


def read_policy(
    text: str, origin: str = "rules", endpoints: Collection[str] | None = None
) -> AccessPolicy:
    """Read lines of rules and limits.

    Args:
        text: The lines.
        origin: Where they come from, for errors.
        endpoints: Names of endpoints that there are; None for any.

    Raises:
        Malformed: ``ORIGIN:LINE: REASON``.
    """
    rules: list[AccessRule] = []
    limits: list[tuple[str, str, int]] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            _check_endpoint(words, endpoints)
            if words[0] == "limit":
                limits.append(_limit(words))
            else:
                rules.append(_rule(words))
        except ValueError as error:
            raise Malformed(f"{origin}:{number}: {error}") from None
        if len(rules) > _MOST_RULES:
            raise Malformed(f"{origin}:{number}: more than {_MOST_RULES} rules")
    return AccessPolicy(rules, limits)


def _rule(words: list[str]) -> AccessRule:
    if words[0] not in ("allow", "deny"):
        raise ValueError(f"expected allow, deny or limit, found {words[0][:40]}")
    if len(words) != 5:
        raise ValueError(f"expected {words[0]} ENDPOINT IDENTITY METHOD TARGET")
    _, endpoint, identity, method, target = words
    if method not in (*METHODS, _ANY):
        raise ValueError(f"expected GET, SET or *, found {method[:40]}")
    if not re.fullmatch(_PATTERN, target) or len(target) > _LONGEST:
        raise ValueError(f"not a pattern of names: {target[:40]}")
    return AccessRule(words[0] == "allow", endpoint, identity, method, target)


def _limit(words: list[str]) -> tuple[str, str, int]:
    if len(words) != 4:
        raise ValueError("expected limit ENDPOINT WHAT NUMBER")
    _, endpoint, what, number = words
    if what not in EndpointLimits._fields:
        raise ValueError(f"expected one of {' '.join(EndpointLimits._fields)}, found {what[:40]}")
    if not (number.isascii() and number.isdigit() and len(number) < 10):
        raise ValueError(f"expected a number, found {number[:40]}")
    if not int(number) and what != "rate":
        raise ValueError(f"{what} is at least 1")
    if what == "size" and int(number) > EndpointLimits().size:
        raise ValueError(f"size is at most {EndpointLimits().size}")
    return endpoint, what, int(number)


def _check_endpoint(words: list[str], endpoints: Collection[str] | None) -> None:
    if endpoints is not None and len(words) > 1 and words[1] not in (*endpoints, _ANY):
        known = " ".join(endpoints)
        raise ValueError(f"expected an endpoint ({known} or *), found {words[1][:40]}")
