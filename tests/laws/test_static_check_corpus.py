"""The static check over real systems: no finding that is not true, and none that is missed."""

from __future__ import annotations

import glob
import os
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from corpus import CORPUS, ROOT, corpus

from rtkit.deployment.described import data_port, properties_of, type_of
from rtkit.profile.read import read_rts
from rtkit.profile.rtc_model import (
    BasicInfo,
    ConfigurationParameter,
    DataPortDeclaration,
    DeclaredParameters,
    RtcProfile,
    ServicePortDeclaration,
)
from rtkit.profile.rts_model import ComponentInstance, InstancePort, RtsProfile
from rtkit.profile.words import strip_instance
from rtkit.report.finding import ERROR
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.check import findings
from rtkit.static_check.stock import CandidateDocument, stocked
from rtkit.static_check.verdict import opened, verdict

SYSTEMS = list(map(str, corpus("rts/*", "yaml/gb*")))
FILES = SYSTEMS + sorted(glob.glob(str(ROOT / "profiles" / "systems" / "*.xml")))
needs_corpus = pytest.mark.skipif(not SYSTEMS, reason="corpus absent")

# Each was looked at: what is told is so in the file.
TRUE = {
    "gbiggs__rtsprofile__test__rtsystem.xml": {"condition-wait": 3},
    "gbiggs__rtsprofile__test__rtsystem.yaml": {"condition-wait": 3, "unknown-set": 1},
    "OpenRTM__RTM_Tutorial__choreonoid__share__project__TankSystem.xml": {"data-type": 1},
    "OpenRTM__RTM_Tutorial__choreonoid__share__project__TankVisionSystem-NewIDL.xml": {
        "data-type": 4
    },
    "OpenRTM__RTM_Tutorial__choreonoid__share__project__TankVisionSystem.xml": {"data-type": 4},
    "openhri__OpenHRIVoice__semvalidator__rtsystem-invalid.xml": {
        "unknown-port": 4,
        "context-rate": 2,
    },
    "sugarsweetrobotics__vrep_mrpt_mapper_test__system__navSystem.xml": {"parameter-constraint": 1},
}
WAITS = {"condition-wait"}  # is of the orders of a system, whatever its types are
KNOWN = {
    "openhri__OpenHRIVoice__semvalidator__rtsystem-invalid.xml": 2,
    "rsdlab__mycobotSystem__system__DefaultSystem.xml": 1,
    "rsdlab__wa_management3__system__DefaultSystem.xml": 1,
}


def catalogue(types: set[str]) -> Catalogue:
    files = sorted([*(CORPUS / "rtc").iterdir(), *(ROOT / "profiles").glob("*.xml")])
    found, troubles = stocked((CandidateDocument(str(f), f.read_bytes()) for f in files), types)
    assert troubles == []
    return found


@needs_corpus
@pytest.mark.parametrize("file", FILES, ids=os.path.basename)
def test_what_is_found_in_real_systems_is_true(file: str) -> None:
    name = os.path.basename(file)
    system = opened(Path(file).read_bytes(), file)
    assert system.profile is not None
    known = catalogue(system.types)
    checked = verdict(system, known)
    told = Counter(f.rule for f in checked.findings if f.rule != "no-profile")
    assert told == TRUE.get(name, {})
    errors = {f.rule for f in checked.findings if f.severity == ERROR}
    assert errors == ({"unknown-port"} if "invalid" in name else WAITS & TRUE.get(name, {}).keys())
    ids = [component.id for component in system.profile.components]
    matched = sum(known.find(id) is not None for id in ids)
    assert matched == (len(ids) if file not in SYSTEMS else KNOWN.get(name, 0))
    assert all(f.line > 0 and f.path.startswith("/rts:RtsProfile") for f in checked.findings)


def derived(component: ComponentInstance) -> RtcProfile:
    """Return the profile of a type that is just what this component is."""
    type = type_of(component.id)
    kinds = {context.kind for context in component.execution_contexts}
    execution = "EventDriven" if "EVENT_DRIVEN" in kinds else "Periodic"
    info = BasicInfo(
        type.type_name,
        *("STATIC", "PERIODIC", "DataFlowComponent"),
        *(type.category, type.vendor, type.version, f"{execution}ExecutionContext", "", ""),
        execution_rate=next((c.rate for c in component.execution_contexts), None),
    )
    sets = [each for each in component.configuration_sets if not each.id.startswith("__")]
    parameters = {data.name: data.data or "" for each in sets for data in each.data}
    made = tuple(ConfigurationParameter(name, "string", text) for name, text in parameters.items())
    own = component.instance_name
    return RtcProfile(
        component.id,
        "0.3",
        info,
        configuration_set=DeclaredParameters(made),
        data_ports=tuple(derived_port(port, own) for port in component.data_ports),
        service_ports=tuple(
            ServicePortDeclaration(strip_instance(port.name, own), "LEFT")
            for port in component.service_ports
        ),
    )


def derived_port(port: InstancePort, instance: str) -> DataPortDeclaration:
    known = data_port(port, instance, None, "")
    told = properties_of(port.properties)
    return DataPortDeclaration(
        known.port_type.value,
        known.name,
        known.data_type or "Any",
        "LEFT",
        interface_type=told.get("dataport.interface_type"),
        dataflow_type=told.get("dataport.dataflow_type"),
        subscription_type=told.get("dataport.subscription_type"),
    )


def errors_of(profile: RtsProfile, types: list[RtcProfile]) -> set[str]:
    known = Catalogue((each, str(number)) for number, each in enumerate(types))
    return {each.rule for each in findings(profile, known) if each.severity == ERROR}


@pytest.mark.parametrize("file", FILES, ids=os.path.basename)
def test_a_system_fits_the_types_that_are_what_its_components_are(file: str) -> None:
    profile = read_rts(Path(file).read_bytes(), file).profile
    types = [derived(each) for each in profile.components]
    # Directions are guessed where a file tells none, and old files contradict themselves.
    told = errors_of(profile, types) - {"data-type", "connector-direction"} - WAITS
    one_type_each = len({each.id for each in types}) == len(types)
    assert told == set() or not one_type_each
    for number, each in enumerate(types):
        rest = types[:number] + types[number + 1 :]
        if not one_type_each:
            continue
        if each.data_ports:
            fewer = replace(each, data_ports=each.data_ports[1:])
            assert "unknown-port" in errors_of(profile, [*rest, fewer])
        if each.configuration_set is not None and each.configuration_set.configurations:
            fewer = replace(each, configuration_set=None)
            assert "unknown-parameter" in errors_of(profile, [*rest, fewer])
