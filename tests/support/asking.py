"""Asks services in tests: the code of an error, and what comes to hold."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import waiting

import rtkit


def code(work: Callable[[], object]) -> str:
    with pytest.raises(rtkit.PropertyError) as caught:
        work()
    return caught.value.code


def until(holds: Callable[[], object]) -> None:
    """Wait for something to hold."""
    waiting.until(holds, "it never came to hold")
