"""Laws of the profile room: what is written is read back equal, and is valid by both schemas."""

from __future__ import annotations

import json
from dataclasses import MISSING, fields, is_dataclass, replace
from functools import cache
from typing import Any

import xmlschema
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from lxml import etree

from rtkit.errors import Malformed
from rtkit.profile import constraint_model as c
from rtkit.profile.common import NO_FOREIGN, Foreign, ForeignElement
from rtkit.profile.constraint_text import format_constraint, parse_constraint
from rtkit.profile.constraint_value import allows
from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile, read_rtc, read_rts
from rtkit.profile.rtc_model import ConfigurationParameter, DeclaredParameters, RtcProfile
from rtkit.profile.rtc_spec import COMPARISONS, RTC_PROFILE
from rtkit.profile.rts_model import (
    ComponentInstance,
    ComponentRef,
    InstancePort,
    RtsProfile,
    TargetComponent,
    TargetPort,
)
from rtkit.profile.rts_spec import RTS_PROFILE
from rtkit.profile.spec import DATE, FLAG, REAL, WHOLE, Attr, ElementSpec
from rtkit.profile.words import normal_data_type, strip_instance
from rtkit.profile.write import write_profile, write_rtc, write_rts
from rtkit.profile.xmlnames import NAMESPACES
from rtkit.resources import resource

TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"], exclude_characters="\ufffe\uffff")
    | st.sampled_from("\t\n\r \u3042"),
    max_size=8,
)
NAMES = st.text(st.sampled_from("abc.:_日"), min_size=1, max_size=6)
DATES = st.datetimes().map(lambda value: value.replace(year=max(1, value.year)).isoformat())
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
WHOLES = st.integers(-(10**18) + 1, 10**18 - 1)
LOCALS = st.sampled_from(
    [
        "{urn:f}a",
        "{urn:f}b",
        "{urn:g}a-1",
        "{urn:h}日",
        f"{{{NAMESPACES['rtsExt']}}}newer",
        f"{{{NAMESPACES['rtcExt']}}}Newer",
        f"{{{NAMESPACES['rtcDoc']}}}newer",
    ]
)
INNER_LOCALS = LOCALS | st.just("bare")


def attributes_of(names: st.SearchStrategy[str]) -> st.SearchStrategy[tuple[tuple[str, str], ...]]:
    return st.dictionaries(names, TEXTS, max_size=2).map(lambda found: tuple(sorted(found.items())))


def unless_blank(text: str) -> str | None:
    return text if text and not text.isspace() else None


def leaf_text(text: str) -> str | None:
    return text or None


LEAVES = st.builds(
    ForeignElement,
    LOCALS,
    attributes_of(INNER_LOCALS),
    TEXTS.map(leaf_text),
    st.just(()),
    st.none(),
)


def with_children(below: st.SearchStrategy[ForeignElement]) -> st.SearchStrategy[ForeignElement]:
    inner = st.builds(lambda element, tail: replace(element, tail=unless_blank(tail)), below, TEXTS)
    return st.builds(
        ForeignElement,
        LOCALS,
        attributes_of(LOCALS),
        TEXTS.map(unless_blank),
        st.lists(inner, min_size=1, max_size=2).map(tuple),
        st.none(),
    )


ELEMENTS = st.recursive(LEAVES, with_children, max_leaves=3)
FOREIGN = st.builds(
    Foreign, attributes_of(LOCALS), st.lists(ELEMENTS, max_size=1).map(tuple)
) | st.just(NO_FOREIGN)


def value(attribute: Attr) -> st.SearchStrategy[Any]:
    if attribute.words:
        return st.sampled_from(attribute.words)
    return {FLAG: st.booleans(), WHOLE: WHOLES, REAL: NUMBERS, DATE: DATES}.get(
        attribute.kind, TEXTS
    )


def instances(spec: ElementSpec) -> st.SearchStrategy[Any]:
    """Generate models along the tables; constraints have a strategy of their own."""
    if spec.make is c.Constraint:
        return CONSTRAINTS
    return st.deferred(lambda: of(spec))


