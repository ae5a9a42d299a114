"""Answers watches: as soon as something else is to be seen than the client knows, or in time."""

from __future__ import annotations

from dataclasses import dataclass

from rtkit.deployment.watch import Watch, look, states_to_text
from rtkit.manager.core.events import Answer, AnswerClient, Instruction, WatchAsked
from rtkit.manager.core.state import State
from rtkit.property.exchange import Reply


@dataclass(slots=True)
class _Waiting:
    watch: Watch
    answer: Answer
    until: float | None = None


class Watchers:
    """The clients that wait for a state to change; `out` collects what the shell is to do."""

    def __init__(self, state: State, out: list[Instruction]) -> None:
        self._state = state
        self._out = out
        self._waiting: list[_Waiting] = []

    def begin(self, asked: WatchAsked) -> None:
        """Take a watch in; `run` answers it."""
        self._waiting.append(_Waiting(asked.watch, asked.answer))

    def run(self, now: float) -> float | None:
        """Answer those that have to be; return when it is time for the next one [s]."""
        self._waiting = [each for each in self._waiting if not self._is_answered(each, now)]
        return min((each.until for each in self._waiting if each.until is not None), default=None)

    def dismiss(self, reply: Reply) -> None:
        """Give everybody this answer."""
        self._out += [AnswerClient(each.answer, reply) for each in self._waiting]
        self._waiting.clear()

    def _is_answered(self, each: _Waiting, now: float) -> bool:
        if each.until is None:
            each.until = now + each.watch.timeout_s
        states = look(each.watch.targets, self._state.components.get)
        if states == each.watch.known and now < each.until:
            return False
        self._out.append(AnswerClient(each.answer, Reply(states_to_text(states))))
        return True
