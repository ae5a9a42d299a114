"""Deployments to plan: read from instance files, generated large, or drawn at random."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypothesis import strategies as st

from rtkit.deployment.planning.model import (
    ComponentVariable,
    ConnectionVariable,
    Model,
    ParameterVariable,
    Wish,
)


def model_from(plain: Mapping[str, Any], costs: Mapping[str, float]) -> Model:
    """Return the deployment that an instance file describes."""
    units = {
        name: ComponentVariable(
            name,
            each["module"],
            tuple(f"{manager}:{mode}" for manager in each["managers"] for mode in each["modes"]),
        )
        for name, each in plain["components"].items()
    }
    wires = {
        name: ConnectionVariable(tuple(end.partition(".")[0] for end in ends))
        for name, ends in plain["connections"].items()
    }
    keys = {
        name: ParameterVariable(each["default"], each.get("hot", False))
        for name, each in plain["config"].items()
    }
    managers = {name: frozenset(each["modules"]) for name, each in plain["managers"].items()}
    desired = {
        variable: tuple(wish) if isinstance(wish, list) else wish
        for variable, wish in plain["desired"].items()
    }
    return Model(managers, units, wires, keys, plain["live"], desired, {"reset": 1, **costs})


def large(components: int, connections: int, *, is_free: bool = False) -> Model:
    """Return a deployment to be brought up from nothing, or moved freely; wired pseudo-randomly."""
    units, desired = {}, {}
    wires, keys = {}, {}
    for number in range(components):
        name = f"c{number}"
        places = (f"m1:slave/s{number % 7}", "m1:inproc") if is_free else ("m1:inproc",)
        units[name] = ComponentVariable(name, f"T{number % 20}", places)
        desired[f"cmp:{name}"] = "*" if is_free else "m1:inproc"
        desired[f"act:{name}"] = "active"
        keys[f"{name}.gain"] = ParameterVariable("0")
        desired[f"cfg:{name}.gain"] = str(number % 3)
    for number in range(connections):
        ends = (
            f"c{number % components}",
            f"c{(number * 37 + number // components + 1) % components}",
        )
        wires[f"k{number}"] = ConnectionVariable(ends)
        desired[f"con:k{number}"] = "yes"
    return Model({"m1": None}, units, wires, keys, {}, desired)


NAMES = ("a", "b", "c")
PLACES = ("m:inproc", "m:slave", "n:inproc")


def _wishes(*values: str) -> st.SearchStrategy[Wish | None]:
    return st.sampled_from([None, *values])


@st.composite
def models(draw: st.DrawFn, most: int = 3) -> Model:
    """Return a small deployment: any state that can be, any wishes, also some that cannot."""
    names = NAMES[: draw(st.integers(1, most))]
    finds = st.sampled_from([None, frozenset("XY"), frozenset("X")])
    managers = {"m": draw(finds), "n": draw(finds)}
    live: dict[str, str] = {}
    desired: dict[str, Wish | None] = {}
    units, keys, wires = {}, {}, {}
    for name in names:
        places = draw(st.lists(st.sampled_from(PLACES), min_size=1, max_size=2, unique=True))
        members = tuple(draw(st.sets(st.sampled_from(names), max_size=1)) - {name})
        is_whole = name == names[-1] and draw(st.booleans())
        units[name] = ComponentVariable(
            name,
            draw(st.sampled_from("XY")),
            tuple(places),
            members=members if is_whole else (),
            package=draw(st.sampled_from(["", "p==1", "p==2"])),
        )
        live[f"cmp:{name}"] = draw(st.sampled_from(["absent", *PLACES]))
        desired[f"cmp:{name}"] = draw(
            st.sampled_from([None, "absent", "*", places[0], tuple(places), "m:inproc"])
        )
        desired[f"act:{name}"] = draw(_wishes("active", "inactive"))
        for key in ("k", "l")[: draw(st.integers(0, 2))]:
            kinds = st.sampled_from(["cold", "hot", "hot", "fixed"])
            kind = draw(kinds)
            keys[f"{name}.{key}"] = ParameterVariable("0", kind == "hot", is_fixed=kind == "fixed")
            desired[f"cfg:{name}.{key}"] = draw(_wishes("0", "1"))
        if live[f"cmp:{name}"] != "absent":
            live[f"act:{name}"] = draw(st.sampled_from(["inactive", "active", "error"]))
            live.update(
                {
                    f"cfg:{key}": draw(st.sampled_from("012"))
                    for key in keys
                    if key.startswith(f"{name}.")
                }
            )
    for unit in units.values():
        # What is composed of others lives only with them.
        if any(live[f"cmp:{member}"] == "absent" for member in unit.members):
            live[f"cmp:{unit.name}"] = "absent"
            live = {
                v: x
                for v, x in live.items()
                if not v.startswith((f"act:{unit.name}", f"cfg:{unit.name}."))
            }
    for number in range(draw(st.integers(0, most))):
        ends = tuple(draw(st.sampled_from(names)) for _ in range(2))
        wires[f"w{number}"] = ConnectionVariable(
            ends, draw(st.sampled_from(["", "", "", "ports differ"]))
        )
        if all(live[f"cmp:{end}"] != "absent" for end in ends):
            live[f"con:w{number}"] = draw(st.sampled_from(["no", "yes", "other"]))
        desired[f"con:w{number}"] = draw(_wishes("yes", "no"))
    for name in units:
        place = live[f"cmp:{name}"]
        if place != "absent":
            live[f"mgr:{place[0]}"] = "up"
            if place.endswith("inproc"):
                live[f"mod:{place[0]}/{units[name].module}"] = "loaded"
    for manager in "mn":
        if draw(st.booleans()):
            live[f"mgr:{manager}"] = "up"
        desired[f"mgr:{manager}"] = draw(st.sampled_from([None, None, "up", "down"]))
        for module in "XY":
            variable = f"mod:{manager}/{module}"
            if live.get(f"mgr:{manager}") == "up" and draw(st.booleans()):
                live[variable] = "loaded"
            desired[variable] = draw(st.sampled_from([None, None, None, "loaded", "absent"]))
    hosts = draw(st.sampled_from([{}, {"n": "robot1"}]))
    for package in ("localhost/p==1", "localhost/p==2", "robot1/p==1"):
        variable = f"pkg:{package}"
        if draw(st.booleans()):
            live[variable] = "installed"
        desired[variable] = draw(st.sampled_from([None, None, None, "installed", "absent"]))
    costs = {
        kind: draw(st.integers(1, 6))
        for kind in (
            "start_manager",
            "install",
            "uninstall",
            "load",
            "unload",
            "create",
            "create_slave",
            "delete",
            "connect",
            "disconnect",
            "configure",
            "activate",
            "deactivate",
            "reset",
        )
    }
    wished = {variable: wish for variable, wish in desired.items() if wish is not None}
    return Model(
        managers,
        units,
        wires,
        keys,
        live,
        wished,
        costs,
        slaves_need_modules=draw(st.booleans()),
        hosts=hosts,
    )
