"""Properties of a manager: old names, kinds of values, what may be changed when."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.settings import properties
from rtkit.settings.properties import Settings


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("corba.nameservers", "net.nameservers"),
        ("corba.endpoints", "net.endpoints"),
        ("corba.endpoint", "net.endpoints"),
        ("manager.corba_servant", "manager.net_servant"),
        ("naming.formats", "naming.formats"),
        ("corbana", "corbana"),
    ],
)
def test_old_names(key, name):
    assert properties.canonical(key) == name


def test_every_default_is_of_its_kind():
    for known in properties.KNOWN.values():
        assert properties.check(known.key, known.default) == known.default, known
        assert known.kind in ("text", "list", "number", "boolean", "level"), known


@pytest.mark.parametrize(
    "key",
    [
        "manager.modules.C++.load_paths",
        "manager.modules.Java.profile_cmd",
        "ec.PeriodicExecutionContext.rate",
        "ec.slow.a.b",
        "port.inport.dataport.buffer.length",
        "Sensors.Robot0.config_file",
        "composite.PeriodicECShared.Both0.config_file",
        "composite.PeriodicECShared.Both0.conf.default.members",
        "Sensors.Robot0.exec_cxt.periodic.rate",
        "corba.args",
        "logger.logstream.fluentd.output0.tag",
    ],
)
def test_keys_of_a_pattern_are_known(key):
    assert properties.find(key) is not None


@pytest.mark.parametrize(
    "key",
    ["port", "ec", "a.b", "x.config_file", "..config_file", "a.conf.b", "a..conf.b", "net.x", ""],
)
def test_others_are_not(key):
    assert properties.find(key) is None


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("naming.format", "naming.formats"),
        ("corba.endpoits", "corba.endpoints"),
        ("manager.component.precreate", "manager.components.precreate"),
        ("exec_cxt.periodic_rate", "exec_cxt.periodic.rate"),
        ("zzz", ""),
    ],
)
def test_an_unknown_key_is_told_with_the_nearest(key, hint):
    told = properties.unknown(key)
    assert told == f"unknown property: {key}" + (f" (did you mean {hint}?)" if hint else "")


@pytest.mark.parametrize(
    ("key", "value", "kept"),
    [
        ("naming.enable", " yes ", "YES"),
        ("naming.enable", "true", "YES"),
        ("naming.enable", "0", "NO"),
        ("exec_cxt.periodic.rate", "1e3", "1e3"),
        ("logger.log_level", "debug", "DEBUG"),
        ("manager.cpu_affinity", "0, 2-3", "0, 2-3"),
        ("net.endpoints", ":0", ":0"),
        ("corba.endpoints", "none", "none"),
        ("manager.components.precreate", "", ""),
    ],
)
def test_values_that_are_taken(key, value, kept):
    assert properties.check(key, value) == kept


@pytest.mark.parametrize(
    ("key", "value", "error", "why"),
    [
        ("naming.enable", "maybe", Malformed, "naming.enable: neither YES nor NO: maybe"),
        ("exec_cxt.periodic.rate", "fast", Malformed, "not a number"),
        ("exec_cxt.periodic.rate", "0", Malformed, "above 0"),
        ("timer.tick", "nan", Malformed, "not a number"),
        ("timer.tick", "inf", Malformed, "not a number"),
        ("timer.tick", "-1", Malformed, "not a number"),
        ("logger.log_level", "LOUD", Malformed, "no log level"),
        ("manager.cpu_affinity", "0,x", Malformed, "processors"),
        ("manager.cpu_affinity", "3-1", Malformed, "processors"),
        ("manager.cpu_affinity", "999999999", Malformed, "processors"),
        ("net.endpoints", "here", Malformed, "net.endpoints: not"),
        ("corba.endpoints", ":99999", Malformed, "corba.endpoints: not"),
        ("net.endpoints", "0.0.0.0:2810", Refused, "TLS"),
        ("naming.formats", "%n.rtc,%x.rtc", Malformed, "unknown %x"),
        ("naming.formats", "../%n.rtc", Malformed, "dotted"),
        ("manager.modules.preload", "a (b", Malformed, "InitFunc"),
        ("manager.name", "a\x1b", Malformed, "control"),
    ],
)
def test_values_that_are_not(key, value, error, why):
    with pytest.raises(error, match=why):
        properties.check(key, value)


def test_given_values_lie_over_defaults():
    settings = Settings({"corba.endpoints": ":2811", "naming.formats": "a/%n.rtc,%n.rtc"})
    assert settings.text("net.endpoints") == ":2811"
    assert settings.items("naming.formats") == ("a/%n.rtc", "%n.rtc")
    assert settings.flag("naming.enable")
    assert settings.number("exec_cxt.periodic.rate") == 1000
    assert settings.is_given("net.endpoints")
    assert not settings.is_given("exec_cxt.periodic.rate")
    assert settings.below("naming.") == {"naming.formats": "a/%n.rtc,%n.rtc"}
    assert settings.lookup("corba.endpoints") == settings.lookup("net.endpoints") == ":2811"
    assert settings.lookup("corba.nameservers") == "localhost"
    assert settings.lookup("nonsense") is None


def test_the_table_shows_each_property_once_under_the_name_given():
    settings = Settings({"corba.endpoints": ":2811", "of.my.own": "1"})
    table = settings.table()
    assert table["corba.endpoints"] == ":2811"
    assert "net.endpoints" not in table
    assert table["net.nameservers"] == "localhost"
    assert table["of.my.own"] == "1"
    assert len(table) == len(properties.KNOWN) + 1
    settings.take("net.endpoints", "none")
    assert settings.table()["net.endpoints"] == "none"


@pytest.mark.parametrize(
    ("key", "error", "why"),
    [
        ("openrtm.version", Refused, "read-only property: openrtm.version"),
        ("corba.endpoints", Refused, "takes effect only at start"),
        ("naming.format", NotFound, "did you mean naming.formats"),
    ],
)
def test_what_cannot_be_changed_while_it_runs(key, error, why):
    settings = Settings()
    before = settings.table()
    with pytest.raises(error, match=why):
        settings.change(key, "1")
    assert settings.table() == before


def test_what_can():
    settings = Settings()
    settings.change("logger.log_level", "debug")
    settings.change("port.inport.dataport.buffer.length", "4")
    assert settings.text("logger.log_level") == "DEBUG"
    assert settings.below("port.") == {"port.inport.dataport.buffer.length": "4"}


def test_what_is_given_for_components_is_kept_by_their_names():
    settings = properties.Settings({
        "Sensors.Robot0.conf.default.speed": "3",
        "composite.PeriodicECShared.Both0.exec_cxt.periodic.rate": "5",
        "exec_cxt.periodic.rate": "10",
        "Sensors.Robot0.config_file": "a.conf",
    })  # fmt: skip
    assert settings.of_components() == {
        "Sensors.Robot0": {"conf.default.speed": "3"},
        "composite.PeriodicECShared.Both0": {"exec_cxt.periodic.rate": "5"},
    }
