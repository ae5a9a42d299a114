"""Asks the terminal of a component: looks at it, types, and waits until that was read."""

from __future__ import annotations

from collections.abc import Iterable
from time import monotonic
from typing import TYPE_CHECKING

from rtkit.deployment.terminal import LONGEST_LINE, LONGEST_WAIT_S
from rtkit.errors import Malformed, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.deployment.terminal import TerminalAnswer
    from rtkit.tree.client import Tree

_FULL_S = 0.5
"""How long to wait for room where a terminal takes no more [s]."""


class TerminalClient:
    """One who looks at the terminal of a component, and types.

    Args:
        tree: Connection to the manager of the component.
        instance: The component.
        is_attached: It stays, which others are told.

    Attributes:
        last: The last answer.
    """

    def __init__(self, tree: Tree, instance: str, *, is_attached: bool = False) -> None:
        from rtkit.deployment.terminal import TerminalAnswer
        from rtkit.tree.client import request_id

        self._tree = tree
        self._instance = instance
        self._who = request_id()
        self._is_attached = is_attached
        self.last = TerminalAnswer(after=-1)

    def look(self, wait_s: float = 0.0) -> TerminalAnswer:
        """Return what was shown since the last look; wait so long for something new [s].

        Raises:
            NotFound: There is no such component.
            Unreachable: Its manager does not answer.
        """
        known = self.last
        self.last = self._ask(after=known.after, waits=known.waits, wait_s=wait_s)
        return self.last

    def type(self, data: bytes) -> None:
        """Type something, when there is room for it.

        Raises:
            NotFound: The component is no more.
            Unreachable: Its manager does not answer.
        """
        for begin in range(0, len(data), LONGEST_LINE):
            text = data[begin : begin + LONGEST_LINE].decode("latin-1")
            while (answer := self._ask(input=text)).is_full:
                self._await_read(_FULL_S)
            self._check(answer)

    def resize(self, lines: int, columns: int) -> None:
        """Have the terminal know the size of the window of its user [characters]."""
        self._ask(size=[lines, columns])

    def send(self, lines: Iterable[bytes], timeout_s: float) -> None:
        """Type lines and wait until the component has read all of them.

        Raises:
            Malformed: A line is longer than a terminal takes.
            Refused: They are not all read in time; what is left stays there to be read.
            NotFound: The component is no more.
        """
        for line in lines:
            whole = line.rstrip(b"\r\n") + b"\n"
            if len(whole) > LONGEST_LINE:
                most = LONGEST_LINE - 1
                raise Malformed(f"a line of {len(whole) - 1} bytes: a terminal takes {most}")
            self.type(whole)
        answer = self._await_read(timeout_s)
        if answer.unread:
            left = f"{answer.unread} bytes of it stay there to be read"
            raise Refused(f"{self._instance} has not read it within {timeout_s:g} s: {left}")

    def _await_read(self, timeout_s: float) -> TerminalAnswer:
        until = monotonic() + timeout_s
        while True:
            wait_s = min(max(0.0, until - monotonic()), LONGEST_WAIT_S)
            answer = self._ask(is_until_read=True, wait_s=wait_s)
            self._check(answer)
            if not answer.unread or monotonic() >= until:
                return answer

    def _ask(self, **question: object) -> TerminalAnswer:
        fixed = {
            "instance": self._instance,
            "who": self._who,
            "is_attached": self._is_attached,
            "after": self.last.after,
        }
        return self._tree.ask_terminal({**fixed, **question})

    @staticmethod
    def _check(answer: TerminalAnswer) -> None:
        if answer.ended:
            raise NotFound(answer.ended)
