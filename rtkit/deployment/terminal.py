"""Contract of terminals: what is asked of the terminal of a component, and what it answers.

A question is plain data, which travels through the manager to the process of the component:

- ``instance``: the component; ``who``: an id of whoever asks;
- ``after``: the number of bytes shown so far; below 0 for the last lines;
- ``input``: what is typed; ``size``: lines and columns, where they have changed;
- ``wait_s``: how long to wait for something new [s]; ``waits``: what was answered last;
- ``is_until_read``: wait until all that was typed has been read, and for nothing else;
- ``is_attached``: whoever asks stays.

Bytes travel as texts of characters below 256.
"""

from __future__ import annotations

import json
import math
from typing import Any

from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass

TERMINAL = "terminal"
"""The view of a manager, the operation of a container, and what it answers."""
LONGEST_WAIT_S = 30.0
LONGEST_LINE = 4095
"""Longest line that a terminal takes, with its end, as Linux has it [bytes]."""
_MOST_TYPED = 1 << 15


@dataclass(frozen=True, slots=True)
class TerminalAnswer:
    """Answer of a terminal.

    Attributes:
        output: What was shown since.
        after: Number of bytes shown so far.
        waits: ``waiting for input since 12:00:00``; empty where the component does not wait.
        unread: How much of what was typed has not been read yet [bytes].
        is_full: It takes no more before some of that is read; nothing of the input was taken.
        others: How many others are attached.
        ended: Why there is no such terminal any more; empty while there is.
    """

    output: bytes = b""
    after: int = 0
    waits: str = ""
    unread: int = 0
    is_full: bool = False
    others: int = 0
    ended: str = ""


def question_from_text(text: str) -> dict[str, Any]:
    """Read a question.

    Raises:
        Malformed: It is none.
    """
    try:
        asked: dict[str, Any] = dict(json.loads(text))
        known: dict[str, Any] = {
            "instance": str(asked["instance"]),
            "who": str(asked.get("who", ""))[:64],
            "after": int(asked.get("after", -1)),
            "input": str(asked.get("input", "")),
            "waits": str(asked.get("waits", "")),
            "wait_s": float(asked.get("wait_s", 0.0)),
            "is_until_read": bool(asked.get("is_until_read")),
            "is_attached": bool(asked.get("is_attached")),
            "size": [int(each) & 0xFFFF for each in asked.get("size") or ()],
        }
        known["input"].encode("latin-1")
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        raise Malformed(f"no question to a terminal: {error}") from None
    if len(known["input"]) > _MOST_TYPED or not math.isfinite(known["wait_s"]):
        raise Malformed(f"no question to a terminal: more than {_MOST_TYPED} bytes at once")
    if len(known["size"]) not in (0, 2):
        raise Malformed("no question to a terminal: a size is lines and columns")
    known["wait_s"] = min(max(0.0, known["wait_s"]), LONGEST_WAIT_S)
    return known


def answer_from_text(text: str) -> TerminalAnswer:
    """Read an answer.

    Raises:
        Malformed: It cannot be read.
    """
    try:
        read = dict(json.loads(text))
        return TerminalAnswer(
            output=str(read.get("output", "")).encode("latin-1"),
            after=int(read.get("after", 0)),
            waits=str(read.get("waits", "")),
            unread=int(read.get("unread", 0)),
            is_full=bool(read.get("is_full")),
            others=int(read.get("others", 0)),
            ended=str(read.get("ended", "")),
        )
    except (TypeError, ValueError) as error:
        raise Malformed(f"the answer of the terminal cannot be read: {error}") from error
