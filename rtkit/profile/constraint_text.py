"""Parses constraints on one line, as configuration files write them, and formats them again.

``100`` equal, ``x>1`` ``x<=9`` ``x!=3`` comparisons, ``1<=x<=9`` between, ``1<x<9`` both,
``(a,b,c)`` one of these, ``c1,c2`` one for each element of a vector, ``{k1:c1,k2:c2}`` one for
each key. Blanks mean nothing. These forms are those of other tools too; the rest of the model
has forms of rtkit's own: ``not(c)``, ``and(c1,c2)``, ``or(c1,c2)``, ``null()``,
``like("a*")``, ``like("a%","%","_","!")`` (any text, one character, escape), ``list(c1,…)``
and ``hash(c1,…)`` where they stand inside others, ``key(k,c)``. A literal in double quotes may
hold anything, one in single quotes is compared by case too.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.profile.constraint_model import (
    Between,
    Comparison,
    Constraint,
    ConstraintGroup,
    ConstraintTest,
    ConstraintUnit,
    IsNull,
    Like,
    Logical,
)

VARIABLE = "x"
"""Placeholder of the value in ``x>1``."""

_TOKEN = re.compile(
    r"""\s*(?:
        (?P<quoted>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')
      | (?P<sign><=|>=|!=|<|>)
      | (?P<mark>[(){},:])
      | (?P<word>(?:[^<>=(){},:\s!]|!(?!=))+)
    )\s*""",
    re.DOTALL | re.VERBOSE,
)
_PLAIN = re.compile(r"[^<>=(){},:\s!\\'\"]+")
_ESCAPED = {"\n": "n", "\r": "r", "\t": "t"}
_MEANT = {letter: character for character, letter in _ESCAPED.items()}


class Token(NamedTuple):
    """A piece of a constraint.

    Attributes:
        kind: word, quoted, sign or mark.
        is_exact: Whether its case matters, as in ``'Word'``.
    """

    kind: str
    text: str
    is_exact: bool = False

    @property
    def is_literal(self) -> bool:
        """Return whether it can be a value."""
        return self.kind in ("word", "quoted")

    @property
    def is_variable(self) -> bool:
        """Return whether it stands for the value that is tested."""
        return self.kind == "word" and self.text == VARIABLE


def tokens(text: str) -> list[Token]:
    """Return the pieces of a constraint; blanks mean nothing, except inside quotes.

    Raises:
        Malformed: A character belongs nowhere.
    """
    found: list[Token] = []
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            if text[place:].isspace():
                break
            raise Malformed(f"bad constraint {text!r}: nothing begins with {text[place:].strip()}")
        place = match.end()
        kind = match.lastgroup or ""
        token = Token(kind, match[kind])
        if kind == "quoted":
            token = Token(kind, _unquoted(token.text), token.text[0] == "'")
        elif kind == "word" and found and found[-1].kind == "word":
            token = Token(kind, found.pop().text + token.text)
        found.append(token)
    return found


def _unquoted(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: _MEANT.get(m[1], m[1]), text[1:-1], flags=re.DOTALL)


def literal(text: str, *, is_exact: bool = False) -> str:
    """Return a value as `tokens` reads it back: plain where that is possible."""
    if not is_exact and _PLAIN.fullmatch(text):
        return text
    quote = "'" if is_exact else '"'
    written = "".join(
        f"\\{_ESCAPED.get(c, c)}" if c in _ESCAPED or c in (quote, "\\") else c for c in text
    )
    return f"{quote}{written}{quote}"


MAX_DEPTH = 64
"""Constraints nested deeper than this are malformed."""

SIGNS = {
    "propertyIsLessThan": "<",
    "propertyIsLessThanOrEqualTo": "<=",
    "propertyIsGreaterThan": ">",
    "propertyIsGreaterThanOrEqualTo": ">=",
    "propertyIsNotEqualTo": "!=",
}
"""Signs of the kinds of comparisons between ``x`` and a literal."""

LIKE_MARKS = ("*", "?", "\\")
"""Wild card, single character and escape of ``like("…")`` when it names none."""

_KINDS = {sign: kind for kind, sign in SIGNS.items()}
_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "!=": "!="}
_END = Token("end", "")


def parse_constraint(text: str) -> Constraint | None:
    """Read a constraint; None when the text is blank.

    Raises:
        Malformed: It follows none of the forms.
    """
    found = tokens(text)
    return _Parser(found, text).whole() if found else None


class _Parser:
    def __init__(self, found: list[Token], text: str) -> None:
        self._tokens = found
        self._text = text
        self._place = 0
        self._depth = 0
        self._forms: dict[str, Callable[[], Constraint]] = {
            "not": lambda: _unit(Logical("Not", self._several(1, 1))),
            "and": lambda: _unit(Logical("And", self._several(2))),
            "or": lambda: _unit(Logical("Or", self._several(2))),
            "null": lambda: _unit(IsNull()),
            "like": self._like,
            "list": lambda: _group("ConstraintListType", self._several(0)),
            "hash": lambda: _group("ConstraintHashType", self._several(0)),
            "key": self._keyed,
        }

    def whole(self) -> Constraint:
        parts = self._listed()
        if self._next.kind != "end":
            raise self._bad(f"{self._next.text!r} belongs nowhere")
        return parts[0] if len(parts) == 1 else _group("ConstraintListType", tuple(parts))

    def _listed(self) -> list[Constraint]:
        parts = [self._one()]
        while self._takes(","):
            parts.append(self._one())
        return parts

    @property
    def _next(self) -> Token:
        return self._tokens[self._place] if self._place < len(self._tokens) else _END

    def _take(self) -> Token:
        token = self._next
        self._place += 1
        return token

    def _takes(self, mark: str) -> bool:
        is_there = self._next.kind == "mark" and self._next.text == mark
        self._place += is_there
        return is_there

    def _needs(self, mark: str) -> None:
        if not self._takes(mark):
            raise self._bad("brackets or commas do not fit")

    def _bad(self, why: str) -> Malformed:
        return Malformed(f"bad constraint {self._text!r}: {why}")

    def _one(self) -> Constraint:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._bad(f"nested deeper than {MAX_DEPTH}")
        made = self._form()
        self._depth -= 1
        return made

    def _form(self) -> Constraint:
        if self._takes("{"):
            return self._hash()
        if self._takes("("):
            return self._enumeration()
        token = self._next
        follower = self._tokens[self._place + 1 : self._place + 2]
        if token.kind == "word" and follower == [Token("mark", "(")]:
            form = self._forms.get(token.text)
            if form is None:
                raise self._bad(f"there is no {token.text}(); there are {', '.join(self._forms)}")
            self._place += 2
            made = form()
            self._needs(")")
            return made
        return _unit(self._comparison())

    def _several(self, least: int, most: int | None = None) -> tuple[Constraint, ...]:
        parts = [] if self._next == Token("mark", ")") else self._listed()
        if len(parts) < least or len(parts) > (most or len(parts)):
            raise self._bad("not() needs one constraint; and(), or() need two or more")
        return tuple(parts)

    def _hash(self) -> Constraint:
        parts: list[Constraint] = []
        while not self._takes("}"):
            if parts:
                self._needs(",")
            key = self._literal("a hash is written {key1:c1,key2:c2}").text
            if not self._takes(":"):
                raise self._bad("a hash is written {key1:c1,key2:c2}")
            parts.append(self._with_key(key, self._one()))
        return _group("ConstraintHashType", tuple(parts))

    def _keyed(self) -> Constraint:
        key = self._literal("key() is written key(k,c)").text
        self._needs(",")
        return self._with_key(key, self._one())

    def _with_key(self, key: str, part: Constraint) -> Constraint:
        if not isinstance(part.content, ConstraintUnit) or part.content.key is not None:
            raise self._bad(f"key {key} is for one test")
        return Constraint(replace(part.content, key=key))

    def _enumeration(self) -> Constraint:
        found = [self._literal("(a,b,c) lists values")]
        while self._takes(","):
            found.append(self._literal("(a,b,c) lists values"))
        self._needs(")")
        units = tuple(_unit(_equal(each)) for each in found)
        return units[0] if len(units) == 1 else _unit(Logical("Or", units))

    def _like(self) -> Constraint:
        why = 'like() is written like("a*") or like("a%","%","_","!")'
        parts = [self._literal(why).text]
        while self._takes(","):
            parts.append(self._literal(why).text)
        if len(parts) not in (1, 4):
            raise self._bad(why)
        pattern, *marks = parts
        return _unit(Like(pattern, *(marks or LIKE_MARKS)))

    def _literal(self, why: str) -> Token:
        token = self._take()
        if not token.is_literal:
            raise self._bad(why)
        return token

    def _comparison(self) -> Comparison | Between | Logical:
        operands = [self._literal("it is none of 100, x>1, 1<=x<9, (a,b), c1,c2, {k:c}")]
        signs = []
        while self._next.kind == "sign":
            signs.append(self._take().text)
            operands.append(self._literal(f"nothing is behind {signs[-1]}"))
        if not signs:
            return _equal(operands[0])
        if len(signs) == 1 and operands[0].is_variable:
            return _compare(signs[0], operands[1])
        if len(signs) == 1 and operands[1].is_variable:
            return _compare(_TURNED[signs[0]], operands[0])
        low, middle, high = operands if len(signs) == 2 else (operands[0], operands[1], _END)
        directions = {sign[0] for sign in signs}
        if len(signs) != 2 or not middle.is_variable or directions not in ({"<"}, {">"}):
            raise self._bad("a range is written 1<=x<9")
        if directions == {">"}:
            low, high = high, low
            signs = [_TURNED[sign] for sign in reversed(signs)]
        return _range(low, signs[0], signs[1], high)


def _unit(test: ConstraintTest) -> Constraint:
    return Constraint(ConstraintUnit(test))


def _group(kind: str, parts: tuple[Constraint, ...]) -> Constraint:
    return Constraint(ConstraintGroup(kind, parts))


def _equal(value: Token) -> Comparison:
    return Comparison("propertyIsEqualTo", value.text, value.is_exact)


def _compare(sign: str, value: Token) -> Comparison:
    return Comparison(_KINDS[sign], value.text, value.is_exact)


def _range(low: Token, above: str, below: str, high: Token) -> Between | Logical:
    if above == below == "<=":
        return Between(low.text, high.text)
    ends = (_compare(_TURNED[above], low), _compare(below, high))
    return Logical("And", tuple(_unit(end) for end in ends))


_LOW = ("propertyIsGreaterThan", "propertyIsGreaterThanOrEqualTo")
_HIGH = ("propertyIsLessThan", "propertyIsLessThanOrEqualTo")
_LOW_SIGNS = {_LOW[0]: "<", _LOW[1]: "<="}


def format_constraint(constraint: Constraint | None) -> str:
    """Write a constraint in one line, in the usual form where it has one; nothing for none."""
    if constraint is None:
        return ""
    content = constraint.content
    if isinstance(content, ConstraintUnit) or content.kind == "ConstraintHashType":
        return _format(constraint)
    return _joined(content.constraints) if len(content.constraints) > 1 else _format(constraint)


def _format(constraint: Constraint) -> str:
    content = constraint.content
    if isinstance(content, ConstraintUnit):
        text = _format_test(content.test)
        return text if content.key is None else f"key({literal(content.key)},{text})"
    if content.kind == "ConstraintListType":
        return f"list({_joined(content.constraints)})"
    pairs = _pairs(content.constraints)
    if pairs is None:
        return f"hash({_joined(content.constraints)})"
    return "{" + ",".join(pairs) + "}"


def _joined(parts: Iterable[Constraint]) -> str:
    return ",".join(map(_format, parts))


def _pairs(parts: Iterable[Constraint]) -> list[str] | None:
    """Return ``key:constraint`` of each part; None when one of them has no key."""
    found = []
    for part in parts:
        unit = part.content
        if not isinstance(unit, ConstraintUnit) or unit.key is None:
            return None
        found.append(f"{literal(unit.key)}:{_format_test(unit.test)}")
    return found


def _format_test(test: ConstraintTest) -> str:
    match test:
        case Between(lower, upper):
            return f"{literal(lower)}<={VARIABLE}<={literal(upper)}"
        case Comparison(kind, text, is_exact):
            value = literal(text, is_exact=is_exact)
            return f"{VARIABLE}{SIGNS[kind]}{value}" if kind in SIGNS else value
        case Like(pattern, wild_card, single_char, escape_char):
            marks = (wild_card, single_char, escape_char)
            parts = (pattern,) if marks == LIKE_MARKS else (pattern, *marks)
            return f"like({','.join(map(_quoted, parts))})"
        case IsNull():
            return "null()"
        case Logical(kind, parts):
            usual = (
                _enumeration_text(parts)
                if kind == "Or"
                else _range_text(parts)
                if kind == "And"
                else ""
            )
            return usual or f"{kind.lower()}({_joined(parts)})"


def _quoted(text: str) -> str:
    plain = literal(text)
    return plain if plain[:1] == '"' else f'"{plain}"'


def _comparisons(parts: Iterable[Constraint]) -> list[Comparison]:
    """Return the comparisons that these are; nothing when one is another test or has a key."""
    found = []
    for part in parts:
        unit = part.content
        if not isinstance(unit, ConstraintUnit) or unit.key is not None:
            return []
        if not isinstance(unit.test, Comparison):
            return []
        found.append(unit.test)
    return found


def _enumeration_text(parts: tuple[Constraint, ...]) -> str:
    found = _comparisons(parts)
    if len(found) < 2 or any(each.kind != "propertyIsEqualTo" for each in found):
        return ""
    return "(" + ",".join(map(_format_test, found)) + ")"


def _range_text(parts: tuple[Constraint, ...]) -> str:
    """Return ``low<x<high``; both ends included would be read as between, another test."""
    found = _comparisons(parts)
    if len(found) != 2 or found[0].kind not in _LOW or found[1].kind not in _HIGH:
        return ""
    low, high = found
    if (low.kind, high.kind) == (_LOW[1], _HIGH[1]):
        return ""
    bottom = literal(low.literal, is_exact=low.match_case)
    top = literal(high.literal, is_exact=high.match_case)
    return f"{bottom}{_LOW_SIGNS[low.kind]}{VARIABLE}{SIGNS[high.kind]}{top}"
