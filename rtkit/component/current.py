"""Names the component whose code runs on this thread, to label the output of that code."""

from __future__ import annotations

from contextvars import ContextVar

current: ContextVar[str] = ContextVar("current", default="")
"""Instance name; empty on threads that no component is called on, those of its own too."""
