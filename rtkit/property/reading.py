"""Reads values from text: the grammar, in one pass without recursion into brackets.

Source: `property-service` reference, section 3. Nothing is repaired: what cannot be read is
``syntax OFFSET WHAT WAS EXPECTED``; a value over a limit is ``too-large``.
"""

from __future__ import annotations

import re

from rtkit.property.codes import PropertyError
from rtkit.property.limits import LIMITS, Budget, ValueLimits, syntax
from rtkit.property.values import Value, Word

_SHORT = 32
_LONGEST_NUMBER = 1000
"""Digits of an integer; to read one takes the square of its length."""

CONTROL = "\\x00-\\x1f\\x7f-\\x9f"
_TOKEN = re.compile(
    rf"""[ \t\r\n]*(?:
      ([^\s()<>"{{}}{CONTROL}]+)                                     # 1 number, boolean, word
    | (\()                                                           # 2
    | (\))                                                           # 3
    | ("[^"\\{CONTROL}]*(?:\\[^{CONTROL}][^"\\{CONTROL}]*)*")        # 4 string
    | (<)                                                            # 5 element
    | (\Z)                                                           # 6
    )""",
    re.VERBOSE,
)
_FLAT = re.compile(r"\([^()<>\"{}\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]*\)")
_DECIMAL = r"[+-]?\d+\.\d+(?:e[+-]?\d+)?"
_VECTOR = re.compile(rf"\({_DECIMAL}(?: {_DECIMAL})*\)", re.ASCII)
"""A group of numbers as they are written here, which needs no look at each."""
_NUMBER = re.compile(r"[+-]?(?:(\d+)|(?:\d+\.\d*|\.?\d+)(?:[eE][+-]?\d+)?|inf)|nan", re.ASCII)
_ESCAPE = re.compile(r"\\(?:([\"\\nrt])|u\{([0-9A-Fa-f]{1,6})\}|)")
_ESCAPED = {'"': '"', "\\": "\\", "n": "\n", "r": "\r", "t": "\t"}


def read(text: str, limits: ValueLimits = LIMITS) -> Value:
    """Return the value that a text stands for; the empty text is the empty string.

    Raises:
        PropertyError: ``syntax`` or ``too-large``.
    """
    if len(text) > limits.text:
        raise PropertyError("too-large", f"longer than {limits.text} characters")
    number = lone_number(text)
    return number if number is not None else read_item(text, 0, Budget(limits))


def lone_number(text: str) -> float | None:
    """Return the number that a text is, None if it is none or a long one.

    What is set is most often one, and as often as a loop turns.
    """
    number = _NUMBER.fullmatch(text) if len(text) < _SHORT else None
    if number is None:
        return None
    return int(text) if number.lastindex else float(text)


def read_item(text: str, depth: int, budget: Budget) -> Value:
    """Read a whole text as one item that lies `depth` deep in another one."""
    if _FLAT.fullmatch(text) and text.isascii():
        return _flat(text, depth, budget)
    match = _TOKEN.match
    open_groups: list[list[Value]] = []
    done: Value | None = None
    position = 0
    while True:
        token = match(text, position)
        if token is None:
            raise syntax(*_unreadable(text, position))
        kind = token.lastindex
        start, position = token.start(kind or 0), token.end()
        if kind == 6:
            break
        if done is not None:
            raise syntax(start, "expected the end of the text")
        item: Value
        if kind == 1:
            # Counted without a call: nearly all there is are atoms, and they are no deeper.
            budget.items += 1
            item = _atom(token[1], start)
        elif kind == 2:
            budget.spend(depth + len(open_groups) + 1)
            open_groups.append([])
            continue
        elif kind == 3:
            if not open_groups:
                raise syntax(start, "unexpected )")
            budget.check()
            item = tuple(open_groups.pop())
        elif kind == 4:
            budget.items += 1
            item = _string(token[4], start)
        else:
            from rtkit.property.elements import read_element  # seldom needed: seven patterns

            level = depth + len(open_groups) + 1
            item, position = read_element(text, start, level, budget, read_item)
        if open_groups:
            open_groups[-1].append(item)
        else:
            done = item
    if open_groups:
        raise syntax(len(text), "expected )")
    return "" if done is None else done


def _flat(text: str, depth: int, budget: Budget) -> Value:
    """Read a group of nothing but atoms, as most large ones are."""
    budget.spend(depth + 1)
    tokens = text[1:-1].split()
    budget.items += len(tokens)
    budget.check()
    if _VECTOR.fullmatch(text):
        return tuple(map(float, tokens))
    atom = _atom
    return tuple([atom(token, 0) for token in tokens])


def _atom(token: str, offset: int) -> Value:
    if token[0] in "+-.0123456789in":
        number = _NUMBER.fullmatch(token)
        if number is not None:
            if number[1] is None:
                return float(token)
            if len(token) > _LONGEST_NUMBER:
                raise PropertyError(
                    "too-large", f"an integer of more than {_LONGEST_NUMBER} digits"
                )
            return int(token)
    if token == "true":
        return True
    if token == "false":
        return False
    if not token.isprintable():
        bad = next(index for index, c in enumerate(token) if not c.isprintable())
        raise syntax(offset + bad, "unexpected character")
    return Word(token)


def _string(token: str, offset: int) -> str:
    if "\\" not in token:
        return token[1:-1]

    def character(match: re.Match[str]) -> str:
        if match[1]:
            return _ESCAPED[match[1]]
        code = int(match[2], 16) if match[2] else -1
        if not 0 <= code <= 0x10FFFF or 0xD800 <= code < 0xE000:
            raise syntax(offset + match.start(), "unknown escape")
        return chr(code)

    return _ESCAPE.sub(character, token[:-1])[1:]


def _unreadable(text: str, position: int) -> tuple[int, str]:
    """Return where the unreadable character is, and what was expected there."""
    while position < len(text) and text[position] in " \t\r\n":
        position += 1
    if text[position] != '"':
        return position, "unexpected character"
    cursor = position + 1
    while cursor < len(text) and not re.match(f"[{CONTROL}]", text[cursor]):
        cursor += 2 if text[cursor] == "\\" else 1
    return min(cursor, len(text)), 'expected "'
