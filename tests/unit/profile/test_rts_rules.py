"""Each repair of RTS profiles, and each error that no mode forgives."""

from __future__ import annotations

import pytest

from rtkit.profile.common import ExtensionProperty, Reading
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.read import read_rts
from rtkit.profile.rts_model import ComponentInstance, ComponentRef, Location, RtsProfile
from rtkit.profile.rts_rules import NO_DATE
from rtkit.profile.words import property_value
from rtkit.profile.write import write_rts

RTS = "http://www.openrtp.org/namespaces/rts"
HEAD = f"""<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile xmlns:rts="{RTS}" xmlns:rtsExt="{RTS}_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" {{attributes}}>
"""
ROOT = (
    'rts:id="RTSystem:a:b:1" rts:version="0.2" '
    'rts:creationDate="2020-01-02T03:04:05" rts:updateDate="2021-01-02T03:04:05"'
)
OUT = """<rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:v:c:Out:1"
    rts:pathUri="localhost/Out0.rtc" rts:instanceName="Out0" rts:isRequired="true">
  <rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="Out0.out"/>
</rts:Components>
"""
IN = OUT.replace("Out", "In").replace(".out", ".in")
SOURCE = """<rts:sourceDataPort xsi:type="rtsExt:target_port_ext" rts:componentId="RTC:v:c:Out:1"
      rts:instanceName="Out0" rts:portName="out"/>"""
TARGET = """<rts:targetDataPort xsi:type="rtsExt:target_port_ext" rts:componentId="RTC:v:c:In:1"
      rts:instanceName="In0" rts:portName="in"/>"""
CONNECTOR = f"""<rts:DataPortConnectors xsi:type="rtsExt:dataport_connector_ext"
    rts:connectorId="c1" rts:name="out_in" rts:dataType="IDL:RTC/TimedLong:1.0"
    rts:interfaceType="corba_cdr" rts:dataflowType="push">
  {SOURCE}
  {TARGET}
</rts:DataPortConnectors>
"""
TARGET_COMPONENT = (
    '<rts:TargetComponent rts:componentId="RTC:v:c:Out:1" rts:instanceName="Out0" rts:id="0"/>'
)


def document(body: str = "", attributes: str = ROOT) -> bytes:
    return f"{HEAD.format(attributes=attributes)}{body}</rts:RtsProfile>\n".encode()


def repaired(data: bytes, *texts: str) -> RtsProfile:
    """Read `data`, expecting just these notes, which strict reading refuses line by line."""
    reading = read_rts(data, "a.xml")
    assert [note.text for note in reading.notes] == list(texts)
    with pytest.raises(InvalidProfile) as caught:
        read_rts(data, "a.xml", strict=True)
    told = [note.text for note in caught.value.problems]
    assert told == list(texts)
    assert all(f"a.xml:{note.line}: {note.text}" in str(caught.value) for note in reading.notes)
    again = read_rts(write_rts(reading.profile), "again", strict=True)
    assert again.profile == reading.profile
    return reading.profile


def errors(body: str, attributes: str = ROOT) -> list[tuple[int, str]]:
    found = []
    for strict in (False, True):
        with pytest.raises(InvalidProfile) as caught:
            read_rts(document(body, attributes), "a.xml", strict=strict)
        found.append([(note.line, note.text) for note in caught.value.problems])
    assert set(found[0]) <= set(found[1])
    return found[0]


def only_component(profile: RtsProfile) -> ComponentInstance:
    (component,) = profile.components
    return component


def test_a_strict_document_has_no_notes() -> None:
    reading = read_rts(document(OUT + IN + CONNECTOR), strict=True)
    assert reading.notes == ()
    (connector,) = reading.profile.data_port_connectors
    assert (connector.source.port_name, connector.target.port_name) == ("out", "in")


@pytest.mark.parametrize(
    ("old", "text"),
    [
        (' xsi:type="rtsExt:component_ext"', "xsi:type is absent: taken as 'rtsExt:component_ext'"),
        (' xsi:type="rtsExt:dataport_ext"', "xsi:type is absent: taken as 'rtsExt:dataport_ext'"),
        (' rts:isRequired="true"', "rts:isRequired is absent: taken as 'true'"),
    ],
)
def test_absent_parts_are_supplied(old: str, text: str) -> None:
    expected = read_rts(document(OUT)).profile
    assert repaired(document(OUT.replace(old, "")), text) == expected


