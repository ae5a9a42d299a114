"""The strict form, byte for byte, and what cannot be written."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rtkit.errors import Malformed
from rtkit.profile.common import ExtensionProperty, Foreign, ForeignElement
from rtkit.profile.rtc_model import Actions, ActionStatus, Language, RtcProfile
from rtkit.profile.rts_model import (
    ComponentInstance,
    ComponentRef,
    ConfigurationData,
    ConfigurationSet,
    DataPortConnector,
    InstancePort,
    Location,
    Order,
    OrderStep,
    OwnedContext,
    RtsProfile,
    TargetComponent,
    TargetPort,
    WaitTime,
)
from rtkit.profile.write import write_rtc, write_rts

SYSTEM = RtsProfile(
    id="RTSystem:v:s:1",
    version="0.2",
    creation_date="2024-01-01T00:00:00",
    update_date="2024-01-02T00:00:00+09:00",
    abstract="two\nlines",
    components=(
        ComponentInstance(
            id="RTC:v:c:A:1",
            path_uri="localhost/A0.rtc",
            instance_name="A0",
            composite_type="PeriodicECShared",
            data_ports=(InstancePort("out", visible=False),),
            configuration_sets=(ConfigurationSet("default", (ConfigurationData("gain", "<1>"),)),),
            execution_contexts=(
                OwnedContext("0", "PERIODIC", 1000.0, (ComponentRef("RTC:v:c:A:1", "A0"),)),
            ),
            participants=(ComponentRef("RTC:v:c:A:1", "A0"),),
            location=Location(1, 2, -1, -1, "DOWN"),
            properties=(ExtensionProperty("rtkit.module", "a.py"), ExtensionProperty("empty")),
        ),
    ),
    data_port_connectors=(
        DataPortConnector(
            "id",
            "name",
            "IDL:RTC/TimedLong:1.0",
            "corba_cdr",
            "push",
            TargetPort("RTC:v:c:A:1", "A0", "out"),
            TargetPort("RTC:v:c:A:1", "A0", "out"),
            push_interval=0.5,
        ),
    ),
    activation=Order((OrderStep(1, TargetComponent("RTC:v:c:A:1", "A0", "0"), WaitTime(250)),)),
    foreign=Foreign(
        (("{urn:z}a", "1"),),
        (ForeignElement("{urn:y}b", children=(ForeignElement("{urn:z}c", (("d", "2"),), "t"),)),),
    ),
)
WRITTEN = """<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts" \
xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns:ns3="urn:z" xmlns:ns4="urn:y" \
rts:id="RTSystem:v:s:1" rts:version="0.2" rts:abstract="two&#10;lines" \
rts:creationDate="2024-01-01T00:00:00" rts:updateDate="2024-01-02T00:00:00+09:00" ns3:a="1">
    <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:v:c:A:1" \
rts:pathUri="localhost/A0.rtc" rts:instanceName="A0" rts:isRequired="true" \
rts:compositeType="PeriodicECShared">
        <rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="out" rtsExt:visible="false"/>
        <rts:ConfigurationSets rts:id="default">
            <rts:ConfigurationData rts:name="gain" rts:data="&lt;1&gt;"/>
        </rts:ConfigurationSets>
        <rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" \
rts:kind="PERIODIC" rts:rate="1000.0">
            <rts:Participants>
                <rts:Participant rts:componentId="RTC:v:c:A:1" rts:instanceName="A0"/>
            </rts:Participants>
        </rts:ExecutionContexts>
        <rts:Participants>
            <rts:Participant rts:componentId="RTC:v:c:A:1" rts:instanceName="A0"/>
        </rts:Participants>
        <rtsExt:Location rtsExt:x="1" rtsExt:y="2" rtsExt:height="-1" rtsExt:width="-1" \
rtsExt:direction="DOWN"/>
        <rtsExt:Properties rtsExt:name="rtkit.module" rtsExt:value="a.py"/>
        <rtsExt:Properties rtsExt:name="empty"/>
    </rts:Components>
    <rts:DataPortConnectors xsi:type="rtsExt:dataport_connector_ext" rts:connectorId="id" \
rts:name="name" rts:dataType="IDL:RTC/TimedLong:1.0" rts:interfaceType="corba_cdr" \
rts:dataflowType="push" rts:pushInterval="0.5">
        <rts:sourceDataPort xsi:type="rtsExt:target_port_ext" rts:componentId="RTC:v:c:A:1" \
rts:instanceName="A0" rts:portName="out"/>
        <rts:targetDataPort xsi:type="rtsExt:target_port_ext" rts:componentId="RTC:v:c:A:1" \
rts:instanceName="A0" rts:portName="out"/>
    </rts:DataPortConnectors>
    <rts:Activation>
        <rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="1">
            <rts:WaitTime rts:waitTime="250"/>
            <rts:TargetComponent rts:componentId="RTC:v:c:A:1" rts:instanceName="A0" rts:id="0"/>
        </rts:targets>
    </rts:Activation>
    <ns4:b>
        <ns3:c d="2">t</ns3:c>
    </ns4:b>
</rts:RtsProfile>
"""


def test_the_strict_form() -> None:
    assert write_rts(SYSTEM).decode() == WRITTEN


def test_rtc_form() -> None:
    profile = RtcProfile(
        "i", "0.3", actions=Actions(on_reset=ActionStatus(True)), language=Language("Python")
    )
    assert write_rtc(profile).decode() == (
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
        '<rtc:RtcProfile xmlns:rtc="http://www.openrtp.org/namespaces/rtc" '
        'xmlns:rtcDoc="http://www.openrtp.org/namespaces/rtc_doc" '
        'xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext" '
        'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" rtc:id="i" rtc:version="0.3">\n'
        "    <rtc:Actions>\n"
        '        <rtc:OnReset xsi:type="rtcDoc:action_status_doc" rtc:implemented="true"/>\n'
        "    </rtc:Actions>\n"
        '    <rtc:Language xsi:type="rtcExt:language_ext" rtc:kind="Python"/>\n'
        "</rtc:RtcProfile>\n"
    )


@pytest.mark.parametrize("bad", ["\0", "\x1b[31m", "\ud800", "\uffff"])
def test_characters_that_xml_cannot_carry(bad: str) -> None:
    with pytest.raises(Malformed, match="cannot be written to XML"):
        write_rts(replace(SYSTEM, abstract=f"a{bad}"))


@pytest.mark.parametrize("rate", [float("nan"), float("inf"), float("-inf")])
def test_numbers_that_are_not_finite(rate: float) -> None:
    context = OwnedContext("0", "PERIODIC", rate)
    component = replace(SYSTEM.components[0], execution_contexts=(context,))
    with pytest.raises(Malformed, match="rts:rate must be a finite number"):
        write_rts(replace(SYSTEM, components=(component,)))


def test_numbers_that_are_too_long() -> None:
    component = replace(SYSTEM.components[0], location=Location(10**18, 0, 0, 0, "UP"))
    with pytest.raises(Malformed, match="rtsExt:x is beyond 18 digits"):
        write_rts(replace(SYSTEM, components=(component,)))


@pytest.mark.parametrize("name", ["{urn:x}a b", "{urn:x}", "{urn:x}a><b", "1a"])
def test_foreign_names_that_are_none(name: str) -> None:
    foreign = Foreign(elements=(ForeignElement(name),))
    with pytest.raises(Malformed, match="is not an XML name"):
        write_rts(replace(SYSTEM, foreign=foreign))
