"""Whatever is asked of a new profile: it is strictly valid in every form, or refused in words."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile
from rtkit.profile.write import write_profile
from rtkit.profile_tools import new_component as new
from rtkit.profile_tools.new_system import NewMember, default_instance, new_system
from rtkit.profile_tools.validation import validated

DATE = "2025-01-01T00:00:00+09:00"
WORDS = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=8)
NAMES = st.one_of(st.sampled_from(["Range", "距離", "in", "_x1"]), WORDS)
TYPES = st.sampled_from(["TimedLong", "RTC::TimedDouble", "Img::TimedCameraImage", "any"])
PORTS = st.tuples(st.one_of(st.sampled_from("abcdef"), WORDS), TYPES).map(":".join)
PARAMETERS = st.one_of(
    st.sampled_from(["a:int=1", "b:double=1.5;0<=x<=9", "c:std::string=a,b", "d:short=1;(1,2)"]),
    WORDS,
)


def told(error: Exception) -> None:
    assert str(error)
    assert "\n" not in str(error)


def check(profile: object, kind: str) -> None:
    for form in FORMS:
        data = write_profile(profile, form)  # type: ignore[arg-type]
        verdict = validated(data, f"new.{form}", strict=True)
        assert verdict.findings == ()
        assert verdict.what == kind
        assert read_profile(data, form=form).profile == profile


@settings(deadline=None)
@given(
    NAMES,
    WORDS,
    st.lists(PORTS, max_size=3),
    st.lists(PORTS, max_size=3),
    st.lists(PORTS, max_size=3),
    st.lists(PARAMETERS, max_size=2),
    st.sampled_from([(), ("onExecute", "onRateChanged"), ("onNothing",)]),
    st.one_of(st.none(), st.floats(min_value=0, max_value=1e6)),
)
def test_new_components_are_strictly_valid(
    name: str,
    text: str,
    ins: list[str],
    outs: list[str],
    services: list[str],
    parameters: list[str],
    callbacks: tuple[str, ...],
    rate: float | None,
) -> None:
    try:
        ports = [new.data_port(each, "DataInPort") for each in ins]
        ports += [new.data_port(each, "DataOutPort") for each in outs]
        wishes = [new.interface(each, "Provided") for each in services]
        made = new.new_component(
            new.ComponentHeading(name, DATE, vendor=text, description=text, rate=rate),
            ports,
            new.service_ports(wishes),
            [new.parameter(each) for each in parameters],
            callbacks,
        )
    except Malformed as error:
        told(error)
        return
    check(made, "RTC profile")


def component(name: str, ins: list[str], outs: list[str]) -> NewMember:
    ports = [new.data_port(each, "DataInPort") for each in ins]
    ports += [new.data_port(each, "DataOutPort") for each in outs]
    services = new.service_ports([new.interface("service:Clock", "Provided")])
    return NewMember(new.new_component(new.ComponentHeading(name, DATE), ports, services), name)


ENDS = st.builds(
    "{}.{}={}.{}".format,
    *[st.sampled_from(["A", "B", "C", "A0"]), st.sampled_from(["i", "o", "service", "no"])] * 2,
)


@settings(deadline=None)
@given(NAMES, WORDS, st.lists(st.one_of(ENDS, WORDS), max_size=4), TYPES, TYPES)
def test_new_systems_are_strictly_valid(
    name: str, text: str, connections: list[str], one: str, other: str
) -> None:
    members = [
        component("A", [f"i:{one}"], [f"o:{other}"]),
        component("B", [f"i:{other}"], [f"o:{one}"]),
    ]
    try:
        made = new_system(name, DATE, members, connections, vendor=text, abstract=text)
    except (Malformed, NotFound, Refused) as error:
        told(error)
        return
    check(made, "RTS profile")


@given(st.lists(st.sampled_from(["A0", "A1", "A2", "B0"])))
def test_an_instance_gets_a_name_that_is_free(taken: list[str]) -> None:
    assert default_instance("A", taken) not in taken
