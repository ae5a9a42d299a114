"""Terminals of the components of a process: made when they are read, or looked at, first."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from threading import Lock
from time import monotonic
from typing import Any

from rtkit.component.current import current
from rtkit.container.operations import LATER, ContainerServices
from rtkit.container.terminal import ComponentTerminal
from rtkit.deployment.message import Message
from rtkit.deployment.terminal import TERMINAL
from rtkit.errors import NotFound
from rtkit.logs.logs import Printed

_STAYS_S = 5.0
"""How long whoever asked last counts as attached [s]."""


class Terminals:
    """The terminals of one process, and the questions that wait for news of them.

    Args:
        host: The container.
        send: Sends an answer to the manager, on the container's thread.
        has_descriptor: Descriptor 0 becomes that of the first terminal, too: for programs that a
            component starts, and C code.
    """

    def __init__(
        self,
        host: ContainerServices,
        send: Callable[[Message], object],
        *,
        has_descriptor: bool = False,
    ) -> None:
        self._has_descriptor = has_descriptor
        self._owner = ""
        self._host = host
        self._send = send
        self._terminals: dict[str, ComponentTerminal] = {}
        self._questions: dict[str, dict[int, Message]] = {}
        self._attached: dict[str, dict[str, float]] = {}
        self._lock = Lock()
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, Printed):
                stream.tap = self._printed

    def of(self, instance: str) -> ComponentTerminal:
        """Return the terminal of a component, on any thread.

        Raises:
            EOFError: The component is just being made, or ended.
        """
        terminal = self._terminals.get(instance)
        if terminal is None:
            with self._lock:
                terminal = self._terminals.get(instance)
                if terminal is None:
                    terminal = self._terminals[instance] = self._made(instance)
        return terminal

    def _made(self, instance: str) -> ComponentTerminal:
        try:
            component = self._host.component(instance)
        except NotFound:
            why = "nobody can answer it then: let it read while it is active"
            raise EOFError(f"{instance} reads stdin while it is made, or ends: {why}") from None
        terminal = ComponentTerminal(
            instance,
            lambda: self._host.post(lambda: self._host.report(component)),
            lambda: self._news(instance),
        )
        if self._has_descriptor and not self._owner:
            self._owner = instance
            os.dup2(terminal.descriptor, 0)
        if isinstance(sys.stdout, Printed) and current.get() == instance:
            terminal.show_text(sys.stdout.recent())
        return terminal

    def _printed(self, text: str) -> None:
        terminal = self._terminals.get(current.get())
        if terminal is not None:
            terminal.show_text(text)

    def forget(self, instance: str) -> None:
        """End the terminal of a component that has ended."""
        terminal = self._terminals.pop(instance, None)
        if terminal is not None:
            self._take_descriptor(instance)
            terminal.close()
        self._attached.pop(instance, None)
        for message in self._questions.pop(instance, {}).values():
            self._answer(message, {"ended": f"{instance} has ended"})

    def _take_descriptor(self, instance: str) -> None:
        """Have descriptor 0 lead nowhere again, where it led to the terminal of a component."""
        if self._owner == instance:
            self._owner = ""
            nowhere = os.open(os.devnull, os.O_RDONLY)
            os.dup2(nowhere, 0)
            os.close(nowhere)

    # questions

    def serve(self, message: Message) -> object:
        """Answer a question to a terminal, at once or when there is something new."""
        instance = message["instance"]
        try:
            self._host.component(instance)
        except NotFound as error:
            self._answer(message, {"ended": str(error)})
            return LATER
        terminal = self.of(instance)
        if message["size"]:
            terminal.resize(*message["size"])
        if message["is_attached"]:
            self._attached.setdefault(instance, {})[message["who"]] = monotonic()
        is_taken = not message["input"] or terminal.take(message["input"].encode("latin-1"))
        if is_taken and message["wait_s"] and not self._is_due(message, terminal):
            self._questions.setdefault(instance, {})[message["number"]] = message
        else:
            self._questions.get(instance, {}).pop(message["number"], None)
            self._answer(message, {**self._state(message, terminal), "is_full": not is_taken})
        return LATER

    def _news(self, instance: str) -> None:
        """See who waits for what is new at a terminal; on any thread."""
        if self._questions.get(instance):
            self._host.post(lambda: self._review(instance))

    def _review(self, instance: str) -> None:
        terminal, questions = self._terminals.get(instance), self._questions.get(instance, {})
        for number, message in list(questions.items()) if terminal is not None else ():
            if terminal is not None and self._is_due(message, terminal):
                del questions[number]
                self._answer(message, self._state(message, terminal))

    @staticmethod
    def _is_due(message: Message, terminal: ComponentTerminal) -> bool:
        if message["is_until_read"]:
            return terminal.unread == 0
        is_new = terminal.end != message["after"]  # it may be that of an earlier terminal
        return bool(is_new or terminal.wait != message["waits"])

    def _state(self, message: Message, terminal: ComponentTerminal) -> dict[str, Any]:
        now_s, attached = monotonic(), self._attached.get(message["instance"], {})
        for who in [who for who, at_s in attached.items() if now_s > at_s + _STAYS_S]:
            del attached[who]
        end = terminal.end
        return {
            "output": terminal.since(message["after"]).decode("latin-1"),
            "after": end,
            "waits": terminal.wait,
            "unread": terminal.unread,
            "others": len(attached.keys() - {message["who"]}),
        }

    def _answer(self, message: Message, state: dict[str, Any]) -> None:
        self._send({TERMINAL: state, "number": message["number"]})
