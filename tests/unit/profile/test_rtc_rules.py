"""Each repair of RTC profiles, through the versions."""

from __future__ import annotations

import pytest

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.constraint_model import (
    Between,
    Comparison,
    Constraint,
    ConstraintGroup,
    ConstraintUnit,
    IsNull,
    Like,
    Logical,
)
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.read import read_rtc
from rtkit.profile.rtc_model import (
    ConfigurationParameter,
    FsmTransition,
    Language,
    Library,
    RtcProfile,
    SystemParameter,
    TargetEnvironment,
)
from rtkit.profile.write import write_rtc

RTC = "http://www.openrtp.org/namespaces/rtc"
HEAD = f"""<rtc:RtcProfile xmlns:rtc="{RTC}" xmlns:rtcDoc="{RTC}_doc" xmlns:rtcExt="{RTC}_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" {{attributes}}>
"""
ROOT = 'rtc:id="RTC:v:c:n:1" rtc:version="0.3"'
INFO = """<rtc:BasicInfo xsi:type="rtcExt:basic_info_ext" rtc:name="n" rtc:componentType="STATIC"
    rtc:activityType="PERIODIC" rtc:componentKind="DataFlowComponent" rtc:category="c"
    rtc:vendor="v" rtc:version="1" rtc:executionType="PeriodicExecutionContext"
    rtc:creationDate="2020-01-02T03:04:05" rtc:updateDate="2021-01-02T03:04:05"/>
"""
BASE = INFO + "<rtc:Actions/>\n"
PORT = """<rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="DataInPort" rtc:name="in"
    rtc:type="RTC::TimedLong" rtcExt:position="LEFT"/>
"""
CONFIGURATION = """<rtc:ConfigurationSet><rtc:Configuration xsi:type="rtcExt:configuration_ext"
    rtc:name="gain" rtc:type="double" rtc:defaultValue="1.0">{}</rtc:Configuration>
</rtc:ConfigurationSet>"""


def document(body: str = BASE, attributes: str = ROOT) -> bytes:
    return f"{HEAD.format(attributes=attributes)}{body}</rtc:RtcProfile>\n".encode()


def repaired(data: bytes, *texts: str) -> RtcProfile:
    reading = read_rtc(data, "a.xml")
    assert [note.text for note in reading.notes] == list(texts)
    with pytest.raises(InvalidProfile) as caught:
        read_rtc(data, "a.xml", strict=True)
    assert [note.text for note in caught.value.problems] == list(dict.fromkeys(texts))
    assert read_rtc(write_rtc(reading.profile), "again").profile == reading.profile
    return reading.profile


def test_a_strict_document_has_no_notes() -> None:
    reading = read_rtc(document(BASE + PORT), strict=True)
    assert reading.notes == ()
    assert reading.profile.data_ports[0].type == "RTC::TimedLong"


@pytest.mark.parametrize(
    ("spelt", "meant"),
    [
        ("PERIODOC", "PERIODIC"),
        ("EVENT_DRIVEN", "EVENTDRIVEN"),
        ("Sporadics", "SPORADIC"),
        ("periodic", "PERIODIC"),
    ],
)
def test_misspelt_activity_types(spelt: str, meant: str) -> None:
    profile = repaired(
        document(BASE.replace('"PERIODIC"', f'"{spelt}"')),
        f"rtc:activityType {spelt!r} taken as {meant!r}",
    )
    assert profile.basic_info is not None
    assert profile.basic_info.activity_type == meant


def test_an_activity_type_like_no_other_is_an_error() -> None:
    with pytest.raises(InvalidProfile, match="rtc:activityType is 'XYZ'; allowed: PERIODIC, "):
        read_rtc(document(BASE.replace('"PERIODIC"', '"XYZ"')))


def test_absent_id_is_composed() -> None:
    profile = repaired(
        document(attributes='rtc:version="0.2"'), "rtc:id is absent: taken as 'RTC:v:c:n:1'"
    )
    assert profile.id == "RTC:v:c:n:1"


def test_absent_version_and_basic_facts() -> None:
    body = '<rtc:BasicInfo xsi:type="rtcExt:basic_info_ext" rtc:name="n"/><rtc:Actions/>'
    info = read_rtc(document(body, 'rtc:id="i"')).profile.basic_info
    assert info is not None
    assert (info.component_type, info.activity_type, info.component_kind) == (
        "STATIC",
        "PERIODIC",
        "DataFlowComponent",
    )
    assert (info.vendor, info.category, info.version) == ("", "", "")
    assert info.execution_type == "PeriodicExecutionContext"


