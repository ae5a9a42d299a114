"""What is no assembly is refused by the constraint of the parameter, with the same sentence."""

from __future__ import annotations

import json
import random
from itertools import product

import pytest
from bug.assembly import WORDS, read_assembly, variants
from bug.rules import constraint_of_variants

from rtkit.component.configuration.constraint_check import Declared, misfit_of, read_constraint
from rtkit.errors import Refused
from rtkit.profile.constraint_text import parse_constraint

RULE = constraint_of_variants()
DECLARED = Declared("string", RULE, read_constraint(RULE))


def _why(text: str) -> str:
    return misfit_of(DECLARED, text)


def _refusal(value: dict[str, object]) -> str:
    try:
        read_assembly(value, "")
    except Refused as error:
        return str(error).removeprefix(": ")
    return ""


def test_a_name_that_is_known_is_one() -> None:
    assert not any(map(_why, variants()))
    assert _why("bug9").startswith("it is one of bug1, bug2, ")


def _drawn(count: int) -> list[dict[str, object]]:
    draw = random.Random(7)
    every = list(product(*((None, *words) for words in WORDS.values()), (None, 0, 0.5)))
    keys = (*WORDS, "gain")
    return [
        {key: word for key, word in zip(keys, words, strict=True) if word is not None}
        for words in draw.sample(every, count)
    ]


@pytest.mark.parametrize("is_compact", [False, True])
def test_what_reading_refuses_the_constraint_refuses_with_the_same_sentence(
    is_compact: bool,
) -> None:
    kept = 0
    for value in [*_drawn(300), *({"motion": m, "leave": m} for m in ("m-line", "tangent"))]:
        text = json.dumps(value, separators=(",", ":") if is_compact else None)
        refusal, why = _refusal(value), _why(text)
        assert bool(refusal) is bool(why), (value, refusal, why)
        kept += not refusal
        if why:
            assert why in RULE
            assert "(" not in why
    assert kept >= 3


def test_a_single_fault_has_its_own_sentence() -> None:
    for value in ({"leave": "m-line"}, {"by": "free range"}, {"direction": "sliding"}):
        assert _why(json.dumps(value)) == _refusal(value)


def test_a_name_that_is_nearly_one_has_a_hint() -> None:
    assert _why("bugg2").endswith(" (did you mean bug2?)")
    assert "(did you mean bug2" in _why("Bug2")


_LINE = {"motion": "m-line", "leave": "m-line"}
_BOUND = {"over": "disc"}


@pytest.mark.parametrize(
    "value",
    [
        {"leav": "m-line"},
        {**_LINE, "Memory": "turn round"},
        {**_LINE, "": "m-line"},
        {"by": "free range", "gain": 11},
        {"by": "free range", "gain": -1},
        {"by": "free range", "gain": "0.5"},
        {"by": "free range", "gain": True},
        {"by": "free range", "gain": None},
        {"by": "free range", "gain": 0.5},
        {"motion": "M-line", "leave": "m-line"},
        {"motion": " m-line", "leave": "m-line"},
        {"motion": ["m-line"], "leave": "m-line"},
        {"motion": None},
        {"source": 'leave: m-line, "motion", {"x": 1}', "summary": "motion"},
        {"bound": _BOUND},
        {"bound": {**_BOUND, "each": 1.5, "crossing": 0, "minimum": 2}},
        {"bound": {**_BOUND, "each": -1}},
        {"bound": {**_BOUND, "each": "1"}},
        {"bound": {**_BOUND, "eech": 1}},
        {"bound": {"over": "disk"}},
        {"bound": {"each": 1}},
        {"bound": {}},
        {"bound": None},
        {"bound": "over"},
        {},
    ],
    ids=json.dumps,
)
def test_any_object_is_refused_by_both_or_by_none(value: dict[str, object]) -> None:
    refusal, why = _refusal(value), _why(json.dumps(value))
    assert bool(refusal) is bool(why), (refusal, why)


def test_a_key_that_is_none_is_refused() -> None:
    assert _why('{"leav": "m-line"}') == (
        "an assembly has no other keys than motion, leave, nearer_than, by, research, direction,"
        " memory, gain, bound, source, summary"
    )


@pytest.mark.parametrize(
    "text", ['{"motion": ', "{motion: m-line, leave: m-line}", "{'motion': 'm-line'}", "{"]
)
def test_what_is_no_json_is_told_so(text: str) -> None:
    assert _why(text) == "what is in braces is no JSON object"


def test_a_word_that_is_none_is_refused() -> None:
    assert _why('{"leave": "anytime"}') == "leave is one of anywhere, m-line, nearest point"


def test_the_shipped_assemblies_are_valid_as_data_too() -> None:
    from pathlib import Path

    import bug

    shipped = json.loads((Path(bug.__file__).parent / "variants.json").read_text())
    for name, value in shipped.items():
        assert not _why(json.dumps(value)), name


def test_the_constraint_can_be_written_and_read_again() -> None:
    from rtkit.profile.constraint_text import format_constraint

    again = format_constraint(parse_constraint(RULE))
    assert parse_constraint(again) == parse_constraint(RULE)
