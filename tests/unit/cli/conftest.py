"""A small world and a way to type commands at it."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import NamedTuple

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.cli.shared.commands import load
from rtkit.deployment import actions as act
from rtkit.rtc.enums import LifeCycleState, Polarity, PortType
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import DEFINITION, PortInterfaceProfile, PortProfile, TypeProfile

LONG = {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}
TEXT = {"dataport.data_type": "IDL:RTC/TimedString:1.0"}
PUSH_ONLY = {**LONG, "dataport.dataflow_type": "push", "dataport.subscription_type": "new,flush"}


class Outcome(NamedTuple):
    """What a command line came to."""

    status: int
    out: str
    err: str


def _service(name: str, interface: str, polarity: Polarity) -> PortProfile:
    offered = PortInterfaceProfile("acc", interface, polarity)
    definition = f"interface {interface} {{\n    long {interface.lower()}(in long a);\n  }};"
    properties = {"port.port_type": "CorbaPort", DEFINITION: definition}
    return PortProfile(name, PortType.SERVICE, properties, (offered,))


def _types() -> list[ComponentPattern]:
    return [
        ComponentPattern(
            TypeProfile("Std", "Me", "test", "1.0", "A standard component"),
            (PortProfile("in", PortType.IN, LONG), PortProfile("out", PortType.OUT, LONG)),
            {
                "default": {"param": "0"},
                "set1": {"param": "1"},
                "set2": {"param": "2"},
                "__hidden__": {"param": "3"},
            },
        ),
        ComponentPattern(
            TypeProfile("Output", "Me", "test", "1.0"),
            (PortProfile("out", PortType.OUT, PUSH_ONLY),),
        ),
        ComponentPattern(
            TypeProfile("Input", "Me", "test", "1.0"),
            (PortProfile("in", PortType.IN, PUSH_ONLY),),
            contexts=(ContextPattern("0"), ContextPattern("slow", rate=10.0)),
        ),
        ComponentPattern(
            TypeProfile("Text", "Me", "test", "1.0"), (PortProfile("in", PortType.IN, TEXT),)
        ),
        ComponentPattern(
            TypeProfile("Adder", "Me", "test", "1.0"),
            (_service("offer", "Add", Polarity.PROVIDED),),
        ),
        ComponentPattern(
            TypeProfile("User", "Me", "test", "1.0"),
            (
                _service("need", "Add", Polarity.REQUIRED),
                _service("also", "Add", Polarity.PROVIDED),
                _service("other", "Subtract", Polarity.REQUIRED),
            ),
        ),
    ]


def make_world() -> FakeManager:
    """Return a world with components in the manager, in slaves, in a directory, and a zombie."""
    types = _types()
    world = FakeManager(types, modules={"/mods/a.py": types[:1], "b.py": types[1:2]})
    for create, name in (
        ("Std?instance_name=Std0", ""),
        ("Output?instance_name=Output0", "localhost/local.host_cxt/Output0.rtc"),
        ("Input?instance_name=Input0&manager_name=slave1", ""),
        ("Text?instance_name=Text0", ""),
        ("Adder?instance_name=Adder0", ""),
        ("User?instance_name=User0", ""),
        ("Std?instance_name=Zombie0&manager_name=slave2", ""),
        ("Std?instance_name=Err0", ""),
    ):
        world.perform(act.Create(create, (name,) if name else ()))
    world.kill("slave2")
    world.set_state("Err0", LifeCycleState.ERROR, "ValueError: no such speed (robot.py:12)")
    world.performed.clear()
    return world


@pytest.fixture
def world() -> FakeManager:
    return make_world()


@pytest.fixture(autouse=True)
def plain_environment(
    monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Nothing that a user may have set, or has running, changes what is printed."""
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(name, str(tmp_path_factory.mktemp(name)))
    for name in (
        "RTKIT_CWD",
        "RTCSH_CWD",
        "RTKIT_MANAGER",
        "RTKIT_EXIT_DETAIL",
        "FORCE_COLOR",
        "NO_COLOR",
    ):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("SHELL", "/bin/bash")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture
def run(
    world: FakeManager, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[[str], Outcome]:
    """Return what types a line as a shell takes it: ``NAME=VALUE command … && command …``."""

    def type_one(line: str) -> int:
        words = shlex.split(line)
        with monkeypatch.context() as patch:
            while "=" in words[0]:
                patch.setenv(*words.pop(0).split("=", 1))
            status: int = load(words[0])(words[1:], tree=fake_tree(world))
        return status

    def typed(line: str) -> Outcome:
        status = next(filter(None, map(type_one, line.split(" && "))), 0)
        captured = capsys.readouterr()
        return Outcome(status, captured.out, captured.err)

    return typed