def test_absent_path_is_empty() -> None:
    data = document(OUT.replace(' rts:pathUri="localhost/Out0.rtc"', "\n").replace("\n   ", "\n"))
    profile = repaired(data, "rts:pathUri is absent: taken as ''")
    assert only_component(profile).path_uri == ""


@pytest.mark.parametrize("wrong", ["rtsExt:none_ext", "rtsExt:dataport_ext", "rts:component_ext"])
def test_unknown_type_keeps_the_known_attributes(wrong: str) -> None:
    body = OUT.replace("rtsExt:component_ext", wrong).replace("<rts:Comp", "<rts:Comp", 1)
    profile = repaired(
        document(body), f"unknown xsi:type {wrong!r} taken as 'rtsExt:component_ext'"
    )
    assert only_component(profile).instance_name == "Out0"


def test_type_on_an_element_that_has_none() -> None:
    body = OUT.replace(
        "</rts:Components>",
        '<rts:ConfigurationSets xsi:type="x:y" rts:id="default"/></rts:Components>',
    )
    profile = repaired(document(body), "xsi:type 'x:y' dropped")
    assert only_component(profile).configuration_sets[0].id == "default"


def test_other_prefixes_and_a_prefix_declared_inside() -> None:
    body = (
        f'<Components xmlns="{RTS}" xmlns:e="{RTS}_ext" xmlns:r="{RTS}" xsi:type="e:component_ext" '
        'r:id="i" r:pathUri="" r:instanceName="a" r:isRequired="1" e:comment="remark"/>'
    )
    reading = read_rts(document(body), strict=True)
    assert only_component(reading.profile).comment == "remark"


def test_type_is_supplied_where_the_extension_is_the_default_namespace() -> None:
    data = (
        f'<r:RtsProfile xmlns:r="{RTS}" xmlns="{RTS}_ext" r:id="" r:version="0.2" '
        'r:creationDate="2020-01-01T00:00:00" r:updateDate="2020-01-01T00:00:00">'
        '<r:Components r:id="i" r:pathUri="" r:instanceName="a" r:isRequired="0">'
        '<Properties r:name="x"/></r:Components></r:RtsProfile>'
    ).encode()
    reading = read_rts(data)
    assert only_component(reading.profile).properties == (ExtensionProperty("x"),)


def test_absent_dates() -> None:
    profile = repaired(
        document(attributes='rts:id="i" rts:version="0.2"'),
        f"rts:creationDate is absent: taken as {NO_DATE!r}",
        f"rts:updateDate is absent: taken as {NO_DATE!r}",
    )
    assert profile.creation_date == profile.update_date == NO_DATE


@pytest.mark.parametrize("given", ["", ' rts:creationDate="  "'])
def test_an_absent_or_empty_date_is_the_other_one(given: str) -> None:
    date = "2021-01-02T03:04:05.123+09:00"
    profile = repaired(
        document(attributes=f'rts:id="i" rts:version="0.2" rts:updateDate="{date}"{given}'),
        f"rts:creationDate is absent: taken as {date!r}",
    )
    assert profile.creation_date == date


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("2020-01-02", "2020-01-02T00:00:00"),
        ("2020/01/02 03:04:05", "2020-01-02T03:04:05"),
        (" 2020-01-02T03:04:05 ", None),
    ],
)
def test_dates_in_other_forms(written: str, meant: str | None) -> None:
    data = document(attributes=ROOT.replace("2020-01-02T03:04:05", written))
    if meant is None:
        assert read_rts(data, strict=True).profile.creation_date == written
    else:
        profile = repaired(data, f"rts:creationDate {written!r} taken as {meant!r}")
        assert profile.creation_date == meant


def with_inside(inside: str) -> bytes:
    return document(OUT.replace("</rts:Components>", f"{inside}</rts:Components>"))


LOCATION = (
    '<rtsExt:Location rtsExt:x="1" rtsExt:y="-2" rtsExt:height="3" rtsExt:width="4" '
    'rtsExt:direction="{}"/>'
)


def test_direction_in_lower_case() -> None:
    profile = repaired(
        with_inside(LOCATION.format("right")), "rtsExt:direction 'right' taken as 'RIGHT'"
    )
    assert only_component(profile).location == Location(1, -2, 3, 4, "RIGHT")


def test_numbers_and_flags_in_other_forms() -> None:
    body = LOCATION.format("UP").replace('"1"', '"1.0"') + ('<rtsExt:Properties rtsExt:name="a"/>')
    data = with_inside(body).replace(b'isRequired="true"', b'isRequired="True"')
    profile = repaired(data, "rts:isRequired 'True' taken as 'true'", "rtsExt:x '1.0' taken as '1'")
    assert only_component(profile).location == Location(1, -2, 3, 4, "UP")


