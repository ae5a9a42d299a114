"""Laws of parameters: nothing changes without them, prefixes keep systems apart and come off."""

from __future__ import annotations

from pathlib import Path

import pytest
from corpus import corpus, needs_corpus
from hypothesis import given
from hypothesis import strategies as st

from rtkit.profile import rts_model as m
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.parameters import GivenValue
from rtkit.profile.parameters.naming import prefixed, renamed
from rtkit.profile.parameters.resolve import SourceProfile, resolve
from rtkit.profile.parameters.texts import substituted
from rtkit.profile.read import read_file, read_rts
from rtkit.profile.write import write_rts

FILES = corpus("rts/*", "yaml/*rts*")
NAMES = st.text(st.sampled_from("cde0_."), min_size=1, max_size=4)
TYPE = "RTC:Me:test:{}:1.0"


def source(profile: m.RtsProfile) -> SourceProfile:
    return SourceProfile("it", "/it", profile)


def end(name: str) -> m.TargetPort:
    path = ExtensionProperty("COMPONENT_PATH_ID", f"localhost/{name}.rtc")
    return m.TargetPort(TYPE.format(name), name, f"{name}.port", (path,))


def component(name: str, members: list[str]) -> m.ComponentInstance:
    refs = tuple(m.ComponentRef(TYPE.format(each), each) for each in members)
    listed = ",".join(members)
    shown = [f"{name}.port", *(f"{name}.{each}.port" for each in members)]
    create = f"T?manager_name=s{name}&instance_name={name}" + (listed and f"&members={listed}")
    return m.ComponentInstance(
        TYPE.format(name),
        f"localhost/{name}.rtc",
        name,
        data_ports=tuple(m.InstancePort(each) for each in dict.fromkeys(shown)),
        configuration_sets=(
            m.ConfigurationSet("default", (m.ConfigurationData("members", listed),)),
        ),
        execution_contexts=(m.OwnedContext("0", "PERIODIC", 10.0, refs),),
        participants=refs,
        properties=(ExtensionProperty("rtkit.create", create),),
    )


@st.composite
def systems(draw: st.DrawFn) -> m.RtsProfile:
    """Draw a system in which components name each other in every way there is."""
    names = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    some = st.lists(st.sampled_from(names), max_size=2, unique=True)
    pairs = draw(st.lists(st.tuples(st.sampled_from(names), st.sampled_from(names)), max_size=3))
    targets = [m.TargetComponent(TYPE.format(each), each, "0") for each in names]
    return m.RtsProfile(
        "RTSystem:Me:Robot:1.0",
        "0.2",
        "2025-01-01T00:00:00",
        "2025-01-01T00:00:00",
        components=tuple(component(each, draw(some)) for each in names),
        groups=(m.ComponentGroup("g", (m.ComponentRef(TYPE.format(names[0]), names[0]),)),),
        data_port_connectors=tuple(
            m.DataPortConnector(f"w{n}", f"n{n}", "", "", "", end(one), end(other))
            for n, (one, other) in enumerate(pairs)
        ),
        activation=m.Order(
            tuple(
                m.OrderStep(n, each, preceding=m.Preceding((targets[0],)))
                for n, each in enumerate(targets)
            )
        ),
        properties=(
            ExtensionProperty("rtkit.state.on", f"{names[0]}=Active; {names[-1]}.x=1; *=Any"),
            ExtensionProperty("rtkit.event.off", f"lost {names[0]}"),
            ExtensionProperty(f"rtkit.restart.slave.s{names[0]}", "never"),
        ),
    )


