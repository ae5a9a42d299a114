"""The operator's language: sentences such as ``take A to (9 3)`` become commands, as plain data.

A place is ``(x y)``; a name is one or more words, an article before it is dropped. In the call of a
defined command each argument is a place or one word; a name of several words stands in quotes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from difflib import get_close_matches
from itertools import pairwise
from typing import NamedTuple

from rtkit.errors import Malformed

Place = tuple[int, int]
_TOKEN = re.compile(
    r'\(\s*(-?\d+)[\s,]+(-?\d+)\s*\)|"([^"]+)"|(;)|(=)|([^\s();="]+)|(\S)', re.ASCII
)
_ARTICLES = ("the", "a", "an")
RELATIONS = ("near", "beside", "left of", "right of", "above", "below")
TURNS = {"lengthwise": 0, "crosswise": 1}
"""How a bar may lie: as it was designated, or a quarter turn from that."""
KINDS = ("object", "bar", "wall", "place", "region")
_BUILT_IN = ("designate", "forget", "define", "go", "pick", "take", "leave", "cancel")
_IT = "it"


class Target(NamedTuple):
    """Goal place, perhaps a fuzzy one.

    Attributes:
        relation: ``at``, ``in``, ``was``, or one of `RELATIONS`.
        name: What it is relative to; empty where a place is given.
        turn: How a bar is to lie, one of `TURNS`; empty for either.
    """

    relation: str
    place: Place | None = None
    name: str = ""
    turn: str = ""

    def __str__(self) -> str:
        turn = f" {self.turn}" if self.turn else ""
        if self.relation == "at":
            return f"{text_of(self.place) if self.place else self.name}{turn}"
        if self.relation == "was":
            return f"where {self.name} was{turn}"
        return f"{self.relation} {self.name}{turn}"


class Go(NamedTuple):
    """Go with what is held, or empty."""

    target: Target

    def __str__(self) -> str:
        return f"go to {self.target}"


class PickUp(NamedTuple):
    """Pick an object up and hold it."""

    name: str

    def __str__(self) -> str:
        return f"pick up {self.name}"


class Take(NamedTuple):
    """Take an object to a place; what blocks the way goes into a region, if one is named."""

    name: str
    target: Target
    into: str = ""

    def __str__(self) -> str:
        into = f" clearing into {self.into}" if self.into else ""
        to = "to " if self.target.relation in ("at", "was") else ""
        return f"take {self.name} {to}{self.target}{into}"


class Call(NamedTuple):
    """Call a defined command; each argument is a place or a name."""

    name: str
    arguments: tuple[Place | str, ...]

    def __str__(self) -> str:
        return " ".join([self.name, *(text_of(each) for each in self.arguments)])


class Designate(NamedTuple):
    """Make something known to the site: its kind, its places, its name (empty: it is asked)."""

    kind: str
    places: tuple[Place, ...]
    name: str


class Forget(NamedTuple):
    """Forget a name: an object, a place, a region or a defined command."""

    name: str


class Define(NamedTuple):
    """Define a command by others."""

    name: str
    parameters: tuple[str, ...]
    body: str


class Cancel(NamedTuple):
    """Drop all tasks and their questions."""


Task = Go | PickUp | Take | Call
Sentence = Task | Designate | Forget | Define | Cancel
Token = Place | str
_PUNCTUATION = (";", "=")


class _Quoted(str):
    """Name of several words, written in quotes."""


def text_of(token: Token) -> str:
    """Return a place or a name as it is typed in a call."""
    if isinstance(token, tuple):
        return f"({token[0]} {token[1]})"
    return f'"{token}"' if " " in token else token


def tokens_of(text: str) -> list[Token]:
    """Return the places, words and marks of a text.

    Raises:
        Malformed: There is a character that belongs to none of these.
    """
    found: list[Token] = []
    for match in _TOKEN.finditer(text):
        x, y, quoted, end, equals, word, other = match.groups()
        if other:
            raise Malformed(f"cannot read {text[match.start() :][:20]!r}: a place is (x y)")
        if x is not None:
            found.append((int(x), int(y)))
        else:
            found.append(_Quoted(quoted) if quoted else end or equals or word)
    return found


def parse(text: str, defined: Mapping[str, Sequence[str]]) -> Sentence:
    """Return what a sentence says; `defined` has the parameters of each defined command.

    Raises:
        Malformed: It says nothing that is known; the message states what was expected.
    """
    tokens = tokens_of(text)
    if tokens and tokens[0] == "define":
        return _define(text, tokens)
    if ";" in tokens:
        raise Malformed("one command at a time: ';' joins commands in a definition only")
    return command_of(tokens, defined)


def body_of(
    body: str,
    parameters: Sequence[str],
    arguments: Sequence[Token],
    defined: Mapping[str, Sequence[str]],
    new: str = "",
) -> list[Task]:
    """Return the commands of a definition with its arguments in place of its parameters.

    `new` is the name that is just being defined: no hint names it.

    Raises:
        Malformed: One of them is no command that moves anything.
    """
    given = dict(zip(parameters, arguments, strict=True))
    commands: list[Task] = []
    part: list[Token] = []
    for token in [*tokens_of(body), ";"]:
        if token != ";":
            part.append(given.get(token, token) if isinstance(token, str) else token)
            continue
        if not part:
            raise Malformed("there is no command between two ';' or at an end")
        command = command_of(part, defined, new)
        if isinstance(command, Designate | Forget | Define | Cancel):
            raise Malformed(f"{part[0]} is for the operator, not for a definition")
        commands.append(command)
        part = []
    return commands


def command_of(
    tokens: Sequence[Token], defined: Mapping[str, Sequence[str]], new: str = ""
) -> Sentence:
    """Return the command that tokens make.

    Raises:
        Malformed: They make none.
    """
    if not tokens or not isinstance(tokens[0], str):
        raise Malformed("a command begins with a word")
    verb, rest = tokens[0], list(tokens[1:])
    if verb in defined:
        return _call(verb, rest, defined[verb])
    parsers: dict[str, Callable[[list[Token]], Sentence]] = {
        "designate": _designate, "forget": lambda r: Forget(_name(r, "forget")), "go": _go,
        "pick": _pick, "take": _take, "leave": _leave, "put": _leave, "cancel": _cancel,
    }  # fmt: skip
    if verb not in parsers:
        known = [each for each in (*_BUILT_IN, *defined) if each != new]
        near = get_close_matches(verb, known, 1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise Malformed(f"no such command: {verb}{hint}")
    return parsers[verb](rest)


def _call(name: str, rest: list[Token], parameters: Sequence[str]) -> Call:
    if len(rest) != len(parameters):
        wanted = " ".join([name, *parameters])
        raise Malformed(f"{name} takes {len(parameters)} arguments, not {len(rest)}: {wanted}")
    return Call(name, tuple(each if isinstance(each, tuple) else str(each) for each in rest))


def _define(text: str, tokens: list[Token]) -> Define:
    head, mark, body = text.partition("=")
    words = [str(each) for each in tokens_of(head)[1:]]
    if not mark or not words or not body.strip():
        raise Malformed("a definition is: define NAME PARAMETER... = COMMAND; COMMAND...")
    name, *parameters = words
    if name in _BUILT_IN or name == "put":
        raise Malformed(f"{name} is a command already")
    if len({*parameters}) < len(parameters):
        raise Malformed(f"{name}: two parameters have one name")
    return Define(name, tuple(parameters), " ".join(body.split()))


def _designate(rest: list[Token]) -> Designate:
    kind = rest.pop(0) if rest else ""
    if kind not in KINDS:
        raise Malformed(f"designate one of: {', '.join(KINDS)}")
    if rest and rest[0] == "at":
        rest.pop(0)
    places: list[Place] = []
    while rest and isinstance(rest[0], tuple):
        places.append(rest[0])
        rest = rest[1:]
    if not places:
        raise Malformed(f"designate {kind} at (x y) NAME: there is no place")
    if kind == "wall":
        if rest:
            raise Malformed("a wall has no name")
        return Designate(kind, tuple(places), "")
    if kind == "place" and len(places) > 1:
        raise Malformed("a place is one place: several are a region")
    return Designate(str(kind), tuple(places), _name(rest, str(kind)) if rest else "")


def _go(rest: list[Token]) -> Go:
    if rest and rest[0] == "to":
        rest.pop(0)
    return Go(_target(rest, "go to"))


def _pick(rest: list[Token]) -> PickUp:
    if not rest or rest[0] != "up":
        raise Malformed("pick up NAME")
    return PickUp(_name(rest[1:], "pick up"))


def _take(rest: list[Token]) -> Take:
    words = [str(each) for each in rest]
    starts = [n for n, word in enumerate(words) if word in ("to", "in", "into", *_FIRSTS)]
    if not starts or not starts[0]:
        raise Malformed("take NAME to (x y), to REGION, or near NAME")
    first = starts[0]
    into = ""
    if "clearing" in words[first:]:
        last = words.index("clearing", first)
        into = _name(rest[last + 2 :], "clearing into") if words[last + 1 :] else ""
        if words[last + 1 : last + 2] != ["into"]:
            raise Malformed("what blocks the way goes where: clearing into REGION")
        rest = rest[:last]
    return Take(_name(rest[:first], "take"), _target(rest[first:], "take NAME to"), into)


def _leave(rest: list[Token]) -> Take:
    if not rest or rest[0] != _IT:
        raise Malformed("leave it at (x y), in REGION, or near NAME")
    return Take(_IT, _target(rest[1:], "leave it at"))


def _cancel(rest: list[Token]) -> Cancel:
    if rest:
        raise Malformed("cancel stands alone: it drops all that is not done yet")
    return Cancel()


_FIRSTS = tuple(relation.split()[0] for relation in RELATIONS)


def _target(rest: list[Token], verb: str) -> Target:
    words = [str(each) for each in rest]
    if len(words) > 1 and words[-1] in TURNS:
        return _target(rest[:-1], verb)._replace(turn=words[-1])
    if words and words[0] in ("to", "at", "in", "into"):
        rest, words = rest[1:], words[1:]
    if not rest:
        raise Malformed(f"{verb} what? (x y), a region, where NAME was, or near NAME")
    if isinstance(rest[0], tuple):
        if len(rest) > 1:
            raise Malformed(f"more after {text_of(rest[0])} than is understood: {words[1]}")
        return Target("at", rest[0])
    if words[0] == "where" and words[-1] == "was" and len(words) > 2:
        return Target("was", None, _name(rest[1:-1], "where"))
    for relation in RELATIONS:
        parts = relation.split()
        if words[: len(parts)] == parts:
            return Target(relation, None, _name(rest[len(parts) :], relation))
    return Target("in", None, _name(rest, verb))


def _name(tokens: Sequence[Token], after: str) -> str:
    if any(isinstance(each, tuple) for each in tokens):
        raise Malformed(f"{after}: a name is expected, not a place")
    words = [str(each) for each in tokens]
    if words and words[0] in _ARTICLES and len(words) > 1:
        words = words[1:]
    if not words:
        raise Malformed(f"{after} whom? a name is expected")
    return " ".join(words)


def endless(definitions: Mapping[str, tuple[Sequence[str], str]], name: str) -> list[str]:
    """Return the calls that lead from a defined command back to itself; none where it ends."""

    def follow(called: str, way: list[str]) -> list[str]:
        if called in way:
            return [*way, called] if called == name else []
        for following in sorted(called_by(definitions, called)):
            found = follow(following, [*way, called])
            if found:
                return found
        return []

    return follow(name, [])


def called_by(definitions: Mapping[str, tuple[Sequence[str], str]], name: str) -> Collection[str]:
    """Return the defined commands that one calls."""
    tokens = [";", *tokens_of(definitions[name][1])]
    return {
        str(second) for first, second in pairwise(tokens) if first == ";" and second in definitions
    }
