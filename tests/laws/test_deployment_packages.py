"""Plans that install: as cheap as a search of everything finds, broken off anywhere they go on."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress

from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, note, settings
from hypothesis import strategies as st
from reference_model import problem_of

from rtkit.deployment.applying import Applier
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.packages import Packages
from rtkit.deployment.planning.default_costs import DEFAULT_COSTS
from rtkit.deployment.planning.deployment_plan import DeploymentPlan, make_plan
from rtkit.deployment.planning.model import ComponentVariable, Model
from rtkit.deployment.wanted import wanted
from rtkit.fast_dataclass import replace
from rtkit.planner import plan
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile
from rtkit.tree.manager_set import ManagerSet

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


# whole systems over two hosts

NAMES = {"localhost": "manager", "robot1": "manager@robot1"}
TYPES = ("One", "Two", "Three")
MODULES = {
    f"/m/{name}.py": [ComponentPattern(TypeProfile(name), (), {"default": {}})] for name in TYPES
}


class Shop:
    """Has all packages, and installs them until it is killed after so many."""

    def __init__(self, there: Collection[str]) -> None:
        self.there = {*there}
        self.left = -1

    def install(self, package: str) -> None:
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        self.there.add(package)

    def uninstall(self, package: str) -> None:
        self.there.remove(package)


class Hosts:
    """A system over two hosts, each with packages of its own; one that is `surplus` may go."""

    def __init__(self, homes: Mapping[str, str], shop: Shop, surplus: Collection[str]) -> None:
        self.worlds = {
            host: FakeManager((), host="box" if host == "localhost" else host, modules=MODULES)
            for host in NAMES
        }
        self.shop, self.surplus, self.homes = shop, surplus, homes
        components = tuple(_component(name, host) for name, host in homes.items())
        date = "2026-01-01T00:00:00"
        profile = rts.RtsProfile("RTSystem:a:b:1", "0.2", date, date, components=components)
        self.system = wanted(profile, "box", managers=["manager@robot1"])

    def fleet(self) -> ManagerSet:
        trees = {NAMES[host]: fake_tree(world) for host, world in self.worlds.items()}
        return ManagerSet([*trees], trees, {f"{n}0": NAMES[h] for n, h in self.homes.items()})

    def goal(self) -> DeploymentGoal:
        of = {f"{name}0": f"{name.lower()}==1" for name in self.homes}
        needed = {f"{host}/{name.lower()}==1" for name, host in self.homes.items()}
        gone = {each: f"/p/{each}" for each in self.surplus if each not in needed}
        packages = Packages(of, frozenset(self.shop.there), {}, gone, self.shop)
        return replace(DeploymentGoal(self.system), packages=packages)

    def reach(self) -> DeploymentPlan:
        fleet, goal = self.fleet(), self.goal()
        before = fleet.snapshot()
        plan = goal.plan(before)
        Applier(fleet, goal, lambda _: None, lambda _: None).run(plan, before)
        return plan


def _component(name: str, host: str) -> rts.ComponentInstance:
    values = {"create": name, "module": f"/m/{name}.py:{name}Init"}
    properties = tuple(ExtensionProperty(f"rtkit.{key}", value) for key, value in values.items())
    return rts.ComponentInstance(
        f"RTC:::{name}:", f"{host}/{name}0.rtc", f"{name}0", properties=properties
    )


ON_HOSTS = [f"{host}/{name.lower()}==1" for host in NAMES for name in TYPES]


@given(
    st.dictionaries(st.sampled_from(TYPES), st.sampled_from([*NAMES]), min_size=1),
    st.sets(st.sampled_from(ON_HOSTS)),
    st.sets(st.sampled_from(ON_HOSTS)),
    st.integers(0, 3),
)
@settings(max_examples=60, deadline=None)
def test_each_host_gets_what_it_lacks_and_is_rid_of_what_nothing_uses(homes, there, surplus, kill):
    shop = Shop(there)
    hosts = Hosts(homes, shop, surplus & there)
    best = plan(problem_of(hosts.goal().survey(hosts.fleet().snapshot()).model))
    needed = {f"{host}/{name.lower()}==1" for name, host in homes.items()}
    gone = (surplus & there) - needed
    planned = hosts.goal().plan(hosts.fleet().snapshot())
    assert (planned.gap, planned.cost) == (0, best.cost)
    packages = {m.subject: m.kind for m in planned.moves if m.subject in ON_HOSTS}
    installs = dict.fromkeys(needed - there, "install")
    assert packages == installs | dict.fromkeys(gone, "uninstall")
    shop.left = kill
    with suppress(KeyboardInterrupt):
        hosts.reach()
    assert kill >= len(installs) or not any(w.components for w in hosts.worlds.values())
    shop.left = -1
    hosts.reach()
    assert shop.there == (there | needed) - gone
    for host, world in hosts.worlds.items():
        assert {*world.components} == {f"{name}0" for name in homes if homes[name] == host}
    assert not hosts.reach().moves
