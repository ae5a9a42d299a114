"""Names the component whose code runs on this thread, so that what it prints bears its name."""

from __future__ import annotations

from contextvars import ContextVar

current: ContextVar[str] = ContextVar("current", default="")
"""Instance name; empty on threads that no component is called on, those of its own too."""
