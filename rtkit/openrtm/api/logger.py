"""Log buffers of components, which write to the log of the process."""

from __future__ import annotations

import logging
from typing import Any

_VERBOSE = 5


class Logger:
    """A logger with OpenRTM's levels: a text, and what its ``%`` signs stand for."""

    SILENT, FATAL, ERROR, WARN, INFO, DEBUG, TRACE, VERBOSE, PARANOID = range(9)

    def __init__(self, name: str) -> None:
        self._logger = logging.getLogger(name)

    def _log(self, level: int, message: Any, arguments: tuple[Any, ...]) -> None:
        if self._logger.isEnabledFor(level):
            self._logger.log(level, "%s", _text(message, arguments))

    def RTC_FATAL(self, message: Any, *arguments: Any) -> None:
        """Log what ends the work."""
        self._log(logging.CRITICAL, message, arguments)

    def RTC_ERROR(self, message: Any, *arguments: Any) -> None:
        """Log an error."""
        self._log(logging.ERROR, message, arguments)

    def RTC_WARN(self, message: Any, *arguments: Any) -> None:
        """Log a warning."""
        self._log(logging.WARNING, message, arguments)

    def RTC_INFO(self, message: Any, *arguments: Any) -> None:
        """Log news."""
        self._log(logging.INFO, message, arguments)

    def RTC_DEBUG(self, message: Any, *arguments: Any) -> None:
        """Log what helps to find mistakes."""
        self._log(logging.DEBUG, message, arguments)

    def RTC_TRACE(self, message: Any, *arguments: Any) -> None:
        """Log each step."""
        self._log(_VERBOSE, message, arguments)

    RTC_VERBOSE = RTC_PARANOID = RTC_TRACE

    def setLevel(self, level: str) -> None:
        """Leave the level to the properties of the manager."""

    @staticmethod
    def print_exception() -> str:
        """Return the present exception as Python prints it."""
        import traceback

        return traceback.format_exc()


def _text(message: Any, arguments: tuple[Any, ...]) -> str:
    given = arguments[0] if len(arguments) == 1 else arguments
    try:
        return str(message) % given if arguments else str(message)
    except (TypeError, ValueError):
        return f"{message} {arguments}"
