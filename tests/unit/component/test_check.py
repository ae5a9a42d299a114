"""May these ports be connected?"""

from __future__ import annotations

import pytest

from rtkit.component.ports.port_matching import refusal
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.profiles import PortInterfaceProfile, PortProfile


def data(kind, data_type="IDL:RTC/TimedLong:1.0", **properties):
    keys = {f"dataport.{key}": value for key, value in properties.items()}
    return PortProfile(kind.name.lower(), kind, {"dataport.data_type": data_type, **keys})


def service(*interfaces):
    return PortProfile(
        "s",
        PortType.SERVICE,
        {},
        tuple(PortInterfaceProfile("i", name, Polarity(pole)) for name, pole in interfaces),
    )


IN, OUT = data(PortType.IN), data(PortType.OUT)


@pytest.mark.parametrize(
    ("ports", "properties", "message"),
    [
        ((OUT, IN), {}, ""),
        ((IN, OUT), {}, ""),
        ((IN, OUT, IN), {}, ""),
        ((IN, IN), {}, "Wrong port type."),
        ((OUT, OUT), {}, "Wrong port type."),
        ((OUT, service()), {}, "Wrong port type."),
        ((service(), service()), {}, ""),
        ((service(("A", "Provided")), service()), {}, ""),
        ((service(("A", "Provided")), service(("A", "Required"))), {}, ""),
        (
            (service(("A", "Provided")), service(("B", "Required"))),
            {},
            "Interfaces do not match.",
        ),
        (
            (service(("A", "Provided")), service(("A", "Provided"))),
            {},
            "Polarities do not match.",
        ),
        ((OUT, data(PortType.IN, "RTC::TimedLong")), {}, ""),
        ((OUT, data(PortType.IN, "TimedLong")), {}, ""),
        ((OUT, data(PortType.IN, "")), {}, ""),
        ((OUT, data(PortType.IN, "Any")), {}, ""),
    ],
)
def test_answers(ports, properties, message):
    assert refusal(ports, properties) == message


def test_types_that_differ_are_both_named():
    text = refusal((OUT, data(PortType.IN, "IDL:RTC/TimedDouble:1.0")), {})
    assert "IDL:RTC/TimedLong:1.0" in text
    assert "IDL:RTC/TimedDouble:1.0" in text
    assert refusal((OUT, data(PortType.IN, "IDL:Mine/TimedLong:1.0")), {})
    assert "RTC::TimedShort" in refusal((OUT, IN), {"dataport.data_type": "RTC::TimedShort"})


@pytest.mark.parametrize(
    ("offered", "wanted", "fits"),
    [
        ("zenoh,direct", "direct", True),
        ("zenoh,direct", "DIRECT", True),
        ("zenoh", "corba_cdr", True),
        ("corba_cdr, data_service", "zenoh", True),
        ("Any", "csp_channel", True),
        ("zenoh", "csp_channel", False),
    ],
)
def test_interface_types(offered, wanted, fits):
    ports = (data(PortType.OUT, interface_type=offered), data(PortType.IN, interface_type=offered))
    text = refusal(ports, {"dataport.interface_type": wanted})
    what = f"(dataport.interface_type is {wanted}; out offers {offered})"
    assert text == ("" if fits else f"Incompatible connection properties. {what}")


def test_a_property_that_one_port_does_not_advertise_is_not_checked():
    ports = (data(PortType.OUT, subscription_type="flush"), IN)
    assert refusal(ports, {"dataport.subscription_type": "periodic"}) == ""
    ports = (ports[0], data(PortType.IN, subscription_type="flush,new"))
    assert refusal(ports, {"dataport.subscription_type": "new"}).startswith("Incompatible")
