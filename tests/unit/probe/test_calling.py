"""Operations of service ports, as their IDL tells them: found, their arguments read."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rtkit.component import ServicePort, raises, returns
from rtkit.component.geometry import Point2D
from rtkit.component.services.defined_interface import RaisedByProvider, interface_of
from rtkit.component.services.interface import Interface
from rtkit.component.services.interface_definition import definition_of
from rtkit.component.types import Long, Octet, ULong, WString
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.probe.calling import ProvidedOperation, chosen
from rtkit.rtc.names import parse_path
from rtkit.rtc.profiles import PortRef, operations_in
from rtkit.tree.wiring import ResolvedPort


class Busy(Exception):
    def __init__(self, seconds: float, which: tuple[str, ...]) -> None:
        self.seconds, self.which = seconds, which


class Plain(Exception):
    pass


class Mode(Enum):
    SLOW = 0
    FAST = 1


@dataclass
class Place:
    x: float = 0.0
    names: tuple[str, ...] = ()


class Gripper(Protocol):
    @raises(Busy, Plain)
    def close(self, force: float) -> bool: ...

    @returns("", "width", "note")
    def measure(self, number: int) -> tuple[int, int, int]: ...

    @returns("left", "right")
    def both(self) -> tuple[int, str]: ...

    @returns("only")
    def one(self) -> str: ...

    def unnamed(self) -> tuple[int, str]: ...
    def move(self, to: Place, mode: Mode) -> Place: ...
    def turn(self, by: tuple[float, float], at: Point2D) -> tuple[float, float]: ...
    def echo(self, text: str) -> str: ...
    def all(self, object: bytes, many: list[list[Place]]) -> list[int]: ...
    def mixed(self, pair: tuple[int, str]) -> None: ...


class Other(Protocol):
    def close(self) -> None: ...
    def move(self, to: Place) -> None: ...


OWN = Interface(Gripper, "M::N::Gripper")
TEXT = definition_of([OWN, Interface(Other)])
DEFINED = interface_of("M::N::Gripper", TEXT)


def operations() -> list[ProvidedOperation]:
    port = ServicePort("port").provide(Gripper, "a", type_name=OWN.name).provide(Other, "b")
    end = ResolvedPort(parse_path("/h/X.rtc:port"), PortRef("X", "port"), port.profile)
    return [
        ProvidedOperation(end, instance, name, interface_of(name, TEXT), each)
        for instance, name in (("a", OWN.name), ("b", "Other"))
        for each in interface_of(name, TEXT).operations.values()
    ]


def test_what_is_read_back_is_called_alike():
    signatures = {name: each.signature for name, each in DEFINED.interface.methods.items()}
    assert signatures.pop("mixed", None) is None  # IDL has no words for it, but for the others
    assert signatures == {n: m.signature for n, m in OWN.methods.items() if n != "mixed"}
    assert len(signatures) == len(OWN.methods) - 1


def test_a_port_tells_its_interfaces_once_for_all_states():
    port = ServicePort("p").provide(Gripper, type_name=OWN.name).require(Other)
    assert port.profile.definition == TEXT
    assert port.profile.definition is port.copy().profile.definition
    assert ServicePort("described").profile.definition == ""


@pytest.mark.parametrize(
    ("name", "returned", "text"),
    [
        ("close", ("",), "boolean close(in double force) raises (Busy, Plain)"),
        (
            "measure",
            ("", "width", "note"),
            "long long measure(in long long number, out long long width, out long long note)",
        ),
        ("both", ("left", "right"), "void both(out long long left, out string right)"),
        ("one", ("only",), "void one(out string only)"),
        ("unnamed", ("", "out1"), "long long unnamed(out string out1)"),
        ("echo", ("",), "string echo(in string text)"),
    ],
)
def test_out_parameters(name, returned, text):
    assert DEFINED.operations[name] == (name, returned, text)
    assert (name, text) in operations_in(TEXT)


def test_operations_of_one_name_are_told_apart():
    assert interface_of("Other", TEXT).operations["close"].text == "void close()"


@pytest.mark.parametrize(
    ("error", "shown", "members"),
    [
        (Busy(2.5, ("a",)), "seconds=2.5, which=('a',)", {"seconds": 2.5, "which": ("a",)}),
        (Plain("hm"), "text='hm'", {"text": "hm"}),
    ],
)
def test_declared_exceptions_arrive_with_what_they_carry(error, shown, members):
    sent = OWN.methods["close"].encode_exception(error)
    assert sent is not None
    raised = DEFINED.interface.methods["close"].decode_exception(*sent)
    assert isinstance(raised, RaisedByProvider)
    assert isinstance(raised, Refused)
    assert (type(raised).__name__, str(raised), raised.members) == (
        type(error).__name__,
        shown,
        members,
    )


@pytest.mark.parametrize(
    ("name", "typed", "values"),
    [
        ("close", ["3"], (3.0,)),
        ("close", ["-1e3"], (-1000.0,)),
        ("echo", ["hello 42"], ("hello 42",)),
        ("echo", ["42"], ("42",)),
        ("echo", ['"a\\u00e4"'], ("aä",)),
        ("echo", ['"'], ('"',)),
        ("echo", [""], ("",)),
        ("all", ["[1, 255]", "[]"], (b"\1\xff", ())),
    ],
)
def test_arguments(name, typed, values):
    called = next(each for each in operations() if each.operation.name == name)
    assert called.arguments(typed) == values


def test_structures_and_words_of_enumerations():
    to, mode = chosen(operations(), "a.move").arguments(["{x: 1.5, names: [a]}", "FAST"])
    assert (to.x, to.names, mode.name) == (1.5, ("a",), "FAST")


@pytest.mark.parametrize(
    ("operation", "typed", "why"),
    [
        (
            "a.close",
            [],
            r"^close takes 1 argument, not 0 \(boolean close\(in double force\) raises",
        ),
        ("echo", ["a", "b"], r"^echo takes 1 argument, not 2 \(string echo\(in string text\)\)$"),
        ("both", ["1"], r"^both takes 0 arguments, not 1 \(void both\("),
        ("a.close", ["abc"], r'^close.force: "abc" is not a value of type float64 \(boolean'),
        ("a.close", ["[1"], r"^neither JSON nor YAML: \[1"),
        ("a.move", ["{y: 1}", "FAST"], r"^move.to: no field y; it has x, names \("),
        ("a.move", ["{}", "FST"], r"^move.mode: 'FST' is none of SLOW, FAST \("),
        ("measure", ["1.5"], r"^measure.number: 1.5 is not a value of type int64"),
        ("measure", ["1e99"], r"^measure.number: 1e\+99 is not a value of type int64"),
        ("all", ["[300]", "[]"], r"^all.object: 300 is not a value of type octet"),
    ],
)
def test_arguments_that_do_not_fit(operation, typed, why):
    with pytest.raises(Malformed, match=why):
        chosen(operations(), operation).arguments(typed)


def test_which_operation_is_meant():
    known = operations()
    assert chosen(known, "echo").instance == "a"
    assert chosen(known, "b.close").type_name == "Other"
    with pytest.raises(Malformed, match=r"several interfaces: a.close or b.close$"):
        chosen(known, "close")
    with pytest.raises(
        NotFound, match=r"^no operation eco of X.port \(did you mean echo\?\); it has"
    ):
        chosen(known, "eco")
    with pytest.raises(NotFound, match=r"no operation c.close"):
        chosen(known, "c.close")
    with pytest.raises(NotFound, match="no operations of Else are known"):
        interface_of("Else", TEXT)


KINDS: list[Any] = [bool, int, float, str, bytes, Long, ULong, Octet, WString, Mode, Place, Point2D]
HINTS = st.sampled_from(KINDS).flatmap(
    lambda kind: st.sampled_from(
        [kind, list[kind], tuple[kind, ...], tuple[kind, kind], list[list[kind]]]  # type: ignore[valid-type]
    )
)


@given(st.lists(HINTS, max_size=4), st.one_of(st.just(type(None)), HINTS))
def test_any_method_is_called_alike_by_its_definition(given, result):
    def method(self: Any) -> None: ...

    import inspect

    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    names = [f"in{number}" for number in range(len(given))]
    method.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [inspect.Parameter(name, kind) for name in ("self", *names)]
    )
    method.__annotations__ = {**dict(zip(names, given, strict=True)), "return": result}
    own = Interface(type("Any", (), {"method": method}))
    assume("sequence<uint8>" not in own.methods["method"].signature)  # read as bytes: left out
    defined = interface_of("Any", definition_of([own])).interface
    assert defined.methods["method"].signature == own.methods["method"].signature
