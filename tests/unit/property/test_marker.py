"""Markers: read, changed, checked, and as type of attributes, getters, arguments and results."""

from __future__ import annotations

import copy
import pickle
from typing import Annotated

import pytest

import rtkit
from rtkit import Element, Marker, PropertyError, Word
from rtkit.property.fitting import from_value
from rtkit.property.reading import read
from tests.unit.property.test_objects import refused, served

BALL = "<marker><location>(1 2 0)</location><type>ball</type><color>(1 0 0)</color></marker>"


class Seeing:
    target: Marker | None = None
    best: Marker = Marker((0, 0, 0))
    word: Word = Word("on")
    tree: Element = Element("a", {}, (), 1)

    def __init__(self) -> None:
        self.found: list[Marker] = [Marker((1, 2))]
        self.moved: list[object] = []
        self._place = Marker((0, 0, 0), frame="world")

    def get_place(self, frame: str = "world") -> Marker:
        return self._place.with_(frame=frame)

    def set_place(self, place: Marker) -> None:
        self._place = place

    def moveto(self, target: Marker | list[Marker]) -> list[Marker]:
        self.moved.append(target)
        return target if isinstance(target, list) else [target]

    def near(self, markers: list[Marker], within: Annotated[float, "m"] = 1.0) -> Marker:
        return markers[0].with_(size=within)


def test_a_marker_is_made_and_written() -> None:
    ball = Marker((1, 2, 0), type="ball", color=(1, 0, 0))
    assert str(ball) == BALL.replace("(1 2 0)", "(1.0 2.0 0.0)")
    assert (ball.location, ball.type, ball.frame, ball.time) == ((1.0, 2.0, 0.0), "ball", "", None)
    assert ball.features == {"color": (1, 0, 0)}
    assert ball == Marker.from_element(read(BALL)) == copy.deepcopy(ball)  # type: ignore[arg-type]
    assert pickle.loads(pickle.dumps(ball)) == ball
    assert repr(ball) == "Marker((1.0, 2.0, 0.0), type='ball', color=(1, 0, 0))"
    assert len({ball, Marker((1, 2, 0))}) == 2


def test_a_marker_is_changed_only_into_another() -> None:
    ball = Marker((1, 2), id="12", variance=0.5, size=(1, 2), shape="round ball")
    moved = ball.with_(location=(3, 4), covariance=((1, 0), (0, 1)), shape=None)
    assert (moved.location, moved.id, moved.variance) == ((3.0, 4.0), "12", None)
    assert (moved.covariance, dict(moved.features)) == (((1.0, 0.0), (0.0, 1.0)), {})
    assert ball.features["shape"] == "round ball"
    with pytest.raises(AttributeError, match="with_"):
        ball.id = "3"  # type: ignore[misc]
    with pytest.raises(TypeError):
        ball.features["shape"] = 3  # type: ignore[index]


def test_nothing_of_a_foreign_marker_is_lost() -> None:
    text = '<marker by="me"><x n="1"><a>1</a></x><location>(1 2)</location><x>2</x></marker>'
    marker = Marker.from_element(read(text))  # type: ignore[arg-type]
    assert str(marker) == text
    first, second = marker.features["x"]
    assert (first.attributes, second) == ({"n": "1"}, 2)
    assert str(marker.with_(id="x")) == text.replace("</marker>", "<id>x</id></marker>")
    assert Marker(None, polar=(1.0, 0.5)).location is None


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"location": (1,)}, "location"),
        ({"location": None}, "location, polar or region"),
        ({"location": "here"}, "location"),
        ({"location": (1, 2), "time": "noon"}, "time: expected a number"),
        ({"location": (1, 2), "covariance": ((1, 0, 0),) * 3}, "covariance: expected as many rows"),
        ({"location": (1, 2), "covariance": (1, 0)}, "covariance: expected numbers"),
        ({"location": (1, 2), "covariance": ((1, 0), (0, 1)), "variance": 1}, "both"),
        ({"location": (1, 2), "image": b"\0"}, "image: bytes"),
    ],
)
def test_what_is_no_marker_is_refused(given: dict[str, object], why: str) -> None:
    with pytest.raises(PropertyError, match=why) as error:
        Marker(**given)  # type: ignore[arg-type]
    assert error.value.code == "bad-value"


def test_markers_are_attributes_getters_and_arguments_of_what_is_served() -> None:
    seeing = Seeing()
    service = served(seeing)
    types = {name: service.get(f"{name}.meta.type") for name in ("best", "found", "place", "word")}
    assert types == {"best": "marker", "found": '"list<marker>"', "place": "marker", "word": "word"}
    assert service.get("target") == "()"
    service.set("target", BALL)
    assert seeing.target == Marker((1, 2, 0), type="ball", color=(1, 0, 0))
    service.set("target", "()")
    assert seeing.target is None
    service.set("found", f"({BALL})")
    assert [each.type for each in seeing.found] == ["ball"]
    service.set("place", BALL)
    assert "<frame>base</frame>" in str(service.get("place?frame=base"))
    assert service.get("place.location.y") == "2"
    service.set("best.location.x", "7")
    assert (seeing.best, seeing.word) == (Marker((7, 0, 0)), Word("on"))
    service.set("word", "off")
    service.set("tree", "<b/>")
    assert (seeing.word, seeing.tree) == (Word("off"), Element("b"))
    assert "moveto" not in str(service.get("best.properties"))


def test_actions_take_markers_and_lists_of_them() -> None:
    seeing = Seeing()
    service = served(seeing)
    service.set("moveto", BALL)
    service.set("moveto", f"({BALL} {BALL})")
    one, two = seeing.moved
    assert isinstance(one, Marker)
    assert isinstance(two, list)
    assert len(two) == 2
    answer = service.set("near?echo=1", f"(({BALL}) 3)")
    result = read(str(answer)).find("result").leaf  # type: ignore[union-attr]
    assert Marker.from_element(result).size == 3.0  # type: ignore[union-attr,arg-type]
    assert str(service.get("near.parameters")).startswith('((markers "list<marker>"')
    assert refused(service, "found", "(<other/>)") == "bad-value"
    assert refused(service, "best", "<marker/>") == "bad-value"
    assert refused(service, "best", BALL.replace("</marker>", "<time>x</time></marker>"))
    assert refused(service, "near", f"({BALL} 3)") == "bad-value"
    assert rtkit.Marker is Marker


def test_what_is_wrong_in_a_value_comes_before_the_kinds_that_it_is_not() -> None:
    bad = read(
        "<marker><type>ball</type><color>(1 0 0)</color><location>(1 2 x)</location></marker>"
    )
    with pytest.raises(PropertyError) as caught:
        from_value(bad, list[Marker] | Marker, None)
    first, second = str(caught.value).split("; or ")
    assert first == "expected a location of 2, 3 or 6 numbers"
    assert second.startswith("expected a list, found marker <marker")
    assert second.endswith("…")
    assert len(second) < 80


def test_a_value_that_may_be_left_out_is_not_refused_for_being_there() -> None:
    place = tuple[float, float, float] | None
    assert from_value((), place, None) is None
    with pytest.raises(PropertyError) as refused:
        from_value((1.0,), place, None)
    assert str(refused.value) == "expected 3 items, found vector (1.0)"
