"""Other places of components: asked for once in a while, and at once when something else is."""

from __future__ import annotations

from rtkit.api.owner_places import AGAIN_S, OtherPlaces


def test_the_same_is_asked_again_after_a_pause_and_something_else_at_once():
    now, whys = [100.0], iter(range(9))
    places = OtherPlaces(lambda: now[0])

    def why(named=None, lost=("robot1",)):
        found = places.find(
            "S", named or {"A": ("robot2",)}, lost, lambda: ({}, {"A": f"{next(whys)} MiB free"})
        )
        return found.whys["A"], found.again_at

    first = ("0 MiB free", 100.0 + AGAIN_S)
    assert [why(), why()] == [first, first]
    assert why(lost=("robot1", "robot2"))[0] == "1 MiB free"
    assert why({"A": ("robot2",), "B": ("robot2",)})[0] == "2 MiB free"
    assert why()[0] == "3 MiB free"
    now[0] += AGAIN_S
    assert why() == ("4 MiB free", now[0] + AGAIN_S)


def test_places_are_not_told_twice_and_nothing_is_asked_for_nothing():
    counted = []
    places = OtherPlaces(lambda: 100.0)
    for _ in range(2):
        found = places.find("S", {"A": ()}, (), lambda: (counted.append(1) or {"A": "here"}, {}))
        assert found.places == {"A": "here"}
    assert len(counted) == 2
    assert places.find("S", {}, (), lambda: ({"A": "x"}, {})) == ({}, {}, 0.0)
