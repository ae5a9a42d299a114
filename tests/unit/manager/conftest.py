"""The core of a manager, driven by hand."""

from __future__ import annotations

import pytest
from fake_shell import FakeShell


@pytest.fixture
def shell() -> FakeShell:
    """A core without processes: the test plays zygote, kernel and containers."""
    return FakeShell()
