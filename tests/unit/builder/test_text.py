"""Literals, docstrings and calls for texts that may be anything."""

from __future__ import annotations

import ast

import pytest

from rtkit.builder import source_text as text
from rtkit.builder.identifiers import (
    Taken,
    class_name,
    identifier,
    in_words,
    module_name,
    snake_case,
)
from rtkit.builder.source_layout import (
    CallExpression,
    PlainExpression,
    assigned,
    chained,
    constant,
    lines,
    mapping,
)


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ("a", '"a"'),
        ('a"b', "'a\"b'"),
        ("a'b", '"a\'b"'),
        ("\"'", '"\\"\'"'),
        ('""\'', "'\"\"\\''"),
        ("a\\b\n\r\t", '"a\\\\b\\n\\r\\t"'),
        ("日本\x00\x85\u200b\U000e0001", '"日本\\x00\\x85\\u200b\\U000e0001"'),
        ("", '""'),
    ],
)
def test_literals(given, code):
    assert text.literal(given) == code
    assert ast.literal_eval(code) == given


@pytest.mark.parametrize(
    ("value", "code"),
    [
        (1, "1"),
        (True, "True"),
        (1.5, "1.5"),
        (1e80, "1e80"),
        (1e-7, "1e-07"),
        (float("inf"), 'float("inf")'),
        (float("nan"), 'float("nan")'),
    ],
)
def test_values(value, code):
    assert text.value(value) == code


def test_long_text_is_cut_and_none_of_it_lost():
    for given in ("word " * 60, "x" * 300, "語" * 150, "\\" * 200, "\U000e0001" * 40, "a b"):
        pieces = text.cut_text(given, " " * 8)
        assert "".join(ast.literal_eval(piece.strip()) for piece in pieces) == given
        assert all(text.width(piece) <= text.WIDTH for piece in pieces)


def test_documentation_is_cleaned():
    assert text.clean(" a\t b\r\n\r\n  c\u200b\x07 ") == "a b\n\nc"
    assert text.clean("a<br/>b<br>c") == "a\nb\nc"
    assert text.one_line("a\nb\n\nc") == "a b c"
    assert text.clean(None) == text.one_line(None) == ""


@pytest.mark.parametrize(
    ("given", "lines"),
    [
        ("Do it", ['"""Do it."""']),
        ("do it!", ['"""Do it!"""']),
        ("", ['"""Neutral."""']),
        ("onExecute does it", ['"""Neutral.', "", "onExecute does it", '"""']),
        ('"quoted" text', ['"""Neutral.', "", '"quoted" text', '"""']),
        ("a\\b", ['r"""a\\b."""']),
        ("two\nlines", ['"""Neutral.', "", "two", "lines", '"""']),
        ("x\n\nNote:\ny", ['"""Neutral.', "", "x", "", "- Note:", "y", '"""']),
        ("x\n# <user code a>", ['"""Neutral.', "", "x", "- # <user code a>", '"""']),
        ('a """ b', ['"""A \'\'\' b."""']),
        ("概要", ['"""概要."""']),
        ("x" * 120, ['"""Neutral.', "", "x" * 120, '"""']),
    ],
)
def test_docstrings(given, lines):
    assert text.docstring("Neutral.", given) == lines
    ast.parse("\n".join(lines))


def test_docstrings_have_paragraphs_and_sections():
    found = text.docstring("N.", "a " * 80, ["more"], "    ", ["", "Raises:", "    X: y"])
    assert found[0] == '    """N.'
    assert found[-5:] == ["    more", "", "    Raises:", "        X: y", '    """']
    assert all(text.width(line) <= text.WIDTH for line in found)


def test_long_words_of_other_scripts_are_cut():
    assert [text.width(line) for line in text.wrapped("語" * 100, 60)] == [60, 60, 60, 20]
    assert text.wrapped("a " + "語" * 40, 60) == ["a", "語" * 30, "語" * 10]
    assert text.wrapped("x" * 90 + " b", 60) == ["x" * 90, "b"]


LONG = "word " * 30


