"""Every real profile is read, with the facts that an independent reader found."""

from __future__ import annotations

import json
import os.path
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import pytest
import xmlschema
from corpus import CORPUS, needs_corpus
from lxml import etree

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.read import read_rtc, read_rts
from rtkit.profile.rtc_model import ActionStatus, RtcProfile
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.rts_rules import NO_DATE
from rtkit.profile.write import write_rtc, write_rts
from rtkit.resources import resource


def facts() -> dict[str, dict[str, Any]]:
    """The facts of the XML files, by file name; none where the corpus is absent."""
    if not os.path.isdir(CORPUS):
        return {}
    with open(os.path.join(CORPUS, "facts.json"), encoding="utf-8") as file:
        files: dict[str, dict[str, Any]] = json.load(file)["files"]
    return {name: fact for name, fact in files.items() if fact["kind"] in ("rtc", "rts")}


def content(name: str) -> bytes:
    with open(os.path.join(CORPUS, name), "rb") as file:
        return file.read()


FACTS = facts()
BARE = "rtc/openhri__OpenHRIVoice__semvalidator__samplertc.xml"
VERSION_0_1 = next((name for name in FACTS if name.endswith("RtsSampleV01.xml")), "")
RTC = [name for name in FACTS if name.startswith("rtc/")]
RTS = [name for name in FACTS if name.startswith("rts/")]


def read(name: str) -> Any:
    return (read_rts if name in RTS else read_rtc)(content(name), name)


def write(profile: Any) -> bytes:
    return write_rts(profile) if isinstance(profile, RtsProfile) else write_rtc(profile)


def below(value: Any) -> Iterator[Any]:
    """Every model object inside a model, itself included."""
    if is_dataclass(value):
        yield value
        for item in fields(value):
            yield from below(getattr(value, item.name))
    elif isinstance(value, tuple):
        for item in value:
            yield from below(item)


def count(value: Any, name: str) -> int:
    return sum(type(item).__name__ == name for item in below(value))


@pytest.fixture(scope="module")
def explainers() -> dict[str, Any]:
    names = {"rtc": "RtcProfile.xsd", "rts": "RtsProfile.xsd"}
    return {kind: xmlschema.XMLSchema10(resource("schemas", xsd)) for kind, xsd in names.items()}


@needs_corpus
def test_the_corpus_is_whole() -> None:
    assert (len(RTC), len(RTS)) == (68, 22)


def rts_facts(profile: RtsProfile) -> dict[str, Any]:
    components = profile.components
    contexts = [context for item in components for context in item.execution_contexts]
    connectors = profile.data_port_connectors + profile.service_port_connectors
    orders = {
        name: order
        for name, order in (
            ("StartUp", profile.start_up),
            ("ShutDown", profile.shut_down),
            ("Activation", profile.activation),
            ("Deactivation", profile.deactivation),
            ("Resetting", profile.resetting),
            ("Initializing", profile.initializing),
            ("Finalizing", profile.finalizing),
        )
        if order is not None
    }
    steps = [step for order in orders.values() for step in order.targets]
    listed = {(item.id, item.instance_name) for item in components}
    ends = [end for item in connectors for end in (item.source, item.target)]
    return {
        "id": profile.id,
        "version": profile.version,
        "abstract": profile.abstract,
        "creationDate": profile.creation_date,
        "updateDate": profile.update_date,
        "components": len(components),
        "instance_names": [item.instance_name for item in components],
        "composite_types": sorted({item.composite_type for item in components} - {None}),
        "composites": sum(bool(item.participants) for item in components),
        "participants": sum(len(item.participants) for item in components),
        "data_ports": sum(len(item.data_ports) for item in components),
        "service_ports": sum(len(item.service_ports) for item in components),
        "config_sets": sum(len(item.configuration_sets) for item in components),
        "config_data": count(profile, "ConfigurationData"),
        "execution_contexts": len(contexts),
        "ec_participants": sum(len(item.participants) for item in contexts),
        "locations": count(profile, "Location"),
        "groups": len(profile.groups),
        "data_connectors": len(profile.data_port_connectors),
        "service_connectors": len(profile.service_port_connectors),
        "dangling_connector_ends": sum(
            (end.component_id, end.instance_name) not in listed for end in ends
        ),
        "message_sending": {name: len(order.targets) for name, order in orders.items()},
        "wait_times": sum(step.wait_time is not None for step in steps),
        "preceding_conditions": sum(step.preceding is not None for step in steps),
        "preceding_components": sum(
            len(step.preceding.preceding_components) for step in steps if step.preceding
        ),
        "ext_properties": count(profile, "ExtensionProperty"),
        "root": "RtsProfile",
    }