def test_a_fragment_is_read_and_noted() -> None:
    body = "<rtc:ConfigurationSet><rtc:Configuration/></rtc:ConfigurationSet>"
    reading = read_rtc(document(body, 'rtc:version="0.3"'), "a.xml")
    assert "a fragment: no rtc:BasicInfo and no rtc:Actions" in [n.text for n in reading.notes]
    profile = reading.profile
    assert (profile.id, profile.basic_info, profile.actions) == ("", None, None)
    assert profile.configuration_set is not None
    assert profile.configuration_set.configurations == (ConfigurationParameter("", "", ""),)


def test_a_nameless_parameter_of_a_whole_profile_is_an_error() -> None:
    body = BASE + "<rtc:ConfigurationSet><rtc:Configuration/></rtc:ConfigurationSet>"
    with pytest.raises(InvalidProfile, match="rtc:Configuration has no rtc:name"):
        read_rtc(document(body))


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('position="LEFT"', 'position="left"', "rtcExt:position 'left' taken as 'LEFT'"),
        ('"DataInPort"', '"IN"', "rtc:portType 'IN' taken as 'DataInPort'"),
        (' rtcExt:position="LEFT"', "", "rtcExt:position is absent: taken as 'LEFT'"),
        (
            " rtcExt:position",
            ' rtc:subscriprionType="new" rtcExt:position',
            "rtc:subscriprionType taken as rtc:subscriptionType",
        ),
        (
            " rtcExt:position",
            ' rtcExt:varname="v" rtcExt:position',
            "rtcExt:varname taken as rtcExt:variableName",
        ),
    ],
)
def test_data_ports_of_old(old: str, new: str, text: str) -> None:
    body = PORT.replace(old, new)
    assert body != PORT
    (port,) = repaired(document(BASE + body), text).data_ports
    assert (port.port_type, port.position) == ("DataInPort", "LEFT")
    assert port.subscription_type == ("new" if "subscri" in text else None)
    assert port.variable_name == ("v" if "varname" in text else None)


@pytest.mark.parametrize("spelt", ["DataOutPort", "OUT"])
def test_an_out_port_without_position_is_on_the_right(spelt: str) -> None:
    body = PORT.replace('"DataInPort"', f'"{spelt}"').replace(' rtcExt:position="LEFT"', "")
    (port,) = read_rtc(document(BASE + body)).profile.data_ports
    assert (port.port_type, port.position) == ("DataOutPort", "RIGHT")


def test_service_interfaces_of_old() -> None:
    body = """<rtc:ServicePorts xsi:type="rtcExt:serviceport_ext" rtc:name="s"
      rtcExt:position="top"><rtc:TransMethods rtc:kind="k"/>
      <rtc:ServiceInterface xsi:type="rtcExt:serviceinterface_ext" rtc:name="i"
        rtc:direction="PROVIDED" rtc:type="M::I" rtc:varname="v" rtc:path="/idl"/>
      </rtc:ServicePorts>"""
    (port,) = repaired(
        document(BASE + body),
        "children of rtc:ServicePorts put in order",
        "rtcExt:position 'top' taken as 'TOP'",
        "rtc:direction 'PROVIDED' taken as 'Provided'",
        "rtc:varname taken as rtcExt:variableName",
    ).service_ports
    (interface,) = port.service_interfaces
    assert (interface.direction, interface.variable_name, interface.path) == (
        "Provided",
        "v",
        "/idl",
    )
    assert [method.kind for method in port.trans_methods] == ["k"]


def test_the_documenting_types_are_right_as_they_stand() -> None:
    body = CONFIGURATION.replace("rtcExt:configuration_ext", "rtcDoc:configuration_doc").format(
        '<rtcDoc:Doc rtcDoc:unit="m"/>'
    )
    reading = read_rtc(document(BASE + body), strict=True)
    assert reading.profile.configuration_set is not None
    (configuration,) = reading.profile.configuration_set.configurations
    assert configuration.doc is not None
    assert (configuration.doc.unit, configuration.doc.range) == ("m", None)
    assert b"rtcExt:configuration_ext" in write_rtc(reading.profile)


