"""The way back: from code to its profile, and what survives there and back again."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from corpus import ROOT, corpus, needs_corpus

from rtkit.builder.component_files import build
from rtkit.builder.prepare import Sources
from rtkit.builder.profile_of import profile_of
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong
from rtkit.component.configuration.kinds import kind_of
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.read import read_rtc
from rtkit.profile.rtc_model import (
    ActionDoc,
    Actions,
    ActionStatus,
    BasicDoc,
    ConfigurationDoc,
    DataPortDeclaration,
    DataPortDoc,
    RtcProfile,
)
from rtkit.profile.words import normal_data_type, property_value

FILES = corpus("rtc/*")
WHOLE = [file for file in FILES if b"BasicInfo" in file.read_bytes()]
"""Those that describe a component; others are fragments, test data of the old tools."""
DATE = "2020-01-01T00:00:00"


def component(profile: RtcProfile, stem: str, monkeypatch: pytest.MonkeyPatch) -> Component:
    """Return an instance of what is built from a profile."""
    built = build(profile, Sources(stem))
    module = ModuleType(built.subject.module)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    exec(built.files[f"{module.__name__}.py"].text, module.__dict__)
    made: Component = getattr(module, built.subject.class_name)("x")
    return made


def words(*texts: str | None) -> list[str]:
    return re.findall(r"\w+", " ".join(filter(None, texts)).replace("<br/>", " ").lower())


def carried(profile: RtcProfile) -> dict[str, Any]:
    """Return all of a profile that code can carry, in one form."""
    info, settings = profile.basic_info, profile.configuration_set
    assert info is not None
    doc = info.doc or BasicDoc()
    return {
        "identity": (info.name, info.vendor, info.category, info.version),
        "driven": (info.execution_type, (info.execution_rate or 0) or 1000.0),
        "told": words(info.description, doc.description)
        + [words(getattr(doc, each)) for each in ("inout", "algorithm", "creator", "license")],
        "ports": sorted(map(port, profile.data_ports)),
        "services": [
            (
                each.name,
                sorted((i.name or each.name, i.type, i.direction) for i in each.service_interfaces),
            )
            for each in profile.service_ports
        ],
        "settings": [setting(each) for each in (settings.configurations if settings else ())],
        "actions": actions(profile),
    }


def port(each: DataPortDeclaration) -> Any:
    doc = each.doc or DataPortDoc()
    kind = normal_data_type(each.type) or "Any"
    # Where the machine begins is told anew: some editors leave it to the order of the states.
    events = sorted((e.name, e.source, e.target) for e in each.events if e.name)
    text = words(doc.description or each.comment, each.unit or doc.unit)
    return (each.name, each.port_type, kind, events, text)


def setting(each: Any) -> Any:
    doc = each.doc or ConfigurationDoc()
    return (
        each.name,
        value(each.type, each.default_value),
        each.unit or doc.unit or None,
        words(doc.description or each.comment),
        format_constraint(each.constraint) if each.constraint else "",
        property_value(each.properties, "__widget__"),
    )


def value(type: str, text: str) -> str:
    kind = {"short": "int", "float": "double"}.get(type, type)
    return str(float(text)) if kind in ("int", "double") else text


def actions(profile: RtcProfile) -> Any:
    """Return what is implemented; a component without states has no transitions to react to."""
    found = {}
    has_states = any(each.events for each in profile.data_ports)
    told = profile.actions or Actions()
    for name in Actions.__dataclass_fields__:
        status = getattr(told, name)
        is_known = has_states if name == "on_action" else name != "on_mode_changed"
        if isinstance(status, ActionStatus) and status.implemented and is_known:
            doc = status.doc or ActionDoc()
            text = (doc.description, doc.pre_condition, doc.post_condition)
            found[name] = tuple(words(each) for each in text)
    return found


@needs_corpus
@pytest.mark.parametrize("file", WHOLE, ids=lambda file: file.stem)
def test_what_code_can_carry_survives(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    profile = read_rtc(file.read_bytes(), file.name).profile
    built = build(profile, Sources("stem"))
    made = component(profile, "stem", monkeypatch)
    back = profile_of(made, DATE, {})
    before, after = carried(profile), carried(back)
    if any("is called" in note for note in built.notes):
        # A name that was taken twice is another one in code; everything else is the same.
        before.pop("settings")
        after.pop("settings")
    if any("is left out" in note for note in built.notes):
        # A transition without an event has no place in a table of events.
        before.pop("ports")
        after.pop("ports")
    assert after == before


@needs_corpus
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_second_time_nothing_changes(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    profile = read_rtc(file.read_bytes(), file.name).profile
    once = profile_of(component(profile, "stem", monkeypatch), DATE, {})
    twice = profile_of(component(once, "stem", monkeypatch), DATE, {})
    assert twice == once
    assert profile_of(component(twice, "stem", monkeypatch), DATE, {}) == twice


SHIPPED = sorted((ROOT / "profiles").glob("*.xml"))


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_profiles_that_ship_survive_whole(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    profile = read_rtc(file.read_bytes(), file.name, strict=True).profile
    info = profile.basic_info
    assert info is not None
    properties = {each.name: each.value or "" for each in info.properties}
    back = profile_of(component(profile, "x", monkeypatch), info.creation_date, properties)
    assert carried(back) == carried(profile)
    assert back.basic_info == info
    assert back.actions == profile.actions
    assert back.configuration_set == profile.configuration_set


class Mixed(Component):
    """Do several things.

    At once.

    Author: Me
    """

    vendor = "me"
    execution_type = "EventDrivenExecutionContext"
    into = InPort(TimedLong, doc="How far [m]")
    out = OutPort(bytes)
    odd = Parameter("a", constraint="a machine (cannot read this", doc="odd", widget="text")

    def on_initialize(self):
        """Make a port."""
        self.add_out_port("more", TimedLong)

    def on_error(self, context):
        """Wait in Error, every period.

        Precondition: it failed
        """


def test_code_that_nobody_generated():
    made = Mixed("x")
    profile = profile_of(made, DATE, {"a": "b"})
    info = profile.basic_info
    assert info.description == "Do several things."
    assert info.doc == BasicDoc(description="At once.", creator="Me")
    assert (info.activity_type, info.execution_rate) == ("EVENTDRIVEN", None)
    assert info.properties == (ExtensionProperty("a", "b"),)
    into, out = profile.data_ports
    assert (into.type, into.unit, into.doc) == ("RTC::TimedLong", "m", DataPortDoc("How far"))
    assert (out.type, out.position, out.doc) == ("Any", "RIGHT", None)
    (odd,) = profile.configuration_set.configurations
    assert odd.doc == ConfigurationDoc(description="odd", constraint="a machine (cannot read this")
    assert odd.constraint is None
    assert profile.actions.on_initialize == ActionStatus(True, ActionDoc("Make a port."))
    assert profile.actions.on_error == ActionStatus(True, ActionDoc(pre_condition="it failed"))
    assert profile.actions.on_execute == ActionStatus(False)
    assert profile.actions.on_action is None
    made.on_initialize()
    assert [each.name for each in profile_of(made, DATE, {}).data_ports] == ["into", "out", "more"]


def test_kinds_of_parameters():
    class Kinds(Component):
        a = Parameter((1, 2))
        b = Parameter(True)

    found = profile_of(Kinds("x"), DATE, {}).configuration_set.configurations
    assert [(each.type, each.default_value) for each in found] == [
        (kind_of((1, 2)).name, "1,2"),
        ("bool", "true"),
    ]
