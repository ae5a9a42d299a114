"""Objects as properties: what is shown, of what type, what is not; classes stay as they are."""

from __future__ import annotations

import dataclasses
import queue
import re
import statistics
import threading
import typing
from collections.abc import Mapping
from enum import Enum
from typing import Annotated

import numpy
import pytest
from simple_pid import PID

from rtkit.property.annotations import Range, Unit
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer
from rtkit.property.objects import Exported
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.service import Service


class Mode(Enum):
    IDLE = 1
    DRIVE = 2


@dataclasses.dataclass
class Arm:
    angle: Annotated[float, Unit("rad"), Range(-3, 3, 0.1)] = 0.0
    name: str = "left"
    _torque: float = 1.0

    def wave(self, times: int = 1) -> int:
        return times * 2


@dataclasses.dataclass(frozen=True)
class Fixed:
    x: float = 1.0


class Robot:
    """A robot.

    Attributes:
        speed: How fast
            it goes.
    """

    kind: typing.Final = "rover"
    _secret = 7

    def __init__(self) -> None:
        self.speed = 0.0
        self.mode = Mode.IDLE
        self.arm = Arm()
        self.fixed = Fixed()
        self.me = self
        self.path = [1.0, 2.0]
        self.tags = ["a", "b c"]
        self.raw = b"\x00"
        self.extra: dict[str, int] = {"a": 1, "_b": 2}
        self.nothing = None
        self.lock = threading.Lock()
        self.module = statistics
        self.cls = Arm
        self.call = lambda: 1
        self.pose = numpy.zeros(3)
        self.grid = numpy.eye(2, dtype=int)
        self.count = numpy.int64(4)
        self._gain = 1.0

    def get_gain(self) -> float:
        """Of the loop."""
        return self._gain

    def set_gain(self, value: float) -> None:
        self._gain = value

    def setOnly(self, value: float) -> None:  # noqa: N802
        self._gain = value

    def move(self, x: float, *, fast: bool = False) -> float:
        """Move it."""
        if x < 0:
            raise ValueError("backwards")
        return x * (2 if fast else 1)

    def get_by(self, key: str) -> str:
        return key

    def _hidden(self) -> None:
        raise AssertionError

    @property
    def broken(self) -> float:
        raise RuntimeError("no sensor")


def served(thing: object, *hidden: str) -> Service:
    service = Service("o")
    Exported(service, thing, hidden)
    return service


def refused(service: Service, target: str, payload: str | None = None) -> str:
    with pytest.raises(PropertyError) as error:
        service.get(target) if payload is None else service.set(target, payload)
    return error.value.code


def test_what_is_shown_and_nothing_else() -> None:
    service = served(Robot())
    names = str(service.get("properties")).strip("()").split()
    assert set(names) == {
        "kind", "move", "get_by", "broken", "speed", "mode", "arm", "fixed", "path", "tags", "raw",
        "extra", "nothing", "pose", "grid", "count", "gain", "only",
    }  # fmt: skip
    assert service.get("arm") == "(angle name wave)"
    assert service.get("extra") == "(a)"
    for name in ("_secret", "lock", "me", "__class__", "arm._torque", "extra._b", "module", "cls"):
        assert refused(service, name) == "unknown"


def test_hidden_names_stay_hidden() -> None:
    service = served(Robot(), "speed", "angle")
    assert refused(service, "speed") == "unknown"
    assert service.get("arm") == "(name wave)"


def test_a_nested_object_is_followed_where_it_goes() -> None:
    robot = Robot()
    service = served(robot)
    service.set("arm.angle", "1")
    assert (robot.arm.angle, type(robot.arm.angle)) == (1.0, float)
    robot.arm = Arm(2.0, "right")
    assert service.get("properties?names=(arm.angle%20arm.name)&values") == (
        '((arm.angle 2.0) (arm.name "right"))'
    )
    assert refused(service, "arm.angle", "4") == "bad-value"
    assert service.get("arm.angle.gui") == (
        '<gui kind="slider" min="-3" max="3" step="0.1" unit="rad" name="arm.angle" type="number" '
        'access="rw"/>'
    )
    assert service.set("arm.wave?echo", "3") == '<call state="done"><result>6</result></call>'


