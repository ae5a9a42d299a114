"""What makes a difference between two profiles, what does not, and that nothing is overlooked."""

from __future__ import annotations

import os.path
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import pytest
from corpus import CORPUS, TYPED

from rtkit.errors import Refused
from rtkit.profile.common import NO_FOREIGN, ExtensionProperty, Foreign, ForeignElement
from rtkit.profile.read import read_file
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile.rts_model import (
    ComponentGroup,
    ComponentInstance,
    ComponentRef,
    DataPortConnector,
    InstancePort,
    Order,
    OrderStep,
    OwnedContext,
    RtsProfile,
    TargetComponent,
    TargetPort,
    WaitTime,
)
from rtkit.profile.rts_model import ConfigurationData as Data
from rtkit.profile.rts_model import ConfigurationSet as Settings
from rtkit.profile_tools.difference import differences

DATE = "2025-01-01T00:00:00"
OUT = ComponentInstance(
    "RTC:v:c:Out:1",
    "h/Out0.rtc",
    "Out0",
    data_ports=(InstancePort("Out0.out"), InstancePort("Out0.more")),
    configuration_sets=(Settings("default", (Data("gain", "1"), Data("name", "x"))),),
    execution_contexts=(OwnedContext("0", "PERIODIC", 100.0),),
)
IN = ComponentInstance("RTC:v:c:In:1", "h/In0.rtc", "In0", data_ports=(InstancePort("In0.in"),))
WIRE = DataPortConnector(
    "1",
    "wire",
    "IDL:RTC/TimedLong:1.0",
    "corba_cdr",
    "push",
    TargetPort(OUT.id, "Out0", "Out0.out"),
    TargetPort(IN.id, "In0", "in"),
    "flush",
)
IN_REF = ComponentRef(IN.id, "In0")
SYSTEM = RtsProfile(
    "RTSystem:v:s:1", "0.2", DATE, DATE, components=(OUT, IN), data_port_connectors=(WIRE,)
)


def changed(**parts: Any) -> list[str]:
    """How the system differs when these parts of it are others."""
    return [each.text for each in differences(SYSTEM, replace(SYSTEM, **parts))]


def component(**parts: Any) -> tuple[ComponentInstance, ...]:
    return (replace(OUT, **parts), IN)


def wire(**parts: Any) -> tuple[DataPortConnector, ...]:
    return (replace(WIRE, **parts),)


def test_the_same_is_the_same() -> None:
    assert differences(SYSTEM, SYSTEM) == differences(SYSTEM, SYSTEM, takes_all=True) == []


def test_what_makes_no_difference() -> None:
    assert changed(id="other", creation_date="2026-01-01T00:00:00", abstract="x", comment="y") == []
    assert changed(components=(IN, OUT)) == []
    assert changed(data_port_connectors=wire(connector_id="2", name="n", visible=False)) == []
    source = replace(WIRE.source, port_name="out")
    short = wire(data_type="TimedLong", dataflow_type="PUSH", source=source)
    assert changed(data_port_connectors=short) == []
    stale = (ExtensionProperty("IOR", "IOR:00"), ExtensionProperty("POSITION", "1"))
    assert changed(components=component(properties=stale, composite_type="None", comment="c")) == []
    hidden = (*OUT.configuration_sets, Settings("__widget__", (Data("gain", "text"),)))
    assert changed(components=component(configuration_sets=hidden)) == []
    live = (
        ExtensionProperty("dataport.corba_cdr.inport_ior", "IOR:1"),
        ExtensionProperty("BEND_POINT", "1"),
    )
    assert changed(data_port_connectors=wire(properties=live)) == []


def test_components_come_and_go_with_all_that_is_theirs() -> None:
    assert changed(components=(IN,)) == ["- component Out0"]
    extra = replace(OUT, instance_name="Out1", data_ports=(InstancePort("o"),))
    assert changed(components=(OUT, IN, extra)) == ["+ component Out1"]


def test_components_change() -> None:
    assert changed(
        components=component(
            id="RTC:v:c:Out:2",
            path_uri="other/Out0.rtc",
            is_required=False,
            active_configuration_set="fast",
            composite_type="Grouping",
            properties=(ExtensionProperty("rtkit.create", "Out?manager_name=m"),),
        ),
        data_port_connectors=(),
    ) == [
        "~ component Out0: type RTC:v:c:Out:1 -> RTC:v:c:Out:2",
        "~ component Out0: path h/Out0.rtc -> other/Out0.rtc",
        "~ component Out0: required true -> false",
        "~ component Out0: active_set (none) -> fast",
        "~ component Out0: composite (none) -> Grouping",
        "~ component Out0: rtkit.create (none) -> Out?manager_name=m",
        "- connector Out0.out -> In0.in",
    ]


def test_policies_of_the_system_change() -> None:
    stale = ExtensionProperty("POSITION", "1")
    assert changed(properties=(stale, ExtensionProperty("rtkit.restart.slave.s1", "never"))) == [
        "~ system: rtkit.restart.slave.s1 (none) -> never"
    ]


def test_ports_parameters_and_contexts() -> None:
    sets = (Settings("default", (Data("gain", ""), Data("new", "1"))), Settings("fast"))
    contexts = (OwnedContext("0", "PERIODIC", 50.0), OwnedContext("1", "EVENT_DRIVEN"))
    assert changed(
        components=component(
            data_ports=(InstancePort("out"), InstancePort("other")),
            configuration_sets=sets,
            execution_contexts=contexts,
        )
    ) == [
        "- port Out0.more",
        "+ port Out0.other",
        "+ set Out0 fast",
        "~ parameter Out0 default.gain: value 1 -> ''",
        "- parameter Out0 default.name",
        "+ parameter Out0 default.new",
        "~ context Out0 0: rate 100 -> 50",
        "+ context Out0 1",
    ]


