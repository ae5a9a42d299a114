"""Other places of components whose hosts are lost: the first named ones that meet all."""

from __future__ import annotations

import pytest

from rtkit.deployment.placement.choice import PlaceCandidate, PlacedComponent, PlacementProblem
from rtkit.deployment.placement.elsewhere import elsewhere
from rtkit.deployment.placement.requirements import Requirements

HOSTS = (
    PlaceCandidate("localhost"),
    PlaceCandidate("robot1", frozenset({"arm"}), why_not="lost"),
    PlaceCandidate("robot2", frozenset({"arm"}), memory=500),
    PlaceCandidate("robot3", frozenset({"arm"}), memory=900),
)
ANY = ("robot2", "robot3", "localhost")
ARM = Requirements(tags=("arm",))
NEAR = PlacedComponent("Near", stated="robot2", home="robot2")


def chosen(named, *components):
    return elsewhere(PlacementProblem((*components, NEAR), HOSTS), named)


@pytest.mark.parametrize(
    ("required", "named", "place"),
    [
        (Requirements(), ANY, "robot2"),
        (Requirements(), ("localhost", "robot2"), "localhost"),
        (ARM, ("localhost", "robot3", "robot2"), "robot3"),
        (Requirements(memory=600), ANY, "robot3"),
        (Requirements(apart=("Near",)), ANY, "robot3"),
        (Requirements(with_=("Near",)), ("robot3", "robot2"), "robot2"),
        (ARM, ("robot1", "robot3"), "robot3"),
    ],
)
def test_the_first_named_host_that_meets_the_requirements_is_chosen(required, named, place):
    assert chosen({"A": named}, PlacedComponent("A", required)) == ({"A": place}, {})


def test_what_fits_nowhere_stays_with_a_reason_and_holds_up_nothing_else():
    found = chosen({"A": ("localhost", "robot1"), "B": ANY}, PlacedComponent("A", ARM),
                   PlacedComponent("B"))  # fmt: skip
    assert found == (
        {"B": "robot2"},
        {
            "A": "no place for A: localhost: lacks tag arm; robot1: lost; robot2: not named;"
            " robot3: not named"
        },
    )


def test_components_of_one_process_go_together_or_stay():
    pair = PlacedComponent("A", ARM), PlacedComponent("B", Requirements(with_=("A",)))
    assert chosen(dict.fromkeys("AB", ANY), *pair)[0] == {"A": "robot2", "B": "robot2"}
    places, lacks = chosen({"A": ("robot2",), "B": ("robot3",)}, *pair)
    assert (places, {*lacks}) == ({}, {"A", "B"})
    staying = PlacedComponent("B", stated="robot1", home="robot1")
    tied = PlacedComponent("A", Requirements(with_=("B",)))
    assert [*chosen({"A": ANY}, tied, staying)[1]] == ["A"]