@needs_corpus
@pytest.mark.parametrize("name", [name for name in RTS if name != VERSION_0_1])
def test_rts_facts(name: str) -> None:
    reading = read(name)
    found = rts_facts(reading.profile)
    expected = {key: value for key, value in FACTS[name].items() if key in found}
    for key in ("creationDate", "updateDate"):
        expected[key] = expected[key] or NO_DATE
    added = [note for note in reading.notes if note.text.endswith("by a connector only: added")]
    expected["data_ports"] += len(added)
    expected["ext_properties"] += 2 * len(added)
    assert len(found) == 27
    assert found == expected


@needs_corpus
@pytest.mark.parametrize("name", RTS)
def test_connector_ids_are_made_unique(name: str) -> None:
    reading = read(name)
    connectors = reading.profile.data_port_connectors + reading.profile.service_port_connectors
    renamed = [note for note in reading.notes if "is used before" in note.text]
    assert len({item.connector_id for item in connectors}) == len(connectors)
    assert FACTS[name]["connector_ids_unique"] + len(renamed) == len(connectors)


@needs_corpus
def test_version_0_1_is_brought_to_the_present_form() -> None:
    profile = read(VERSION_0_1).profile
    assert profile.version == "0.2"
    assert profile.id == FACTS[VERSION_0_1]["id"]
    names = [item.instance_name for item in profile.components]
    assert names == [
        "ConsoleIn0",
        "ConsoleOut1",
        "ConsoleOut2",
        "ConsoleOut3",
        "ConsoleOut4",
        "ConsoleOut0",
    ]
    assert [item.composite_type for item in profile.components[:5]] == [
        "None",
        "PeriodicStateShared",
        "PeriodicECShared",
        "Grouping",
        "Grouping",
    ]
    (connector,) = profile.data_port_connectors
    assert (connector.source.instance_name, connector.source.port_name) == ("ConsoleIn0", "out")
    assert (connector.target.instance_name, connector.target.port_name) == ("ConsoleOut0", "in")


def rtc_facts(profile: RtcProfile) -> dict[str, Any]:
    info, actions = profile.basic_info, profile.actions
    configurations = profile.configuration_set.configurations if profile.configuration_set else ()
    interfaces = [item for port in profile.service_ports for item in port.service_interfaces]
    present = (
        {
            item.name: status
            for item in fields(actions)
            if isinstance(status := getattr(actions, item.name), ActionStatus)
        }
        if actions
        else {}
    )
    of_info = {
        f"basic_{xml}": getattr(info, field, None)
        for xml, field in (
            ("abstract", "abstract"),
            ("activityType", "activity_type"),
            ("category", "category"),
            ("componentKind", "component_kind"),
            ("componentType", "component_type"),
            ("creationDate", "creation_date"),
            ("description", "description"),
            ("executionRate", "execution_rate"),
            ("executionType", "execution_type"),
            ("maxInstances", "max_instances"),
            ("name", "name"),
            ("rtcType", "rtc_type"),
            ("updateDate", "update_date"),
            ("vendor", "vendor"),
            ("version", "version"),
        )
    }
    kinds = [port.port_type for port in profile.data_ports]
    return of_info | {
        "id": profile.id,
        "version": profile.version,
        "actions": len(present),
        "actions_implemented": sorted(
            "".join(part.capitalize() for part in name.split("_"))
            for name, status in present.items()
            if status.implemented
        ),
        "configuration_sets": int(profile.configuration_set is not None),
        "configurations": len(configurations),
        "configuration_names": [item.name for item in configurations if item.name],
        "constraints_top": sum(item.constraint is not None for item in configurations)
        + sum(port.constraint is not None for port in profile.data_ports),
        "data_ports": len(kinds),
        "data_ports_in": kinds.count("DataInPort"),
        "data_ports_out": kinds.count("DataOutPort"),
        "event_ports": kinds.count("EventPort"),
        "data_port_names": [port.name for port in profile.data_ports],
        "events": count(profile, "FsmTransition"),
        "service_ports": len(profile.service_ports),
        "interfaces": len(interfaces),
        "interfaces_provided": sum(item.direction == "Provided" for item in interfaces),
        "interfaces_required": sum(item.direction == "Required" for item in interfaces),
        "trans_methods": count(profile, "TransMethod"),
        "language": profile.language.kind if profile.language else None,
        "language_targets": count(profile, "TargetEnvironment"),
        "parameters": len(profile.parameters),
        "version_up_logs": len(info.version_up_logs) if info else 0,
        "ext_properties": sum(isinstance(item, ExtensionProperty) for item in below(profile)),
        "docs": sum(type(item).__name__.endswith("Doc") for item in below(profile)),
        "root": "RtcProfile",
    }


