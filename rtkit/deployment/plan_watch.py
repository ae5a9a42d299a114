"""Receives what becomes of the steps of a plan under way: for programs, as records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

BEGUN, DONE, HELD, FAILED = "begun", "done", "held", "failed"
"""What becomes of a step; one that `HELD` took no action, as all was so already."""

Write = Callable[[str, Mapping[str, Any]], None]
"""Receives the kind of a record, and its fields."""


class PlanWatch:
    """Receives plans that are carried out, then what becomes of each step, as records."""

    def __init__(self, write: Write) -> None:
        """Have `write` receive the records."""
        self._write = write
        self._steps: Mapping[str, Mapping[str, Any]] = {}
        self._reported: set[str] = set()

    def plan(self, record: Mapping[str, Any], reason: str = "") -> None:
        """Receive a plan; `reason` states why it was made while another one was carried out."""
        self._steps = {step["text"]: step for step in record["steps"]}
        self._reported.clear()
        self._write("plan", {**record, "reason": reason} if reason else record)

    def step(self, text: str, state: str, took_s: float | None = None, why: str = "") -> None:
        """Receive what becomes of the step of the latest plan that has this text."""
        known = self._steps.get(text)
        if known is not None:
            self._reported.add(text)
            fields = {key: known[key] for key in ("number", "layer", "kind", "subject", "text")}
            took = round(took_s, 6) if took_s else None
            self._write("step", {**fields, "state": state, "took_s": took, "why": why})

    def reached(self) -> None:
        """Receive that all is as planned: steps of which nothing was told were not needed."""
        for text in [each for each in self._steps if each not in self._reported]:
            self.step(text, HELD)