def test_types_follow_from_annotations_and_values() -> None:
    robot = Robot()
    service = served(robot)
    types = {name: service.get(f"{name}.meta.type") for name in (
        "speed", "mode", "path", "raw", "gain", "arm.name", "count", "tags")}  # fmt: skip
    assert types == {
        "speed": "number", "mode": "word", "path": "vector", "raw": "bytes", "gain": "number",
        "arm.name": "string", "count": "any", "tags": "list",
    }  # fmt: skip
    assert service.get("speed.meta.doc") == '"How fast it goes."'
    assert service.get("mode.meta.choices") == "(IDLE DRIVE)"
    service.set("mode", "DRIVE")
    assert robot.mode is Mode.DRIVE
    assert refused(service, "mode", "FLY") == "bad-value"
    service.set("tags", "(x y)")
    assert robot.tags == ["x", "y"]
    service.set("raw", b"\xff")
    assert robot.raw == b"\xff"


def test_arrays_keep_their_shape() -> None:
    robot = Robot()
    service = served(robot)
    service.set("pose", "(1 2 3)")
    service.set("pose.y", "7")
    assert robot.pose.tolist() == [1.0, 7.0, 3.0]
    assert robot.pose.dtype == float
    assert service.get("grid") == "((1 0) (0 1))"
    assert refused(service, "pose", "(1 2)") == "bad-value"


def test_access_follows_from_the_class() -> None:
    service = served(Robot())
    for name in ("kind", "broken", "fixed.x"):
        assert refused(service, name, "3") == "read-only"
    assert refused(service, "only") == "write-only"
    answers: list[Answer] = []
    ear = Requester("ear")
    service.handle(PropertyRequest("only.listen", "self", answers.append, ear))
    assert [each.error for each in answers] == ["write-only"]
    assert refused(service, "broken") == "internal"
    assert service.get("broken.meta.quality") == "bad"


def test_getters_and_setters_are_one_property() -> None:
    robot = Robot()
    service = served(robot)
    service.set("gain", "2")
    service.set("only", "3")
    assert (robot._gain, service.get("gain")) == (3.0, "3.0")
    assert service.get("gain.meta.doc") == '"Of the loop."'
    assert service.get("get_by.parameters") == '((key string () () ""))'


def test_what_cannot_be_got_yet_can_be_set() -> None:
    class Frame:
        def __init__(self) -> None:
            self._image: bytes | None = None
            self._asked = 0

        def get_image(self) -> bytes:
            self._asked += 1
            if self._image is None:
                raise PropertyError("no-service", "no picture yet")
            return self._image

        def set_image(self, image: bytes) -> None:
            self._image = image

    frame = Frame()
    service = served(frame)
    assert refused(service, "image") == "no-service"
    service.set("image", b"\xff")
    assert (service.get("image"), frame._asked) == (b"\xff", 3)


def test_methods_are_actions_with_their_signature() -> None:
    service = served(Robot())
    assert service.get("move.parameters") == '((x number () () "") (fast boolean false () ""))'
    assert service.set("move?fast&echo", "3") == '<call state="done"><result>6.0</result></call>'
    failed = '<call state="failed"><error code="bad-value">ValueError: backwards</error></call>'
    assert service.set("move?echo", "-1") == failed
    assert refused(service, "move", "red") == "bad-value"


def test_keys_that_come_and_go_are_told() -> None:
    robot, heard = Robot(), []
    service = served(robot)
    subscription = Requester("ear")
    subscription.listen = heard.append  # type: ignore[method-assign]
    service.handle(
        PropertyRequest(
            "extra.properties.listen?queue=9&initial=0&mode=diff", "self", print, subscription
        )
    )
    robot.extra["new"] = 3
    assert service.get("extra.new") == "3"
    del robot.extra["a"]
    assert service.get("extra") == "(new)"
    assert service.get("extra.properties") == "(new)"
    events = iter(lambda: heard[0].take(service.values.clock()), None)
    assert [event.payload for event in events] == [
        "((added extra.new) (removed))", "((added) (removed extra.a))"]  # fmt: skip


