"""Values that return by themselves: a velocity goes back to zero when nobody sets it any more."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from rtkit.property.codes import PropertyError
from rtkit.property.property_spec import PropertySpec
from rtkit.property.types import Content, parse_type
from rtkit.property.user_code import UserCode
from rtkit.property.values import is_number

TIMEOUT = PropertySpec(
    parse_type("number"), unit="s", minimum=0.0, doc="Time after the last SET until it returns"
)


class Returning:
    """Return of one property, some time after the last SET.

    Args:
        name: Of the property.
        read: Returns the present value.
        apply: Puts a value in force.
        user_code: Calls both in their turn.
        after: How long after [s]; infinity for never.
        to: The value; None for the one that it has before it is set first.
    """

    def __init__(
        self,
        name: str,
        read: Callable[[], Content],
        apply: Callable[[Content], None],
        user_code: UserCode,
        after: float,
        to: Content | None,
    ) -> None:
        self.after = after
        self._name = name
        self._read = read
        self._apply = apply
        self._user_code = user_code
        self._to = to
        self._cancel: Callable[[], object] | None = None
        self._planned: object = None
        self._is_returning = False

    def before_set(self) -> None:
        """Learn the value to return to.

        Raises:
            PropertyError: It cannot be read.
        """
        if self._to is None:
            self._to = self._read()

    def was_set(self) -> None:
        """Return later than was planned."""
        if not self._is_returning:
            self._user_code.post(self._plan)

    def _plan(self) -> None:
        if self._cancel is not None:
            self._cancel()
        self._cancel = None
        if self.after < inf:
            planned = object()
            take_back = self._user_code.refuse_after(self.after, lambda _late: self._queue(planned))
            self._planned, self._cancel = planned, take_back

    def _queue(self, planned: object) -> None:
        go, again = lambda: self._go(planned), lambda _late: self._plan()
        self._user_code.later(self._name, go, again, 0.0)

    def _go(self, planned: object) -> None:
        if planned is not self._planned or self._to is None:
            return  # it was set meanwhile
        self._is_returning, self._cancel = True, None
        try:
            self._apply(self._to)
        except PropertyError:
            self._plan()  # a moving value is not to move on: once more
        finally:
            self._is_returning = False

    def read_timeout(self, _given: object) -> float:
        """Return the time-out [s]."""
        return self.after

    def write_timeout(self, value: Content, _given: object) -> None:
        """Set the time-out [s]; it holds at once.

        Raises:
            PropertyError: ``bad-value``: it is not positive and finite.
        """
        assert is_number(value)
        if not 0 < value < inf:  # type: ignore[operator]
            raise PropertyError("bad-value", f"a time-out is positive and finite, not {value!r}")
        self.after = float(value)  # type: ignore[arg-type]
        if self._cancel is not None:
            self.was_set()
