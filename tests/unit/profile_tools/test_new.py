"""New profiles: what the words of the command line become."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile_tools import new_component as new
from rtkit.profile_tools.new_system import NewMember, in_slaves, new_system

DATE = "2025-01-01T00:00:00"


def made(name: str, *ports: str, activity: str = "PERIODIC") -> RtcProfile:
    """A component with ports written as ``>name:type``, ``<name:type``, ``+name:type``."""
    data = [new.data_port(p[1:], "DataInPort") for p in ports if p[0] == ">"]
    data += [new.data_port(p[1:], "DataOutPort") for p in ports if p[0] == "<"]
    wishes = [new.interface(p[1:], "Provided") for p in ports if p[0] == "+"]
    wishes += [new.interface(p[1:], "Required") for p in ports if p[0] == "-"]
    heading = new.ComponentHeading(name, DATE, activity_type=activity, rate=10.0)
    items = [new.parameter("gain:double=1.0")]
    return new.new_component(heading, data, new.service_ports(wishes), items)


def test_ports() -> None:
    port = new.data_port("pose:TimedPose2D:m", "DataOutPort")
    assert (port.name, port.type, port.unit, port.position) == (
        "pose",
        "RTC::TimedPose2D",
        "m",
        "RIGHT",
    )
    named = new.data_port("scan:Survey::Scan:idl/Survey.idl", "DataOutPort")
    assert (named.type, named.idl_file, named.unit) == ("Survey::Scan", "idl/Survey.idl", None)
    other = new.data_port("in:Img::TimedCameraImage", "DataInPort")
    assert (other.type, other.unit, other.position) == ("Img::TimedCameraImage", None, "LEFT")
    assert new.data_port("x:Mine", "DataInPort").type == "Mine"


@pytest.mark.parametrize("text", ["", "a", "a:", ":T", "a:b:c:d", "a b:T", "a::T"])
def test_what_is_no_port(text: str) -> None:
    with pytest.raises(Malformed):
        new.data_port(text, "DataInPort")
    with pytest.raises(Malformed):
        new.interface(text, "Provided")


def test_interfaces_of_one_port_stand_together() -> None:
    wishes = [
        new.interface("control:Cal::Calibration:Cal.idl", "Provided"),
        new.interface("other:Clock", "Required"),
        new.interface("control:Clock", "Required"),
    ]
    control, other = new.service_ports(wishes)
    told = [(i.name, i.direction, i.type, i.idl_file) for i in control.service_interfaces]
    assert told == [
        ("Calibration", "Provided", "Cal::Calibration", "Cal.idl"),
        ("Clock", "Required", "Clock", None),
    ]
    assert (control.position, other.position) == ("RIGHT", "LEFT")


def test_parameters() -> None:
    item = new.parameter("limit:unsigned int=4;0<=x<=9")
    assert (item.name, item.type, item.default_value) == ("limit", "unsigned int", "4")
    assert item.constraint is not None
    assert format_constraint(item.constraint) == "0<=x<=9"
    text = new.parameter("name:std::string=a=b:c")
    assert (text.type, text.default_value, text.constraint) == ("std::string", "a=b:c", None)
    for wrong in ("a", "a:int", "a=1", ":int=1", "a:int=1;0<=y"):
        with pytest.raises(Malformed):
            new.parameter(wrong)


def test_components() -> None:
    profile = made("Range", "<distance:TimedDouble")
    assert profile.id == "RTC:Me:Misc:Range:1.0.0"
    assert profile.basic_info is not None
    assert profile.basic_info.execution_type == "PeriodicExecutionContext"
    assert profile.actions is not None
    assert profile.actions.on_action is None
    assert profile.actions.on_execute is not None
    heading = new.ComponentHeading("Range", DATE)
    with pytest.raises(Malformed, match="port a is named twice"):
        made("Range", ">a:TimedLong", "+a:Clock")
    with pytest.raises(Malformed, match="a vendor with a colon would break the id"):
        new.new_component(heading._replace(vendor="a:b"))
    with pytest.raises(Malformed, match="'1x' cannot be the name of a class"):
        new.new_component(heading._replace(name="1x"))
    with pytest.raises(Malformed, match="no such callback: OnExecute; there are onInitialize,"):
        new.new_component(heading, callbacks=["OnExecute"])


RANGE = made("Range", "<distance:TimedDouble", ">trigger:TimedBoolean", "+clock:Clock")
MOTOR = made("Motor", ">range:RTC::TimedDouble", ">any:any", "-time:Clock", activity="SPORADIC")
MEMBERS = (NewMember(RANGE, "Range0"), NewMember(MOTOR, "Motor0"))


def test_systems() -> None:
    wires = (
        "Motor0.range=Range0.distance",
        "Range0.distance=Motor0.any",
        "Motor0.time=Range0.clock",
    )
    profile = new_system("Robot", DATE, MEMBERS, wires, vendor="V", host="arm", abstract="It moves")
    assert profile.id == "RTSystem:V:Robot:1.0.0"
    one, other = profile.components
    assert (one.path_uri, one.active_configuration_set) == ("arm/Range0.rtc", "default")
    assert [(s.id, s.data[0].name, s.data[0].data) for s in one.configuration_sets] == [
        ("default", "gain", "1.0")
    ]
    assert [(c.kind, c.rate) for c in one.execution_contexts] == [("PERIODIC", 10.0)]
    assert [(c.kind, c.rate) for c in other.execution_contexts] == [("EVENT_DRIVEN", None)]
    distance = next(port for port in one.data_ports if port.name == "Range0.distance")
    assert distance.properties == (
        ExtensionProperty("dataport.data_type", "IDL:RTC/TimedDouble:1.0"),
        ExtensionProperty("port.port_type", "DataOutPort"),
    )
    assert one.location is not None
    assert other.location is not None
    assert one.location.x < other.location.x
    ends = [(c.source.port_name, c.target.port_name) for c in profile.data_port_connectors]
    assert ends == [("Range0.distance", "Motor0.range"), ("Range0.distance", "Motor0.any")]
    assert {c.data_type for c in profile.data_port_connectors} == {"IDL:RTC/TimedDouble:1.0"}
    (service,) = profile.service_port_connectors
    assert (service.connector_id, service.source.port_name) == ("3", "Motor0.time")


@pytest.mark.parametrize(
    ("wire", "error", "told"),
    [
        ("Range0.distance", Malformed, "a connection is INSTANCE.PORT=INSTANCE.PORT"),
        ("a=b=c", Malformed, "a connection is INSTANCE.PORT=INSTANCE.PORT"),
        ("Nix.a=Range0.distance", NotFound, "no such component: Nix.a; there are: Range0, Motor0"),
        (
            "Range0.nix=Motor0.any",
            NotFound,
            "no such port: Range0.nix; Range0 has: trigger, distance",
        ),
        ("Motor0.any=Range0.trigger", Refused, "cannot be connected: DataInPort and DataInPort"),
        ("Range0.clock=Motor0.any", Refused, "one is a data port, one a service port"),
        ("Range0.clock=Range0.clock", Refused, "neither provides what the other requires"),
    ],
)
def test_what_cannot_be_connected(wire: str, error: type[Exception], told: str) -> None:
    with pytest.raises(error, match=told):
        new_system("Robot", DATE, MEMBERS, [wire])


def test_components_in_slaves() -> None:
    members = in_slaves(MEMBERS, ["Motor0=drive=1"])
    one, other = new_system("Robot", DATE, members).components
    assert one.properties == ()
    assert other.properties == (ExtensionProperty("rtkit.create", "Motor?manager_name=drive%3D1"),)
    with pytest.raises(NotFound, match=r"no such component: Moter0 \(did you mean Motor0\?\)"):
        in_slaves(MEMBERS, ["Moter0=drive"])
    for text in ("Motor0", "Motor0=", "=drive"):
        with pytest.raises(Malformed, match=f"a component in a slave is INSTANCE=SLAVE: {text}"):
            in_slaves(MEMBERS, [text])
    with pytest.raises(Malformed, match="named twice"):
        new_system("a", DATE, in_slaves([MEMBERS[0]] * 2, ["Range0=s"]))


def test_types_have_to_be_the_same() -> None:
    other = NewMember(made("Other", ">in:TimedLong"), "Other0")
    with pytest.raises(Refused, match=r"IDL:RTC/TimedDouble:1\.0 and IDL:RTC/TimedLong:1\.0"):
        new_system("R", DATE, [*MEMBERS, other], ["Range0.distance=Other0.in"])


def test_names_of_systems() -> None:
    for name in ("", " ", "a/b", "a:b"):
        with pytest.raises(Malformed):
            new_system(name, DATE)
    with pytest.raises(Malformed, match="component Range0 is named twice"):
        new_system("a", DATE, [MEMBERS[0], MEMBERS[0]])
