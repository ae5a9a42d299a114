"""Laws of reading: whatever is done to a document, both schema libraries judge it alike, reading
ends in a profile or in `InvalidProfile`, and what was read can be written strictly."""

from __future__ import annotations

from functools import cache
from typing import Any
from unittest.mock import patch

import pytest
import xmlschema
from hypothesis import example, given, settings
from hypothesis import strategies as st
from lxml import etree
from profile_reading import profile_kind

from rtkit.profile import constraint_model as c
from rtkit.profile import rtc_model as rtc
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.read import read_rtc, read_rts
from rtkit.profile.rtc_model import ActionDoc, BasicDoc, ConfigurationDoc
from rtkit.profile.write import write_rtc, write_rts
from rtkit.resources import resource

DATE = "2024-01-02T03:04:05+09:00"
REF = rts.ComponentRef("RTC:v:c:A:1", "A0")
END = rts.TargetPort(
    "RTC:v:c:A:1", "A0", "A0.p", (ExtensionProperty("COMPONENT_PATH_ID", "h/A0.rtc"),)
)
STEP = rts.TargetComponent("RTC:v:c:A:1", "A0", "0")
SYSTEM = rts.RtsProfile(
    "RTSystem:v:s:1",
    "0.2",
    DATE,
    DATE,
    components=(
        rts.ComponentInstance(
            "RTC:v:c:A:1",
            "h/A0.rtc",
            "A0",
            composite_type="Grouping",
            visible=True,
            data_ports=(rts.InstancePort("A0.p", True),),
            service_ports=(rts.InstancePort("p"),),
            configuration_sets=(
                rts.ConfigurationSet("default", (rts.ConfigurationData("a", "1"),)),
            ),
            execution_contexts=(rts.OwnedContext("0", "PERIODIC", 10.0, (REF,)),),
            participants=(REF,),
            location=rts.Location(1, 2, 3, 4, "UP"),
            properties=(ExtensionProperty("a", "b"),),
        ),
    ),
    groups=(rts.ComponentGroup("g", (REF,)),),
    data_port_connectors=(
        rts.DataPortConnector("c", "n", "T", "corba_cdr", "push", END, END, push_interval=1.0),
    ),
    service_port_connectors=(rts.ServicePortConnector("s", "n", END, END),),
    start_up=rts.Order(
        (
            rts.OrderStep(1, STEP, wait_time=rts.WaitTime(5)),
            rts.OrderStep(2, STEP, preceding=rts.Preceding((STEP,), 100, "SYNC")),
        )
    ),
    version_up_logs=("one",),
    properties=(ExtensionProperty("a"),),
    systems=(rts.NestedSystem("x.xml"),),
)
ONE = c.Constraint(c.ConstraintUnit(c.Comparison("propertyIsEqualTo", "1")))
COMPONENT = rtc.RtcProfile(
    "RTC:v:c:n:1",
    "0.3",
    rtc.BasicInfo(
        "n",
        "STATIC",
        "PERIODIC",
        "DataFlowComponent",
        "c",
        "v",
        "1",
        "PeriodicExecutionContext",
        DATE,
        DATE,
        execution_rate=1.0,
        max_instances=1,
        doc=BasicDoc("d"),
        version_up_logs=("one",),
        properties=(ExtensionProperty("FSM", "true"),),
    ),
    rtc.Actions(
        on_initialize=rtc.ActionStatus(True, ActionDoc("d")), on_reset=rtc.ActionStatus(False)
    ),
    rtc.DeclaredParameters(
        (
            rtc.ConfigurationParameter(
                "a",
                "int",
                "1",
                constraint=c.Constraint(c.ConstraintUnit(c.Logical("Or", (ONE, ONE)))),
                doc=ConfigurationDoc(unit="m"),
            ),
        )
    ),
    (rtc.SystemParameter("p", "1"),),
    (
        rtc.DataPortDeclaration(
            "EventPort", "e", "Any", "LEFT", events=(rtc.FsmTransition("", "a", "b"),)
        ),
    ),
    (
        rtc.ServicePortDeclaration(
            "s",
            "TOP",
            service_interfaces=(rtc.ServiceInterface("i", "Provided", "M::I"),),
            trans_methods=(rtc.TransMethod("k"),),
        ),
    ),
    rtc.Language(
        "Python",
        (
            rtc.TargetEnvironment(
                "3", os_versions=("a",), cpus=("b",), libraries=(rtc.Library("l"),)
            ),
        ),
    ),
)
DOCUMENTS = {"rts": write_rts(SYSTEM), "rtc": write_rtc(COMPONENT)}
KINDS = st.sampled_from(sorted(DOCUMENTS))
TRIED = (
    "|| |true|TRUE|0|1.0|-5|1e5|1e999|NaN|x|UP|up|LEFT|None|PERIODIC|in|日本|a\nb|٣| 7 |"
    "2024-02-30T00:00:00|2024-01-01|2024-01-01T24:00:00|0000-01-01T00:00:00|A0|RTC:v:c:A:1|"
    "rtsExt:dataport_ext|rtcExt:dataport_ext|none:dataport_ext|1111111111111111111111111"
)
VALUES = st.sampled_from(sorted(set(TRIED.split("|"))))
NUMBER = st.integers(0, 10**6)
CHANGES = st.lists(
    st.tuples(
        st.sampled_from(
            ["drop", "double", "swap", "text", "unset", "set", "rename", "alien", "bare", "move"]
        ),
        NUMBER,
        NUMBER,
        VALUES,
    ),
    min_size=1,
    max_size=4,
)


