"""Errors of rtkit: each with its kind and its exit status.

Nothing is printed here: the command line shows messages, the daemon logs them. The exit
status is in the column ``exit``; ``--exit-detail`` selects the last one, so that a script tells
"the system is wrong" from "I could not look". Any other exception is a fault of rtkit itself.

=================================  ===========  ====  ======
error                              kind         exit  detail
=================================  ===========  ====  ======
RtkitError                         error           1       1
├─ UsageProblem                    usage           2       2
├─ Malformed (ValueError)          malformed       1       2
├─ Refused                         refused         1       1
│  └─ Denied                       denied          1       1
├─ InvalidDocument                 invalid         1       3
├─ NotFound (LookupError)          not-found       1       4
├─ Unreachable (OSError)           unreachable     1       5
├─ Impossible                      impossible      1       7
├─ LimitReached                    limit           1       8
└─ Partial                         partial         1       6
(any other exception)              bug             1      70
=================================  ===========  ====  ======
"""

from __future__ import annotations

from collections.abc import Sequence

BUG_EXIT = 70


class RtkitError(Exception):
    """Base of rtkit's errors; the message is one line: what, where (as the user typed it), hint."""

    kind = "error"
    exit_code = 1
    detail = 1


class UsageProblem(RtkitError):
    """The option parser rejected the command line."""

    kind = "usage"
    exit_code = 2
    detail = 2


class Malformed(RtkitError, ValueError):
    """A path, value or argument that cannot be read."""

    kind = "malformed"
    detail = 2


class Refused(RtkitError):
    """A precondition is not met, a deviation was found, or a required action failed."""

    kind = "refused"
    detail = 1


class Denied(Refused):
    """The user has no right to that."""

    kind = "denied"


class InvalidDocument(RtkitError):
    """A document is not well-formed or violates its schema."""

    kind = "invalid"
    detail = 3


class NotFound(RtkitError, LookupError):
    """No such manager, component, port, property or module."""

    kind = "not-found"
    detail = 4


class Unreachable(RtkitError, OSError):
    """No answer, time-out, or a lost link."""

    kind = "unreachable"
    detail = 5


class Impossible(RtkitError):
    """Nothing leads to the goal: the search was exhaustive."""

    kind = "impossible"
    detail = 7


class LimitReached(RtkitError):
    """A search was given up before it had an answer; it leaves open what is possible."""

    kind = "limit"
    detail = 8


class Partial(RtkitError):
    """Some actions were done and some failed.

    Attributes:
        failures: The error of each failed item, by the item's name as the user typed it.
    """

    kind = "partial"
    detail = 6

    def __init__(self, message: str, failures: Sequence[tuple[str, RtkitError]]) -> None:
        super().__init__(message)
        self.failures = tuple(failures)


_BY_KIND: dict[str, type[RtkitError]] = {
    error.kind: error
    for error in (
        UsageProblem,
        Malformed,
        Refused,
        Denied,
        InvalidDocument,
        NotFound,
        Unreachable,
        Impossible,
        LimitReached,
    )
}


def from_kind(kind: str, message: str) -> RtkitError:
    """Rebuild an error that travelled as (kind, message)."""
    return _BY_KIND.get(kind, RtkitError)(message)
