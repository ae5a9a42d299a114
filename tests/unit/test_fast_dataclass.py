"""Cheap dataclasses mean what standard ones mean."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
from collections.abc import Mapping
from typing import Any

import pytest

from rtkit import fast_dataclass

COMPILED_AFTER = fast_dataclass._COMPILED_AFTER


def define(module: Any) -> tuple[type[Any], type[Any], type[Any]]:
    @module.dataclass(frozen=True, slots=True, order=True)
    class Point:
        """A point."""

        x: int
        y: int = 2

        def __str__(self) -> str:
            return f"{self.x},{self.y}"

    @module.dataclass(slots=True)
    class Pen:
        """What can be changed."""

        point: Any
        marks: Mapping[str, int] = module.field(default_factory=dict)
        note: str = module.field(default="", compare=False, repr=False)

        def __post_init__(self) -> None:
            if self.point is None:
                raise ValueError("no point")

    @module.dataclass(frozen=True, slots=True)
    class Far(Point):
        """One with more."""

        z: int = 3

    return Point, Pen, Far


OURS, THEIRS = define(fast_dataclass), define(dataclasses)
WRONG: list[tuple[tuple[Any, ...], dict[str, Any]]] = [
    ((), {}),
    ((1, 2, 3), {}),
    ((1,), {"x": 2}),
    ((1,), {"w": 2}),
]


def outcome(work: Any) -> object:
    try:
        return work()
    except (TypeError, AttributeError, ValueError) as error:
        return type(error).__name__, str(error)


@pytest.mark.parametrize("many", [1, COMPILED_AFTER + 2])
def test_they_are_made_alike_the_first_and_the_many(many: int) -> None:
    assert made(*OURS, many) == made(*THEIRS, many)


def made(point: Any, pen: Any, far: Any, many: int) -> list[object]:
    for _ in range(many):
        points = [point(1), point(1, y=5), point(y=1, x=2), far(1), far(1, 2, z=9)]
        pens = [pen(points[0]), pen(points[0], {"a": 1}, note="n")]
    assert pens[0].marks is not pens[1].marks
    refused = [outcome(lambda a=a, k=k: point(*a, **k)) for a, k in WRONG]
    return [*map(repr, points + pens), str(points[1]), *refused, outcome(lambda: pen(None))]


def test_they_compare_and_hash_alike() -> None:
    assert compared(*OURS) == compared(*THEIRS)


def compared(point: Any, pen: Any, far: Any) -> list[object]:
    one, same, other = point(1), point(1, 2), point(2)
    return [
        one == same,
        one != other,
        one < other,
        one >= other,
        one == far(1),
        one == (1, 2),
        hash(one) == hash(same),
        pen(one) == pen(same, note="else"),
        outcome(lambda: hash(pen(one))),
        outcome(lambda: one < 3),
    ]


def test_frozen_ones_stay_as_they_are() -> None:
    assert changed(*OURS) == changed(*THEIRS)


def changed(point: Any, pen: Any, far: Any) -> list[object]:
    one, three, held = point(1), far(1), pen(point(1))
    held.note = "changed"
    refused = outcome(lambda: setattr(one, "x", 2))
    assert refused == ("FrozenInstanceError", "cannot assign to field 'x'")
    return [
        held.note,
        refused,
        outcome(lambda: setattr(three, "z", 2)),
        outcome(lambda: delattr(one, "x")),
        outcome(lambda: setattr(held, "other", 2)),
        [hasattr(each, "__dict__") for each in (one, three, held)],
        copy.copy(three) == three,
        copy.deepcopy(held) == held,
    ]


def test_the_standard_library_knows_them() -> None:
    for mine, theirs in zip(OURS, THEIRS, strict=True):
        assert dataclasses.is_dataclass(mine)
        assert str(inspect.signature(mine)) == str(inspect.signature(theirs))
        assert mine.__match_args__ == theirs.__match_args__
        for one, other in zip(dataclasses.fields(mine), dataclasses.fields(theirs), strict=True):
            assert (one.name, one.type, one.repr, one.compare, one.init) == (
                other.name,
                other.type,
                other.repr,
                other.compare,
                other.init,
            )
            assert one.default == other.default
            assert one.default_factory == other.default_factory
    point, _, far = OURS
    assert (
        dataclasses.replace(point(1), y=7) == fast_dataclass.replace(point(1), y=7) == point(1, 7)
    )
    assert dataclasses.astuple(far(1)) == (1, 2, 3)
    assert fast_dataclass.replace(THEIRS[0](1), y=3).y == 3

    @dataclasses.dataclass(frozen=True, slots=True)
    class Farther(far):  # type: ignore[misc,valid-type]
        """A standard one that has one of ours as its base."""

        w: int = 4

    assert repr(Farther(1)).endswith("Farther(x=1, y=2, z=3, w=4)")


def test_what_travels_as_bytes_comes_back() -> None:
    from rtkit.rtc.profiles import PortRef

    assert pickle.loads(pickle.dumps(PortRef("A", "out"))) == PortRef("A", "out")


def test_a_field_without_a_default_comes_before_those_with_one() -> None:
    with pytest.raises(TypeError, match="without a default"):

        @fast_dataclass.dataclass(slots=True)
        class Wrong:
            """Cannot be made."""

            first: int = 1
            second: int  # type: ignore[misc]


def test_a_default_as_a_signature_shows_it_is_made_anew() -> None:
    _, pen, _ = define(fast_dataclass)
    shown = inspect.signature(pen).parameters["marks"].default
    for _ in range(COMPILED_AFTER + 2):
        assert pen(1, shown).marks == pen(1, marks=shown).marks == {}


def test_what_derives_from_a_record_is_a_frozen_dataclass_with_slots() -> None:
    class Shape(fast_dataclass.Record):
        """A shape."""

    class Circle(Shape):
        """A round one."""

        radius: int
        tags: tuple[str, ...] = ()

    @dataclasses.dataclass(frozen=True, slots=True)
    class Plain:
        radius: int
        tags: tuple[str, ...] = ()

    one = Circle(2)
    assert one == Circle(2, ()) != Circle(3)
    assert hash(one) == hash(Circle(2))
    assert fast_dataclass.replace(one, radius=3) == Circle(3)
    assert inspect.signature(Circle).parameters.keys() == inspect.signature(Plain).parameters.keys()
    assert Circle.__match_args__ == Plain.__match_args__
    assert not hasattr(one, "__dict__")
    assert Shape.__subclasses__() == [Circle]
    with pytest.raises(dataclasses.FrozenInstanceError):
        one.radius = 4  # type: ignore[misc]
