"""Parameters of system profiles: variables, conditions, included profiles, prefixes.

See decision 53.
"""

from __future__ import annotations

from typing import NamedTuple


class GivenValue(NamedTuple):
    """A value from outside of a profile.

    Attributes:
        key: A variable, or ``INSTANCE.PARAMETER`` or ``INSTANCE.SET.PARAMETER``; names of an
            included profile begin with its prefix.
        value: As text.
        origin: Where it was given, for messages.
    """

    key: str
    value: str
    origin: str


class SystemParameters(NamedTuple):
    """Values for a system profile, of those for one key the last, and a text before its names."""

    given: tuple[GivenValue, ...] = ()
    prefix: str = ""
