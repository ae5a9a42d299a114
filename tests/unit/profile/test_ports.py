from __future__ import annotations

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.ports import DataPortFacts, DataPortKey, data_port_facts
from rtkit.profile.rts_model import (
    ComponentInstance,
    DataPortConnector,
    InstancePort,
    RtsProfile,
    TargetPort,
)
from rtkit.rtc.enums import PortType

DATE = "2024-01-01T00:00:00"


def port(name: str, **properties: str) -> InstancePort:
    return InstancePort(
        name,
        properties=tuple(
            ExtensionProperty(key.replace("__", "."), text) for key, text in properties.items()
        ),
    )


def system(*ports: InstancePort, data_type: str = "RTC::TimedLong") -> RtsProfile:
    component = ComponentInstance("i", "h/A0.rtc", "A0", data_ports=ports)
    connector = DataPortConnector(
        "c", "n", data_type, "", "", TargetPort("i", "A0", "A0.out"), TargetPort("i", "A0", "in")
    )
    return RtsProfile(
        "s", "0.2", DATE, DATE, components=(component,), data_port_connectors=(connector,)
    )


def test_the_connector_tells_what_the_ports_do_not() -> None:
    facts = data_port_facts(system(port("out"), port("A0.in"), port("idle")))
    assert facts == {
        DataPortKey("i", "A0", "out"): DataPortFacts(PortType.OUT, "IDL:RTC/TimedLong:1.0"),
        DataPortKey("i", "A0", "in"): DataPortFacts(PortType.IN, "IDL:RTC/TimedLong:1.0"),
        DataPortKey("i", "A0", "idle"): DataPortFacts(None, ""),
    }


def test_the_ports_own_word_comes_first() -> None:
    own = {"port__port_type": "dataInPort", "dataport__data_type": "TimedDouble"}
    facts = data_port_facts(system(port("out", **own)))
    assert facts == {
        DataPortKey("i", "A0", "out"): DataPortFacts(PortType.IN, "IDL:RTC/TimedDouble:1.0")
    }


def test_any_is_no_type() -> None:
    facts = data_port_facts(system(port("out", dataport__data_type="Any"), data_type="Any"))
    assert facts[DataPortKey("i", "A0", "out")].data_type == ""
