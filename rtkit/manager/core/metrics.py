"""Requests metrics of components from processes once a second, while somebody wants them."""

from __future__ import annotations

from rtkit.deployment.metrics import METRICS, PERIOD_S, ComponentMetrics, ProcessMetrics
from rtkit.errors import Malformed
from rtkit.manager.core.events import Instruction, Publish, SendToContainer
from rtkit.manager.core.health_monitor import HealthMonitor
from rtkit.manager.core.state import ManagerState, Process
from rtkit.rtc.serde import decode, encode

_PATIENCE_S = 0.25
"""How long the answers of busy processes are waited for [s]."""


class MetricsCollector:
    """Metrics that were requested and have come; `out` collects instructions for the shell."""

    def __init__(
        self, state: ManagerState, out: list[Instruction], run_id: str, judge: HealthMonitor
    ) -> None:
        self._state = state
        self._out = out
        self._run_id = run_id
        self._judge = judge
        self._is_heard = False
        self._number = 0
        self._ask_at = 0.0
        self._tell_by: float | None = None
        self._asked: set[int] = set()
        self._unanswered: set[int] = set()
        self._answers: dict[int, tuple[ComponentMetrics, ...]] = {}

    def listen(self, has_listeners: bool) -> None:
        """Note that somebody wants metrics now, or that nobody does any more."""
        self._is_heard = has_listeners
        self._ask_at = 0.0
        self._tell_by = None

    def take_report(self, process: Process, report: object) -> None:
        """Take the metrics of a process.

        Raises:
            Malformed: They cannot be read.
        """
        if not isinstance(report, list):
            raise Malformed(f"{process.name} reports metrics that are none")
        self._unanswered.discard(process.key)
        self._asked.discard(process.key)
        self._answers[process.key] = tuple(decode(ComponentMetrics, each) for each in report)

    def run(self, now: float) -> float | None:
        """Request or publish metrics when it is time; return when it is time for the next [s]."""
        if not self._is_heard and not self._judge.is_needed:
            return None
        if self._tell_by is not None and (not self._asked or now >= self._tell_by):
            self._tell_by = None
            if self._is_heard:
                self._publish()
            self._judge.judge(self._answers, now)
        if self._tell_by is None and now >= self._ask_at:
            late_s = now - self._ask_at
            self._ask_at = now + PERIOD_S - (late_s if late_s < PERIOD_S else 0.0)
            self._tell_by = now + _PATIENCE_S
            self._ask()
        return self._ask_at if self._tell_by is None else self._tell_by

    def _ask(self) -> None:
        self._answers.clear()
        self._asked = {each.key for each in self._state.processes.values() if _answers(each)}
        # A container that has not answered yet is not asked again: requests would only pile up.
        for key in self._asked - self._unanswered:
            self._out.append(SendToContainer(key, {"op": "metrics"}))
        self._unanswered &= self._asked
        self._unanswered |= self._asked

    def _publish(self) -> None:
        self._number += 1
        processes = [
            encode(self._metrics(each))
            for each in self._state.processes.values()
            if each.is_ready and not each.is_trial
        ]
        message = {"run": self._run_id, "number": self._number, "processes": processes}
        self._out.append(Publish(METRICS, message))

    def _metrics(self, process: Process) -> ProcessMetrics:
        answer = self._answers.get(process.key)
        return ProcessMetrics(process.pid, process.name, answer is not None, answer or ())


def _answers(process: Process) -> bool:
    return process.state == "up" and not process.is_trial
