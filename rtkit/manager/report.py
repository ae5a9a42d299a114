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
    """Reports to the process that waits for the start, until told that the start is over."""

    def __init__(self) -> None:
        number = os.environ.pop(READY_VARIABLE, "")
        self._descriptor = int(number) if number.isdigit() else None
        if self._descriptor is not None:
            os.set_inheritable(self._descriptor, False)

    @property
    def is_heard(self) -> bool:
        """Return whether somebody waits."""
        return self._descriptor is not None

    def warn(self, text: str) -> None:
        """Report a warning."""
        _log.warning("%s", text)
        self._write(WARNING + text)

    def fail(self, what: str, why: str) -> None:
        """Report a failed step of the start."""
        _log.error("%s (%s)", what, why)
        self._write(f"{FAILURE}{what} ({why})")

    def ready(self) -> None:
        """Report that the manager answers."""
        self._end(READY)

    def give_up(self, text: str) -> None:
        """Report why there will be no manager."""
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
