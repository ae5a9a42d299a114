"""Reports the start of a manager to its starter: warnings, failures, readiness.

One line each, on the descriptor whose number is in the environment; without one, in the log.
"""

from __future__ import annotations

import logging
import os

READY_VARIABLE = "RTKIT_READY"
READY = "ready"
WARNING = "warning "
FAILURE = "failure "
ERROR = "error "

_log = logging.getLogger(__name__)


class Report:
    """The way to whoever waits for the start, until it is told that it is over."""

    def __init__(self) -> None:
        number = os.environ.pop(READY_VARIABLE, "")
        self._descriptor = int(number) if number.isdigit() else None
        if self._descriptor is not None:
            os.set_inheritable(self._descriptor, False)

    @property
    def is_heard(self) -> bool:
        """Whether somebody waits."""
        return self._descriptor is not None

    def warn(self, text: str) -> None:
        """Tell what is worth knowing."""
        _log.warning("%s", text)
        self._write(WARNING + text)

    def fail(self, what: str, why: str) -> None:
        """Tell what was to be done at the start and failed."""
        _log.error("%s (%s)", what, why)
        self._write(f"{FAILURE}{what} ({why})")

    def ready(self) -> None:
        """Tell that the manager answers."""
        self._end(READY)

    def give_up(self, text: str) -> None:
        """Tell why there will be no manager."""
        self._end(ERROR + text)

    def _end(self, text: str) -> None:
        self._write(text)
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def _write(self, text: str) -> None:
        if self._descriptor is None:
            return
        try:
            os.write(self._descriptor, text.replace("\n", " ").encode("utf-8", "replace") + b"\n")
        except BrokenPipeError:
            _log.warning("nobody waits for the start any more")