def test_version_up_logs_of_old() -> None:
    body = BASE.replace(
        "/>\n<rtc:Actions",
        "><rtcExt:VersionUpLog>one</rtcExt:VersionUpLog></rtc:BasicInfo><rtc:Actions",
    )
    info = repaired(document(body), "rtcExt:VersionUpLog taken as rtcExt:VersionUpLogs").basic_info
    assert info is not None
    assert info.version_up_logs == ("one",)


def test_language_of_old() -> None:
    body = (
        '<rtc:Language xsi:type="rtcExt:language_ext"><rtc:Cxx rtc:os="Linux">'
        "<rtc:arch>x86</rtc:arch><rtc:library>m</rtc:library><rtc:library rtc:name='z'/>"
        "</rtc:Cxx></rtc:Language>"
    )
    profile = repaired(document(BASE + body), "rtc:Cxx taken as rtc:kind 'C++'")
    target = TargetEnvironment(os="Linux", cpus=("x86",), libraries=(Library("m"), Library("z")))
    assert profile.language == Language("C++", (target,))


@pytest.mark.parametrize(
    ("tag", "kind"), [("Python", "Python"), ("Java", "Java"), ("Csharp", "C#"), ("Ruby", "Ruby")]
)
def test_other_languages_of_old(tag: str, kind: str) -> None:
    body = f'<rtc:Language xsi:type="rtcExt:language_ext"><rtc:{tag}/></rtc:Language>'
    profile = repaired(document(BASE + body), f"rtc:{tag} taken as rtc:kind {kind!r}")
    assert profile.language == Language(kind)


def test_parameters_are_kept() -> None:
    body = (
        BASE + '<rtc:Parameters rtc:name="p" rtc:defaultValue="1"/><rtc:Parameters rtc:name="q"/>'
    )
    profile = read_rtc(document(body), strict=True).profile
    assert profile.parameters == (SystemParameter("p", "1"), SystemParameter("q"))


def test_events_and_occurrence() -> None:
    body = """<rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="EventPort" rtc:name="e"
      rtc:type="Any" rtcExt:position="LEFT">
      <rtc:Event xsi:type="rtcDoc:event_doc" rtc:name="" rtc:source="a" rtc:target="b"/>
      <rtcDoc:Doc rtcDoc:occurrence="often"/></rtc:DataPorts>"""
    (port,) = repaired(
        document(BASE + body), "rtcDoc:occurrence taken as rtcDoc:occerrence"
    ).data_ports
    assert port.events == (FsmTransition("", "a", "b"),)
    assert port.doc is not None
    assert port.doc.occerrence == "often"


def test_port_names_used_twice_are_noted_only() -> None:
    out = PORT.replace("DataInPort", "DataOutPort")
    reading = read_rtc(document(BASE + PORT + out), strict=True)
    assert [note.text for note in reading.notes] == ["port name in is also used on line 9"]


def constraint(inside: str) -> Constraint:
    body = CONFIGURATION.format(f"<rtc:Constraint>{inside}</rtc:Constraint>")
    profile = read_rtc(document(BASE + body), strict=True).profile
    assert read_rtc(write_rtc(profile), strict=True).profile == profile
    assert profile.configuration_set is not None
    found = profile.configuration_set.configurations[0].constraint
    assert found is not None
    return found


def unit(inside: str, attributes: str = "") -> str:
    return f"<rtc:ConstraintUnitType{attributes}>{inside}</rtc:ConstraintUnitType>"


