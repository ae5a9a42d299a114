"""Asks processes what their ports carry, for clients that look; past the core.

Clients ask many times a second. As events these questions would push all others out of the ring of
last events, and they change nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import count
from time import monotonic
from typing import Any

from rtkit.deployment.message import Message
from rtkit.deployment.port_samples import SAMPLES, PortName, ports_from_text
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply, Request

_PATIENCE_S = 0.25
"""How long the answers of busy processes are waited for [s]."""

Send = Callable[[int, Message], object]
"""Sends a message to the container of a process."""


class _Question:
    """A question of a client, and what has been answered so far."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self.give_up_at = monotonic() + _PATIENCE_S
        self.asked: set[int] = set()
        self.samples: list[Any] = []

    def answer(self) -> None:
        self.request.answer(Reply(json.dumps(self.samples, separators=(",", ":"))))


class PortSampler:
    """Questions that wait for answers of processes."""

    def __init__(self, state: ManagerState, send: Send) -> None:
        self._state = state
        self._send = send
        self._questions: dict[int, _Question] = {}
        self._numbers = count(1)
        self._silent: set[int] = set()

    def ask(self, request: Request) -> None:
        """Take a question.

        Raises:
            Malformed: It is none.
        """
        ports: dict[int, list[PortName]] = {}
        for instance, port in ports_from_text(request.payload or ""):
            key = self._state.containers.get(instance)
            process = self._state.processes.get(key) if key is not None else None
            if key is not None and process is not None and process.state == "up":
                ports.setdefault(key, []).append((instance, port))
        self._silent &= self._state.processes.keys()
        number, question = next(self._numbers), _Question(request)
        # One that has not answered yet is not asked again: questions would only pile up.
        question.asked = ports.keys() - self._silent
        if not question.asked:
            question.answer()
            return
        self._questions[number] = question
        for key in question.asked:
            self._send(key, {"op": SAMPLES, "number": number, "ports": ports[key]})

    def take(self, key: int, message: Message) -> None:
        """Take the answer of a process; one that is late only shows that it answers again."""
        self._silent.discard(key)
        number: Any = message.get("number")
        question = self._questions.get(number)
        if question is None or key not in question.asked:
            return
        question.asked.discard(key)
        question.samples += message[SAMPLES]
        if not question.asked:
            del self._questions[number]
            question.answer()

    def due_at(self) -> float | None:
        """Return when to wait no longer for an answer, monotonic [s]."""
        return min((each.give_up_at for each in self._questions.values()), default=None)

    def give_up(self) -> None:
        """Answer without the processes that do not answer in time."""
        now = monotonic()
        for number, question in list(self._questions.items()):
            if now >= question.give_up_at:
                del self._questions[number]
                self._silent |= question.asked
                question.answer()