def test_a_class_of_the_standard_library() -> None:
    before = vars(statistics.NormalDist).copy()
    service = served(statistics.NormalDist(10, 2))
    assert service.get("properties?names=(mean%20stdev)&values") == "((mean 10.0) (stdev 2.0))"
    assert refused(service, "mean", "3") == "read-only"
    assert service.set("cdf?echo", "10") == '<call state="done"><result>0.5</result></call>'
    assert vars(statistics.NormalDist) == before


def test_a_class_of_the_package_index() -> None:
    pid = PID(1, 0.1, 0.05, setpoint=1)
    service = served(pid)
    service.set("Kp", "2.5")
    service.set("tunings", "(1 2 3)")
    service.set("output_limits", "(0 10)")
    assert (pid.Kp, pid.tunings, pid.output_limits) == (1, (1, 2, 3), (0, 10))
    assert refused(service, "output_limits", "(10 0)") == "bad-value"
    service.set("auto_mode", "false")
    assert pid.auto_mode is False
    assert refused(service, "components", "(1 2 3)") == "read-only"
    assert type(pid) is PID


class Metering:
    """Getters that may be asked in several ways."""

    def __init__(self) -> None:
        self.label = "left"
        self._metres = 2.0

    def get_length(self, unit: typing.Literal["m", "cm"] = "m", digits: int = 3) -> float:
        return round(self._metres * (100 if unit == "cm" else 1), digits)

    def set_length(self, value: float, is_relative: bool = False) -> None:
        self._metres = value + (self._metres if is_relative else 0)

    def say(self, text: str) -> str:
        return text


def test_parameters_reach_getters_and_setters() -> None:
    service = Service("meter")
    Exported(service, Metering())
    assert service.get("length") == "2.0"
    assert service.get("length?unit=cm") == "200.0"
    assert service.get("length?digits=0") == "2.0"
    assert service.get("length.parameters") == (
        '((unit string "m" ("m" "cm") "") (digits integer 3 () "") '
        '(is_relative boolean false () ""))'
    )
    for wrong in ("length?unit=km", "length?digits=red", "length?nonsense", "length?is_relative"):
        with pytest.raises(PropertyError) as refused:
            service.get(wrong)
        assert refused.value.code == "bad-parameter", wrong
    with pytest.raises(PropertyError, match=r"no parameter digts \(did you mean digits\?\)$"):
        service.get("length?digts=1")
    with pytest.raises(PropertyError, match=r"\(a text with blanks stands in quotes\)$"):
        service.get("length?unit=c > 0.4")
    service.set("length?is_relative", "1")
    assert service.get("length") == "3.0"
    with pytest.raises(PropertyError) as refused:
        service.set("length?unit=cm", "1")
    assert refused.value.code == "bad-parameter"


def test_what_looks_like_a_number_is_taken_for_a_string() -> None:
    service = Service("meter")
    Exported(service, Metering())
    for payload, told in (("7", '"7"'), (" 1.50 ", '"1.50"'), ("nan", '"nan"'), ("true", '"true"')):
        service.set("label", payload)
        assert service.get("label") == told
        done = service.set("say?echo", payload)
        assert done == f'<call state="done"><result>{told}</result></call>'
    for payload in ("(1 2)", "<a/>"):
        with pytest.raises(PropertyError) as refused:
            service.set("label", payload)
        assert refused.value.code == "bad-value"


def test_a_history_is_kept_of_what_is_told() -> None:
    service = Service("meter")
    service.remember("len*", 2)
    meter = Metering()
    Exported(service, meter)
    assert service.is_polled
    for metres in (2.0, 2.0, 5.0, 7.0):
        meter._metres = metres
        service.poll()
        service.get("length")
    rows = service.get("length.history")
    assert re.findall(r" good ([\d.]+)\)", str(rows)) == ["5.0", "7.0"]
    with pytest.raises(PropertyError):
        service.get("label.history")


