"""Names the component whose code runs on this thread, to label the output of that code."""

from __future__ import annotations

from contextvars import ContextVar

current: ContextVar[str] = ContextVar("current", default="")
"""Instance name; empty where no code of a component runs. Threads that it starts inherit it."""
