"""Properties of a component: who outranks whom, and from which files they come."""

from __future__ import annotations

import os
from dataclasses import replace

import pytest

from rtkit.component.composite import PeriodicECSharedComposite
from rtkit.container.process_settings import layered
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.create import parse_create
from rtkit.rtc.profiles import TypeProfile
from rtkit.settings.configuration import (
    CommandLineSettings,
    name,
    read,
    tcp_endpoint_settings,
    wanted_from_text,
)
from rtkit.settings.properties import Settings
from rtkit.settings.reading import read_private

ARM = TypeProfile("Arm", category="Robot")


@pytest.fixture(autouse=True)
def _no_settings(monkeypatch, tmp_path):
    for key in ("RTC_MANAGER_CONFIG", "RTKIT_PORT", "RTKIT_MANAGER"):
        monkeypatch.delenv(key, raising=False)
    monkeypatch.chdir(tmp_path)


def write(path, text):
    path.write_text(text)
    path.chmod(0o644)
    return str(path)


def test_the_strongest_wins(tmp_path):
    message = {
        "inherited": {"a": "manager", "b": "manager", "c": "manager", "d": "manager"},
        "config_files": {
            "Robot.Arm": write(tmp_path / "type.conf", "b: type\nc: type\nd: type\n"),
            "Robot.Arm0": write(tmp_path / "instance.conf", "c: instance\nd: instance\n"),
            "Other.Arm": str(tmp_path / "absent"),
        },
        "given": {"Robot.Arm": {"c": "given", "e": "given"}, "Robot.Arm0": {"f": "given"}},
    }
    create = parse_create("Arm?instance_name=Arm0&d=string")
    made = layered(create, ARM, message)
    assert made.options == {
        "a": "manager",
        "b": "type",
        "c": "instance",
        "d": "string",
        "e": "given",
        "f": "given",
        "instance_name": "Arm0",
    }
    assert "a" not in layered(create, ARM, message, inherits=False).options
    assert layered(create, ARM, {}) is create


def test_a_composite_has_the_category_of_openrtm_too(tmp_path):
    category = "composite.PeriodicECShared"
    file = write(tmp_path / "composite.conf", "conf.default.members: A, B")
    message = {"config_files": {f"{category}.Both0": file}}
    create = parse_create("PeriodicECSharedComposite?instance_name=Both0")
    for type in (PeriodicECSharedComposite.type_profile(), replace(ARM, category=category)):
        assert layered(create, type, message).options["conf.default.members"] == "A, B"
    assert layered(create, ARM, message) is create


def test_the_file_that_a_create_string_names(tmp_path):
    file = write(tmp_path / "own.conf", "conf.default.speed: 3")
    create = parse_create(f"Arm?instance_name=A&config_file={file}")
    assert layered(create, ARM, {}).options["conf.default.speed"] == "3"


@pytest.mark.parametrize(("text", "error"), [(None, NotFound), ("nonsense", Malformed)])
def test_a_file_that_cannot_be_read(tmp_path, text, error):
    if text is not None:
        write(tmp_path / "x.conf", text)
    message = {"config_files": {"Robot.Arm": str(tmp_path / "x.conf")}}
    with pytest.raises(error, match=r"x\.conf"):
        layered(parse_create("Arm?instance_name=A"), ARM, message)


# what a manager is started with


def test_without_a_file_there_are_only_overrides():
    found = read(CommandLineSettings(overrides=("naming.formats:x/%n.rtc", "mine:1")))
    assert found.settings.text("naming.formats") == "x/%n.rtc"
    assert found.file == ""
    assert found.warnings == ("unknown property: mine",)


def test_the_file_of_the_folder_is_found_and_outranked(tmp_path):
    path = write(tmp_path / "rtc.conf", "naming.enable: NO\nlogger.log_level: ERROR\nx.y: 1\n")
    found = read(CommandLineSettings(overrides=("logger.log_level:WARN",)))
    assert found.file == path
    assert found.warnings == (f"{path}:3: unknown property: x.y",)
    assert not found.settings.flag("naming.enable")
    assert found.settings.text("logger.log_level") == "WARN"


def test_the_file_that_is_named_outranks_that_of_the_environment(tmp_path, monkeypatch):
    write(tmp_path / "rtc.conf", "manager.name: folder")
    write(tmp_path / "env.conf", "manager.name: environment")
    write(tmp_path / "line.conf", "manager.name: line")
    monkeypatch.setenv("RTC_MANAGER_CONFIG", "env.conf")
    assert read(CommandLineSettings()).settings.text("manager.name") == "environment"
    assert read(CommandLineSettings("line.conf")).settings.text("manager.name") == "line"


def test_a_named_file_has_to_be_there(tmp_path, monkeypatch):
    write(tmp_path / "rtc.conf", "manager.name: folder")
    for wanted in (CommandLineSettings("absent"), CommandLineSettings()):
        with pytest.raises(NotFound, match=r"no such configuration file: .*absent"):
            read(wanted)
        monkeypatch.setenv("RTC_MANAGER_CONFIG", "absent")
    assert read(CommandLineSettings("absent", may_lack_file=True)).file == ""
    assert read(CommandLineSettings(may_lack_file=True)).file == ""


def test_files_that_strangers_can_have_written(tmp_path):
    path = tmp_path / "rtc.conf"
    write(path, "manager.name: x")
    path.chmod(0o646)
    with pytest.raises(Refused, match="written by everybody"):
        read(CommandLineSettings())
    path.chmod(0o644)
    tmp_path.chmod(0o777)
    with pytest.raises(Refused, match="written by everybody"):
        read(CommandLineSettings())
    tmp_path.chmod(0o700)
    if os.getuid() == 0:
        os.chown(path, 65534, 65534)
        with pytest.raises(Refused, match="another user"):
            read(CommandLineSettings())


def test_what_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in ("pipe", "."):
        with pytest.raises(Refused, match=r"not a file|cannot open"):
            read_private(path)
    with pytest.raises(Refused):
        read_private("a\0b")


def test_wishes_travel_as_text():
    wanted = CommandLineSettings("a b", ("x:1", "y:ü"), True)
    assert wanted_from_text(wanted.to_text()) == wanted


@pytest.mark.parametrize(
    ("given", "usual", "port", "is_asked"),
    [
        ({}, "", 2810, False),
        ({}, "none", None, True),
        ({}, "2900", 2900, True),
        ({"net.endpoints": "all"}, "2900", 2810, False),
        ({"corba.endpoints": ":0"}, "none", 0, True),
        ({"net.endpoints": "none"}, "2900", None, True),
        ({"manager.corba_servant": "NO", "net.endpoints": ":5"}, "", None, True),
    ],
)
def test_where_the_door_is(monkeypatch, given, usual, port, is_asked):
    monkeypatch.setenv("RTKIT_PORT", usual)
    assert tcp_endpoint_settings(Settings(given)) == (port, is_asked)


def test_a_door_of_the_environment_that_cannot_be_read(monkeypatch):
    monkeypatch.setenv("RTKIT_PORT", "x")
    with pytest.raises(Malformed, match="RTKIT_PORT: not"):
        tcp_endpoint_settings(Settings())


def test_what_a_manager_is_called(monkeypatch):
    settings = Settings({"manager.name": "id", "manager.instance_name": "tree"})
    assert name("typed", settings) == "typed"
    assert name("", settings) == "tree"
    assert name("", Settings({"manager.name": "id"})) == "id"
    assert name("", Settings()) == "manager"
    monkeypatch.setenv("RTKIT_MANAGER", "env")
    assert name("", settings) == "env"
