"""Draws random systems and worlds: profiles, and the changes that others make to live ones."""

from __future__ import annotations

from fake_manager import FakeManager
from hypothesis import strategies as st

from rtkit.deployment import actions as act
from rtkit.deployment.facts import Snapshot
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.enums import LifeCycleState, PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile

SETS = {"default": {"a": "0", "b": "0"}, "fast": {"a": "1", "b": "1"}}
PORTS = (
    PortProfile("out", PortType.OUT),
    PortProfile("in", PortType.IN),
    PortProfile("in2", PortType.IN),
)
INSTANCES = ("Node0", "Node1", "Node2", "Node3")
INACTIVE, ACTIVE = LifeCycleState.INACTIVE, LifeCycleState.ACTIVE


def make_world(manager: str = "manager") -> FakeManager:
    return FakeManager([ComponentPattern(TypeProfile("Node"), PORTS, SETS)], manager=manager)


values = st.sampled_from(["0", "1", "2", "", "x y"])
set_values = st.dictionaries(
    st.sampled_from(["default", "fast"]),
    st.dictionaries(st.sampled_from("ab"), values, max_size=2),
    max_size=2,
)


rates = st.sampled_from([10.0, 12.5, 1000.0])
policies = st.sampled_from(
    [
        {},
        {"rtkit.restart": "always"},
        {"rtkit.critical": "yes"},
        {"rtkit.restart": "on-failure", "rtkit.restart.limit": "2"},
    ]
)


@st.composite
def components(
    draw: st.DrawFn, instance: str, stand_ins: bool, supervised: bool
) -> rts.ComponentInstance:
    slave = draw(st.sampled_from(["", "&manager_name=s1", "&manager_name=s2"]))
    told = [ExtensionProperty("rtkit.create", f"Node?x=y{slave}")]
    if stand_ins and draw(st.booleans()):
        told.append(ExtensionProperty("rtkit.stand-in", "yes"))
    told += [
        ExtensionProperty(key, value)
        for key, value in (draw(policies) if supervised else {}).items()
    ]
    sets = draw(set_values)
    return rts.ComponentInstance(
        "RTC:::Node:",
        f"{draw(st.sampled_from(['localhost', 'localhost/dir', 'box']))}/{instance}.rtc",
        instance,
        data_ports=tuple(
            rts.InstancePort(
                p.name, properties=(ExtensionProperty("port.port_type", p.port_type.value),)
            )
            for p in PORTS
        ),
        active_configuration_set=draw(st.sampled_from([None, "default", "fast"])),
        configuration_sets=tuple(
            rts.ConfigurationSet(
                name, tuple(rts.ConfigurationData(key, value) for key, value in data.items())
            )
            for name, data in sets.items()
        ),
        execution_contexts=(
            rts.OwnedContext("0", "PERIODIC", draw(rates) if supervised else 10.0),
        ),
        properties=tuple(told),
    )


@st.composite
def profiles(
    draw: st.DrawFn, *, stand_ins: bool = True, supervised: bool = False
) -> rts.RtsProfile:
    """Return a system of up to four components, with stand-ins among them, or policies."""
    instances = INSTANCES[: draw(st.integers(1, len(INSTANCES)))]
    made = tuple(draw(components(instance, stand_ins, supervised)) for instance in instances)
    ends = st.sampled_from(instances)
    wires = draw(
        st.lists(st.tuples(ends, ends, st.sampled_from(["in", "in2"])), max_size=4, unique=True)
    )
    return rts.RtsProfile(
        "RTSystem:a:b:1",
        "0.2",
        "2025-01-01T00:00:00",
        "2025-01-01T00:00:00",
        components=made,
        data_port_connectors=tuple(
            rts.DataPortConnector(
                f"w{number}",
                "wire",
                "IDL:RTC/TimedLong:1.0",
                "corba_cdr",
                "push",
                rts.TargetPort("RTC:::Node:", source, f"{source}.out"),
                rts.TargetPort("RTC:::Node:", sink, f"{sink}.{port}"),
            )
            for number, (source, sink, port) in enumerate(wires)
        ),
    )


def _supervision(instance: st.SearchStrategy[str]) -> tuple[st.SearchStrategy[act.Action], ...]:
    """Return what others do to rates, policies and names."""
    return (
        st.builds(act.SetRate, instance, st.just("0"), rates),
        st.builds(act.SetPolicy, instance, policies),
        st.builds(act.Unregister, instance.map(lambda name: f"localhost/{name}.rtc")),
    )


@st.composite
def disturbances(draw: st.DrawFn, *, supervised: bool = False) -> list[act.Action | str]:
    """Return what others did to the world: actions, and slaves that were killed."""
    instance = st.sampled_from(INSTANCES)
    one = st.one_of(
        st.builds(act.Delete, instance),
        st.builds(act.Disconnect, st.sampled_from(["w0", "w1", "w2", "w3"])),
        st.builds(act.ActivateSet, instance, st.sampled_from(["default", "fast"])),
        st.builds(
            act.SetParameters,
            instance,
            st.sampled_from(["default", "fast"]),
            st.dictionaries(st.sampled_from("ab"), values, min_size=1, max_size=2),
        ),
        *(_supervision(instance) if supervised else ()),
        st.sampled_from(["s1", "s2"]),
    )
    return draw(st.lists(one, max_size=6))


def disturb(world: FakeManager, disturbances: list[act.Action | str]) -> None:
    for each in disturbances:
        if not isinstance(each, str):
            world.perform(each)
        elif each in world.processes:
            world.kill(each)


def by_key(snapshot: Snapshot) -> tuple[object, ...]:
    """Return facts without the order in which they came to be, and without process ids."""
    return (
        {c.instance: c for c in snapshot.components},
        {wire.connector_id: wire for wire in snapshot.connectors},
        {process.name for process in snapshot.processes},
    )