def test_empty_number_is_absent() -> None:
    inside = (
        '<rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" '
        'rts:kind="PERIODIC" rts:rate=""/>'
    )
    profile = repaired(with_inside(inside), "empty rts:rate taken as absent")
    assert only_component(profile).execution_contexts[0].rate is None


def test_execution_contexts_without_id_are_numbered() -> None:
    inside = '<rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext"/>' * 2
    profile = repaired(
        with_inside(inside),
        "rts:id is absent: taken as '0'",
        "rts:id is absent: taken as '1'",
        "rts:kind is absent: taken as 'PERIODIC'",
        "rts:kind is absent: taken as 'PERIODIC'",
    )
    assert [context.id for context in only_component(profile).execution_contexts] == ["0", "1"]


def test_children_in_any_order() -> None:
    body = (
        OUT.replace("  <rts:DataPorts", '<rtsExt:Properties rtsExt:name="a"/><rts:DataPorts')
        + '<rts:Groups rts:groupId="g"><rts:Members rts:componentId="RTC:v:c:Out:1" '
        + ('rts:instanceName="Out0"/></rts:Groups>')
    )
    groups_first = body[body.index("<rts:Groups") :] + body[: body.index("<rts:Groups")]
    profile = repaired(
        document(groups_first),
        "children of rts:RtsProfile put in order",
        "children of rts:Components put in order",
    )
    assert profile.groups[0].members == (ComponentRef("RTC:v:c:Out:1", "Out0"),)
    assert only_component(profile).properties == (ExtensionProperty("a"),)


def test_order_of_equal_children_stays() -> None:
    names = "zyxabc"
    inside = LOCATION.format("UP") + "".join(
        f'<rts:ServicePorts xsi:type="rtsExt:serviceport_ext" rts:name="{name}"/>' for name in names
    )
    ports = only_component(read_rts(with_inside(inside)).profile).service_ports
    assert "".join(port.name for port in ports) == names


def test_absent_data_type_is_empty() -> None:
    body = OUT + IN + CONNECTOR.replace(' rts:dataType="IDL:RTC/TimedLong:1.0"', "")
    profile = repaired(document(body), "rts:dataType is absent: taken as ''")
    assert profile.data_port_connectors[0].data_type == ""


def test_absent_data_type_is_taken_from_the_properties() -> None:
    body = CONNECTOR.replace(' rts:dataType="IDL:RTC/TimedLong:1.0"', "").replace(
        "</rts:DataPortConnectors>",
        '<rtsExt:Properties rtsExt:name="dataport.data_type" rtsExt:value="T"/>'
        "</rts:DataPortConnectors>",
    )
    profile = repaired(document(OUT + IN + body), "rts:dataType is absent: taken as 'T'")
    assert profile.data_port_connectors[0].data_type == "T"


def test_repeated_connector_ids() -> None:
    other = CONNECTOR.replace('"c1"', '"c1_2"')
    profile = repaired(
        document(OUT + IN + CONNECTOR + other + CONNECTOR + CONNECTOR),
        "connector id 'c1' is used before: taken as 'c1_3'",
        "connector id 'c1' is used before: taken as 'c1_4'",
    )
    ids = [connector.connector_id for connector in profile.data_port_connectors]
    assert ids == ["c1", "c1_2", "c1_3", "c1_4"]


def test_ports_that_only_a_connector_names() -> None:
    body = OUT + IN + CONNECTOR.replace('portName="out"', 'portName="Out0.more"')
    body = body.replace('portName="in"', 'portName="less"')
    profile = repaired(
        document(body),
        "port Out0.more of Out0 is named by a connector only: added",
        "port less of In0 is named by a connector only: added",
    )
    first, second = profile.components
    assert [port.name for port in first.data_ports] == ["Out0.out", "Out0.more"]
    assert [port.name for port in second.data_ports] == ["In0.in", "less"]
    for port, direction in (
        (first.data_ports[1], "DataOutPort"),
        (second.data_ports[1], "DataInPort"),
    ):
        assert property_value(port.properties, "port.port_type") == direction
        assert property_value(port.properties, "dataport.data_type") == "IDL:RTC/TimedLong:1.0"


