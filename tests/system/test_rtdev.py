"""A live system follows its sources while they are written."""

from __future__ import annotations

import os
import select
import signal
import time
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from waiting import facts_of

from rtkit.tree.client import Tree

KEEPS_MANAGER = True

MODULE = '''
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong
from helper import FACTOR


class Scale(Component):
    """Scales what comes."""

    in_ = InPort(TimedLong, "in")
    out = OutPort(TimedLong)
    factor = Parameter(2)
    rate = 100.0


def ScaleInit(manager):
    manager.register_factory(Scale)
'''
PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:dev:1" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00"
    rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
{components}{connector}</rts:RtsProfile>
"""
COMPONENT = """<rts:Components rts:id="RTC:::Scale:" rts:instanceName="{name}" rts:isRequired="true"
    rts:pathUri="localhost/{name}.rtc" xsi:type="rtsExt:component_ext" rts:compositeType="None"
    rts:activeConfigurationSet="default">
  <rts:ConfigurationSets rts:id="default">
    <rts:ConfigurationData rts:name="factor" rts:data="{factor}"/>
  </rts:ConfigurationSets>
  <rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="100.0"
      xsi:type="rtsExt:execution_context_ext"/>
  <rtsExt:Properties rtsExt:name="rtkit.create"
      rtsExt:value="Scale?instance_name={name}&amp;manager_name={name}s"/>
</rts:Components>
"""
CONNECTOR = """<rts:DataPortConnectors rts:connectorId="w" rts:name="w" rts:dataType="TimedLong"
    rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush">
  <rts:sourceDataPort rts:componentId="RTC:::Scale:" rts:instanceName="A" rts:portName="A.out"/>
  <rts:targetDataPort rts:componentId="RTC:::Scale:" rts:instanceName="B" rts:portName="B.in"/>
