"""The user's terminal, joined to that of a component until the user leaves or it ends."""

from __future__ import annotations

import os
import signal
import sys
import termios
import threading
import tty
from contextlib import ExitStack, suppress
from types import FrameType
from typing import Any

from rtkit.api.attaching import TerminalClient
from rtkit.cli.shared.app import App
from rtkit.cli.shared.signals import ResizeWakeup, resizing
from rtkit.errors import RtkitError, Unreachable

_LEAVE = b"\x1d"
"""Ctrl-], as in telnet."""
_LOOK_S = 3.0
"""How long one look waits for something new [s]: who looks counts as attached for 5 s."""
_AGAIN_S = 0.5
"""How soon a manager that does not answer is asked again [s]."""
_ENDS = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
_CHUNK = 4096


class AttachedScreen:
    """Joins the terminal of a user and that of a component.

    Args:
        app: The run of the command.
        client: Asks the terminal of the component.
        typed: The path of the component, as typed.
    """

    def __init__(self, app: App, client: TerminalClient, typed: str) -> None:
        self._app = app
        self._client = client
        self._typed = typed
        self._keyboard = sys.stdin.fileno()
        self._screen = sys.stdout.fileno()
        self._before: list[Any] = []
        self._has_left = threading.Event()
        self._why = ""

    def run(self) -> int:
        """Stay until the user leaves; return the exit status: 1 where the component ended."""
        answer = self._client.look()
        with ExitStack() as stack:
            resized = stack.enter_context(resizing(is_terminal=True))
            ended = ResizeWakeup()
            stack.callback(ended.close)
            self._take(stack)
            self._note(f"at the terminal of {self._typed}; Ctrl-] leaves it{_also(answer.others)}")
            self._show(answer.output)
            self._fit()
            looking = threading.Thread(target=self._follow, args=(ended,), daemon=True)
            looking.start()
            self._pass_on(resized, ended)
            self._has_left.set()
        if self._why:
            self._app.fail(self._why)
            return 1
        return 0

    def _pass_on(self, resized: ResizeWakeup, ended: ResizeWakeup) -> None:
        """Pass on what the user types, until the user leaves or the component ends."""
        sources = [self._keyboard, resized.fileno(), ended.fileno()]
        while True:
            ready = self._app.wait_for(sources, None)
            if ended.fileno() in ready:
                return
            if resized.take():
                self._make_raw()  # the shell may have had it meanwhile
                self._fit()
            if self._keyboard not in ready:
                continue
            data = os.read(self._keyboard, _CHUNK)
            typed, leave, _ = data.partition(_LEAVE)
            if typed and not self._type(typed):
                return
            if leave or not data:
                self._note(f"left {self._typed}, which goes on")
                return

    def _type(self, data: bytes) -> bool:
        """Type something; return False where the component is no more."""
        try:
            self._client.type(data)
        except Unreachable as error:
            self._note(f"not typed: {error}")
        except RtkitError as error:
            self._why = str(error)
            return False
        return True

    def _fit(self) -> None:
        with suppress(RtkitError):  # it is told when something is typed
            size = os.get_terminal_size(self._screen)
            self._client.resize(size.lines, size.columns)

    def _follow(self, ended: ResizeWakeup) -> None:
        """Show what the component shows, also after its manager was away."""
        is_away = False
        while not self._has_left.is_set():
            try:
                answer = self._client.look(_LOOK_S)
            except Unreachable as error:
                if not is_away and not self._has_left.is_set():
                    self._note(f"no answer: {error}")
                is_away = True
                self._has_left.wait(_AGAIN_S)
                continue
            except RtkitError as error:
                self._why = str(error)
                break
            if self._has_left.is_set():
                return
            if is_away:
                self._note("it answers again")
            is_away = False
            self._show(answer.output)
            if answer.ended:
                self._why = answer.ended
                break
        ended.ring()

    def _show(self, data: bytes) -> None:
        while data:
            data = data[os.write(self._screen, data) :]

    def _note(self, text: str) -> None:
        self._show(f"\r\n[{text}]\r\n".encode("utf-8", "replace"))

    def _take(self, stack: ExitStack) -> None:
        """Have the keyboard raw, and as it was however this ends."""
        self._before = termios.tcgetattr(self._keyboard)
        stack.callback(self._give_back)
        for number in _ENDS:
            stack.callback(signal.signal, number, signal.signal(number, self._end))
        self._make_raw()

    def _make_raw(self) -> None:
        """Have the keyboard raw; what was typed already is not lost."""
        tty.setraw(self._keyboard, termios.TCSADRAIN)

    def _give_back(self) -> None:
        with suppress(termios.error):  # the terminal may be gone
            termios.tcsetattr(self._keyboard, termios.TCSADRAIN, self._before)

    def _end(self, number: int, _frame: FrameType | None) -> None:
        self._give_back()
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)


def _also(others: int) -> str:
    """Return that others are attached, too."""
    if not others:
        return ""
    return f"; {others} other{'s are' if others > 1 else ' is'} there, too"