def service_connector(*ports: str) -> str:
    ends = "".join(
        f'<rts:{end}ServicePort xsi:type="rtsExt:target_port_ext" '
        f'rts:componentId="RTC:v:c:{name}:1" '
        f'rts:instanceName="{name}0" rts:portName="{port}"/>'
        for end, name, port in zip(("source", "target"), ("Out", "In"), ports, strict=True)
    )
    return (
        '<rts:ServicePortConnectors xsi:type="rtsExt:serviceport_connector_ext" '
        f'rts:connectorId="s" rts:name="n">{ends}</rts:ServicePortConnectors>'
    )


def test_service_ports_that_only_a_connector_names() -> None:
    profile = repaired(
        document(OUT + IN + service_connector("give", "take")),
        "port give of Out0 is named by a connector only: added",
        "port take of In0 is named by a connector only: added",
    )
    (port,) = profile.components[0].service_ports
    assert (port.name, port.properties) == (
        "give",
        (ExtensionProperty("port.port_type", "CorbaPort"),),
    )


def test_connectors_without_id_get_one() -> None:
    body = CONNECTOR.replace(" \n", "\n").replace('rts:connectorId="c1"', "")
    profile = read_rts(document(OUT + IN + body + body)).profile
    ids = [connector.connector_id for connector in profile.data_port_connectors]
    assert ids == ["0", "1"]


def test_precondition_after_the_target() -> None:
    body = OUT + (
        '<rts:StartUp><rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="1">'
        f'{TARGET_COMPONENT}<rts:WaitTime rts:waitTime="250"/></rts:targets></rts:StartUp>'
    )
    profile = repaired(document(body), "children of rts:targets put in order")
    assert profile.start_up is not None
    (step,) = profile.start_up.targets
    assert step.wait_time is not None
    assert (step.sequence, step.wait_time.wait_time, step.preceding) == (1, 250, None)


def test_target_without_precondition() -> None:
    body = OUT + (
        '<rts:Finalizing><rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="1">'
        + TARGET_COMPONENT.replace(' rts:id="0"', "")
        + "</rts:targets></rts:Finalizing>"
    )
    profile = repaired(
        document(body),
        "rts:id is absent: taken as '0'",
        "target without WaitTime or Preceding: waits 0 ms",
    )
    assert profile.finalizing is not None
    assert profile.finalizing.targets[0].wait_time.wait_time == 0  # type: ignore[union-attr]
    assert profile.finalizing.targets[0].target_component.id == "0"


def test_absent_timeout_and_timing_stay_absent() -> None:
    body = OUT + (
        '<rts:Activation><rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="1">'
        f"<rts:Preceding/>{TARGET_COMPONENT}</rts:targets></rts:Activation>"
    )
    profile = read_rts(document(body), strict=True).profile
    assert profile.activation is not None
    preceding = profile.activation.targets[0].preceding
    assert preceding is not None
    assert (preceding.timeout, preceding.sending_timing) == (None, None)
    assert b"<rts:Preceding/>" in write_rts(profile)


def test_order_that_spells_the_component_id_otherwise() -> None:
    body = OUT + (
        '<rts:StartUp><rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="1">'
        f'<rts:WaitTime rts:waitTime="0"/>{TARGET_COMPONENT.replace("v:c:Out", "v.c.Out")}'
        "</rts:targets></rts:StartUp>"
    )
    profile = repaired(document(body), "rts:componentId 'RTC:v.c.Out:1' taken as 'RTC:v:c:Out:1'")
    assert profile.start_up is not None
    assert profile.start_up.targets[0].target_component.component_id == "RTC:v:c:Out:1"


def test_foreign_content_is_kept_and_noted_once() -> None:
    inside = '<f:a f:b="&#10;1" xml:lang="ja">x<f:c/>y<d/></f:a>'
    body = OUT.replace("<rts:Components", '<rts:Components xmlns:f="urn:f" f:k="v"').replace(
        "</rts:Components>", f"{inside}</rts:Components>"
    )
    reading: Reading[RtsProfile] = read_rts(document(body), strict=True)
    assert [note.text for note in reading.notes] == [
        "foreign attribute {urn:f}k kept",
        "foreign element {urn:f}a kept",
    ]
    foreign = only_component(reading.profile).foreign
    (element,) = foreign.elements
    assert foreign.attributes == (("{urn:f}k", "v"),)
    assert element.attributes == (
        ("{http://www.w3.org/XML/1998/namespace}lang", "ja"),
        ("{urn:f}b", "\n1"),
    )
    assert (element.text, [below.name for below in element.children]) == ("x", ["{urn:f}c", "d"])
    assert element.children[0].tail == "y"
    written = write_rts(reading.profile)
    assert b'<ns3:a xml:lang="ja" ns3:b="&#10;1">x<ns3:c/>y<d/></ns3:a>' in written
    assert read_rts(written, strict=True).profile == reading.profile


