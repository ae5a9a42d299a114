"""Plans that install: as cheap as a search of everything finds, broken off anywhere they go on."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, note, settings
from hypothesis import strategies as st
from reference_model import problem_of

from rtkit.deployment.planning.deployment_plan import make_plan
from rtkit.deployment.planning.model import DEFAULT_COSTS, ComponentVariable, Model
from rtkit.planner import plan

PLACES = ("m:slave", "n:slave", "o:slave")
HOSTS = {"m": "laptop", "n": "robot1", "o": "robot1"}
PACKAGES = ("a==1", "b==1", "b==2")
VARIABLES = [f"{host}/{package}" for host in ("laptop", "robot1") for package in PACKAGES]
costs = st.integers(1, 9)


@st.composite
def fleets(draw: st.DrawFn) -> Model:
    """Return components that may be made on two hosts, each with what is installed there."""
    units = {}
    live = dict.fromkeys(("mgr:m", "mgr:n"), "up") | {
        "mgr:o": draw(st.sampled_from(["up", "down"]))
    }
    desired = {}
    for name in "cde"[: draw(st.integers(1, 3))]:
        places = draw(st.lists(st.sampled_from(PLACES), min_size=1, max_size=3, unique=True))
        package = draw(st.sampled_from(["", *PACKAGES]))
        units[name] = ComponentVariable(name, "", tuple(places), package=package)
        if draw(st.booleans()):
            live[f"cmp:{name}"] = draw(st.sampled_from(places))
            live[f"mgr:{live[f'cmp:{name}'][0]}"] = "up"
        desired[f"cmp:{name}"] = draw(st.sampled_from(["*", "*", places[-1], "absent"]))
    for each in VARIABLES:
        if draw(st.booleans()):
            live[f"pkg:{each}"] = "installed"
    for each in draw(st.sets(st.sampled_from(VARIABLES), max_size=2)):
        desired[f"pkg:{each}"] = draw(st.sampled_from(["installed", "absent"]))
    # What an offline host lacks is pushed, which costs more than to install it elsewhere.
    special = {f"install {each}": draw(costs) for each in VARIABLES}
    kinds = {kind: draw(costs) for kind in ("install", "uninstall", "start_manager", "delete")}
    table = {**DEFAULT_COSTS, **kinds, **special}
    return Model(dict.fromkeys("mno"), units, live=live, desired=desired, costs=table, hosts=HOSTS)


@given(fleets())
@settings(max_examples=60, deadline=None)
def test_installing_costs_as_little_as_a_search_of_everything_finds(model):
    wished = {v: w for v, w in model.desired.items() if not is_contradicted(model, v)}
    model = replace(model, desired=wished)
    best = plan(problem_of(model))
    found = make_plan(model)
    note([move.text for move in found.moves])
    note(best.commands)
    assert (found.gap, found.cost) == (0, best.cost)


def is_contradicted(model: Model, variable: str) -> bool:
    """Return whether a package is unwished that a component may need."""
    packages = {unit.package for unit in model.units.values()}
    is_unwished = model.desired[variable] == "absent"
    return variable.startswith("pkg:") and is_unwished and variable.partition("/")[2] in packages


@given(fleets(), st.data())
@settings(max_examples=60, deadline=None)
def test_killed_at_any_step_the_rest_costs_what_was_left(model, data):
    model = replace(
        model, desired={v: w for v, w in model.desired.items() if not is_contradicted(model, v)}
    )
    found = make_plan(model)
    count = data.draw(st.integers(0, len(found.moves)))
    live = {variable: model.now(variable) for variable in model.variables()}
    for move in found.moves[:count]:
        live.update(move.changes)
    rest = make_plan(replace(model, live=live))
    assert rest.cost == sum(move.cost for move in found.moves[count:])
    kinds = [move.kind for move in found.moves]
    made = [n for n, kind in enumerate(kinds) if kind.startswith("create")]
    for n in made:
        unit = model.units[found.moves[n].subject]
        needed = f"pkg:{model.needed_package(unit, found.moves[n].value)}"
        before = [c for move in found.moves[:n] for c in move.changes]
        is_there = model.now(needed) == "installed" if unit.package else True
        assert is_there or (needed, "installed") in before
