"""Passes questions of clients to terminals of components, and answers back; past the core.

As events they would push all others out of the ring of last events, and they change nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import count
from time import monotonic
from typing import Any

from rtkit.deployment.message import Message
from rtkit.deployment.terminal import TERMINAL, question_from_text
from rtkit.errors import NotFound, Refused, Unreachable
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply, Request, failure

_PATIENCE_S = 2.0
"""How long a process may take to answer at once [s]."""


class _Pending:
    """A question on its way.

    Attributes:
        due_at: When it is asked again, not to wait any longer; then when it is given up [s].
    """

    def __init__(self, request: Request, key: int, message: Message) -> None:
        self.request = request
        self.key = key
        self.message = message
        self.is_last = not message["wait_s"]
        self.due_at = monotonic() + (message["wait_s"] or _PATIENCE_S)


class TerminalRelay:
    """Questions to terminals that wait for their answers.

    Args:
        state: The manager's.
        send: Sends a message to the container of a process.
    """

    def __init__(self, state: ManagerState, send: Callable[[int, Message], object]) -> None:
        self._state = state
        self._send = send
        self._pending: dict[int, _Pending] = {}
        self._numbers = count(1)

    def ask(self, request: Request) -> None:
        """Take a question.

        Raises:
            Malformed: It is none.
            NotFound: There is no such component, or nobody is behind it any more.
            Refused: Its terminal is that of whoever started it.
            Unreachable: Its process is stopped.
        """
        asked = question_from_text(request.payload or "")
        key = self._key_of(asked["instance"])
        number = next(self._numbers)
        message = {"op": TERMINAL, "number": number, **asked}
        self._pending[number] = _Pending(request, key, message)
        self._send(key, message)

    def _key_of(self, instance: str) -> int:
        state = self._state
        facts, key = state.components.get(instance), state.containers.get(instance)
        if facts is None:
            raise NotFound(f"no component named {instance}")
        if facts.zombie or key is None:
            raise NotFound(f"{instance} is a zombie ({facts.zombie or 'without a process'})")
        process = state.processes[key]
        if process.is_guest:
            raise Refused(f"{instance} was started by hand, and has the terminal of its process")
        if process.unfit:
            raise Unreachable(process.unfit)
        return key

    def take(self, key: int, message: Message) -> None:
        """Take the answer of a process; one that nobody waits for any more is ignored."""
        number: Any = message.get("number")
        pending = self._pending.get(number)
        if pending is not None and pending.key == key:
            del self._pending[number]
            answer = json.dumps(message[TERMINAL], separators=(",", ":"))
            pending.request.answer(Reply(answer))

    def ended(self, key: int, why: str) -> None:
        """Answer the questions to a process that has ended."""
        for number in [each for each, asked in self._pending.items() if asked.key == key]:
            answer = json.dumps({"ended": why}, separators=(",", ":"))
            self._pending.pop(number).request.answer(Reply(answer))

    def due_at(self) -> float | None:
        """Return when to wait no longer for an answer, monotonic [s]."""
        return min((each.due_at for each in self._pending.values()), default=None)

    def hurry(self) -> None:
        """Ask for answers that were waited for long enough; give up those that do not come then."""
        now = monotonic()
        for number, each in list(self._pending.items()):
            if now < each.due_at:
                continue
            if each.is_last:
                del self._pending[number]
                silent = Unreachable(f"{each.message['instance']} does not answer")
                each.request.answer(failure(silent))
            else:
                each.is_last, each.due_at = True, now + _PATIENCE_S
                self._send(each.key, {**each.message, "wait_s": 0.0, "input": "", "size": []})