@cache
def of(spec: ElementSpec) -> st.SearchStrategy[Any]:
    if spec.wraps:
        inner = instances(spec.children[0].spec)  # type: ignore[arg-type]
        return st.builds(lambda item, around: replace(item, around=around), inner, FOREIGN)
    optional = {item.name for item in fields(spec.make) if item.default is not MISSING}  # type: ignore[arg-type]
    made: dict[str, st.SearchStrategy[Any]] = {}
    for attribute in spec.attributes:
        one = value(attribute)
        made[attribute.field] = one if attribute.required else st.none() | one
    for child in spec.children:
        one = TEXTS if child.spec is None else instances(child.spec)
        if child.is_many:
            made[child.field] = st.lists(one, min_size=child.least, max_size=2).map(tuple)
        else:
            made[child.field] = st.none() | one if child.field in optional else one
    made["foreign"] = FOREIGN
    return st.builds(spec.make, **made)


def units(
    tests: st.SearchStrategy[Any], foreign: st.SearchStrategy[Foreign]
) -> st.SearchStrategy[c.Constraint]:
    unit = st.builds(c.ConstraintUnit, tests, st.none() | TEXTS, foreign=foreign)
    return st.builds(c.Constraint, unit, foreign)


def constraints(foreign: st.SearchStrategy[Foreign]) -> st.SearchStrategy[c.Constraint]:
    """Generate constraints with such content of other namespaces in all places."""

    def combined(below: st.SearchStrategy[c.Constraint]) -> st.SearchStrategy[c.Constraint]:
        two = st.lists(below, min_size=2, max_size=3).map(tuple)
        negated = below.map(lambda one: (one,))
        groups = st.sampled_from(["ConstraintListType", "ConstraintHashType"])
        some = st.lists(below, max_size=2).map(tuple)
        return st.one_of(
            units(st.builds(c.Logical, st.just("Not"), negated, foreign), foreign),
            units(st.builds(c.Logical, st.sampled_from(["And", "Or"]), two, foreign), foreign),
            st.builds(c.Constraint, st.builds(c.ConstraintGroup, groups, some, foreign), foreign),
        )

    tests = st.one_of(
        st.builds(c.Comparison, st.sampled_from(COMPARISONS), TEXTS, st.booleans(), foreign),
        st.builds(c.Between, TEXTS, TEXTS, foreign=foreign),
        st.builds(c.Like, TEXTS, TEXTS, TEXTS, TEXTS, foreign=foreign),
        st.builds(c.IsNull, foreign=foreign),
    )
    return st.recursive(units(tests, foreign), combined, max_leaves=4)


CONSTRAINTS = constraints(FOREIGN)
PLAIN_CONSTRAINTS = constraints(st.just(NO_FOREIGN))


def referring(profile: RtsProfile) -> RtsProfile:
    """Make a generated system whole: unique names, references that lead somewhere."""
    components = [
        replace(item, instance_name=f"{item.instance_name.strip()}{number}")
        for number, item in enumerate(profile.components or (ComponentInstance("i", "", ""),))
    ]
    port = (InstancePort("p"),)
    components[0] = replace(
        components[0],
        data_ports=components[0].data_ports + port,
        service_ports=components[0].service_ports + port,
    )
    whole = replace(profile, components=tuple(components))
    referred: RtsProfile = pointing_at(components[0], whole)
    return referred


def pointing_at(home: ComponentInstance, item: Any) -> Any:
    """Let every reference inside `item` name the port ``p`` of `home`."""
    if isinstance(item, tuple):
        return tuple(pointing_at(home, one) for one in item)
    if not is_dataclass(item) or isinstance(item, Foreign | c.Constraint):
        return item
    changed = {field.name: pointing_at(home, getattr(item, field.name)) for field in fields(item)}
    if isinstance(item, ComponentRef | TargetComponent | TargetPort):
        changed |= {"component_id": home.id, "instance_name": home.instance_name}
    if isinstance(item, TargetPort):
        changed["port_name"] = "p"
    return replace(item, **changed)  # type: ignore[type-var]


def numbered(profile: RtsProfile) -> RtsProfile:
    """Give every connector an id of its own."""
    data = tuple(
        replace(item, connector_id=f"{item.connector_id}d{number}")
        for number, item in enumerate(profile.data_port_connectors)
    )
    services = tuple(
        replace(item, connector_id=f"{item.connector_id}s{number}")
        for number, item in enumerate(profile.service_port_connectors)
    )
    return replace(profile, data_port_connectors=data, service_port_connectors=services)


