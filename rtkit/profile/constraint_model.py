"""Constraints on configuration parameters and ports, as RTC profiles hold them.

A `Constraint` holds a unit, or a list or hash of further constraints; a unit holds one test.
"""

from __future__ import annotations

from rtkit.fast_dataclass import dataclass
from rtkit.profile.common import NO_FOREIGN, Foreign


@dataclass(frozen=True, slots=True)
class Comparison:
    """A test against one value.

    Attributes:
        kind: propertyIsEqualTo, propertyIsNotEqualTo, propertyIsLessThan,
            propertyIsGreaterThan, propertyIsLessThanOrEqualTo or
            propertyIsGreaterThanOrEqualTo.
    """

    kind: str
    literal: str
    match_case: bool = False
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Between:
    """A test that a value lies between two others, both included."""

    lower_boundary: str
    upper_boundary: str
    kind: str = "propertyIsBetween"
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Like:
    """A test against a pattern with wild cards."""

    literal: str
    wild_card: str
    single_char: str
    escape_char: str
    kind: str = "propertyIsLike"
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class IsNull:
    """A test that there is no value."""

    kind: str = "propertyIsNullType"
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Logical:
    """Not (of one), And, Or (of two or more) further constraints."""

    kind: str
    constraints: tuple[Constraint, ...] = ()
    foreign: Foreign = NO_FOREIGN


ConstraintTest = Comparison | Between | Like | IsNull | Logical


@dataclass(frozen=True, slots=True)
class ConstraintUnit:
    """One test, for one value; `key` names it within a hash."""

    test: ConstraintTest
    key: str | None = None
    kind: str = "ConstraintUnitType"
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class ConstraintGroup:
    """A list (one constraint per element of a vector) or a hash (one per key).

    Attributes:
        kind: ConstraintListType or ConstraintHashType.
    """

    kind: str
    constraints: tuple[Constraint, ...] = ()
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True)
class Constraint:
    """A constraint."""

    content: ConstraintUnit | ConstraintGroup
    foreign: Foreign = NO_FOREIGN