def change(root: Any, how: str, which: int, what: int, value: str) -> None:
    """Do one thing to the tree; `which` picks the element, `what` a place in it."""
    every = list(root.iter(etree.Element))
    element = every[which % len(every)]
    parent = element.getparent()
    names = sorted(element.attrib)
    name = names[what % len(names)] if names else "none"
    if how == "text":
        element.text = value
    elif how == "set":
        element.set(name, value)
    elif how == "unset" and names:
        del element.attrib[name]
    elif how == "bare" and names:
        element.set(etree.QName(name).localname, element.attrib.pop(name))
    elif how == "alien":
        element.insert(what % 3, etree.Element(f"{{urn:{what % 2}}}alien", {"k": value}))
    elif how == "rename":
        element.tag = every[what % len(every)].tag
    elif parent is not None:
        if how == "drop":
            parent.remove(element)
        elif how == "double":
            parent.append(etree.fromstring(etree.tostring(element, with_tail=False)))
        elif how == "swap":
            parent.insert(0, element)
        elif how == "move" and every[what % len(every)] not in list(element.iter()):
            every[what % len(every)].append(element)


@cache
def schemas(kind: str) -> tuple[etree.XMLSchema, xmlschema.XMLSchema10]:
    path = resource("schemas", f"{kind.capitalize()}Profile.xsd")
    return etree.XMLSchema(file=path), xmlschema.XMLSchema10(path)


def judged_by_xmlschema(kind: str, data: bytes) -> bool:
    root = etree.fromstring(data)
    try:
        return schemas(kind)[1].is_valid(root, use_location_hints=False)
    except KeyError:
        return False  # its way to say that xsi:type is empty


@given(KINDS, CHANGES)
@settings(deadline=None, max_examples=300)
@example("rts", [("set", 0, 0, "2024-02-30T00:00:00")])
@example("rts", [("rename", 0, 1, "")])
def test_verdicts(kind: str, changes: list[tuple[str, int, int, str]]) -> None:
    root = etree.fromstring(DOCUMENTS[kind])
    name = root.tag
    for one in changes:
        change(root, *one)
    data = etree.tostring(root)
    quick = schemas(kind)[0]
    is_valid = quick.validate(etree.fromstring(data))
    # A root that no schema declares: xmlschema accepts it by its xsi:type, lxml refuses it, and
    # readers refuse it before either is asked.
    assert root.tag != name or judged_by_xmlschema(kind, data) == is_valid
    reading = attempt(kind, data)
    with patch("rtkit.profile.build.built", return_value=None):
        assert attempt(kind, data) == reading, "the short way and the long way decide alike"
    with patch("rtkit.profile.parse.may_drop_blanks", return_value=False):
        assert attempt(kind, data) == reading, "blanks between elements mean nothing"
    if reading is None:
        assert attempt(kind, data, strict=True) is None
        return
    written = (write_rts if kind == "rts" else write_rtc)(reading.profile)
    again = attempt(kind, written)
    assert again is not None
    assert again.profile == reading.profile
    quick.assertValid(etree.fromstring(written))
    strictly = attempt(kind, data, strict=True)
    if strictly is None:
        assert reading.notes
    else:
        assert is_valid
        assert strictly == reading


def attempt(kind: str, data: bytes, *, strict: bool = False) -> Any:
    """Read; None where the document was refused, with at least one problem on a line."""
    try:
        return (read_rts if kind == "rts" else read_rtc)(data, "x", strict=strict)
    except InvalidProfile as refused:
        problems = refused.problems
    assert problems
    assert all(note.line >= 1 for note in problems)
    return None


@given(KINDS, NUMBER, st.binary(max_size=4), NUMBER)
@settings(deadline=None, max_examples=300)
def test_bytes_changed_at_random(kind: str, start: int, by: bytes, length: int) -> None:
    data = DOCUMENTS[kind]
    start %= len(data)
    reading = attempt(kind, data[:start] + by + data[start + length % 5 :])
    assert reading is None or reading.profile


@given(st.binary(max_size=200))
@settings(max_examples=200)
def test_bytes_from_nowhere(data: bytes) -> None:
    with pytest.raises(InvalidProfile, match=r"^<stdin>:\d+: "):
        profile_kind(data)


def test_the_kinds_are_told_apart() -> None:
    assert profile_kind(DOCUMENTS["rtc"]) == "rtc"
    assert profile_kind(DOCUMENTS["rts"]) == "rts"