def one_precondition(profile: RtsProfile) -> RtsProfile:
    """Leave each step with exactly one precondition."""
    changed: dict[str, Any] = {}
    for field in fields(profile):
        order = getattr(profile, field.name)
        if type(order).__name__ == "Order":
            steps = tuple(
                replace(step, wait_time=None) if step.preceding else step
                for step in order.targets
                if step.preceding or step.wait_time
            )
            changed[field.name] = replace(order, targets=steps)
    return replace(profile, **changed)


SYSTEMS: st.SearchStrategy[RtsProfile] = (
    of(RTS_PROFILE).map(one_precondition).map(referring).map(numbered)
)
COMPONENTS: st.SearchStrategy[RtcProfile] = of(RTC_PROFILE)


@cache
def schemas(name: str) -> tuple[etree.XMLSchema, xmlschema.XMLSchema10]:
    path = resource("schemas", name)
    return etree.XMLSchema(file=path), xmlschema.XMLSchema10(path)


def assert_valid_by_both(written: bytes, name: str) -> None:
    quick, full = schemas(name)
    root = etree.fromstring(written)
    assert quick.validate(root), quick.error_log
    assert not [str(e)[:300] for e in full.iter_errors(root)]


@given(SYSTEMS)
@settings(deadline=None, max_examples=40)
def test_a_system_comes_back_equal(profile: RtsProfile) -> None:
    written = write_rts(profile)
    assert_valid_by_both(written, "RtsProfile.xsd")
    assert read_rts(written, strict=True).profile == profile
    assert write_rts(read_rts(written).profile) == written


@given(COMPONENTS)
@settings(deadline=None, max_examples=40)
def test_a_component_comes_back_equal(profile: RtcProfile) -> None:
    written = write_rtc(profile)
    assert_valid_by_both(written, "RtcProfile.xsd")
    assert read_rtc(written).profile == profile
    assert write_rtc(read_rtc(written).profile) == written


@cache
def json_validator(name: str) -> Draft202012Validator:
    with open(resource("schemas", name), encoding="utf-8") as stream:
        return Draft202012Validator(json.load(stream))


def json_schema(profile: RtsProfile | RtcProfile) -> Draft202012Validator:
    kind = "Rts" if isinstance(profile, RtsProfile) else "Rtc"
    return json_validator(f"{kind}Profile.schema.json")


@given(SYSTEMS | COMPONENTS)
@settings(deadline=None, max_examples=60)
def test_every_form_holds_the_same(profile: RtsProfile | RtcProfile) -> None:
    for form in FORMS:
        written = write_profile(profile, form)
        assert read_profile(written, form=form).profile == profile
        assert read_profile(written).profile == profile, "the form is found out"
        if form == "json":
            found = json_schema(profile).iter_errors(json.loads(written))
            assert not [str(error)[:300] for error in found]


@given(SYSTEMS | COMPONENTS, st.permutations(FORMS))
@settings(deadline=None, max_examples=50)
def test_every_form_becomes_every_other(profile: RtsProfile | RtcProfile, forms: list[str]) -> None:
    there = profile
    for form in (*forms, forms[0]):
        there = read_profile(write_profile(there, form), form=form).profile
    assert write_profile(there, forms[0]) == write_profile(profile, forms[0])


@given(PLAIN_CONSTRAINTS)
@settings(deadline=None)
def test_a_constraint_comes_back_equal_from_its_line(constraint: c.Constraint) -> None:
    line = format_constraint(constraint)
    assert parse_constraint(line) == constraint
    configuration = ConfigurationParameter("p", "double", "0", constraint=constraint)
    profile = RtcProfile("", "0.3", configuration_set=DeclaredParameters((configuration,)))
    read = read_rtc(write_rtc(profile)).profile.configuration_set
    assert read is not None
    assert read.configurations[0].constraint == constraint


@given(st.text("xab19<=>!(){},:'\"\\ .-", max_size=12) | TEXTS)
def test_a_line_that_can_be_read_is_written_so_that_it_means_the_same(text: str) -> None:
    try:
        constraint = parse_constraint(text)
    except Malformed:
        return
    if constraint is not None:
        line = format_constraint(constraint)
        assert parse_constraint(line) == constraint
        assert format_constraint(constraint) == line
        assert allows(constraint, "1") in (True, False)


@given(NAMES, NAMES)
def test_a_prefixed_port_name_loses_its_prefix(instance: str, port: str) -> None:
    assert strip_instance(f"{instance}.{port}", instance) == port


@given(TEXTS)
def test_a_normal_data_type_stays_normal(text: str) -> None:
    normal = normal_data_type(text)
    assert normal_data_type(normal) == normal
