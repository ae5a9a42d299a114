"""Placement: as cheap as trying everything finds, with minimal conflicts."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, note, settings
from hypothesis import strategies as st

from rtkit.deployment.placement.choice import (
    PlaceCandidate,
    PlacedComponent,
    PlacementProblem,
    choose,
)
from rtkit.deployment.placement.conflict import conflict, placed
from rtkit.deployment.placement.requirements import DevicePolicy, Requirements
from rtkit.deployment.planning.deployment_plan import make_plan
from rtkit.deployment.planning.model import ComponentVariable, Model
from rtkit.errors import Impossible
from rtkit.fast_dataclass import replace

PLACES = {
    "localhost": "localhost",
    "localhost/m1.mgr": "localhost",
    "robot1": "robot1",
    "robot2": "robot2",
}
NAMES = "ABCD"
WORDS = ("x", "y")
costs = st.integers(1, 4).map(float)
some_words = st.lists(st.sampled_from(WORDS), max_size=1).map(tuple)


@st.composite
def problems(draw: st.DrawFn) -> PlacementProblem:
    """Return a few components and places; many of them have no choice."""
    names = NAMES[: draw(st.integers(1, 4))]
    others = st.lists(st.sampled_from(names), max_size=1)
    free = st.sampled_from([0, 2 << 20, 3 << 20])
    components = tuple(
        PlacedComponent(
            name,
            Requirements(
                draw(st.sampled_from([(), (), (), ("localhost", "robot1"), ("robot2",)])),
                draw(some_words),
                draw(free),
                draw(some_words),
                tuple(each for each in draw(others) if each != name),
                tuple(each for each in draw(others) if each != name),
                draw(st.sampled_from(DevicePolicy)),
            ),
            draw(st.sampled_from(["", "", "", *PLACES])),
            draw(st.sampled_from(["", "", *PLACES])),
            draw(costs),
            draw(costs),
            draw(st.booleans()),
        )
        for name in names
    )
    memory = {host: draw(st.sampled_from([3 << 20, 5 << 20, 9 << 20])) for host in PLACES.values()}
    words = {
        host: [frozenset(draw(st.sets(st.sampled_from(WORDS)))) for _ in range(2)]
        for host in PLACES.values()
    }
    extras = st.dictionaries(st.sampled_from(["p", "q"]), costs, max_size=2)
    candidates = tuple(
        PlaceCandidate(
            place,
            words[host][0],
            memory[host],
            words[host][1],
            draw(st.sampled_from(["", "", "", "cannot be reached"])),
            draw(st.dictionaries(st.sampled_from(names), st.just("no module"), max_size=1)),
            {name: {f"{host}/{key}": cost for key, cost in draw(extras).items()} for name in names},
        )
        for place, host in PLACES.items()
    )
    # What a need costs on a host does not depend on the component.
    first: dict[str, float] = {}
    candidates = tuple(
        replace(
            each,
            extras={
                name: {key: first.setdefault(key, cost) for key, cost in own.items()}
                for name, own in each.extras.items()
            },
        )
        for each in candidates
    )
    links = draw(st.lists(st.tuples(st.sampled_from(names), st.sampled_from(names)), max_size=3))
    return PlacementProblem(components, candidates, tuple(links))


def everything(problem: PlacementProblem) -> list[tuple[float, int]]:
    """Return cost and connections between hosts of each choice that meets all requirements."""
    found = []
    for chosen in product(problem.candidates, repeat=len(problem.components)):
        at = {c.name: p for c, p in zip(problem.components, chosen, strict=True)}
        if all(is_met(each, at, problem) for each in problem.components):
            found.append(price(problem, at))
    return found


def price(problem: PlacementProblem, at: dict[str, PlaceCandidate]) -> tuple[float, int]:
    total, extras = 0.0, dict[str, float]()
    for each in problem.components:
        if at[each.name].place != each.home:
            total += each.making + (each.leaving if each.home else 0)
            extras |= at[each.name].extras.get(each.name, {})
    crossings = sum(at[one].host != at[other].host for one, other in problem.links)
    return total + sum(extras.values()), crossings


def is_met(each: PlacedComponent, at: dict[str, PlaceCandidate], problem: PlacementProblem) -> bool:
    """Return whether a component may be there with all others where they are."""
    here, own = at[each.name], each.required
    stays = each.home == here.place
    mates = [c for c in problem.components if c.name in mates_of(each.name, problem)]
    coming = [c.required.memory for c in problem.components
              if at[c.name].host == here.host and at[c.name].place != c.home]  # fmt: skip
    return all(
        (
            stays or not (here.why_not or each.name in here.lacks),
            each.stated in ("", here.place),
            # Nobody is put into another manager than the usual one without a word.
            "/" not in here.place or any(here.place in (c.stated, c.home) for c in mates),
            not own.hosts or here.host in own.hosts,
            {*own.tags} <= here.tags,
            {*own.devices} <= here.devices or (stays and own.device_policy is DevicePolicy.KEEP),
            stays or not own.memory or sum(coming) <= here.memory,
            all(at[other] is here for other in own.with_ if other in at),
            all(at[other].host != here.host for other in own.apart if other in at),
        )
    )


def mates_of(name: str, problem: PlacementProblem) -> set[str]:
    """Return the components that share a process with one, itself too."""
    found, size = {name}, 0
    while len(found) > size:
        size = len(found)
        for each in problem.components:
            if each.name in found or found & {*each.required.with_}:
                names = {c.name for c in problem.components}
                found |= {each.name, *each.required.with_} & names
    return found


@given(problems())
@settings(max_examples=100, deadline=None)
def test_a_choice_is_as_good_as_trying_everything_finds(problem):
    choice, best = choose(problem), min(everything(problem), default=None)
    note(choice)
    if choice is None or best is None:
        assert (choice, best) == (None, None)
        return
    at = {n: next(c for c in problem.candidates if c.place == p) for n, p in choice.places.items()}
    assert all(is_met(each, at, problem) for each in problem.components)
    assert price(problem, at) == (choice.cost, choice.crossings)
    assert choice.cost == best[0]
    assert (choice.crossings, choice.gap) == (best[1], 0)


@given(problems())
@settings(max_examples=60, deadline=None)
def test_nothing_of_a_conflict_can_be_left_out(problem):
    if choose(problem) is not None:
        return
    found = conflict(problem)
    note(found.requirements)
    assert choose(found.problem) is None
    assert everything(found.problem) == []
    for each in found.problem.components:
        assert everything(found.problem.without({each.name}))
    for name, kind in found.requirements:
        fewer = [
            replace(each, required=replace(each.required, **{kind: 0 if kind == "memory" else ()}))
            if each.name == name
            else each
            for each in found.problem.components
        ]
        assert everything(replace(found.problem, components=tuple(fewer)))


@given(problems())
@settings(max_examples=60, deadline=None)
def test_only_components_that_are_not_required_are_left_out(problem):
    required = {each.name for each in problem.components if each.is_required}
    if choose(problem.without({*NAMES} - required)) is None:
        with pytest.raises(Impossible):
            placed(problem)
        return
    choice, lacks = placed(problem)
    optional = {each.name for each in problem.components if not each.is_required}
    assert {*lacks} <= optional
    assert {*choice.places} == {each.name for each in problem.components} - {*lacks}


@st.composite
def fleets(draw: st.DrawFn) -> tuple[Model, PlacementProblem]:
    """Return components that may be anywhere: for the planner, and as a problem of placement."""
    hosts = ("localhost", "robot1", "robot2")
    live = {f"mgr:{host}": draw(st.sampled_from(["up", "down"])) for host in hosts}
    special = {f"install {host}/{p}": draw(costs) for host in hosts for p in ("p==1", "q==1")}
    for key in special:
        if draw(st.booleans()):
            live[f"pkg:{key.removeprefix('install ')}"] = "installed"
    units, parts, needs = {}, [], {}
    for name in NAMES[: draw(st.integers(1, 3))]:
        package = draw(st.sampled_from(["", "p==1", "q==1"]))
        places = tuple(f"{host}:slave" for host in hosts)
        units[name] = ComponentVariable(name, "", places, package=package)
        home = draw(st.sampled_from(["", *hosts]))
        if home:
            live |= {f"cmp:{name}": f"{home}:slave", f"mgr:{home}": "up"}
        table = {"create_slave": draw(costs), "delete": draw(costs)}
        special |= {f"{kind} {name}": cost for kind, cost in table.items()}
        parts.append(
            PlacedComponent(name, Requirements(), "", home, table["create_slave"], table["delete"])
        )
        needs[name] = package
    candidates = []
    start = draw(costs)
    for host in hosts:
        extras = {}
        for name, package in needs.items():
            extra = {} if live[f"mgr:{host}"] == "up" else {f"mgr:{host}": start}
            if package and f"pkg:{host}/{package}" not in live:
                extra[f"pkg:{host}/{package}"] = special[f"install {host}/{package}"]
            extras[name] = extra
        candidates.append(PlaceCandidate(host, extras=extras))
    table = {"install": 3.0, "uninstall": 1.0, "start_manager": start, "create_slave": 1.0}
    model = Model(
        dict.fromkeys(hosts), units, live=live, desired={f"cmp:{n}": "*" for n in units},
        costs={"delete": 1.0, "create": 1.0, "deactivate": 1.0, **table, **special},
        hosts={host: host for host in hosts[1:]},
    )  # fmt: skip
    return model, PlacementProblem(tuple(parts), tuple(candidates))


@given(fleets())
@settings(max_examples=100, deadline=None)
def test_a_choice_costs_what_the_planner_pays_for_free_places(drawn):
    model, problem = drawn
    choice = choose(problem)
    assert choice is not None
    assert choice.cost == make_plan(model).cost
    fixed = {f"cmp:{name}": f"{place}:slave" for name, place in choice.places.items()}
    assert make_plan(model.wishing(fixed.items())).cost == choice.cost


def test_many_components_are_placed_within_the_tries():
    required = [
        Requirements(memory=(5 + n % 7) << 20, apart=(f"c{n - 1}",) if n else ())
        for n in range(300)
    ]
    parts = tuple(PlacedComponent(f"c{n}", each) for n, each in enumerate(required))
    extras = {each.name: {"start": 8.0} for each in parts}
    hosts = [PlaceCandidate(f"robot{n}", memory=900 << 20) for n in range(5)]
    hosts += [PlaceCandidate("robot9", extras=extras)]
    links = tuple((f"c{n}", f"c{n // 2}") for n in range(1, 300))
    choice = choose(PlacementProblem(parts, tuple(hosts), links))
    assert choice is not None
    assert (choice.cost, choice.gap) == (300, 0)