def test_attributes_of_xml_itself() -> None:
    body = (
        '<rts:Groups xml:base="urn:x" xml:lang="!"><f:a xmlns:f="urn:f" xml:id="a"/></rts:Groups>'
    )
    with pytest.raises(InvalidProfile) as caught:
        read_rts(document(body), strict=True)
    told = [note.text for note in caught.value.problems]
    assert "xml:base 'urn:x' dropped" in told
    assert "xml:lang '!' dropped" in told


def test_unknown_names_of_the_profile_itself_are_dropped() -> None:
    body = OUT.replace("<rts:Components", '<rts:Components rts:odd="1" loose="2"').replace(
        "</rts:Components>", "<rts:Odd/><loose/></rts:Components>"
    )
    profile = repaired(
        document(body),
        "unknown attribute loose dropped",
        "unknown attribute rts:odd dropped",
        "unknown element loose dropped",
        "unknown element rts:Odd dropped",
    )
    assert profile == read_rts(document(OUT)).profile


def test_bare_and_misplaced_attributes() -> None:
    bare = OUT.replace("rts:pathUri", "pathUri").replace(
        "rts:isRequired", 'rts:comment="c" isRequired'
    )
    profile = repaired(
        document(bare),
        "isRequired taken as rts:isRequired",
        "pathUri taken as rts:pathUri",
        "rts:comment taken as rtsExt:comment",
    )
    assert (only_component(profile).path_uri, only_component(profile).comment) == (
        "localhost/Out0.rtc",
        "c",
    )


def test_a_whole_document_of_bare_names() -> None:
    data = (
        f'<RtsProfile xmlns="{RTS}" id="i" version="0.2" creationDate="2020-01-01T00:00:00" '
        'updateDate="2020-01-01T00:00:00"><Components id="c" pathUri="p" instanceName="n" '
        'isRequired="true"><Properties name="k" value="v"/></Components></RtsProfile>'
    ).encode()
    component = only_component(read_rts(data).profile)
    assert (component.instance_name, component.properties) == ("n", (ExtensionProperty("k", "v"),))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("AllShared", "PeriodicStateShared"),
        ("ECShared", "PeriodicECShared"),
        ("NonShared", "Grouping"),
        ("Choice", "Grouping"),
        ("none", "None"),
    ],
)
def test_composite_types_of_old(old: str, new: str) -> None:
    body = OUT.replace("<rts:Components", f'<rts:Components rts:compositeType="{old}"')
    profile = repaired(document(body), f"rts:compositeType {old!r} taken as {new!r}")
    assert only_component(profile).composite_type == new


def test_nested_orders_and_connectors_of_version_0_1() -> None:
    body = """<rts:Component rts:id="RTC:v:c:A:1" rts:instanceName="A0" rts:pathUri="h/A0.rtc"
    rts:isRequired="true">
  <rts:ServicePorts rts:name="s"><rts:ServicePortConnectors rts:connectorId="c" rts:name="n">
    <rts:targetServicePort rts:componentId="RTC:v:c:B:1" rts:instanceName="B0" rts:portName="t"/>
  </rts:ServicePortConnectors></rts:ServicePorts>
  <rts:StartUp rts:sequence="2"><rts:WaitTime rts:waitTime="5"/></rts:StartUp>
  <rts:ShutDown><rts:Condition rts:sequence="1"/></rts:ShutDown>
</rts:Component>"""
    reading = read_rts(document(body, ROOT.replace("0.2", "0.1")))
    profile = reading.profile
    assert [component.instance_name for component in profile.components] == ["A0", "B0"]
    assert [port.name for port in profile.components[1].service_ports] == ["t"]
    (connector,) = profile.service_port_connectors
    assert (connector.source.instance_name, connector.source.port_name) == ("A0", "s")
    assert profile.start_up is not None
    assert profile.shut_down is not None
    (step,) = profile.start_up.targets
    assert (step.sequence, step.target_component.instance_name) == (2, "A0")
    assert step.wait_time is not None
    assert step.wait_time.wait_time == 5
    assert [step.sequence for step in profile.shut_down.targets] == [1]
    assert read_rts(write_rts(profile), strict=True).profile == profile


def line_of(body: str, text: str) -> int:
    lines = document(body).decode().splitlines()
    return next(number for number, line in enumerate(lines, 1) if text in line)


