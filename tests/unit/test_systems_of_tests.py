"""Stand-ins in the systems of tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.api.system_profiles import load
from rtkit.errors import NotFound
from rtkit.testing.system import replaced

HEATING = Path(__file__).parents[2] / "examples" / "ci" / "Heating.xml"


def stand_ins(stand_in):
    return {
        each.instance_name: {p.name: p.value for p in each.properties if "stand-in" in p.name}
        for each in replaced(load(HEATING), stand_in).profile.components
    }


def test_components_are_marked_and_transmit_what_was_said():
    assert stand_ins(["Heater0"]) == {
        "Thermometer0": {},
        "Thermostat0": {},
        "Heater0": {"rtkit.stand-in": "yes"},
    }
    values = ({"data": 1.5}, {"data": 2})
    assert stand_ins({"Thermometer0": {"temperature": values}})["Thermometer0"] == {
        "rtkit.stand-in": "yes",
        "rtkit.stand-in.temperature": '[{"data": 1.5}, {"data": 2}]',
    }


def test_the_file_stays_what_errors_name():
    loaded = load(HEATING)
    changed = replaced(loaded, ["Heater0"])
    assert (changed.source, changed.data) == (loaded.source, loaded.data)
    assert changed.profile != loaded.profile


def test_a_component_that_there_is_not_cannot_be_a_stand_in():
    with pytest.raises(NotFound, match=r"no component named heater0 \("):
        replaced(load(HEATING), ["heater0"])
