"""The short way answers as the long one does, or not at all."""

from __future__ import annotations

import pytest
from conformance import subject

from rtkit.property.access import read_policy
from rtkit.property.line import Requests, write_answer
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.objects import Exported
from rtkit.property.requests import ListeningRequester, PropertyRequest, Requester
from rtkit.property.service import Service

LINES = [
    b"GET speed", b"GET speed ", b"GET  speed", b"GET speed\r", b"GET", b"GET ", b"SET", b"SET ",
    b"SET speed", b"SET speed ", b"SET speed 0.5", b"SET speed 0.5\r", b"SET speed  0.5 ",
    b"SET speed +.5", b"SET speed 1e-3", b"SET speed -0.0", b"SET speed 2", b"SET speed nan",
    b"SET speed inf", b"SET speed (", b"SET speed {3}", b"SET speed true", b"SET speed?if=1 0.1",
    b"SET notes", b"SET notes ", b"SET notes SET notes", b"SET notes {3}", b"SET notes a b  c ",
    b"SET count 007", b"SET count 1.0", b"SET count " + b"9" * 40, b"SET count " + b"9" * 1001,
    b"SET name word", b'SET name "a b"', "SET name späße".encode(), b"SET name \xff",
    b"SET serial X", b"SET door_code open", b"GET door_code", b"SET fussy odd", b"GET broken",
    b"GET location.x", b"SET location.x 3", b"GET blob", b"SET blob abc", b"GET double",
    b"SET double 3", b"GET sp\xffeed", b"XET speed", b"SETspeed 1", b"#7 GET speed", b"", b" ",
    b"GET %73peed", b"SET arm.angle 5", b"SET arm.angle red", b"GET arm", b"SET mode drive",
    b"SET mode fly",
]  # fmt: skip
ENDS = ("speed", "notes", "count", "name", "arm.angle", "mode", "location", "blob")


def _long(service: Service, line: bytes, caller: Requester) -> bytes:
    requests = Requests()
    requests.feed(line)
    asked = requests.next()
    assert asked is not None
    assert asked.error is None, "the short way took what is no request"
    answers: list[Answer] = []
    service.handle(PropertyRequest(asked.target, asked.payload, answers.append, caller))
    return write_answer(answers[0])


@pytest.mark.parametrize("rules", ["", "deny * * SET arm\ndeny * * GET notes"])
def test_it_comes_to_the_same(rules: str) -> None:
    short, long = subject(), subject()
    caller = Requester("known")
    caller.access = read_policy(rules).access("unix")
    taken = 0
    for line in LINES * 2:
        reply = short.quick(line + b"\n", caller)
        if reply is None:
            continue
        taken += 1
        assert reply == _long(long, line + b"\n", caller), line
        assert [short.get(name) for name in ENDS] == [long.get(name) for name in ENDS], line
    assert taken > 40


class Arm:
    """An object whose attributes are plain, and one that is not."""

    def __init__(self) -> None:
        self.angle = 0.5
        self.mode = "idle"
        self.joints = [1, 2]

    @property
    def double(self) -> float:
        return 2 * self.angle


@pytest.mark.parametrize(
    "line",
    [b"GET angle", b"SET angle 2.5", b"SET angle red", b"SET angle 7", b"GET mode", b"SET mode on",
     b"GET joints", b"SET joints (1 2 3)"],
)  # fmt: skip
def test_plain_attributes_need_no_long_way(line: bytes) -> None:
    short, long, caller = Service(), Service(), Requester("known")
    one, other = Arm(), Arm()
    Exported(short, one)
    Exported(long, other)
    heard = [_listening(each, "angle") for each in (short, long)]
    assert short.quick(line + b"\n", caller) == _long(long, line + b"\n", caller)
    assert vars(one) == vars(other)
    assert [each.payload for each in heard[0]] == [each.payload for each in heard[1]]


@pytest.mark.parametrize("line", [b"GET double\n", b"SET double 1\n"])
def test_code_of_users_is_left_to_the_long_way(line: bytes) -> None:
    service, arm = Service(), Arm()
    Exported(service, arm)
    assert service.quick(line, Requester("known")) is None


def _listening(service: Service, name: str) -> list[PropertyEvent]:
    heard: list[PropertyEvent] = []

    class Ear(ListeningRequester):
        def wake(self) -> None:
            self.send_due(0.0, lambda: True, lambda _, event: heard.append(event))

    service.handle(PropertyRequest(f"{name}.listen", "self", lambda _: None, Ear("known")))
    return heard


def test_it_knows_of_names_that_come_and_go() -> None:
    service, caller = subject(), Requester("known")
    assert service.quick(b"GET count\n", caller) == b"= 7\n"
    service.remove("count")
    assert service.quick(b"GET count\n", caller) is None
    service.add("count", 3, "integer")
    assert service.quick(b"GET count\n", caller) == b"= 3\n"
    assert service.quick(b"SET count 4\n", Requester("")) is None
    assert service.quick(b"GET count\n", caller) == b"= 3\n"


def test_listings_tell_present_values_of_what_may_be_got() -> None:
    service, known, ruled = Service(), Requester("known"), Requester("known")
    ruled.access = read_policy("deny * * GET b").access("unix")
    for name, value in (("a", 1.0), ("b", 2.0), ("true", 3.0)):
        service.add(name, value, "number")
    target = "properties?values&names=(a%20b%20%22true%22)"

    def told(caller: Requester) -> tuple[object, str]:
        answers: list[Answer] = []
        service.handle(PropertyRequest(target, None, answers.append, caller))
        return answers[0].payload, answers[0].error

    assert told(known) == ('((a 1.0) (b 2.0) ("true" 3.0))', "")
    service.update("a", -0.0)
    assert told(known) == ('((a -0.0) (b 2.0) ("true" 3.0))', "")
    service.quick(b"SET a 0.0\n", known)
    assert told(known) == ('((a 0.0) (b 2.0) ("true" 3.0))', "")
    assert told(ruled)[1] == "denied"
    service.remove("b")
    assert told(known)[1] == "unknown"


def test_each_change_of_a_number_is_one_and_no_other() -> None:
    service, known = Service(), Requester("known")
    service.add("x", 0.0, "number")
    revisions = []
    for text in ("0.0", "-0.0", "0.0", "nan", "nan", "inf", "2.5", "2.50", "2", "2.0", "1e400"):
        assert service.quick(f"SET x {text}\n".encode(), known) == b"=\n"
        revisions.append(service.revision("x"))
    assert revisions == [1, 2, 3, 4, 4, 5, 6, 6, 7, 8, 9]
