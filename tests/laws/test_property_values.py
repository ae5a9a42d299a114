"""Values written and read again are the same; rubbish is refused, never repaired, never a crash."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import to_value
from rtkit.property.fitting import from_value
from rtkit.property.limits import ValueLimits
from rtkit.property.marker import _KNOWN, Marker
from rtkit.property.naming import canonical, escape, parse_parameters, unescape, write_parameters
from rtkit.property.reading import read
from rtkit.property.values import Element, Value, Word, is_number
from rtkit.property.writing import write

XNAME = st.from_regex(r"[A-Za-z_][A-Za-z0-9_.\-]{0,5}", fullmatch=True)
TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
XTEXT = st.text(
    st.characters(exclude_categories=["Cs", "Cc"], include_characters="\n\r\t",
                  exclude_characters="\ufffe\uffff"), max_size=8)  # fmt: skip
WORD = st.text(st.characters(exclude_categories=["Cs", "Cc", "Z", "C"]), min_size=1, max_size=8)
NUMBER = st.integers(-(10**30), 10**30) | st.floats()
ATOM = NUMBER | st.booleans() | TEXT | WORD.map(Word)


def _elements(inner: st.SearchStrategy[Value]) -> st.SearchStrategy[Element]:
    attributes = st.dictionaries(XNAME, XTEXT, max_size=2)
    leaf = st.builds(Element, XNAME, attributes, st.just(()), inner)
    return st.builds(Element, XNAME, attributes, st.lists(leaf, max_size=3).map(tuple)) | leaf


VALUE: st.SearchStrategy[Value] = st.recursive(
    ATOM, lambda inner: st.lists(inner, max_size=4).map(tuple) | _elements(inner), max_leaves=12
)


def same(one: Value, other: Value) -> bool:
    """Equal and of equal types; nan is nan, a word that needs quotes has become a string."""
    if isinstance(one, float) and isinstance(other, float):
        return (math.isnan(one) and math.isnan(other)) or (
            one == other and math.copysign(1, one) == math.copysign(1, other)
        )
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, Element) and isinstance(other, Element):
        leaves = (one.leaf is None and other.leaf is None) or (
            one.leaf is not None and other.leaf is not None and same(one.leaf, other.leaf)
        )
        head = (one.name, one.attributes) == (other.name, other.attributes)
        return (
            head
            and leaves
            and len(one.children) == len(other.children)
            and all(map(same, one.children, other.children))
        )
    if isinstance(one, Word) and not isinstance(other, Word):
        return str(one) == other and write(one).startswith('"')
    return type(one) is type(other) and one == other


@given(VALUE)
@example(Element("A", {}, (), Word("<")))
def test_what_is_written_reads_as_it_was(value: Value) -> None:
    text = write(value)
    assert same(value, read(text))
    assert write(read(text)) == text


PIECES = st.lists(
    st.sampled_from(
        ["(", ")", " ", "\n", '"', "\\", "1", "-0.0", "nan", ".", "e5", "word", "<a>", "</a>",
         "<a/>", "<a b='1'>", "&lt;", "&#10;", "&", "<!--", "-->", "{3}", "\x00", "é", '"x"']
    ),
    max_size=12,
).map("".join)  # fmt: skip


@given(PIECES | st.text(max_size=20))
def test_any_text_is_read_or_refused(text: str) -> None:
    told = _read(text)
    if isinstance(told, PropertyError):
        assert told.code == "syntax"
        offset, _, expected = str(told).partition(" ")
        assert 0 <= int(offset) <= len(text)
        assert expected
    else:
        assert write(read(write(told))) == write(told)


def _read(text: str) -> Value | PropertyError:
    try:
        return read(text)
    except PropertyError as error:
        return error


@pytest.mark.parametrize(
    ("spelt", "written"),
    [
        ("(1.0 0.1 0.1)", "(1.0 0.1 0.1)"),
        ("( 1.0\t0.1\r\n0.1 )", "(1.0 0.1 0.1)"),
        ("((1.0 0.0)(2.0 0.1))", "((1.0 0.0) (2.0 0.1))"),
        ('(a"b"(1)c)', '(a "b" (1) c)'),
        ("+5", "5"),
        ("1.", "1.0"),
        (".5e1", "5.0"),
        ("1e999", "inf"),
        ("-inf", "-inf"),
        ("-nan", "-nan"),
        ("007", "7"),
        ("1.2.3", "1.2.3"),
        ("tRUE", "tRUE"),
        ("<a><b>true</b></a>", "<a><b>true</b></a>"),
        ('<a><b>"true"</b></a>', '<a><b>"true"</b></a>'),
        ("<a> two  words </a>", "<a>two  words</a>"),
        ("<a>one\ntwo</a>", "<a>one&#10;two</a>"),
        ("<a></a>", "<a/>"),
        ("<a><!-- note --><b/></a>", "<a><b/></a>"),
        ("<a>&lt;b/&gt;</a>", "<a>&lt;b/&gt;</a>"),
        ("<a x='&quot;'/>", '<a x="&quot;"/>'),
        ("", '""'),
    ],
)
def test_liberal_in_reading_one_way_of_writing(spelt: str, written: str) -> None:
    assert write(read(spelt)) == written


def test_kinds_of_groups_follow_from_what_is_in_them() -> None:
    assert isinstance(read("(location velocity)"), tuple)
    assert read("()") == ()
    assert read("(3 red)") == (3, Word("red"))


@pytest.mark.parametrize("depth", [10**3, 10**6])
@pytest.mark.parametrize("bracket", ["(", "<a>", "(<a>", "<a>&lt;b&gt;"])
def test_deep_nesting_is_too_large(bracket: str, depth: int) -> None:
    text = (bracket * depth)[: (1 << 20)]
    with pytest.raises(PropertyError) as refused:
        read(text)
    assert refused.value.code in ("too-large", "syntax")


def test_leaves_in_leaves_are_as_deep_as_brackets() -> None:
    text = "1"
    for _ in range(80):
        text = "<a>" + text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;") + "</a>"
    with pytest.raises(PropertyError, match="deeper"):
        read(text)


def test_limits_are_those_that_were_stated() -> None:
    small = ValueLimits(text=128, depth=4, items=5)
    assert read("((1) (2))", small) == ((1,), (2,))
    for text in ("1" * 129, "(((((1)))))", "((1)(2)(3)(4))"):
        with pytest.raises(PropertyError) as refused:
            read(text, small)
        assert refused.value.code == "too-large"


@pytest.mark.parametrize("value", ["\ud800", Element("1a"), Element("a", {"b": "\x00"}), object()])
def test_what_has_no_text_is_refused(value: Value) -> None:
    with pytest.raises(PropertyError):
        write(value)


@given(st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=20))
def test_any_text_makes_a_part_of_a_name(text: str) -> None:
    segment = escape(text)
    assert unescape(segment) == text
    assert canonical(segment) == segment


@given(st.dictionaries(st.from_regex(r"[a-z_][a-z0-9_-]{0,5}", fullmatch=True),
                       st.none() | TEXT, min_size=1, max_size=4))  # fmt: skip
def test_parameters_come_back(parameters: dict[str, str | None]) -> None:
    assert parse_parameters(write_parameters(parameters)) == parameters


@given(st.lists(NUMBER, min_size=1, max_size=8).map(tuple), st.data())
def test_a_part_that_is_replaced_is_the_part(
    vector: tuple[float, ...], data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from(components.names(vector)))
    replaced = components.replace(vector, [name], 42)
    assert components.get(replaced, [name]) == 42
    assert isinstance(replaced, tuple)
    assert sum(not same(a, b) for a, b in zip(vector, replaced, strict=True)) <= 1
    assert is_number(components.get(vector, [name]))


KNOWN = st.sampled_from(["id", "name", "type", "frame", "source"])
PART = _elements(ATOM).filter(lambda each: each.name not in _KNOWN)
COORDINATES = st.sampled_from([2, 3, 6]).flatmap(lambda n: st.tuples(*[st.floats()] * n))


@given(COORDINATES, st.dictionaries(KNOWN, XTEXT), st.lists(PART, max_size=4))
def test_markers_lose_nothing(
    location: tuple[float, ...], told: dict[str, str], parts: list[Element]
) -> None:
    marker = Marker(location, **told)  # type: ignore[arg-type]
    whole = Element("marker", {"by": "x"}, (*parts, *marker.element.children))
    read_again = Marker.from_element(read(write(whole)))  # type: ignore[arg-type]
    assert same(read_again.element, read(write(whole)))
    assert same(read_again.location or (), location)
    for name in told:
        assert getattr(marker, name) == told[name]
        assert getattr(read_again, name).strip() == told[name].strip()
    assert set(read_again.features) == {part.name for part in parts}
    changed = read_again.with_(confidence=0.5)
    assert changed.with_(confidence=None).element.children == read_again.element.children


@dataclasses.dataclass(frozen=True)
class Inner:
    text: str
    numbers: tuple[float, ...]


@dataclasses.dataclass(frozen=True)
class Outer:
    count: int
    is_on: bool
    inner: Inner
    more: tuple[Inner, ...] = ()
    maybe: Inner | None = None


INNER = st.builds(Inner, XTEXT, st.lists(st.floats(allow_nan=False), max_size=3).map(tuple))
OUTER = st.builds(
    Outer, st.integers(-(10**9), 10**9), st.booleans(), INNER,
    st.lists(INNER, max_size=3).map(tuple), st.none() | INNER,
)  # fmt: skip


@given(OUTER)
def test_dataclasses_lose_nothing_as_elements(record: Outer) -> None:
    element = to_value(record)
    assert not isinstance(element, bytes)
    assert from_value(read(write(element)), Outer, None) == record
