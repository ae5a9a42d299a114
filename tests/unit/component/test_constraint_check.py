"""Which texts fit which parameters."""

from __future__ import annotations

import pytest

from rtkit.component.configuration.constraint_check import misfit


@pytest.mark.parametrize(
    ("declared", "good", "bad"),
    [
        ("int", ["-3", "+4", " 5 "], ["1.5", "x", ""]),
        ("unsigned short", ["3"], ["3.0"]),
        ("double", ["1", "1e-3", "-inf"], ["1,2", "one", ""]),
        ("RTC::Anything", ["", "what", "1"], []),
        ("string", ["", "what"], []),
        ("bool", ["true", "OFF", "1"], ["2", "maybe"]),
        ("std::vector<double>", ["", "1", "1,2.5", "(1 2)", "[1, 2]"], ["1,x", "(1"]),
        ("vector<int>", ["1,2"], ["1.5,2"]),
        ("double[]", ["1.5,2"], ["a"]),
        ("", ["", "what"], []),
        ("unsigned int", ["3"], ["-3"]),
        ("std::vector<unsigned short>", ["3,4"], ["3,-4"]),
        ("unsigned", ["3"], ["-3", "x"]),
    ],
)
def test_types(declared: str, good: list[str], bad: list[str]) -> None:
    sets = {"__type__": {"gain": declared}}
    assert {text: misfit(sets, "gain", text) for text in good} == dict.fromkeys(good, "")
    assert [text for text in bad if not misfit(sets, "gain", text)] == []
    assert misfit(sets, "other", "what") == ""


@pytest.mark.parametrize(
    ("hints", "text", "why"),
    [
        ({"__constraints__": "0<=x<=9"}, "10", "it is to be 0<=x<=9"),
        ({"__constraints__": "0<=x<=9"}, "9", ""),
        ({"__constraints__": "whatever (is) good"}, "10", ""),
        ({"__constraints__": "(a,b)"}, "a,b", "it is to be (a,b)"),
        ({"__constraints__": "(a,b)", "__widget__": "checkbox"}, "a,b", ""),
        ({"__constraints__": "(a,b)", "__widget__": "ordered_list"}, "b,c", "it is to be (a,b)"),
        ({"__constraints__": "x>0", "__type__": "vector<double>"}, "1,0", "it is to be x>0"),
        ({"__constraints__": "x>0", "__type__": "int"}, "1.5", "it is no integer"),
        ({"__constraints__": "(true,false)", "__type__": "bool"}, "1", ""),
        ({"__constraints__": "(true,false)"}, "1", ""),
        ({"__constraints__": "(true,false)"}, "maybe", "it is to be (true,false)"),
        ({"__constraints__": "remark"}, "1", ""),
        ({"__constraints__": "remark", "__type__": "int"}, "1", ""),
        ({"__constraints__": "remark", "__type__": "string"}, "1", "it is to be remark"),
        ({"__constraints__": "100"}, "1", "it is to be 100"),
        ({"__constraints__": "span,error"}, "error", ""),
        ({"__constraints__": "span,error"}, "other", "it is to be span,error"),
        ({"__constraints__": "x>0", "__type__": "int", "default": "1,2"}, "3,4", ""),
        ({"__constraints__": "x>0", "__type__": "int", "default": "1"}, "3,4", "it is no integer"),
        ({"__constraints__": "x>0", "__type__": "int", "default": "1,2"}, "0,4", "it is to be x>0"),
        ({"__type__": "vector<int>"}, "1,x", "'x' is no integer"),
        ({"__type__": "double"}, "x", "it is no number"),
        ({"__type__": "bool"}, "x", "it is no truth value"),
    ],
)
def test_the_reason_is_told(hints: dict[str, str], text: str, why: str) -> None:
    sets = {set_id: {"gain": hint} for set_id, hint in hints.items()}
    assert misfit(sets, "gain", text) == why