def test_dangling_component_is_an_error() -> None:
    body = OUT + CONNECTOR
    text = "rts:targetDataPort names component In0 (RTC:v:c:In:1), which is not listed"
    assert errors(body) == [(line_of(body, 'instanceName="In0"'), text)]


def test_component_listed_twice_names_both_lines() -> None:
    body = OUT + IN + OUT
    first = line_of(body, 'instanceName="Out0"')
    assert errors(body) == [
        (
            first + 8,
            f"component Out0 (RTC:v:c:Out:1) is listed twice; it is first listed on line {first}",
        )
    ]


def test_equal_instance_names_of_different_types_are_noted() -> None:
    reading = read_rts(document(OUT + OUT.replace("c:Out", "c:Other")), strict=True)
    assert [note.text for note in reading.notes] == ["instance name Out0 is also used on line 5"]


FAULTS: list[tuple[str, str]] = [
    (
        CONNECTOR.replace(SOURCE, ""),
        "rts:DataPortConnectors needs at least 1 of: rts:sourceDataPort",
    ),
    (
        CONNECTOR.replace(TARGET, TARGET * 2),
        "second rts:targetDataPort; at most one is allowed",
    ),
    (OUT.replace(' rts:instanceName="Out0"', ""), "rts:Components has no rts:instanceName"),
    (OUT.replace('"Out0"', '" "'), "component without a name: rts:instanceName is empty"),
    (OUT.replace('"true"', '"maybe"'), "rts:isRequired is 'maybe'; allowed: true, false, 1, 0"),
    (
        '<rts:Groups rts:groupId="g"/>',
        "rts:Groups needs at least 1 of: rts:Members",
    ),
    ("<rts:StartUp/><rts:StartUp/>", "second rts:StartUp; at most one is allowed"),
    ("junk", "rts:RtsProfile may not hold text: 'junk'"),
    (
        "<rtsExt:VersionUpLogs>a<rts:b/></rtsExt:VersionUpLogs>",
        "rtsExt:VersionUpLogs may hold text only, not rts:b",
    ),
    (
        OUT.replace("<rts:Components", '<rts:Components rts:compositeType="Heap"'),
        "rts:compositeType is 'Heap'; allowed: None, PeriodicECShared, PeriodicStateShared, "
        "Grouping, FsmECShared, FsmStateShared",
    ),
]


@pytest.mark.parametrize(("body", "text"), FAULTS)
def test_errors_in_every_mode(body: str, text: str) -> None:
    assert text in [told for _line, told in errors(OUT + IN + body if "Conn" in body else body)]


@pytest.mark.parametrize("value", ["1e999", "NaN", "INF", "-INF", "0x10", "1,5", "\u0661"])
def test_numbers_that_are_none(value: str) -> None:
    inside = (
        '<rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" '
        f'rts:kind="PERIODIC" rts:rate="{value}"/>'
    )
    with pytest.raises(InvalidProfile, match=f"rts:rate is '{value}'; allowed: a finite number"):
        read_rts(with_inside(inside))


@pytest.mark.parametrize("value", ["2020-02-30T00:00:00", "2020-01-01T24:00:00", "yesterday"])
def test_dates_that_are_none(value: str) -> None:
    assert len(errors("", ROOT.replace("2020-01-02T03:04:05", value))) == 1


def test_unknown_members_and_targets_are_errors() -> None:
    body = (
        OUT
        + '<rts:Groups rts:groupId="g"><rts:Members rts:componentId="x" '
        + ('rts:instanceName="Nobody"/></rts:Groups>')
    )
    ((_, text),) = errors(body)
    assert text == "rts:Members names component Nobody (x), which is not listed"


def test_all_problems_are_told_by_line() -> None:
    body = OUT.replace(' rts:instanceName="Out0"', "") + "<rts:Groups/>\n<rts:Systems/>\n"
    told = errors(body + "<rtsExt:Systems/>")
    assert [line for line, _ in told] == sorted(line for line, _ in told)
    assert len(told) == 5


def test_the_schema_has_the_last_word(monkeypatch: pytest.MonkeyPatch) -> None:
    from rtkit.profile import rts_spec

    monkeypatch.setattr(rts_spec.RTS_PROFILE, "required_count", 0)
    with pytest.raises(InvalidProfile, match="attribute 'rts:id' is required but missing"):
        read_rts(document(attributes=ROOT.replace('rts:id="RTSystem:a:b:1"', "")))