class Holding:
    """Getters with side effects, one that tells an object, and what only looks like a getter."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.nested = queue.Queue()  # type: ignore[var-annotated]

    @property
    def limb(self) -> object:
        self.calls.append("limb")
        return Arm(0.5)

    def get_next(self):  # type: ignore[no-untyped-def]
        self.calls.append("next")
        return 1.5

    def set_next(self, value):  # type: ignore[no-untyped-def]
        self.calls.append(f"set {value}")


def test_names_are_listed_without_a_call_of_any_getter() -> None:
    holding = Holding()
    service = served(holding)
    assert service.get("properties?all") == "(limb calls next)"
    assert str(service.get("properties?meta")).count("<meta>") == 3
    assert holding.calls == []
    tail = service.get("properties?values&names=(next)")
    assert (tail, holding.calls) == ("((next 1.5))", ["next"])


def test_getters_of_the_standard_library_are_none() -> None:
    filled: queue.SimpleQueue[int] = queue.SimpleQueue()
    waiting: queue.Queue[int] = queue.Queue()
    for each in (filled, waiting):
        each.put(1)
        service = served(each)
        service.get("properties?all&meta")
        assert service.set("get_nowait?echo", "") == (
            '<call state="done"><result>1</result></call>'
        )


def test_what_a_getter_tells_has_names_below_it_when_somebody_asks() -> None:
    holding = Holding()
    service = served(holding)
    assert service.get("limb.angle") == "0.5"
    assert service.get("limb") == "(angle name wave)"
    assert service.get("properties?all") == "(calls next limb limb.angle limb.name limb.wave)"


def test_the_type_of_a_getter_is_known_from_its_first_value() -> None:
    holding = Holding()
    service = served(holding)
    assert refused(service, "next", "red") == "bad-value"
    service.set("next", "3")
    assert holding.calls[-2:] == ["set 3", "next"]
    assert service.get("next.meta.type") == "number"


def test_a_first_set_with_an_id_sets() -> None:
    holding = Holding()
    service = served(holding)
    for _ in range(2):
        assert service.set("next?id=1&echo", "3") == "1.5"
    assert holding.calls.count("set 3") == 1


def test_all_or_none_holds_where_a_type_is_learnt_meanwhile() -> None:
    class Pair(Holding):
        level: int = 1

    holding = Pair()
    service = served(holding)
    assert refused(service, "properties", "((level 2) (next red))") == "bad-value"
    assert holding.level == 1
    service.set("properties", "((level 2) (next 3))")
    assert (holding.level, holding.calls[-2]) == (2, "set 3")


class Strict:
    """What annotations say of the inside of values."""

    names: list[str]
    pair: tuple[int, str]
    flags: set[bool]
    table: dict[str, int]
    maybe: float | None
    either: int | str
    kind: typing.Literal["a", "c"]
    rows: list[list[float]]

    def __init__(self) -> None:
        self.names, self.pair, self.flags = ["a"], (1, "b"), {True}
        self.table, self.maybe, self.either, self.kind = {}, None, 1, "a"
        self.rows = [[1.0]]
        self.small = numpy.zeros(2, dtype=numpy.int32)
        self.tiny = numpy.uint8(4)


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("names", {"(x y)": ["x", "y"], "()": []}, ["(1 2)", "(x 2)", "x"]),
        ("pair", {"(2 x)": (2, "x")}, ["(x 2)", "(2)", "(2 x y)", "(2.5 x)"]),
        ("flags", {"(false)": {False}}, ["(1)", "(red)"]),
        ("maybe", {"2": 2.0, "()": None}, ["red", "(1)"]),
        ("either", {"2": 2, "red": "red"}, ["2.5", "(1)"]),
        ("kind", {"a": "a", "c": "c"}, ["b", "4"]),
        ("rows", {"((1 2) (3 4))": [[1.0, 2.0], [3.0, 4.0]]}, ["(1 2)", "((1 red))"]),
        ("small", {"(1 -2)": [1, -2]}, ["(2.5 0)", "(2147483648 0)", "(red 0)", "(1)"]),
        ("tiny", {"255": 255}, ["256", "-1", "2.5", "1e30"]),
    ],
)
def test_what_is_inside_a_value_is_checked_too(
    name: str, good: dict[str, object], bad: list[str]
) -> None:
    strict = Strict()
    service = served(strict)
    for text, value in good.items():
        service.set(name, text)
        told = getattr(strict, name)
        assert (told.tolist() if hasattr(told, "tolist") else told) == value
    before = service.get(name)
    for text in bad:
        assert refused(service, name, text) == "bad-value", text
    assert service.get(name) == before


class Steering:
    def steer(self, direction):  # type: ignore[no-untyped-def]
        return direction


def test_a_vector_that_is_the_only_argument_needs_no_second_bracket() -> None:
    service = served(Steering())
    for payload in ("(1 0)", "((1 0))"):
        done = service.set("steer?echo", payload)
        assert done == '<call state="done"><result>(1 0)</result></call>', payload


class Initialised:
    def __init__(self, gain: float) -> None:
        self.gain: Annotated[float, Unit("V"), Range(0, 10)] = gain
        self.steps: typing.Final = 3
        if gain:
            self.names: list[str] = []
        self.lost: NoSuchThing = 1  # type: ignore[name-defined]  # noqa: F821


class Later(Initialised):
    def __init__(self) -> None:
        super().__init__(1)
        self.more: Annotated[float, Unit("A")] = 2


def test_annotations_in_init_count_as_those_of_the_class() -> None:
    service = served(Later())
    assert service.get("gain.meta.unit") == '"V"'
    assert service.get("more.meta.unit") == '"A"'
    assert refused(service, "gain", "11") == "bad-value"
    assert refused(service, "names", "(1)") == "bad-value"
    assert refused(service, "steps", "4") == "read-only"
    assert service.get("lost") == "1"


class Unlistable(Mapping[str, int]):
    def __getitem__(self, key: str) -> int:
        raise SystemExit(1)

    def __iter__(self) -> typing.Iterator[str]:
        raise SystemExit(2)

    def __len__(self) -> int:
        return 1


class Untold:
    def __str__(self) -> str:
        raise SystemExit(3)


class Spoilt:
    def __init__(self) -> None:
        self.fine = 1.0
        self.table = Unlistable()
        self.untold = [Untold()]

    def give(self) -> Untold:
        return Untold()


def test_what_cannot_be_looked_at_is_no_harm_to_the_rest() -> None:
    service = served(Spoilt())
    assert service.get("properties?all") == "(give fine table untold)"
    assert service.get("fine") == "1.0"
    assert refused(service, "table") == "internal"
    assert refused(service, "untold") == "internal"
    assert "SystemExit: 3" in str(service.set("give?echo", ""))


class Carrier:
    def __init__(self) -> None:
        self.tools: dict[str, Arm] = {}

    def get_places(self) -> dict[str, int]:
        return {}


def test_a_place_with_nothing_in_it_is_there() -> None:
    carrier = Carrier()
    service = served(carrier)
    assert service.get("properties") == "(tools places)"
    assert service.get("tools") == service.get("tools.properties") == service.get("places") == "()"
    assert refused(service, "tools", "(1)") == "read-only"
    carrier.tools["left"] = Arm(0.5)
    assert service.get("tools") == "(left)"
    assert service.get("tools.left.angle") == "0.5"
    del carrier.tools["left"]
    assert service.get("properties?all=1") == "(places tools)"
    assert service.get("tools") == "()"


def test_a_further_look_at_names_asks_accessors_and_methods_for_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each listing and each tick looks: what arguments are is found out once for each name."""
    service = served(Arm(0.5))
    before = service.get("properties")
    asked: list[object] = []
    monkeypatch.setattr("rtkit.property.objects.accepted", lambda *given: asked.append(given))
    monkeypatch.setattr("rtkit.property.objects.arguments_of", asked.append)
    assert service.get("properties") == before
    assert asked == []