@needs_corpus
@pytest.mark.parametrize("name", [name for name in RTC if name != BARE])
def test_rtc_facts(name: str) -> None:
    found = rtc_facts(read(name).profile)
    expected = {key: value for key, value in FACTS[name].items() if key in found}
    for key, turn in (("basic_executionRate", float), ("basic_maxInstances", int)):
        expected[key] = None if expected[key] is None else turn(expected[key])
    misspelt = {"PERIODOC": "PERIODIC", "EVENT_DRIVEN": "EVENTDRIVEN"}
    activity = expected["basic_activityType"]
    expected["basic_activityType"] = misspelt.get(activity, activity)
    expected["id"] = expected["id"] or ""
    if expected["version"] in ("0.1", "1.0"):
        expected["version"] = "0.2"
    expected["configuration_names"] = [item for item in expected["configuration_names"] if item]
    assert len(found) == 41
    assert found == expected


@needs_corpus
def test_bare_attributes_are_read() -> None:
    profile = read(BARE).profile
    assert profile.id == "RTC:AIST:communication:Emphasis:1.0.0"
    assert profile.basic_info.name == "Emphasis"
    assert profile.basic_info.execution_rate == 100.0
    assert [(port.name, port.port_type) for port in profile.data_ports] == [
        ("indata", "DataInPort"),
        ("outdata", "DataOutPort"),
    ]
    (semantics,) = profile.foreign.elements
    assert semantics.name == "{http://openhri.net/RTCSemantics}semantics"
    assert len(semantics.children) == 2
    assert semantics.children[0].children[0].children[0].text == (
        "RTC:AIST:communication:Emphasis:1.0.0"
    )


@needs_corpus
@pytest.mark.parametrize("name", FACTS)
def test_read_write_read(name: str, explainers: dict[str, Any]) -> None:
    first = read(name).profile
    written = write(first)
    again = (read_rts if name in RTS else read_rtc)(written, "written").profile
    assert again == first
    assert write(again) == written
    kind = name.partition("/")[0]
    schema = etree.XMLSchema(file=resource("schemas", f"{kind.capitalize()}Profile.xsd"))
    schema.assertValid(etree.fromstring(written))
    assert explainers[kind].is_valid(etree.fromstring(written))


@needs_corpus
@pytest.mark.parametrize("name", FACTS)
def test_what_is_written_is_strict(name: str) -> None:
    profile = read(name).profile
    read_strictly = read_rts if name in RTS else read_rtc
    written = write(profile)
    if isinstance(profile, RtcProfile) and not (profile.basic_info and profile.actions):
        with pytest.raises(InvalidProfile, match="written:2: a fragment: no rtc:"):
            read_strictly(written, "written", strict=True)
    else:
        assert read_strictly(written, "written", strict=True).profile == profile