EQUAL = (
    '<rtc:propertyIsEqualTo rtc:matchCase="true"><rtc:Literal> 1 </rtc:Literal>'
    "</rtc:propertyIsEqualTo>"
)
IS_ONE = Constraint(ConstraintUnit(Comparison("propertyIsEqualTo", " 1 ", True)))
ONE = f"<rtc:Constraint>{unit(EQUAL)}</rtc:Constraint>"


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        (unit(EQUAL), IS_ONE),
        (
            unit(EQUAL, ' rtc:key="k"'),
            Constraint(ConstraintUnit(Comparison("propertyIsEqualTo", " 1 ", True), "k")),
        ),
        (
            unit(
                "<rtc:propertyIsBetween><rtc:LowerBoundary>1</rtc:LowerBoundary>"
                "<rtc:UpperBoundary/></rtc:propertyIsBetween>"
            ),
            Constraint(ConstraintUnit(Between("1", ""))),
        ),
        (
            unit(
                '<rtc:propertyIsLike rtc:wildCard="*" rtc:singleChar="?" rtc:escapeChar="!">'
                "<rtc:Literal>a*</rtc:Literal></rtc:propertyIsLike>"
            ),
            Constraint(ConstraintUnit(Like("a*", "*", "?", "!"))),
        ),
        (unit("<rtc:propertyIsNullType/>"), Constraint(ConstraintUnit(IsNull()))),
        (unit(f"<rtc:Not>{ONE}</rtc:Not>"), Constraint(ConstraintUnit(Logical("Not", (IS_ONE,))))),
        (
            unit(f"<rtc:Or>{ONE}{ONE}</rtc:Or>"),
            Constraint(ConstraintUnit(Logical("Or", (IS_ONE, IS_ONE)))),
        ),
        (
            f"<rtc:ConstraintListType>{ONE}</rtc:ConstraintListType>",
            Constraint(ConstraintGroup("ConstraintListType", (IS_ONE,))),
        ),
        (
            "<rtc:ConstraintHashType/>",
            Constraint(ConstraintGroup("ConstraintHashType")),
        ),
    ],
)
def test_constraints(inside: str, expected: Constraint) -> None:
    assert constraint(inside) == expected


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ("", "rtc:Constraint needs at least 1 of: rtc:ConstraintHashType"),
        (unit(""), "rtc:ConstraintUnitType needs at least 1 of: rtc:Not | rtc:And"),
        (unit(EQUAL * 2), "second rtc:propertyIsEqualTo"),
        (unit(EQUAL) + "<rtc:ConstraintListType/>", "second rtc:ConstraintListType"),
        (unit(f"<rtc:And>{ONE}</rtc:And>"), "rtc:And needs at least 2 of: rtc:Constraint"),
        (unit(f"<rtc:Not>{ONE}{ONE}</rtc:Not>"), "rtc:Not holds more than one rtc:Constraint"),
        (unit("<rtc:propertyIsLike/>"), "rtc:propertyIsLike has no rtc:wildCard"),
    ],
)
def test_constraints_that_mean_nothing(inside: str, text: str) -> None:
    body = CONFIGURATION.format(f"<rtc:Constraint>{inside}</rtc:Constraint>")
    with pytest.raises(InvalidProfile, match=text.replace("|", r"\|")):
        read_rtc(document(BASE + body))


def test_absent_match_case_is_false() -> None:
    careless = EQUAL.replace(' rtc:matchCase="true"', "")
    body = CONFIGURATION.format(f"<rtc:Constraint>{unit(careless)}</rtc:Constraint>")
    profile = repaired(document(BASE + body), "rtc:matchCase is absent: taken as 'false'")
    assert profile.configuration_set is not None
    found = profile.configuration_set.configurations[0].constraint
    assert found == Constraint(ConstraintUnit(Comparison("propertyIsEqualTo", " 1 ")))


def test_foreign_content_of_text_is_dropped_with_a_note() -> None:
    careless = EQUAL.replace("<rtc:Literal>", '<rtc:Literal xmlns:f="urn:f" f:a="1">')
    body = CONFIGURATION.format(
        f"<rtc:Constraint>{unit(careless)}</rtc:Constraint>"
        '<rtcExt:Properties rtcExt:name="__widget__" rtcExt:value="slider.0.1"/>'
    )
    profile = repaired(document(BASE + body), "unknown attribute {urn:f}a dropped")
    assert profile.configuration_set is not None
    (configuration,) = profile.configuration_set.configurations
    assert configuration.properties == (ExtensionProperty("__widget__", "slider.0.1"),)


def test_a_language_may_leave_its_kind_open() -> None:
    profile = repaired(document(f"{BASE}<rtc:Language/>"), "rtc:kind is absent: taken as ''",
                       "xsi:type is absent: taken as 'rtcExt:language_ext'")  # fmt: skip
    assert profile.language == Language("")


def test_system_parameters_stand_behind_the_service_ports() -> None:
    port = (
        '<rtc:ServicePorts xsi:type="rtcExt:serviceport_ext" rtc:name="s" rtcExt:position="LEFT"/>'
    )
    old = '<rtc:Parameters rtc:name="a" rtc:defaultValue="1"/>'
    profile = read_rtc(document(f"{BASE}{PORT}{port}{old}"), strict=True).profile
    assert profile.parameters == (SystemParameter("a", "1"),)
    assert write_rtc(profile).index(b"<rtc:ServicePorts") < write_rtc(profile).index(
        b"<rtc:Parameters"
    )
    repaired(document(f"{BASE}{old}{PORT}"), "children of rtc:RtcProfile put in order")