def names_of(profile: m.RtsProfile) -> set[str]:
    """Return the names that a system gives; hosts, types, states and contexts are not its own."""
    found = {profile.id}
    for each in profile.components:
        create = dict(each.properties and [(p.name, p.value) for p in each.properties])
        found |= {each.instance_name, str(create.get("rtkit.create"))}
        found |= {each.path_uri} if each.path_uri.endswith(".rtc") else set()  # else it is no name
        found |= {port.name for port in each.data_ports + each.service_ports if "." in port.name}
        found |= {ref.instance_name for ref in each.participants}
    found |= {each.group_id for each in profile.groups}
    for wire in (*profile.data_port_connectors, *profile.service_port_connectors):
        found |= {wire.connector_id, wire.source.instance_name, wire.target.instance_name}
    for order in (profile.activation, profile.start_up, profile.deactivation):
        for step in order.targets if order is not None else ():
            found.add(step.target_component.instance_name)
    slaves = (p.name for p in profile.properties if p.name.startswith("rtkit.restart.slave"))
    return found | set(slaves) - {""} | {p.value or "" for p in profile.properties if p.value}


@given(systems())
def test_a_profile_without_parameters_is_what_it_resolves_to(profile: m.RtsProfile) -> None:
    assert resolve(source(profile)).profile == profile


@given(systems())
def test_a_prefix_comes_off_again(profile: m.RtsProfile) -> None:
    made = prefixed(profile, "a.")
    assert renamed(made, lambda name: name.removeprefix("a.")) == profile
    assert prefixed(prefixed(profile, "a."), "b.") == prefixed(profile, "b.a.")


@given(systems())
def test_two_prefixes_share_no_name(profile: m.RtsProfile) -> None:
    a, b = (resolve(source(profile), prefix=each).profile for each in ("a.", "b."))
    assert names_of(a) & names_of(b) <= {"None", "never"}
    for each in (a, b):
        assert read_rts(write_rts(each), strict=True).profile == each


@given(systems())
def test_including_twice_is_prefixing_twice(profile: m.RtsProfile) -> None:
    both = m.RtsProfile(
        "RTSystem:Me:Both:1.0",
        "0.2",
        "",
        "",
        includes=tuple(m.IncludedSystem("it", prefix) for prefix in ("a.", "b.")),
    )
    outer = SourceProfile("both", "/both", both)
    made = resolve(outer, load=lambda *_: source(profile)).profile
    a, b = prefixed(profile, "a."), prefixed(profile, "b.")
    assert made.components == a.components + b.components
    assert made.data_port_connectors == a.data_port_connectors + b.data_port_connectors
    assert made.groups == a.groups + b.groups
    assert made.activation is not None
    assert a.activation is not None
    assert b.activation is not None
    assert made.activation.targets == a.activation.targets + b.activation.targets
    assert made.includes == ()


@given(systems(), st.text(max_size=5))
def test_a_given_parameter_is_what_the_component_gets(profile: m.RtsProfile, text: str) -> None:
    name = profile.components[-1].instance_name
    value = GivenValue(f"{name}.gain", text, "")
    made = resolve(source(profile), [value], "a.").profile
    assert m.ConfigurationData("gain", text) in made.components[-1].configuration_sets[0].data
    assert made.components[:-1] == prefixed(profile, "a.").components[:-1]


@given(st.text("${}a$"), st.text(max_size=3))
def test_a_text_without_references_stays_and_dollars_come_back(text: str, value: str) -> None:
    escaped = text.replace("$", "$$")
    assert substituted(escaped, {}) == text
    assert substituted(f"{escaped}${{a}}", {"a": value}) == text + value


@needs_corpus
@pytest.mark.parametrize("file", FILES or [Path("none")], ids=lambda file: file.name)
def test_real_systems_keep_apart_under_prefixes(file: Path) -> None:
    profile = read_file(str(file), kind="rts").profile
    assert isinstance(profile, m.RtsProfile)
    assert resolve(source(profile)).profile == profile
    a, b = (prefixed(profile, prefix) for prefix in ("a.", "b."))
    assert renamed(a, lambda name: name.removeprefix("a.")) == profile
    assert {each.instance_name for each in a.components}.isdisjoint(
        each.instance_name for each in b.components
    )
    assert names_of(a) & names_of(b) <= {"", "None"}
