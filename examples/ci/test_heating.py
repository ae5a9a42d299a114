POWER = "/localhost/Thermostat0.rtc:power"
DRIVERS = {"Thermometer0": {"temperature": [{"data": 20.0}]}, "Heater0": {}}


def test_heats_as_much_as_is_missing(rtsystem):
    system = rtsystem("Heating.xml", stand_in=DRIVERS)
    assert system.read(POWER, timeout_s=10.0).data == 0.5


def test_does_not_heat_what_is_warm_enough(rtsystem):
    system = rtsystem("Heating.xml", stand_in=DRIVERS)
    system.configure("/localhost/Thermostat0.rtc", target=18.0)
    system.wait("/localhost/Heater0.rtc", state="active", timeout_s=10.0)
    assert any(each.value.data == 0.0 for each in system.values(POWER, timeout_s=10.0))