def test_expressions_are_on_one_line_where_they_fit():
    call = CallExpression("f", [("", PlainExpression("1")), ("doc", "a")])
    assert assigned("x", call) == ['    x = f(1, doc="a")']
    assert assigned("x", constant((1, 2)), "") == ["x = (1, 2)"]
    assert assigned("x", constant((1,)), "") == ["x = (1,)"]
    assert assigned("x", {"a": constant("b")}, "") == ['x = {"a": "b"}']


@pytest.mark.parametrize(
    "node",
    [
        LONG,
        CallExpression(
            "f",
            [
                ("", PlainExpression("1")),
                ("doc", LONG),
                ("more", "a"),
            ],
        ),
        CallExpression(
            "f",
            [
                ("", CallExpression("g", [("", LONG)])),
                ("x", (LONG,)),
            ],
        ),
        {"a" * 120: PlainExpression("1"), "b": LONG},
        constant(tuple(range(60))),
        CallExpression("f", [("", PlainExpression("a" * 120))]),
    ],
)
def test_long_expressions_are_split_and_mean_the_same(node):
    found = lines("x = ", node, indent="")
    tree = ast.parse("\n".join(found))
    assert ast.unparse(tree).startswith("x = ")
    assert len(found) > 2
    if "a" * 120 not in "".join(found):
        assert all(text.width(line) <= text.WIDTH for line in found)


def test_chains():
    short = [CallExpression("a", []), CallExpression(".b", [("", PlainExpression("1"))])]
    assert chained("x", short, "") == ["x = a().b(1)"]
    assert chained("x", short[:1], "") == ["x = a()"]
    assert chained("x", [*short, CallExpression(".c", [])], "") == [
        "x = (",
        "    a()",
        "    .b(1)",
        "    .c()",
        ")",
    ]
    last = [CallExpression("a", []), CallExpression(".b", [("", LONG)])]
    assert chained("x", last, "")[0] == "x = a().b("
    first = [CallExpression("a", [("", LONG)]), CallExpression(".b", [])]
    assert chained("x", first, "")[-1] == ").b()"


def test_mappings_have_a_line_for_each_item():
    assert mapping("x", {"a": PlainExpression("1")}, "") == ["x = {", '    "a": 1,', "}"]


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("in", "in"),
        ("targetVelocity", "target_velocity"),
        ("TimedPose3DQuaternion", "timed_pose3d_quaternion"),
        ("RTCOut", "rtc_out"),
        ("a-b c", "a_b_c"),
        ("3d", "port_3d"),
        ("_x_", "x"),
        ("", "port"),
        ("?", "port"),
        ("速度", "速度"),
        ("ﬁx", "fix"),
    ],
)
def test_attributes(given, name):
    assert snake_case(given, "port") == name
    assert name.isidentifier()


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("ConsoleIn", "ConsoleIn"),
        ("RTC_CO2_K30", "RTCCO2K30"),
        ("goaljudge", "Goaljudge"),
        ("my comp-3", "MyComp3"),
        ("None", "RtcNone"),
        ("3D", "Rtc3D"),
        ("日本", "Rtc日本"),
        ("", "Rtc"),
    ],
)
def test_classes(given, name):
    assert class_name(given) == name


def test_modules_hide_nothing():
    assert module_name("ConsoleIn") == "ConsoleIn"
    assert module_name("logging") == "logging_rtc"
    assert module_name("rtkit") == "rtkit_rtc"
    assert module_name("class") == "class_rtc"
    assert module_name("a b") == "a_b"


def test_identifiers_are_bounded():
    assert len(identifier("x" * 300, "y")) == 40
    assert text.width(identifier("語" * 300, "y")) == 40


def test_taken_names_get_underscores():
    taken = Taken(["port"])
    assert [taken.add(name) for name in ("in", "port", "port", "str", "x")] == [
        "in_",
        "port_",
        "port__",
        "str_",
        "x",
    ]
    assert "x" in taken
    assert "y" not in taken


def test_names_in_words():
    assert in_words("getEchoHistory") == "get echo history"
    assert in_words("set_value") == "set value"
    assert in_words("_") == "_"
