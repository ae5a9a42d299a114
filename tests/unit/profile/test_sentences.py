"""Constraints that carry the sentence with which what breaks them is refused."""

from __future__ import annotations

import pytest

from rtkit.component.configuration.constraint_check import Declared, misfit_of, read_constraint

RULE = 'and(or("Even numbers only.", (2,4,6)), or("Nothing has more than four.", x<=4))'


@pytest.mark.parametrize(
    ("rule", "value", "why"),
    [
        (RULE, "4", ""),
        (RULE, "3", "Even numbers only"),
        (RULE, "6", "Nothing has more than four"),
        (RULE, "7", "Even numbers only"),
        ('or("One or two.", (1,2))', "3", "One or two"),
        ("and(x>1,x<3)", "5", "it is to be and(x>1,x<3)"),
        ('or("New York", "Los Angeles")', "Rome", 'it is to be or("New York", "Los Angeles")'),
        ('and(or("Why.", x>1), x<9)', "9", 'it is to be and(or("Why.", x>1), x<9)'),
        ('{"a":(1,2)}', '{"a": "3"}', 'it is to be {"a":(1,2)}'),
        ('{"a":(1,2)}', '{"a": "2", "b": "9"}', ""),
    ],
)
def test_the_sentence_of_what_is_broken_is_told(rule: str, value: str, why: str) -> None:
    assert misfit_of(Declared("string", rule, read_constraint(rule)), value) == why
