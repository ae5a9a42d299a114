"""Constraints in one line, as configuration files write them, to and from the model.

``100`` equal, ``x>1`` ``x<=9`` comparisons, ``1<=x<=9`` between, ``1<x<9`` both, ``(a,b,c)`` one
of these, ``c1,c2`` one for each element of a vector, ``{k1:c1,k2:c2}`` one for each key. Blanks
mean nothing.
"""

from __future__ import annotations

import re

from rtkit.errors import Malformed
from rtkit.profile.constraint_model import (
    Between,
    Comparison,
    Constraint,
    ConstraintGroup,
    ConstraintUnit,
    Logical,
)

_LITERAL = r"[^<>=(){},:\s]+"
_ONE = re.compile(rf"x(<=|>=|<|>)({_LITERAL})")
_ONE_TURNED = re.compile(rf"({_LITERAL})(<=|>=|<|>)x")
_TWO = re.compile(rf"({_LITERAL})(<=|<)x(<=|<)({_LITERAL})")
_TWO_TURNED = re.compile(rf"({_LITERAL})(>=|>)x(>=|>)({_LITERAL})")
_KINDS = {
    "": "propertyIsEqualTo",
    "<": "propertyIsLessThan",
    "<=": "propertyIsLessThanOrEqualTo",
    ">": "propertyIsGreaterThan",
    ">=": "propertyIsGreaterThanOrEqualTo",
}
_SIGNS = {kind: sign for sign, kind in _KINDS.items()}
_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}
_Test = Comparison | Between | Logical


def parse_constraint(text: str) -> Constraint | None:
    """Read a constraint; None when the text is blank.

    Raises:
        Malformed: It follows none of the forms.
    """
    bare = "".join(text.split())
    if not bare:
        return None
    if bare.startswith("{") and bare.endswith("}"):
        pairs = [part.partition(":") for part in _parts(bare[1:-1], text)]
        if any(not colon or not key for key, colon, _ in pairs):
            raise Malformed(f"bad constraint {text!r}: a hash is written {{key1:c1,key2:c2}}")
        units = tuple(Constraint(ConstraintUnit(_test(c, text), key)) for key, _, c in pairs)
        return Constraint(ConstraintGroup("ConstraintHashType", units))
    parts = _parts(bare, text)
    if len(parts) == 1:
        return _unit(bare, text)
    return Constraint(
        ConstraintGroup("ConstraintListType", tuple(_unit(part, text) for part in parts))
    )


def _parts(bare: str, text: str) -> list[str]:
    parts = re.findall(r"(?:[^,(){}]|\([^(){}]*\))+", bare)
    if ",".join(parts) != bare:
        raise Malformed(f"bad constraint {text!r}: brackets or commas do not fit")
    return parts


def _unit(part: str, text: str) -> Constraint:
    return Constraint(ConstraintUnit(_test(part, text)))


def _compare(sign: str, literal: str) -> Comparison:
    return Comparison(_KINDS[sign], literal)


def _test(part: str, text: str) -> _Test:
    if part.startswith("(") and part.endswith(")"):
        literals = part[1:-1].split(",")
        if not all(re.fullmatch(_LITERAL, literal) for literal in literals):
            raise Malformed(f"bad constraint {text!r}: {part} lists an unusable value")
        if len(literals) == 1:
            return _compare("", literals[0])
        units = (Constraint(ConstraintUnit(_compare("", literal))) for literal in literals)
        return Logical("Or", tuple(units))
    if two := _TWO.fullmatch(part):
        return _range(*two.groups())
    if two := _TWO_TURNED.fullmatch(part):
        high, above, below, low = two.groups()
        return _range(low, _TURNED[below], _TURNED[above], high)
    if one := _ONE.fullmatch(part):
        return _compare(one[1], one[2])
    if one := _ONE_TURNED.fullmatch(part):
        return _compare(_TURNED[one[2]], one[1])
    if re.fullmatch(_LITERAL, part):
        return _compare("", part)
    raise Malformed(
        f"bad constraint {text!r}: {part!r} is none of 100, x>1, 1<=x<9, (a,b), c1,c2, {{k:c}}"
    )


def _range(low: str, above: str, below: str, high: str) -> Between | Logical:
    if above == below == "<=":
        return Between(low, high)
    ends = (_compare(_TURNED[above], low), _compare(below, high))
    return Logical("And", tuple(Constraint(ConstraintUnit(end)) for end in ends))


def format_constraint(constraint: Constraint) -> str:
    """Write a constraint in one line.

    Raises:
        Malformed: It has no such form, as Not, Like or nested groups.
    """
    content = constraint.content
    if isinstance(content, ConstraintUnit):
        return _format_test(content.test)
    units = [part.content for part in content.constraints]
    if any(not isinstance(unit, ConstraintUnit) for unit in units):
        raise Malformed("a constraint of groups within groups has no one-line form")
    texts = [
        (unit.key, _format_test(unit.test)) for unit in units if isinstance(unit, ConstraintUnit)
    ]
    if content.kind == "ConstraintListType":
        return ",".join(text for _, text in texts)
    return "{" + ",".join(f"{key or ''}:{text}" for key, text in texts) + "}"


def _format_test(test: object) -> str:
    if isinstance(test, Between):
        return f"{test.lower_boundary}<=x<={test.upper_boundary}"
    if isinstance(test, Comparison) and test.kind in _SIGNS:
        sign = _SIGNS[test.kind]
        return f"x{sign}{test.literal}" if sign else test.literal
    if isinstance(test, Logical):
        inside = _comparisons(test)
        if test.kind == "Or" and all(sign == "" for sign, _ in inside) and inside:
            return "(" + ",".join(literal for _, literal in inside) + ")"
        signs = [sign for sign, _ in inside]
        if test.kind == "And" and len(signs) == 2 and signs[0][:1] == ">" and signs[1][:1] == "<":
            return f"{inside[0][1]}{_TURNED[signs[0]]}x{signs[1]}{inside[1][1]}"
    raise Malformed(f"a constraint with {getattr(test, 'kind', test)} has no one-line form")


def _comparisons(test: Logical) -> list[tuple[str, str]]:
    found = []
    for part in test.constraints:
        unit = part.content
        inner = unit.test if isinstance(unit, ConstraintUnit) else None
        if not isinstance(inner, Comparison) or inner.kind not in _SIGNS:
            raise Malformed(f"a constraint with {test.kind} of other tests has no one-line form")
        found.append((_SIGNS[inner.kind], inner.literal))
    return found
