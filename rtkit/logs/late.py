"""Lazy loggers: `logging` is imported at the first record.

An attached process rarely logs anything, and `logging` takes longer to import than a question
takes to be answered.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from logging import Logger


def late(name: str) -> Callable[[], Logger]:
    """Return what returns the logger of that name."""

    def logger() -> Logger:
        import logging

        return logging.getLogger(name)

    return logger
