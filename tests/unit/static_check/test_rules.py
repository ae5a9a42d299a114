"""Each rule: a sound system changed in one place, and what is found there."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest
from lxml import etree

from rtkit.deployment.limits import Capacity
from rtkit.fast_dataclass import replace
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, DataPortConnector, RtsProfile, TargetPort
from rtkit.profile.xmlnames import NAMESPACES
from rtkit.report.finding import ERROR, NOTE, WARNING
from rtkit.static_check.check import findings
from rtkit.static_check.finding import RULES
from rtkit.static_check.stock import stocked
from rtkit.static_check.verdict import Options

ROBOT, SERVICE, KEYS = "sensor-controller-motor", "my-service", "microwave"
SYSTEMS = ("console", "microwave", "my-service", "sensor-controller-motor", "seq")
MOTOR = "RTC:rtkit:example:Motor:1.0"


MOTOR_MADE = (
    '<rtsExt:Properties rtsExt:name="rtkit.create" rtsExt:value="Motor?manager_name=motor'
    '&amp;instance_name=Motor0"/>'
)


class Case(NamedTuple):
    """A change of a system, and the one thing that is found because of it."""

    system: str
    old: str
    new: str
    severity: str
    rule: str
    found: str | None
    allowed: str
    text: str


CASES = [
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.restrat" rtsExt:value="always"/>',
        WARNING,
        "unknown-property",
        "rtkit.restrat",
        "",
        "Motor0: unknown property: rtkit.restrat (did you mean rtkit.restart?)",
    ),
    Case(
        ROBOT,
        "</rts:RtsProfile>",
        '<rtsExt:Properties rtsExt:name="rtkit.critical" rtsExt:value="yes"/></rts:RtsProfile>',
        WARNING,
        "unknown-property",
        "rtkit.critical",
        "",
        "unknown property: rtkit.critical (it belongs to a component)",
    ),
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.limit.memory" rtsExt:value="much"/>',
        ERROR,
        "supervision",
        "much",
        "",
        "Motor0: rtkit.limit.memory: not an amount of memory from 1M on,"
        " such as 200M or 1.5G: much",
    ),
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.place.with" rtsExt:value="Sensr0"/>',
        ERROR,
        "placement",
        "Sensr0",
        "",
        "Motor0: rtkit.place.with: no such component: Sensr0 (did you mean Sensor0?)",
    ),
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.place.tag" rtsExt:value="arm"/>',
        ERROR,
        "placement",
        "arm",
        "",
        "Motor0: unknown requirement: rtkit.place.tag (did you mean rtkit.place.tags?)",
    ),
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.movable" rtsExt:value="soon robot2"/>',
        ERROR,
        "placement",
        "soon robot2",
        "",
        "Motor0: rtkit.movable: not SECONDS [HOST...]: 'soon robot2'",
    ),
    Case(
        ROBOT,
        "Motor?manager_name=motor&amp;instance_name=Motor0",
        "Motor?rtkit.limit.memory=1G",
        ERROR,
        "limits",
        "Motor?rtkit.limit.memory=1G",
        "",
        "Motor0 has limits, and only a slave can be limited, not the manager itself:"
        " name one in its create string (manager_name=SLAVE)",
    ),
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.restart" rtsExt:value="sometimes"/>',
        ERROR,
        "supervision",
        "sometimes",
        "",
        "Motor0: rtkit.restart: not one of never, on-failure, always: sometimes",
    ),
    Case(
        ROBOT,
        MOTOR_MADE,
        f'{MOTOR_MADE}<rtsExt:Properties rtsExt:name="rtkit.health.stuck" rtsExt:value="panic"/>',
        ERROR,
        "supervision",
        "panic",
        "",
        "Motor0: rtkit.health.stuck: not one of log, degrade, restart, stop: panic",
    ),
    Case(
        ROBOT,
        "</rts:RtsProfile>",
        '<rtsExt:Properties rtsExt:name="rtkit.restart.slave.wheel" rtsExt:value="always"/>'
        "</rts:RtsProfile>",
        WARNING,
        "supervision",
        "rtkit.restart.slave.wheel",
        "",
        "no component is in such a slave: rtkit.restart.slave.wheel",
    ),
    Case(
        ROBOT,
        "</rts:RtsProfile>",
        '<rtsExt:Properties rtsExt:name="rtkit.restart.slave.motor" rtsExt:value="now"/>'
        "</rts:RtsProfile>",
        ERROR,
        "supervision",
        "now",
        "",
        "rtkit.restart.slave.motor: not one of never, on-failure, always: now",
    ),
    Case(
        ROBOT,
        "</rts:RtsProfile>",
        '<rtsExt:Properties rtsExt:name="rtkit.states" rtsExt:value="idle, idle"/>'
        "</rts:RtsProfile>",
        ERROR,
        "system-states",
        "idle, idle",
        "",
        "rtkit.states: named twice: idle",
    ),
    Case(
        ROBOT,
        '<rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="Motor0.pose"',
        '<rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="Motor0.place"/>\n'
        '<rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="Motor0.pose"',
        ERROR,
        "unknown-port",
        "Motor0.place",
        "velocity, pose",
        "Motor0 has no data port place",
    ),
    Case(
        SERVICE,
        '<rts:ServicePorts xsi:type="rtsExt:serviceport_ext" rts:name="MyServiceConsumer0',
        '<rts:ServicePorts xsi:type="rtsExt:serviceport_ext" rts:name="value"/>\n'
        '<rts:ServicePorts xsi:type="rtsExt:serviceport_ext" rts:name="MyServiceConsumer0',
        ERROR,
        "unknown-port",
        "value",
        "myservice",
        "MyServiceConsumer0 has no service port value; value is a data port",
    ),
    Case(
        ROBOT,
        'rts:portName="Sensor0.pose"',
        'rts:portName="nose"',
        ERROR,
        "unknown-port",
        "nose",
        "pose, distance",
        "Sensor0 has no data port nose",
    ),
    Case(
        ROBOT,
        '"How to drive"/>\n            <rtsExt:Properties rtsExt:name="port.port_type"'
        ' rtsExt:value="DataInPort"',
        '"How to drive"/>\n            <rtsExt:Properties rtsExt:name="port.port_type"'
        ' rtsExt:value="dataoutport"',
        ERROR,
        "port-direction",
        "dataoutport",
        "DataInPort",
        "port velocity of Motor0 is to be a dataoutport, but is a DataInPort",
    ),
    Case(
        ROBOT,
        '<rtsExt:Properties rtsExt:name="dataport.data_type" rtsExt:value="IDL:RTC/TimedPose2D:1.0',
        '<rtsExt:Properties rtsExt:name="dataport.data_type" rtsExt:value="RTC::TimedPose3D',
        ERROR,
        "data-type",
        "RTC::TimedPose3D",
        "RTC::TimedPose2D",
        "port pose of Motor0 is to carry RTC::TimedPose3D, but carries RTC::TimedPose2D",
    ),
    Case(
        ROBOT,
        'rts:dataType="IDL:RTC/TimedDouble:1.0"',
        'rts:dataType="TimedLong"',
        ERROR,
        "data-type",
        "TimedLong",
        "RTC::TimedDouble",
        "connector Sensor0.distance-Controller0.distance is for TimedLong,"
        " but Sensor0.distance carries RTC::TimedDouble",
    ),
    Case(
        ROBOT,
        'rts:portName="Sensor0.pose"',
        'rts:portName="Sensor0.distance"',
        ERROR,
        "connector-direction",
        "Sensor0.distance",
        "an in port",
        "connector Motor0.pose-Sensor0.pose joins two out ports, Motor0.pose and Sensor0.distance",
    ),
    Case(
        ROBOT,
        'rts:dataflowType="push" rts:subscriptionType="new" rtsExt:visible="true">\n'
        '        <rts:sourceDataPort xsi:type="rtsExt:target_port_ext" rts:componentId="' + MOTOR,
        'rts:dataflowType="shove" rts:subscriptionType="new" rtsExt:visible="true">\n'
        '        <rts:sourceDataPort xsi:type="rtsExt:target_port_ext" rts:componentId="' + MOTOR,
        ERROR,
        "dataflow-type",
        "shove",
        "pull, push",
        "connector Motor0.pose-Sensor0.pose: Motor0.pose and Sensor0.pose do not offer"
        " dataflow type shove",
    ),
    Case(
        SERVICE,
        'rts:portName="MyServiceProvider0.myservice"',
        'rts:portName="MyServiceProvider0.other"',
        ERROR,
        "unknown-port",
        "MyServiceProvider0.other",
        "myservice",
        "MyServiceProvider0 has no service port other",
    ),
    Case(
        ROBOT,
        'rts:name="patience" rts:data="0.5"',
        'rts:name="patients" rts:data="0.5"',
        ERROR,
        "unknown-parameter",
        "patients",
        "patience",
        "Motor0 has no configuration parameter patients (set default)",
    ),
    Case(
        ROBOT,
        'rts:name="patience" rts:data="0.5"',
        'rts:name="patience" rts:data="long"',
        ERROR,
        "parameter-type",
        "long",
        "double",
        "default.patience of Motor0 cannot be 'long': it is no number",
    ),
    Case(
        ROBOT,
        'rts:instanceName="Motor0" rts:isRequired="true" rts:activeConfigurationSet="default"',
        'rts:instanceName="Motor0" rts:isRequired="true" rts:activeConfigurationSet="slow"',
        WARNING,
        "unknown-set",
        "slow",
        "default",
        "Motor0: configuration set slow is active, but is not listed",
    ),
    Case(
        ROBOT,
        'rts:instanceName="Motor0" rts:isRequired="true" rts:activeConfigurationSet="default"',
        'rts:instanceName="Motor0" rts:isRequired="true" rts:activeConfigurationSet="__type__"',
        ERROR,
        "unknown-set",
        "__type__",
        "default",
        "Motor0: configuration set __type__ is hidden and cannot be active",
    ),
    Case(
        ROBOT,
        'rts:kind="PERIODIC" rts:rate="100.0"',
        'rts:kind="EVENT_DRIVEN" rts:rate="100.0"',
        ERROR,
        "context-kind",
        "EVENT_DRIVEN",
        "PERIODIC",
        "execution context 0 of Controller0 is EVENT_DRIVEN, its type's is PERIODIC",
    ),
    Case(
        ROBOT,
        'rts:kind="PERIODIC" rts:rate="100.0"',
        'rts:kind="PERIODIC" rts:rate="0"',
        ERROR,
        "context-rate",
        "0",
        "more than 0 Hz",
        "execution context 0 of Controller0 has a rate of 0 Hz",
    ),
    Case(
        ROBOT,
        'rts:kind="PERIODIC" rts:rate="100.0"',
        'rts:kind="PERIODIC" rts:rate="10"',
        WARNING,
        "context-rate",
        "10",
        "100",
        "execution context 0 of Controller0 has a rate of 10 Hz, its type's is 100 Hz",
    ),
    Case(
        KEYS,
        'rts:kind="EVENT_DRIVEN" rts:rate="0.0"',
        'rts:kind="PeriodicExecutionContext"',
        ERROR,
        "context-kind",
        "PeriodicExecutionContext",
        "EVENT_DRIVEN",
        "execution context 0 of Microwave0 is PeriodicExecutionContext, its type's is EVENT_DRIVEN",
    ),
    Case(
        ROBOT,
        'rts:pathUri="localhost/Motor0.rtc"',
        'rts:pathUri="127.0.0.1:2809/Sensor0.rtc"',
        ERROR,
        "path-clash",
        "localhost/Sensor0.rtc",
        "a path of its own",
        "Sensor0 is registered as localhost/Sensor0.rtc, and so is Motor0",
    ),
    Case(
        ROBOT,
        "RTC:rtkit:example:Motor:1.0",
        "RTC:rtkit:example:Motor:0.9",
        NOTE,
        "version",
        "RTC:rtkit:example:Motor:0.9",
        "RTC:rtkit:example:Motor:1.0",
        "Motor0 is checked against version 1.0 (Motor.xml)",
    ),
    Case(
        ROBOT,
        "RTC:rtkit:example:Motor:1.0",
        "RTC:others:example:Motor:1.0",
        WARNING,
        "no-profile",
        "RTC:others:example:Motor:1.0",
        "",
        "no RTC profile is known for Motor0 (RTC:others:example:Motor:1.0);"
        " of that name there is RTC:rtkit:example:Motor:1.0",
    ),
]


@pytest.mark.parametrize("name", SYSTEMS)
def test_what_ships_is_sound(name: str, check: Any, text_of: Any) -> None:
    checked = check(text_of(name))
    assert checked.findings == ()
    assert checked.what.startswith("system of ")


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.rule}: {case.text[:40]}")
def test_one_change_is_one_finding_at_its_place(case: Case, check: Any, text_of: Any) -> None:
    text = text_of(case.system)
    assert case.old in text
    # An identity stands in several places, and is to be changed in all of them.
    text = text.replace(case.old, case.new, -1 if case.old.startswith("RTC:") else 1)
    findings = [f for f in check(text).findings if f.rule != "unconnected-service"]
    assert [(f.severity, f.rule, f.found, f.allowed, f.text) for f in findings] == [case[3:]]
    finding = findings[0]
    assert finding.rule in RULES
    assert finding.file == "sys"
    found = etree.fromstring(text.encode()).xpath(finding.path, namespaces=NAMESPACES)
    if case.found is not None and "@" in finding.path:
        assert len(found) == 1
        assert {found[0], str(found[0]).removesuffix(".0")} & {case.found, case.found + ".0"}
        assert found[0] in text.splitlines()[finding.line - 1]


@pytest.mark.parametrize(
    ("key", "rule"),
    [
        ("subscription_type", "subscription-type"),
        ("dataflow_type", "dataflow-type"),
        ("interface_type", "interface-type"),
    ],
)
def test_the_property_of_a_connector_counts(key: str, rule: str, check: Any, text_of: Any) -> None:
    head, connectors, tail = text_of("console").partition("<rts:DataPortConnectors")
    old = f'rtsExt:name="dataport.{key}" rtsExt:value="'
    before, found, rest = tail.partition(old)
    assert found
    text = head + connectors + before + old + 'odd"' + rest.partition('"')[2]
    (finding,) = check(text).findings
    assert (finding.severity, finding.rule, finding.found) == (ERROR, rule, "odd")
    assert "Properties" in finding.path
    assert "odd" in text.splitlines()[finding.line - 1]


def test_what_a_port_offers_comes_from_its_profile_first(
    check: Any, text_of: Any, profile_of: Any
) -> None:
    old = 'rtc:portType="DataInPort" rtc:name="in" rtc:type="RTC::TimedLong"'
    profile = profile_of("ConsoleOut")
    assert old in profile
    offers = f'{old} rtc:subscriptionType="Periodic" rtc:interfaceType="CORBA_Any, other"'
    checked = check(text_of("console"), {"ConsoleOut.xml": profile.replace(old, offers)})
    told = [(f.rule, f.found, f.allowed) for f in checked.findings]
    assert told == [
        ("interface-type", "corba_cdr", "corba_any, other"),
        ("subscription-type", "new", "periodic"),
    ]
    any_type = offers.replace("Periodic", "Any").replace("other", "data_service")
    assert check(text_of("console"), {"ConsoleOut.xml": profile.replace(old, any_type)}).is_valid


@pytest.mark.parametrize("type", ["block", "NONBLOCK"])
def test_subscription_types_of_openrtm_2_are_known(type: str, check: Any, text_of: Any) -> None:
    text = text_of("console")
    assert 'subscriptionType="new"' in text
    assert not check(text.replace('subscriptionType="new"', f'subscriptionType="{type}"')).findings


def test_a_pulled_connector_needs_no_subscription(check: Any, text_of: Any) -> None:
    text = text_of("console").replace('Type="push"', 'Type="pull"')
    text = text.replace('"push"/>', '"pull"/>').replace(
        'subscriptionType="new"', 'subscriptionType="x"'
    )
    assert check(text).findings == ()


def test_a_reversed_connector_is_noted(check: Any, text_of: Any) -> None:
    text = text_of("console")
    head, mark, tail = text.partition("<rts:DataPortConnectors")
    swapped = tail.replace("sourceDataPort", "?").replace("targetDataPort", "sourceDataPort")
    (finding,) = check(head + mark + swapped.replace("?", "targetDataPort")).findings
    assert (finding.severity, finding.rule) == (NOTE, "connector-reversed")
    assert finding.text.endswith("taken from ConsoleIn0.out to ConsoleOut0.in")


def test_any_data_type_can_be_forced(check: Any, text_of: Any, profile_of: Any) -> None:
    profile = profile_of("ConsoleOut").replace("RTC::TimedLong", "RTC::TimedDouble")
    text = text_of("console")
    told = check(text, {"ConsoleOut.xml": profile}).findings
    assert [(f.rule, f.found, f.allowed) for f in told] == [
        ("data-type", "IDL:RTC/TimedLong:1.0", "RTC::TimedDouble"),
        ("data-type", "RTC::TimedDouble", "RTC::TimedLong"),
    ]
    forced = '<rtsExt:Properties rtsExt:name="rtkit.any_data_type" rtsExt:value="YES"/>'
    text = text.replace("</rts:DataPortConnectors>", forced + "</rts:DataPortConnectors>")
    assert len(check(text, {"ConsoleOut.xml": profile}).findings) == 1
    open_type = profile.replace("RTC::TimedDouble", "Any")
    assert check(text_of("console"), {"ConsoleOut.xml": open_type}).is_valid


def without_connectors(text: str) -> str:
    head, mark, tail = text.partition("    <rts:ServicePortConnectors")
    assert mark
    return head + tail.partition("</rts:ServicePortConnectors>\n")[2]


def test_what_is_required_has_to_be_provided(check: Any, text_of: Any) -> None:
    text = without_connectors(text_of("my-service"))
    (finding,) = check(text).findings
    assert (finding.severity, finding.rule) == (WARNING, "unconnected-service")
    assert finding.text == (
        "MyServiceConsumer0.myservice requires a provider of MyService, but is connected to nothing"
    )
    assert finding.allowed == "a connector to a provider of MyService"
    assert finding.path == "/rts:RtsProfile/rts:Components[1]/rts:ServicePorts"
    assert "MyServiceConsumer0.myservice" in text.splitlines()[finding.line - 1]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            'rtc:type="MyService"',
            'rtc:type="Other::MyService2"',
            {"service-interface", "unconnected-service"},
        ),
        (
            'rtc:direction="Provided"',
            'rtc:direction="Required"',
            {"service-polarity", "unconnected-service"},
        ),
        ('rtc:type="MyService"', 'rtc:type="SimpleService::MyService"', set()),
    ],
)
def test_services_have_to_match(
    old: str, new: str, told: set[str], check: Any, text_of: Any, profile_of: Any
) -> None:
    profile = profile_of("MyServiceProvider")
    assert old in profile
    checked = check(text_of("my-service"), {"MyServiceProvider.xml": profile.replace(old, new)})
    assert {f.rule for f in checked.findings} == told
    assert {f.rule for f in checked.findings if f.severity != ERROR} <= {"unconnected-service"}


def test_an_unknown_partner_may_provide_what_is_required(check: Any, text_of: Any) -> None:
    text = text_of("my-service").replace("RTC:rtkit:example:MyServiceProvider", "RTC:a:b:Provider")
    assert [f.rule for f in check(text).findings] == ["no-profile"]


@pytest.mark.parametrize(
    ("key", "rules"),
    [
        ("MyServiceProvider0.port.myservice.provided.MyService.myservice0", []),
        ("MyServiceProvider0.port.myservice.required.MyService.myservice0", ["service-polarity"]),
        ("MyServiceProvider0.port.myservice.provided.Mine.myservice0", ["service-interface"]),
        ("Other0.port.myservice.provided.Mine.myservice0", []),
    ],
)
def test_properties_of_a_connector_tell_of_interfaces(
    key: str, rules: list[str], check: Any, text_of: Any
) -> None:
    told = f'<rtsExt:Properties rtsExt:name="{key}" rtsExt:value="IOR:00"/>'
    end = "</rts:ServicePortConnectors>"
    text = text_of("my-service").replace(end, told + end)
    assert [f.rule for f in check(text).findings] == rules


def test_two_of_one_name(check: Any, text_of: Any) -> None:
    text = text_of("console")
    begin = text.index("    <rts:Components")
    end = text.index("</rts:Components>\n") + len("</rts:Components>\n")
    second = text[begin:end].replace(
        "RTC:rtkit:example:ConsoleIn:1.0", "RTC:rtkit:example:SeqOut:1.0"
    )
    for uri, rules in (
        ("localhost/ConsoleIn0.rtc", ["name-clash"]),
        ("localhost:2809/more/ConsoleIn0.rtc", ["name-clash"]),
        ("otherhost/ConsoleIn0.rtc", []),
        ("localhost/other.mgr/ConsoleIn0.rtc", []),
    ):
        twice = text[:begin] + second.replace("localhost/ConsoleIn0.rtc", uri) + text[begin:]
        found = check(twice).findings
        assert [f.rule for f in found if f.rule in ("name-clash", "path-clash")] == rules
        if rules:
            clash = next(f for f in found if f.rule == "name-clash")
            assert clash.text == "two components are named ConsoleIn0 on localhost"
            assert clash.path == "/rts:RtsProfile/rts:Components[2]/@rts:instanceName"


def target(instance: str, before: str = "", **more: str) -> str:
    kind = instance.rstrip("0")
    ref = 'rts:componentId="RTC:rtkit:example:{0}:1.0" rts:instanceName="{0}0" rts:id="{1}"'
    wait = '<rts:WaitTime rts:waitTime="5"/>'
    if before:
        first = ref.format(before.rstrip("0"), more.get("context", "0"))
        wait = f"<rts:Preceding><rts:PrecedingComponents {first}/></rts:Preceding>"
    own = ref.format(kind, "0")
    return f'<rts:targets rts:sequence="1">{wait}<rts:TargetComponent {own}/></rts:targets>\n'


@pytest.mark.parametrize("order", ["Activation", "Deactivation", "Resetting", "Finalizing"])
def test_conditions_in_a_circle(order: str, check: Any, text_of: Any) -> None:
    targets = [
        target("Sensor0", "Motor0"),
        target("Motor0", "Controller0"),
        target("Controller0", "Sensor0"),
    ]
    text = text_of(ROBOT).replace(
        "</rts:RtsProfile>", f"<rts:{order}>\n{''.join(targets)}</rts:{order}></rts:RtsProfile>"
    )
    (finding,) = check(text).findings
    assert (finding.severity, finding.rule) == (ERROR, "condition-circle")
    told = "Sensor0 waits for Motor0 waits for Controller0 waits for Sensor0"
    assert finding.text == f"{order}: conditions in a circle: {told}"
    assert finding.found == told
    assert finding.path == f"/rts:RtsProfile/rts:{order}/rts:targets[1]"
    assert "Sensor0" in text.splitlines()[finding.line - 1]
    straight = text.replace(targets[2], target("Controller0"))
    assert check(straight).findings == ()


@pytest.mark.parametrize(("bound", "told"), [("4", ERROR), ("5", ERROR), ("6", ""), ("0", "")])
def test_who_waits_less_long_than_others_take_is_told(
    bound: str, told: str, check: Any, text_of: Any
) -> None:
    bounded = target("Motor0", "Controller0").replace(
        "<rts:Preceding>", f'<rts:Preceding rts:timeout="{bound}">'
    )
    targets = [bounded, target("Controller0", "Sensor0"), target("Sensor0")]
    text = text_of(ROBOT).replace(
        "</rts:RtsProfile>",
        f"<rts:Activation>\n{''.join(targets)}</rts:Activation></rts:RtsProfile>",
    )
    findings = check(text).findings
    assert [(f.severity, f.rule) for f in findings] == ([(told, "condition-wait")] if told else [])
    if told:
        assert findings[0].full_text == (
            f"Activation: Motor0 waits at most {bound} ms for Controller0, whose turn comes after"
            " 5 ms; allowed: more than 5, or 0 for no bound"
        )
        assert (
            findings[0].path
            == "/rts:RtsProfile/rts:Activation/rts:targets[1]/rts:Preceding/@rts:timeout"
        )


def test_each_circle_is_told_and_bad_targets_too(check: Any, text_of: Any) -> None:
    targets = (
        target("Sensor0", "Sensor0"),
        target("Motor0", "Controller0"),
        target("Controller0", "Motor0"),
        target("Controller0", "Motor0", context="7"),
        target("Motor0").replace('waitTime="5"', 'waitTime="-5"'),
    )
    text = text_of(ROBOT).replace(
        "</rts:RtsProfile>",
        f"<rts:Activation>\n{''.join(targets)}</rts:Activation></rts:RtsProfile>",
    )
    found = [f for f in check(text).findings if f.rule.startswith("condition-")]
    assert [(f.rule, f.text) for f in found] == [
        ("condition-circle", "Activation: conditions in a circle: Sensor0 waits for Sensor0"),
        (
            "condition-circle",
            "Activation: conditions in a circle: Motor0 waits for Controller0 waits for Motor0",
        ),
        (
            "condition-target",
            "Activation: unknown target: execution context 7 of component Motor0 (it has 0)",
        ),
        ("condition-target", "Activation: waitTime of component Motor0 is negative: -5"),
    ]


def test_a_long_chain_of_conditions_takes_no_ages(check: Any, text_of: Any) -> None:
    count = 2000
    names = [f"S{number}" for number in range(count)]
    head, begin, rest = text_of("console").partition("    <rts:Components")
    whole = begin + rest.partition("</rts:Components>\n")[0] + "</rts:Components>\n"
    components = [whole.replace("ConsoleIn0", name) for name in names]
    ref = 'rts:componentId="RTC:rtkit:example:ConsoleIn:1.0" rts:instanceName="{}" rts:id="0"'
    targets = [
        '<rts:targets rts:sequence="1"><rts:Preceding>'
        f"<rts:PrecedingComponents {ref.format(after)}/></rts:Preceding>"
        f"<rts:TargetComponent {ref.format(name)}/></rts:targets>"
        for name, after in zip(names, [*names[1:], names[0]], strict=True)
    ]
    order = f"<rts:Activation>{''.join(targets)}</rts:Activation>"
    (finding,) = check(f"{head}{''.join(components)}{order}</rts:RtsProfile>").findings
    assert finding.rule == "condition-circle"
    assert finding.text.count(" waits for ") == 20
    assert " waits for S9 waits for … 1981 more … waits for S1991 waits for " in finding.text
    assert finding.text.endswith(" waits for S1999 waits for S0")


def test_more_than_a_host_has_is_an_error_there(check: Any, text_of: Any) -> None:
    limit = '<rtsExt:Properties rtsExt:name="rtkit.limit.memory" rtsExt:value="2G"/>'
    text = text_of(ROBOT).replace(MOTOR_MADE, MOTOR_MADE + limit)
    assert check(text, options=Options(capacity=lambda: Capacity(memory=2 << 30))).is_valid
    (finding,) = check(text, options=Options(capacity=lambda: Capacity(memory=1 << 30))).findings
    assert (finding.severity, finding.rule) == (ERROR, "limits")
    assert finding.text == (
        "rtkit.limit.memory: 2 GiB in all (Motor0 2 GiB), but this host has 1 GiB"
    )


def test_strict_makes_warnings_errors_and_rules_can_be_ignored(check: Any, text_of: Any) -> None:
    text = text_of("console").replace("RTC:rtkit:example:ConsoleIn", "RTC:a:b:ConsoleIn")
    assert check(text).is_valid
    strict = check(text, options=Options(strict=True))
    assert [(f.severity, f.rule) for f in strict.findings] == [(ERROR, "no-profile")]
    assert check(text, options=Options(strict=True, ignored=("no-profile",))).findings == ()


def test_a_composite_shows_ports_of_its_members(check: Any, text_of: Any) -> None:
    text = text_of("my-service")
    composite = (
        '<rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:rtkit:composite:Any:1.0"'
        ' rts:pathUri="localhost/C0.rtc" rts:instanceName="C0" rts:isRequired="true"'
        ' rts:compositeType="PeriodicECShared">'
        '<rts:ServicePorts xsi:type="rtsExt:serviceport_ext"'
        ' rts:name="C0.MyServiceConsumer0.myservice"/>'
        "<rts:Participants><rts:Participant rts:componentId="
        '"RTC:rtkit:example:MyServiceConsumer:1.0" rts:instanceName="MyServiceConsumer0"/>'
        "</rts:Participants></rts:Components>\n"
    )
    end = (
        'rts:componentId="RTC:rtkit:example:MyServiceConsumer:1.0"'
        ' rts:instanceName="MyServiceConsumer0" rts:portName="MyServiceConsumer0.myservice"'
    )
    assert end in text
    through = (
        'rts:componentId="RTC:rtkit:composite:Any:1.0" rts:instanceName="C0"'
        ' rts:portName="C0.MyServiceConsumer0.myservice"'
    )
    text = text.replace("    <rts:ServicePortC", composite + "    <rts:ServicePortC", 1)
    assert check(text.replace(end, through)).findings == ()


def test_what_a_system_says_itself_is_held_against_it(check: Any, text_of: Any) -> None:
    text = text_of(ROBOT).replace("RTC:rtkit:example", "RTC:a:b")
    text = text.replace('rts:name="patience" rts:data="0.5"', 'rts:name="patience" rts:data="y"')
    text = text.replace('rts:dataType="IDL:RTC/TimedDouble:1.0"', 'rts:dataType="TimedLong"')
    found = [f for f in check(text).findings if f.rule != "no-profile"]
    assert [(f.severity, f.rule, f.found) for f in found] == [
        (WARNING, "parameter-type", "y"),
        (WARNING, "data-type", "TimedLong"),
    ]


def test_a_document_that_is_no_system_is_told_of(check: Any, profile_of: Any) -> None:
    checked = check(profile_of("Motor"))
    assert not checked.is_valid
    assert [f.rule for f in checked.findings] == ["wrong-root"]
    assert checked.what == ""


def test_an_interval_that_makes_no_sense_is_an_error() -> None:
    ends = [TargetPort("RTC:M:c:A:1", "A0", each) for each in ("out", "in")]
    wire = DataPortConnector("w", "w", "TimedLong", "corba_cdr", "push", *ends, push_interval=-1.0)
    stated = (ExtensionProperty("dataport.push_interval", "0.5"),)
    catalogue, _ = stocked([], [])
    for each, told in (
        (wire, ["connector w: dataport.push_interval=-1: not a positive number of s"]),
        (replace(wire, push_interval=0.5), []),
        (replace(wire, properties=stated), []),
    ):
        profile = RtsProfile("R:m:s:1", "0.2", "", "", data_port_connectors=(each,))
        found = [f for f in findings(profile, catalogue) if f.rule == "connector-property"]
        assert [f.text for f in found] == told
        assert all(f.severity == ERROR for f in found)


PLACES = [
    ("manager_name=a", "manager_name=b", "ConsoleIn0 in a, ConsoleOut0 in b"),
    ("", "manager_name=b", "ConsoleIn0 in the manager, ConsoleOut0 in b"),
    ("manager_name=a", "manager_name=a", ""),
    ("", "", ""),
]


@pytest.mark.parametrize(("one", "other", "told"), PLACES)
def test_a_direct_connection_needs_one_process(one: str, other: str, told: str) -> None:
    def made(name: str, place: str) -> ComponentInstance:
        create = (ExtensionProperty("rtkit.create", f"{name[:-1]}?{place}".rstrip("?")),)
        return ComponentInstance(f"RTC:M:c:{name[:-1]}:1", "h/x", name, properties=create)

    ends = [TargetPort(f"RTC:M:c:{n}:1", f"{n}0", n) for n in ("ConsoleIn", "ConsoleOut")]
    wire = DataPortConnector("w", "w", "TimedLong", "direct", "push", *ends)
    parts = (made("ConsoleIn0", one), made("ConsoleOut0", other))
    profile = RtsProfile("R:m:s:1", "0.2", "", "", components=parts, data_port_connectors=(wire,))
    catalogue, _ = stocked([], [])
    found = [each.text for each in findings(profile, catalogue) if each.rule == "interface-type"]
    text = f"connector w: interface type direct joins ports of one process: {told}"
    assert found == ([text] if told else [])
