"""The rule of ports."""

from itertools import product

import pytest

from rtkit.rtc.data_types import is_same_type
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.port_types import (
    are_reversed,
    declared_port_type,
    interfaces_fit,
    stated_port_type,
    types_fit,
)
from rtkit.rtc.profiles import PortInterfaceProfile

IN, OUT, SERVICE = PortType.IN, PortType.OUT, PortType.SERVICE


def test_data_goes_from_out_to_in_and_services_to_services():
    fitting = {pair for pair in product(PortType, repeat=2) if types_fit(pair)}
    assert fitting == {(OUT, IN), (IN, OUT), (SERVICE, SERVICE)}
    assert [pair for pair in product(PortType, repeat=2) if are_reversed(pair)] == [(IN, OUT)]


@pytest.mark.parametrize(
    ("text", "told"), [("DataInPort", IN), (" out ", OUT), ("CorbaPort", None), ("", None)]
)
def test_a_system_profile_states_the_type_of_a_data_port(text, told):
    assert stated_port_type(text) is told


def test_an_event_port_of_a_component_profile_is_an_in_port():
    assert list(map(declared_port_type, ("DataOutPort", "DataInPort", "EventPort"))) == [
        OUT,
        IN,
        IN,
    ]


def test_a_service_goes_to_who_requires_it_and_is_compared_as_told():
    provider = (PortInterfaceProfile("a", "M::Add", Polarity.PROVIDED),)
    user, short = (
        (PortInterfaceProfile("b", name, Polarity.REQUIRED),) for name in ("M::Add", "Add")
    )
    assert interfaces_fit(provider, user)
    assert interfaces_fit(user, provider)
    assert not interfaces_fit(provider, provider)
    assert not interfaces_fit(provider, short)
    assert interfaces_fit(provider, short, is_same_type)
    assert interfaces_fit(provider, ())