def test_connectors() -> None:
    assert changed(data_port_connectors=()) == ["- connector Out0.out -> In0.in"]
    other = replace(WIRE.source, port_name="more")
    assert changed(data_port_connectors=wire(source=other)) == [
        "+ connector Out0.more -> In0.in",
        "- connector Out0.out -> In0.in",
    ]
    options = (
        ExtensionProperty("dataport.buffer.length", "9"),
        ExtensionProperty("dataport.dataflow_type", "x"),
    )
    assert changed(data_port_connectors=wire(subscription_type="new", properties=options)) == [
        "~ connector Out0.out -> In0.in: subscription_type flush -> new",
        "~ connector Out0.out -> In0.in: dataport.buffer.length (none) -> 9",
    ]
    assert changed(data_port_connectors=(WIRE, WIRE)) == ["+ connector Out0.out -> In0.in (2)"]


def test_orders_and_groups() -> None:
    target = TargetComponent(OUT.id, "Out0", "0")
    assert changed(
        activation=Order((OrderStep(1, target),)), groups=(ComponentGroup("wheels", (IN_REF,)),)
    ) == ["+ order Activation", "+ group wheels"]
    one = replace(SYSTEM, activation=Order((OrderStep(1, target), OrderStep(2, target))))
    other = replace(SYSTEM, activation=Order((OrderStep(1, target, wait_time=WaitTime(5)),)))
    assert [each.text for each in differences(one, other)] == [
        "~ step Activation 1 Out0 in 0: wait_ms (none) -> 5",
        "- step Activation 2 Out0 in 0",
    ]


def test_components_of_one_name_are_told_apart_by_their_path() -> None:
    twin = replace(OUT, id="RTC:v:c:Twin:1", path_uri="g/Out0.rtc")
    two = replace(SYSTEM, components=(OUT, IN, twin))
    assert [each.text for each in differences(SYSTEM, two)] == ["+ component Out0 at g/Out0.rtc"]
    assert [each.text for each in differences(two, SYSTEM)] == ["- component Out0 at g/Out0.rtc"]


def sensor() -> RtcProfile:
    profile = read_file(str(TYPED / "sensor.xml")).profile
    assert isinstance(profile, RtcProfile)
    return profile


def test_kinds_cannot_be_compared() -> None:
    with pytest.raises(Refused, match="cannot be compared"):
        differences(SYSTEM, sensor())


def test_component_types() -> None:
    before = sensor()
    assert before.basic_info is not None
    assert before.configuration_set is not None
    assert before.actions is not None
    filtered, limit = before.configuration_set.configurations
    info = replace(before.basic_info, execution_rate=0.0, version="2.0", update_date=DATE, doc=None)
    after = replace(
        before,
        id="other",
        basic_info=info,
        actions=replace(before.actions, on_execute=None, on_error=None),
        configuration_set=replace(
            before.configuration_set,
            configurations=(replace(filtered, constraint=None), replace(limit, type=" Double ")),
        ),
        data_ports=(replace(before.data_ports[0], type="TimedBoolean", position="TOP"),),
        service_ports=(replace(before.service_ports[0], service_interfaces=()),),
    )
    assert [each.text for each in differences(before, after)] == [
        "~ component: version 1.0 -> 2.0",
        "~ component: execution_rate 50 -> (none)",
        "- port distance",
        "- interface control.calibrate",
        "- interface control.clock",
        "~ parameter filter: constraint (none,median) -> (none)",
        "- callback onExecute",
    ]


SCALARS = ("str | None", "bool | None", "int | None", "float | None")


def variations(value: Any) -> Iterator[Any]:
    """Every copy of a model with one value in it changed."""
    for each in fields(value):
        item = getattr(value, each.name)
        if is_dataclass(item) and not isinstance(item, Foreign):
            for other in variations(item):
                yield replace(value, **{each.name: other})
        elif isinstance(item, tuple):
            for index, part in enumerate(item):
                rest = (*item[:index], *item[index + 1 :])
                yield replace(value, **{each.name: rest})
                inner = variations(part) if is_dataclass(part) else [f"{part}x"]
                for other in inner:
                    yield replace(value, **{each.name: (*item[:index], other, *item[index + 1 :])})
        elif item is not None or each.type in SCALARS:
            yield replace(value, **{each.name: _other(item)})


def _other(value: Any) -> Any:
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return value + 1
    if isinstance(value, Foreign):
        other = Foreign((("{urn:x}a", "1"),), (ForeignElement("{urn:x}e"),))
        return other if value == NO_FOREIGN else NO_FOREIGN
    return "other" if value is None else f"{value}x"


SAMPLES = [
    str(TYPED / "sensor.xml"),
    *(
        str(CORPUS / name)
        for name in (
            "rts/gbiggs__rtsprofile__test__rtsystem.xml",
            "rtc/OpenRTM__OpenRTP-aist__jp.go.aist.rtm.rtcbuilder__resource__FSM__eventName__RTC.xml",
        )
    ),
]


@pytest.mark.parametrize("file", SAMPLES, ids=os.path.basename)
def test_with_all_each_value_makes_a_difference_of_its_own(file: str) -> None:
    if not os.path.exists(file):
        pytest.skip("corpus absent")
    profile = read_file(file).profile
    count = 0
    for other in variations(profile):
        found = differences(profile, other, takes_all=True)
        assert found, other
        assert "order of its elements" not in found[0].text, other
        count += 1
    assert count >= 100


def test_with_all_the_order_makes_a_difference() -> None:
    turned = replace(SYSTEM, components=(IN, OUT))
    (found,) = differences(SYSTEM, turned, takes_all=True)
    assert found.text == "~ profile: order of its elements"
