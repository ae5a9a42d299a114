"""Standard input of a process that holds components: each component has a terminal of its own.

Nothing is opened before a component reads; see `rtkit.container.terminals` and decision 94.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterable
from threading import Lock
from typing import TYPE_CHECKING, Any, TextIO, cast

from rtkit.component.contexts.input_wait import allow_input, leave_input
from rtkit.component.current import current
from rtkit.container.operations import ContainerServices
from rtkit.deployment.message import Message

if TYPE_CHECKING:
    from rtkit.container.terminal import ComponentTerminal
    from rtkit.container.terminals import Terminals


class LazyTerminals:
    """Terminals of a process, of which nothing is loaded before one is read or looked at.

    Args:
        host: The container of the components.
        send: Sends an answer to the manager.

    Attributes:
        has_descriptor: Descriptor 0 is that of the first terminal, too.
    """

    def __init__(self, host: ContainerServices, send: Callable[[Message], object]) -> None:
        self._host = host
        self._send = send
        self._terminals: Terminals | None = None
        self.has_descriptor = False
        self._lock = Lock()

    def _all(self) -> Terminals:
        with self._lock:
            if self._terminals is None:
                from rtkit.container.terminals import Terminals

                self._terminals = Terminals(
                    self._host, self._send, has_descriptor=self.has_descriptor
                )
            return self._terminals

    def of(self, instance: str) -> ComponentTerminal:
        """Return the terminal of a component, on any thread.

        Raises:
            EOFError: The component is just being made, or ended.
        """
        return self._all().of(instance)

    def serve(self, message: Message) -> object:
        """Answer a question to a terminal."""
        return self._all().serve(message)

    def leave(self, instances: Iterable[str]) -> None:
        """End the waits of components, which are to end."""
        for instance in instances:
            leave_input(instance)

    def forget(self, instance: str) -> None:
        """End the terminal of a component that has ended, if it has one."""
        if self._terminals is not None:
            self._terminals.forget(instance)
        allow_input(instance)


class ComponentStdin(io.TextIOBase):
    """Stream that is ``sys.stdin``: for code of a component that of its terminal.

    For all other code it is what was there before.

    Args:
        terminals: The terminals of the process.
        before: What was ``sys.stdin`` until now.
    """

    def __init__(self, terminals: LazyTerminals, before: TextIO | None) -> None:
        self._terminals = terminals
        self._before: Any = io.StringIO() if before is None else before

    @property
    def _stream(self) -> Any:
        instance = current.get()
        return self._terminals.of(instance).stdin if instance else self._before

    @property
    def buffer(self) -> Any:
        """The stream as bytes."""
        return self._stream.buffer

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Encoding of the text."""
        return "utf-8"

    @property
    def name(self) -> str:
        """Name of the stream."""
        return "<stdin>"

    @property
    def mode(self) -> str:
        """Mode in which it is open."""
        return "r"

    def fileno(self) -> int:
        """Return the descriptor, for `select`, `termios` and programs that are started with it."""
        return int(self._stream.fileno())

    def isatty(self) -> bool:
        """Return whether it is a terminal: that of every component is one."""
        return bool(current.get()) or bool(self._before.isatty())

    def readable(self) -> bool:
        """Return whether it can be read: always true."""
        return True

    def read(self, size: int | None = -1, /) -> str:
        """Return so many characters, or all up to the end that a user types as Ctrl-D."""
        return str(self._stream.read(size))

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        """Return a line; an empty text at the end."""
        return str(self._stream.readline(size))

    def readlines(self, hint: int | None = -1, /) -> list[str]:  # type: ignore[override]
        """Return all lines up to the end."""
        return list(self._stream.readlines(hint))

    def writelines(self, lines: Iterable[Any], /) -> None:
        """Refuse to be written to."""
        raise io.UnsupportedOperation("not writable")

    def close(self) -> None:
        """Stay open: it belongs to all components of the process."""


def give_stdin(terminals: LazyTerminals) -> None:
    """Have components of this process read from terminals of their own."""
    sys.stdin = cast("TextIO", ComponentStdin(terminals, sys.stdin))