</rts:DataPortConnectors>
"""


class Development:
    """A run of rtdev on a profile of two components."""

    def __init__(self, shell: Any, options: str = "") -> None:
        self.folder: Path = shell.modules
        self.save("helper.py", "FACTOR = 1\n")
        self.save("Scale.py", MODULE)
        self.profile()
        self.process = shell.open(f"rtdev {options} {self.folder}/dev.xml")
        self.begun = self.until("Ctrl-C ends that")

    def save(self, name: str, text: str) -> None:
        """Save a file as many editors do: another one takes its place."""
        draft = self.folder / f"{name}.new"
        draft.write_text(text)
        draft.replace(self.folder / name)

    def profile(self, names: str = "AB", factor: int = 2, connector: str = CONNECTOR) -> None:
        components = "".join(COMPONENT.format(name=each, factor=factor) for each in names)
        self.save("dev.xml", PROFILE.format(components=components, connector=connector))

    def until(self, *marks: str) -> str:
        """Return all that is told until one of these is."""
        told, deadline = "", time.monotonic() + 40.0
        sources = [self.process.stdout.fileno(), self.process.stderr.fileno()]
        while not any(mark in told for mark in marks):
            ready = select.select(sources, [], [], max(0.0, deadline - time.monotonic()))[0]
            assert ready, told
            for each in ready:
                piece = os.read(each, 65536).decode()
                assert piece, told
                told += piece
        return told

    def next(self) -> str:
        return self.until("] done", "nothing to do", "stays as it was")

    def rest(self) -> str:
        """Return what was told on stderr meanwhile: it is another stream."""
        stderr = self.process.stderr.fileno()
        is_there = select.select([stderr], [], [], 0.0)[0]
        return os.read(stderr, 65536).decode() if is_there else ""

    def end(self) -> None:
        self.process.send_signal(signal.SIGINT)
        _, err = self.process.communicate(timeout=20.0)
        assert (self.process.returncode, "the system runs on" in err) == (0, True)


@pytest.fixture
def development(manager: Any, request: pytest.FixtureRequest) -> Any:
    development = Development(manager, getattr(request, "param", ""))
    yield development
    if development.process.poll() is None:
        development.end()
    manager.run(f"rtteardown --exit {development.folder}/dev.xml")
    for name in ("helper.py", "Scale.py", "dev.xml"):
        (development.folder / name).unlink()


def test_what_is_saved_becomes_the_smallest_plan(
    development: Development, tree: Tree, manager: Any
) -> None:
    development.profile(factor=5)
    told = development.next()
    assert [f"set {name}.factor=5" in told for name in "AB"] == [True, True]
    assert "create" not in told
    development.save("helper.py", "FACTOR = 2\n")
    told = development.next()
    assert "replace: its code has changed since it was loaded" in told
    assert "connect A.out to B.in" in told
    facts = facts_of(tree, "A")
    assert (facts.state, facts.sets["default"]["factor"]) == ("Active", "5")
    assert len(tree.snapshot().connectors) == 1
    development.profile("AB", 5, connector="")
    assert "disconnect A.out to B.in" in development.next()
    assert tree.snapshot().connectors == ()
    development.profile("A", 5, connector="")
    assert "delete B" in development.next()
    assert tree.snapshot().component("B") is None
    development.save("dev.xml", (development.folder / "dev.xml").read_text() + " ")
    assert "nothing to do" in development.next()
    development.end()
    assert facts_of(tree, "A").state == "Active"


ERRORS = (
    ("Scale.py", MODULE + "\nclass\n", "Scale.py:18: SyntaxError"),
    ("Scale.py", MODULE, "nothing to do"),
    ("helper.py", "FACTOR = (\n", "helper.py:1: SyntaxError"),
    ("helper.py", "OTHER = 1\n", "ImportError: cannot import name 'FACTOR'"),
    ("dev.xml", PROFILE, "dev.xml:5"),
    ("Robot.idl", "struct {\n", "Robot.idl:1"),
)


def test_an_error_is_told_with_its_line_and_leaves_the_system(
    development: Development, tree: Tree
) -> None:
    before = [(each.instance, each.process, each.state) for each in tree.snapshot().components]
    for name, text, why in ERRORS:
        development.save(name, text)
        assert why in development.next() + development.rest()
        now = [(each.instance, each.process, each.state) for each in tree.snapshot().components]
        assert now == before
    (development.folder / "Robot.idl").unlink()
    development.save("helper.py", "FACTOR = 1\n")
    development.profile()
    development.next()


@pytest.mark.parametrize("development", ["--json"], indirect=True)
def test_what_happens_is_told_as_records(development: Development) -> None:
    development.profile(factor=5)
    told = development.begun + development.until('"done"')
    development.save("dev.xml", "<x")
    told += development.until('"failed"')
    development.profile(factor=5)
    told += development.until('"nothing"')
    records = jsonrecords.checked("\n".join(x for x in told.splitlines() if x.startswith("{")))
    assert {jsonrecords.kind_of(each) for each in records} == {"development"}
    assert [each["event"] for each in records] == [
        *("plan", "done", "watching"),
        *("saved", "plan", "done"),
        *("saved", "failed", "saved", "nothing"),
    ]
    assert str(development.folder / "dev.xml") in records[2]["lines"]
    assert any("A.factor=5" in line for line in records[4]["lines"])
    assert "dev.xml:1" in records[7]["lines"][0]


def test_with_down_it_ends_the_system(manager: Any, tree: Tree) -> None:
    folder = manager.modules
    (folder / "helper.py").write_text("FACTOR = 1\n")
    (folder / "Scale.py").write_text(MODULE)
    text = PROFILE.format(components=COMPONENT.format(name="A", factor=2), connector="")
    (folder / "dev.xml").write_text(text)
    process = manager.open(f"rtdev --down {folder}/dev.xml")
    for line in process.stdout:
        if "Ctrl-C" in line:
            break
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=20.0)
    assert process.returncode == 0, err
    assert tree.snapshot().components == ()
    for name in ("helper.py", "Scale.py", "dev.xml"):
        (folder / name).unlink()


@pytest.mark.parametrize(
    ("line", "status", "why"),
    [
        ("rtdev", 1, "One system profile has to be given, as a file"),
        ("rtdev nowhere.xml", 1, "no such file: nowhere.xml"),
        ("rtdev -s odd dev.xml", 2, "--state"),
    ],
)
def test_what_cannot_be_developed(manager: Any, line: str, status: int, why: str) -> None:
    outcome = manager.run(line)
    assert (outcome.status, outcome.out) == (status, "")
    assert why in outcome.err


def test_another_version_than_the_profile_states_is_told_and_not_made_for_ever(
    development: Development, tree: Tree
) -> None:
    development.save("Scale.py", MODULE.replace("    rate", '    version = "2"\n    rate'))
    told = development.until("left; run it again", "] done")
    assert "A was made, and is not what the profile says all the same" in told
    development.save("Scale.py", MODULE)
    development.until("] done")
    assert [each.state for each in tree.snapshot().components] == ["Active"] * 2


INCLUDING = """rtsProfile:
  id: RTSystem:Me:Two:1
  version: "0.2"
  creationDate: 2026-01-01T00:00:00
  updateDate: 2026-01-01T00:00:00
  rtkit::include:
  - {file: part.xml, prefix: left.}
"""


def test_what_an_included_profile_says_is_followed(manager: Any, tree: Tree) -> None:
    folder = manager.modules
    part = folder / "part.xml"
    (folder / "helper.py").write_text("FACTOR = 1\n")
    (folder / "Scale.py").write_text(MODULE)
    part.write_text(PROFILE.format(components=COMPONENT.format(name="A", factor=2), connector=""))
    (folder / "dev.yaml").write_text(INCLUDING)
    process = manager.open(f"rtdev {folder}/dev.yaml")
    development = Development.__new__(Development)
    development.folder, development.process = folder, process
    development.until("Ctrl-C ends that")
    assert facts_of(tree, "left.A").sets["default"]["factor"] == "2"
    part.write_text(PROFILE.format(components=COMPONENT.format(name="A", factor=6), connector=""))
    assert "set left.A.factor=6" in development.next()
    part.write_text("<x")
    assert "part.xml:1" in development.next() + development.rest()
    part.write_text(PROFILE.format(components=COMPONENT.format(name="A", factor=6), connector=""))
    assert "nothing to do" in development.next()
    development.end()
    manager.ok(f"rtteardown --exit {folder}/dev.yaml")
    for name in ("helper.py", "Scale.py", "dev.yaml", "part.xml"):
        (folder / name).unlink()
