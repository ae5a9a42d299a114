"""Conformance table: required answers of every endpoint of the Property Service.

Each endpoint is a row of a test. The subject is one service; an endpoint is any object with
``ask`` (target, payload) and ``listen``.
"""

from __future__ import annotations

import itertools
import re
import socket
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Protocol

from rtkit.property.functional import FunctionalProperty
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.service import Service
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Element, Value, Word


class Door(Protocol):
    """A way to a service, as a client has it."""

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """GET, or SET."""
        ...

    def listen(self, target: str) -> AbstractContextManager[Iterator[PropertyEvent]]:
        """Listen to ``P`` or ``P?queue=…``; what is iterated waits for the next event."""
        ...


def _frame(given: dict[str, Value]) -> Content:
    return (1.0, 2.0, 0.5) if given.get("frame") == Word("robot") else (11.0, 12.0, 0.5)


def _broken(given: dict[str, Value]) -> Content:
    raise RuntimeError("no hand on the sensor")


def _clamped(value: Content, given: dict[str, Value]) -> Content:
    return min(value, 10) if isinstance(value, int | float) else value


def _refusing(value: Content, given: dict[str, Value]) -> None:
    if value == Word("odd"):
        raise ValueError("odd is not to my taste")
    if value == Word("gone"):
        raise OSError("no device")


def subject() -> Service:
    """Return the service that the rows are about; each test has its own."""
    service = Service("robot")
    number, word = parse_type("number"), parse_type("word")
    speed = PropertySpec(
        number, unit="m/s", minimum=-1, maximum=1, step=0.1, warn=(-0.5, 0.5), doc="Ahead"
    )
    service.add("speed", 0.25, speed, history=4)
    service.add("location", (1.0, 2.0, 0.0, 0.0, 0.0, 0.5), "vector[6]")
    service.add("colour", (1, 0, 0), PropertySpec(parse_type("vector[3]"), labels=("r", "g", "b")))
    service.add("mode", Word("idle"), PropertySpec(word, choices=(Word("idle"), Word("drive"))))
    service.add("name", "rover", "string")
    service.add("label", "two words", "string")
    service.add("is_on", True, "boolean")
    service.add("count", 7, "integer")
    service.add("notes", "plain (text", "text")
    service.add("blob", b"\x00\xff\n{}", "bytes")
    service.add("any", (Word("a"), (1, 2), "b c"), "any")
    location = Element("location", {}, (), (1, 2))
    service.add("target", Element("marker", {}, (location, Element("color", {}, (), Word("red")))),
                "marker")  # fmt: skip
    service.add("arm.angle", 3, "number")
    service.add("arm.joint.1", 0.5, "number")
    service.add("image.jpg", "not a picture", "text")
    service.add("a%20b", 1, "any")
    service.add("serial", Word("X1"), PropertySpec(word, access="r"))
    service.add("door_code", None, PropertySpec(word, access="w"), write=lambda value, given: None)
    frame = RequestParameter(
        "frame", word, Word("global"), (Word("global"), Word("robot")), "of what"
    )
    service.add(
        "pose", spec=PropertySpec(parse_type("vector"), "r", parameters=(frame,)), read=_frame
    )
    service.add("broken", spec=PropertySpec(number, "r"), read=_broken)
    service.add("clamped", 5, "number", write=_clamped)
    service.add("fussy", Word("even"), PropertySpec(word), write=_refusing)
    double = FunctionalProperty(lambda x, times=2: x * times, (
        RequestParameter("x", number), RequestParameter("times", number, 2)))  # fmt: skip
    service.add(
        "double", function=double, spec=PropertySpec(parse_type("element"), is_functional=True)
    )
    tallies = itertools.count(1)
    tally = FunctionalProperty(lambda: next(tallies))
    service.add(
        "tally", function=tally, spec=PropertySpec(parse_type("element"), is_functional=True)
    )
    fail = FunctionalProperty(lambda: 1 / 0)
    service.add("fail", function=fail, spec=PropertySpec(parse_type("element"), is_functional=True))
    return service


_MANY_NAMES = "%20".join(["speed", "count"])

