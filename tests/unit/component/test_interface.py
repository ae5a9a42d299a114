"""Service interfaces read from protocol classes, and calls as bytes."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Protocol

import pytest

from rtkit.component import Float, Long, TimedLong
from rtkit.component.services.interface import Interface
from rtkit.errors import Malformed, Refused


class Colour(Enum):
    RED = 0
    BLUE = 1


class Base(Protocol):
    """A part of the interface."""

    def reset(self) -> None: ...


class Everything(Base, Protocol):
    """Every kind of argument."""

    def echo(self, text: str) -> str: ...

    def mix(self, a: Long, b: Float = 2.5, *, flag: bool = False) -> list[float]: ...

    def send(self, value: TimedLong, raw: bytes, colours: tuple[Colour, ...]) -> TimedLong: ...

    def pair(self) -> tuple[int, str]: ...

    def _private(self) -> None: ...


EVERYTHING = Interface(Everything)


def test_methods_and_their_signatures():
    assert {name: m.signature for name, m in EVERYTHING.methods.items()} == {
        "reset": "reset()->void",
        "echo": "echo(text:string)->string",
        "mix": "mix(a:int32,b:float32,flag:boolean)->sequence<float64>",
        "send": "send(value:TimedLong,raw:sequence<octet>,colours:sequence<Colour>)->TimedLong",
        "pair": "pair()->array of 2",
    }


@pytest.mark.parametrize(
    ("name", "arguments", "named", "read"),
    [
        ("reset", (), {}, ()),
        ("echo", ("grüße",), {}, ("grüße",)),
        ("mix", (1,), {}, (1, 2.5, False)),
        ("mix", (1, 0.5), {"flag": True}, (1, 0.5, True)),
        ("mix", (), {"b": 1.0, "a": 3}, (3, 1.0, False)),
        (
            "send",
            (TimedLong(data=4), b"\0\1", (Colour.BLUE, Colour.RED)),
            {},
            (TimedLong(data=4), b"\0\1", (Colour.BLUE, Colour.RED)),
        ),
    ],
)
def test_arguments_there_and_back(name, arguments, named, read):
    method = EVERYTHING.methods[name]
    assert method.decode_arguments(method.encode_arguments(arguments, named)) == read


@pytest.mark.parametrize(
    ("name", "result"),
    [("reset", None), ("echo", ""), ("mix", [1.0, 2.0]), ("pair", (5, "x"))],
)
def test_results_there_and_back(name, result):
    method = EVERYTHING.methods[name]
    assert method.decode_result(method.encode_result(result)) == result


@pytest.mark.parametrize(
    ("name", "arguments", "named", "why"),
    [
        ("echo", (), {}, "Everything.echo: missing a required argument: 'text'"),
        ("echo", ("a", "b"), {}, "Everything.echo: too many positional arguments"),
        ("echo", (), {"word": "a"}, "Everything.echo: missing a required argument"),
        ("echo", (5,), {}, "Everything.echo.text: 5 is not a value of type string"),
        ("mix", (2**31,), {}, "Everything.mix.a: 2147483648 is not a value of type int32"),
        ("mix", (1, 2.0, True), {}, "too many positional"),
    ],
)
def test_arguments_that_do_not_fit(name, arguments, named, why):
    with pytest.raises(Malformed, match=why):
        EVERYTHING.methods[name].encode_arguments(arguments, named)


def test_results_that_do_not_fit():
    with pytest.raises(Malformed, match=r"echo.result: None is not a value of type string"):
        EVERYTHING.methods["echo"].encode_result(None)
    with pytest.raises(Malformed, match="reset returns nothing, not int"):
        EVERYTHING.methods["reset"].encode_result(0)


def test_keyword_only_arguments_reach_an_implementation_by_name():
    def mix(a, b, *, flag):
        return [a, b, flag]

    assert EVERYTHING.methods["mix"].call(mix, (1, 2.0, True)) == [1, 2.0, True]


def interface(**members):
    return type("Bad", (), members)


def untyped(self, value): ...
def no_result(self, value: int): ...
def object_taken(self, value: object) -> None: ...
def any_number(self, *values: int) -> None: ...
def any_names(self, **values: int) -> None: ...
def optional(self, value: int | None) -> None: ...
def unknown(self, value: Nowhere) -> None: ...  # noqa: F821
def fine(self) -> None: ...
def sequence(self, values: Sequence[int]) -> None: ...


@pytest.mark.parametrize(
    ("members", "why"),
    [
        ({"f": untyped}, "Bad.f does not say the type of value; annotate it"),
        ({"f": no_result}, "Bad.f does not say what it returns; annotate it"),
        ({"f": object_taken}, "Bad.f: value cannot be carried"),
        ({"f": any_number}, r"Bad.f has parameter \*values: 'int', which cannot be carried"),
        ({"f": any_names}, "Bad.f has parameter .*values"),
        ({"f": optional}, "Bad.f: value cannot be carried"),
        ({"f": unknown}, "Bad.f: its annotations cannot be read"),
        ({"f": fine, "limit": 5}, "interface Bad has what is no method: limit"),
        ({"f": property(fine)}, "no method: f"),
        ({}, "Bad has no methods"),
    ],
)
def test_interfaces_that_cannot_be_carried(members, why):
    with pytest.raises(Malformed, match=why):
        Interface(interface(**members))


def test_what_is_no_class_is_no_interface():
    with pytest.raises(Malformed, match="not a class"):
        Interface("MyService")
    with pytest.raises(Malformed, match="control characters"):
        Interface(Everything, "My\tService")


def test_a_sequence_may_be_any():
    method = Interface(interface(f=sequence)).methods["f"]
    assert method.decode_arguments(method.encode_arguments([[1, 2]], {})) == ((1, 2),)


def test_what_an_implementation_lacks():
    lacks = "P.p: object does not implement Everything: it lacks reset, echo, mix, send, pair"
    with pytest.raises(Refused, match=lacks):
        EVERYTHING.check_methods(object(), "P.p")