Row = tuple[str, Payload | None, str | bytes | Callable[[str], bool]]

ROWS: tuple[Row, ...] = (
    # values
    ("speed", None, "0.25"),
    ("location", None, "(1.0 2.0 0.0 0.0 0.0 0.5)"),
    ("label", None, '"two words"'),
    ("notes", None, "plain (text"),
    ("blob", None, b"\x00\xff\n{}"),
    ("any", None, '(a (1 2) "b c")'),
    ("target", None, "<marker><location>(1 2)</location><color>red</color></marker>"),
    ("a%20b", None, "1"),
    ("%61%20b", None, "1"),
    ("image.jpg", None, "not a picture"),
    # parts and inner nodes
    ("location.x", None, "1.0"),
    ("location.c", None, "0.5"),
    ("location.5", None, "0.5"),
    ("location.q", None, "!unknown"),
    ("location.6", None, "!unknown"),
    ("location.01", None, "!unknown"),
    ("colour.g", None, "0"),
    ("target.location.1", None, "2"),
    ("target.color", None, "red"),
    ("target.color.x", None, "!unknown"),
    ("arm", None, "(angle joint)"),
    ("arm.joint.1", None, "0.5"),
    ("arm.joint.2", None, "!unknown"),
    ("any.1.0", None, "1"),
    # extensions
    ("arm.properties", None, "(angle joint)"),
    ("arm.properties?all", None, "(angle joint joint.1)"),
    ("location.properties", None, "(x y z a b c)"),
    ("colour.properties", None, "(r g b)"),
    ("target.properties", None, "(location color)"),
    ("properties?match=s*", None, "(speed serial)"),
    (f"properties?names=({_MANY_NAMES})&values", None, "((speed 0.25) (count 7))"),
    ("properties?names=(speed%20nope)&values", None, "!unknown"),
    (
        "properties?names=(blob%20notes)&values",
        None,
        '((blob <bytes length="5"/>) (notes "plain (text"))',
    ),
    ("properties?names=(door_code)&values", None, "!write-only"),
    (
        "arm.properties?meta",
        None,
        lambda text: (
            text.startswith("((angle <meta><type>number</type>") and text.endswith(" 3) (joint))")
        ),
    ),
    ("count.listen.properties", None, "!unknown"),
    ("count.nope.properties", None, "!unknown"),
    ("count.properties.properties", None, "!unknown"),
    ("count.listen.nope", None, "!unknown"),
    ("nope.properties", None, "!unknown"),
    ("nope.listen", None, "!unknown"),
    ("count.listen.properties", "1", "!unknown"),
    ("nope.properties", "((x 1))", "!unknown"),
    ("location.q.gui", None, "!unknown"),
    ("properties?nonsense=1", None, "!bad-parameter"),
    ("properties?depth=red", None, "!bad-parameter"),
    ("speed.meta.unit", None, '"m/s"'),
    ("speed.meta.severity", None, "none"),
    ("speed.meta.quality", None, "good"),
    ("broken.meta.quality", None, "bad"),
    ("speed.meta.nonsense", None, "!unknown"),
    (
        "speed.gui",
        None,
        '<gui kind="slider" min="-1" max="1" step="0.1" unit="m/s" name="speed" '
        'type="number" access="rw" warn="(-0.5 0.5)" doc="Ahead"/>',
    ),
    (
        "mode.gui",
        None,
        '<gui kind="choice" choices="(idle drive)" name="mode" type="word" access="rw"/>',
    ),
    ("speed.gui.html", None, "!unknown"),
    ("pose.parameters", None, '((frame word global (global robot) "of what"))'),
    ("double.parameters", None, '((x number () () "") (times number 2 () ""))'),
    ("count.history", None, "!unknown"),
    ("nope.meta", None, "!unknown"),
    # parameters
    ("pose", None, "(11.0 12.0 0.5)"),
    ("pose?frame=robot", None, "(1.0 2.0 0.5)"),
    ("pose?frame=robot&frame=global", None, "!bad-parameter"),
    ("pose?frame=moon", None, "!bad-parameter"),
    ("pose?frame=3", None, "!bad-parameter"),
    ("speed?frame=robot", None, "!bad-parameter"),
    ("speed?=1", None, "!bad-parameter"),
    ("speed?", None, "!bad-parameter"),
    # sets
    ("speed", "0.5", ""),
    ("speed", None, "0.5"),
    ("speed.history?n=1", None, lambda text: text.endswith(" good 0.5))")),
    ("speed", "2", "!bad-value"),
    ("speed", "-1.0001", "!bad-value"),
    ("speed", "nan", "!bad-value"),
    ("speed", "fast", "!bad-value"),
    ("speed", "(", "!syntax"),
    ("speed", "1 2", "!syntax"),
    ("speed", "", "!bad-value"),
    ("speed", None, "0.5"),
    ("speed?echo", "0.75", "0.75"),
    ("speed.meta.severity", None, "warn"),
    ("speed?if=1", "0.1", "!conflict"),
    ("speed?if=red", "0.1", "!bad-parameter"),
    ("speed?nonsense", "0.1", "!bad-parameter"),
    ("clamped?echo=1", "70", "10"),
    ("count", "1.5", "!bad-value"),
    ("count", "  8  ", ""),
    ("count", None, "8"),
    ("mode", "drive", ""),
    ("mode", "fly", "!bad-value"),
    ("name", "word", ""),
    ("name", None, '"word"'),
    ("name", '"a \\u{e9}\\n\\"q\\""', ""),
    ("name", None, '"a é\\n\\"q\\""'),
    ("name", "7", ""),
    ("name", None, '"7"'),
    ("name", "(7)", "!bad-value"),
    ("notes", 'Zeile\nzwei ((" <', ""),
    ("notes", None, 'Zeile\nzwei ((" <'),
    ("blob", b"\xff\x00\xfe{3}\r\n", ""),
    ("blob", None, b"\xff\x00\xfe{3}\r\n"),
    ("any", "( nan inf -0.0 )", ""),
    ("any", None, "(nan inf -0.0)"),
    ("any", "<a b='1'><c/>  <d>x  y</d></a>", ""),
    ("any", None, '<a b="1"><c/><d>x  y</d></a>'),
    ("location.x", "5", ""),
    ("location", None, "(5 2.0 0.0 0.0 0.0 0.5)"),
    ("location.x", "red", "!bad-value"),
    ("location.q", "1", "!unknown"),
    ("location", "(1 2 3)", "!bad-value"),
    ("target.color", "blue", ""),
    ("target.color", None, "blue"),
    ("target", "<marker><color>red</color></marker>", "!bad-value"),
    ("target", "<other/>", "!bad-value"),
    ("serial", "X2", "!read-only"),
    ("pose", "(1 2)", "!read-only"),
    ("arm", "3", "!read-only"),
    ("speed.meta", "3", "!read-only"),
    ("speed.meta.unit", "3", "!read-only"),
    ("door_code", "1234", "!bad-value"),
    ("door_code", "sesame", ""),
    ("door_code", None, "!write-only"),
    ("fussy", "odd", "!bad-value"),
    ("fussy", "gone", "!internal"),
    ("fussy", None, "even"),
    ("broken", None, "!internal"),
    # bulk: all or nothing
    ("properties", "((count 9) (arm.angle 4))", ""),
    ("properties?names=(count%20arm.angle)&values", None, "((count 9) (arm.angle 4))"),
    ("properties", "((count 10) (arm.angle red))", "!bad-value"),
    ("properties", "((count 10) (nope 1))", "!unknown"),
    ("properties", "((count 10) (serial Y))", "!read-only"),
    ("properties", "((count 10) (count 11))", "!bad-value"),
    ("properties", "((count 10) (fussy odd))", "!bad-value"),
    ("properties", "((count 10) (double 1))", "!bad-value"),
    ("properties", "((count 10) 3)", "!bad-value"),
    ("properties", "3", "!bad-value"),
    ("count", None, "9"),
    ("arm.properties", "((angle 6) (joint.1 7))", ""),
    ("arm.joint.1", None, "7"),
    # functional
    ("double", None, '<call state="idle"/>'),
    ("double?echo", "21", '<call state="done"><result>42</result></call>'),
    ("double", "(3 5)", ""),
    ("double", None, '<call state="done"><result>15</result></call>'),
    ("double?x=4&times=3&echo", "", '<call state="done"><result>12</result></call>'),
    ("double.state", None, "done"),
    ("double", "red", "!bad-value"),
    ("double", "", "!bad-value"),
    ("double", "(1 2 3)", "!bad-value"),
    ("double?y=1", "1", "!bad-parameter"),
    ("fail?echo", "", lambda text: text.startswith('<call state="failed"><error code="internal">')),
    # once: repeated with its id it acts once
    ("tally?id=7&echo", "", '<call state="done"><result>1</result></call>'),
    ("tally?id=7&echo", "", '<call state="done"><result>1</result></call>'),
    ("tally?id=8&echo", "", '<call state="done"><result>2</result></call>'),
    ("tally?id=7&echo", "", '<call state="done"><result>1</result></call>'),
    ("tally?echo", "", '<call state="done"><result>3</result></call>'),
    ("tally?echo", "", '<call state="done"><result>4</result></call>'),
    # names
    ("", None, "!syntax"),
    (".", None, "!syntax"),
    ("speed..x", None, "!syntax"),
    ("speed.", None, "!syntax"),
    ("sp%eed", None, "!syntax"),
    ("%ff%fe", None, "!syntax"),
    ("%2", None, "!syntax"),
    ("späße", None, "!syntax"),
    ("*", None, "!syntax"),
    ("Speed", None, "!unknown"),
    ("x" * 256, None, "!too-large"),
    (".".join("x" * 33), None, "!too-large"),
    ("nope", None, "!unknown"),
    ("nope", "1", "!unknown"),
    # too much
    ("any", "(" * 1_000_000, "!too-large"),
    ("any", "<a>" * 65, "!too-large"),
    ("any", "(" * 64 + ")" * 64, ""),
    ("any", "(" * 65 + ")" * 65, "!too-large"),
    ("any", "9" * 1001, "!too-large"),
    ("any", "x" * ((1 << 20) + 1), "!too-large"),
    ("any", "\x00", "!syntax"),
    ("any", b"\xff\xfe", "!syntax"),
    ("notes", b"\xed\xa0\x80", "!syntax"),
    ("count", "nan", "!bad-value"),
    ("properties", "((a%20b 1) (%61%20b 2))", "!bad-value"),
    ("properties?names=(%2561%2520b)&values", None, "((a%20b 1))"),
    ("any", '"\x1b"', "!syntax"),
    ("any", "<!DOCTYPE a>", "!syntax"),
    ("any", '<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "!syntax"),
    ("any", "<a>&b;</a>", "!syntax"),
    ("any", "<a><![CDATA[x]]></a>", "!syntax"),
    ("any", "<?xml version='1.0'?><a/>", "!syntax"),
    ("any", "<a>text<b/></a>", "!syntax"),
    ("any", "<a x='1' x='2'/>", "!syntax"),
    ("any", "<a></b>", "!syntax"),
    ("any", "{3}", "!syntax"),
    ("any", ")", "!syntax"),
    ("any", '"\\q"', "!syntax"),
    ("any", '"\\u{d800}"', "!syntax"),
    ("any", "()", ""),
)


def check_answers(endpoint: Door, rows: tuple[Row, ...] = ROWS) -> None:
    """Ask everything of a fresh subject in order, and compare."""
    wrong = [told for row in rows if (told := _compared(endpoint, row))]
    assert not wrong, "\n" + "\n".join(wrong)


def _compared(endpoint: Door, row: Row) -> str:
    target, payload, expected = row
    answer = endpoint.ask(target, payload)
    asked = f"{'GET' if payload is None else 'SET'} {target[:60]} {str(payload)[:60]}"
    if isinstance(expected, str) and expected.startswith("!"):
        found: Payload = f"!{answer.error}"
        if answer.error and not answer.payload:
            return f"{asked}: {answer.error} without a word"
    elif answer.error:
        found = f"!{answer.error} {answer.payload!s}"
    elif callable(expected):
        return "" if expected(str(answer.payload)) else f"{asked}: {answer.payload!r}"
    else:
        found = answer.payload
        if isinstance(expected, bytes) and isinstance(found, str):
            found = found.encode("utf-8", "surrogateescape")
    return "" if found == expected else f"{asked}: expected {expected!r}, found {found!r}"


def check_once(path: str) -> None:
    """Ask twice with one id at a unix socket of the line protocol, for each of two connections."""
    counts: list[str] = []
    for _ in range(2):
        with socket.socket(socket.AF_UNIX) as end:
            end.settimeout(30.0)
            end.connect(path)
            with end.makefile(encoding="utf-8") as replies:
                for id in ("a", "a", "b", "a"):
                    end.sendall(f"#{id} SET tally?echo \n".encode())
                    counts += re.findall(r"^#(. =.*?>\d+<)", replies.readline())
    told = [re.sub(r" =.*>(\d+)<", r"\1", each) for each in counts]
    assert told == ["a1", "a1", "b2", "a1", "a3", "a3", "b4", "a3"], counts


def check_events(
    endpoint: Door, service: Service, as_owner: Callable[[Callable[[], None]], None]
) -> None:
    """Listen in every way there is; `as_owner` runs something as the service's owner."""
    with endpoint.listen("count?queue=100") as events:
        assert next(events).payload == "7"
        for value in range(20, 25):
            as_owner(lambda value=value: service.update("count", value))  # type: ignore[misc]
        heard = [next(events) for _ in range(5)]
        assert [event.payload for event in heard] == ["20", "21", "22", "23", "24"]
        assert [event.dropped for event in heard] == [0] * 5
        revisions = [event.revision for event in heard]
        assert revisions == sorted(set(revisions))
        as_owner(lambda: service.update("count", 24))
        as_owner(lambda: service.update("count", 25, "uncertain"))
        last = next(events)
        assert (last.payload, last.quality) == ("25", "uncertain")
    with endpoint.listen("location.x?initial=0") as events:
        as_owner(lambda: service.update("location", (1.0, 9.0, 0.0, 0.0, 0.0, 0.5)))
        as_owner(lambda: service.update("location", (8.0, 9.0, 0.0, 0.0, 0.0, 0.5)))
        assert next(events).payload == "8.0"
    with endpoint.listen("arm.angle?deadband=0.5&queue=9") as events:
        for value in (3.2, 3.4, 3.6, 3.7, 4.2):
            as_owner(lambda value=value: service.update("arm.angle", value))  # type: ignore[misc]
        assert [next(events).payload for _ in range(3)] == ["3", "3.6", "4.2"]
    with endpoint.listen("mode?mode=all&queue=9&initial=0") as events:
        for _ in range(2):
            assert endpoint.ask("mode", "idle").error == ""
        assert [next(events).payload for _ in range(2)] == ["idle", "idle"]
    with endpoint.listen("properties?mode=diff&queue=9&initial=0") as events:
        as_owner(lambda: _hotplug(service))
        assert next(events).payload == "((added gripper) (removed))"
        with endpoint.listen("gripper") as of_gripper:
            assert next(of_gripper).payload == "0"
            as_owner(lambda: service.remove("gripper"))
            gone = next(of_gripper)
            assert (gone.quality, gone.code) == ("bad", "unknown")
        assert next(events).payload == "((added) (removed gripper))"
    for target, code in (
        ("nope", "unknown"),
        ("count?queue=0", "bad-parameter"),
        ("count?queue=1000000", "bad-parameter"),
        ("count?every=-1", "bad-parameter"),
        ("count?every=inf", "bad-parameter"),
        ("count?mode=some", "bad-parameter"),
        ("count?nonsense=1", "bad-parameter"),
        ("door_code", "write-only"),
    ):
        name, mark, tail = target.partition("?")
        assert endpoint.ask(f"{name}.listen{mark}{tail}", "self").error == code, target
    assert endpoint.ask("count.listen", "tcp://elsewhere/x").error == "denied"


def _hotplug(service: Service) -> None:
    service.add("gripper", 0, "number")
