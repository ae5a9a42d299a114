"""The RTS profile in XML: which class, field and element belong together."""

from __future__ import annotations

from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as m
from rtkit.profile import rts_rules as rules
from rtkit.profile.common import NO_FOREIGN, ExtensionProperty, Foreign
from rtkit.profile.spec import (
    DATE,
    FLAG,
    REAL,
    WHOLE,
    ElementSpec,
    attribute,
    child,
    field_name,
    required,
)

DIRECTIONS = ("DOWN", "RIGHT", "UP", "LEFT")
COMPOSITE_TYPES = (
    "None",
    "PeriodicECShared",
    "PeriodicStateShared",
    "Grouping",
    "FsmECShared",
    "FsmStateShared",
)
SENDING_TIMINGS = ("SYNC", "ASYNC", "NO_SYNC")
ORDERS = tuple((field_name(name), name) for name in rules.ORDERS)
"""Field and element of each order."""
_OLD_COMPOSITES = {
    "allshared": "PeriodicStateShared",
    "ecshared": "PeriodicECShared",
    "nonshared": "Grouping",
    "choice": "Grouping",
}


def _only(participant: m.ComponentRef | None, around: Foreign) -> m.ComponentRef:
    if participant is None:
        raise ValueError("no participant")
    return replace(participant, around=around) if around != NO_FOREIGN else participant


_PROPERTY = ElementSpec(
    ExtensionProperty, [attribute("rtsExt:name", required=True), "rtsExt:value"]
)
_PROPERTIES = child("rtsExt:Properties", _PROPERTY, many=True)
_SEEN = (attribute("rtsExt:visible", FLAG), "rtsExt:comment")
_REF = required("rts:componentId", "rts:instanceName")
_COMPONENT_REF = ElementSpec(m.ComponentRef, _REF)
_PARTICIPANTS = ElementSpec(
    _only, children=[child("rts:Participant", _COMPONENT_REF, least=1)], wraps="participant"
)
_PORT = (attribute("rts:name", required=True), *_SEEN)
_DATA_PORT = ElementSpec(m.InstancePort, _PORT, [_PROPERTIES], xsi_type="rtsExt:dataport_ext")
_SERVICE_PORT = ElementSpec(m.InstancePort, _PORT, [_PROPERTIES], xsi_type="rtsExt:serviceport_ext")
_CONFIGURATION_SET = ElementSpec(
    m.ConfigurationSet,
    [attribute("rts:id", required=True)],
    [
        child(
            "rts:ConfigurationData",
            ElementSpec(m.ConfigurationData, [attribute("rts:name", required=True), "rts:data"]),
            field="data",
            many=True,
        )
    ],
)
_EXECUTION_CONTEXT = ElementSpec(
    m.OwnedContext,
    [
        attribute("rts:id", supply=rules.position_among_siblings),
        attribute("rts:kind", supply="PERIODIC"),
        attribute("rts:rate", REAL),
    ],
    [child("rts:Participants", _PARTICIPANTS, many=True), _PROPERTIES],
    xsi_type="rtsExt:execution_context_ext",
)
_LOCATION = ElementSpec(
    m.Location,
    [
        attribute("rtsExt:x", WHOLE, supply="0"),
        attribute("rtsExt:y", WHOLE, supply="0"),
        attribute("rtsExt:height", WHOLE, supply="-1"),
        attribute("rtsExt:width", WHOLE, supply="-1"),
        attribute("rtsExt:direction", words=DIRECTIONS, supply="DOWN"),
    ],
)
_COMPONENT = ElementSpec(
    m.ComponentInstance,
    [
        attribute("rts:id", required=True),
        attribute("rts:pathUri", supply=""),
        attribute("rts:instanceName", required=True),
        attribute("rts:isRequired", FLAG, supply="true"),
        "rts:activeConfigurationSet",
        attribute("rts:compositeType", words=COMPOSITE_TYPES, respellings=_OLD_COMPOSITES),
        *_SEEN,
    ],
    [
        child("rts:DataPorts", _DATA_PORT, many=True),
        child("rts:ServicePorts", _SERVICE_PORT, many=True),
        child("rts:ConfigurationSets", _CONFIGURATION_SET, many=True),
        child("rts:ExecutionContexts", _EXECUTION_CONTEXT, many=True),
        child("rts:Participants", _PARTICIPANTS, many=True),
        child("rtsExt:Location", _LOCATION),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:component_ext",
)
_GROUP = ElementSpec(
    m.ComponentGroup,
    [attribute("rts:groupId", required=True)],
    [child("rts:Members", _COMPONENT_REF, many=True, least=1), _PROPERTIES],
)
_TARGET_PORT = ElementSpec(
    m.TargetPort,
    [*_REF, attribute("rts:portName", required=True)],
    [_PROPERTIES],
    xsi_type="rtsExt:target_port_ext",
)
_CONNECTOR = (
    attribute("rts:connectorId", supply=rules.position_among_siblings),
    attribute("rts:name", supply=""),
)
_DATA_CONNECTOR = ElementSpec(
    m.DataPortConnector,
    [
        *_CONNECTOR,
        attribute("rts:dataType", supply=rules.property_or_empty("data_type")),
        attribute("rts:interfaceType", supply=rules.property_or_empty("interface_type")),
        attribute("rts:dataflowType", supply=rules.property_or_empty("dataflow_type")),
        "rts:subscriptionType",
        attribute("rts:pushInterval", REAL),
        *_SEEN,
    ],
    [
        child("rts:sourceDataPort", _TARGET_PORT, field="source", least=1),
        child("rts:targetDataPort", _TARGET_PORT, field="target", least=1),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:dataport_connector_ext",
)
_SERVICE_CONNECTOR = ElementSpec(
    m.ServicePortConnector,
    [*_CONNECTOR, "rts:transMethod", *_SEEN],
    [
        child("rts:sourceServicePort", _TARGET_PORT, field="source", least=1),
        child("rts:targetServicePort", _TARGET_PORT, field="target", least=1),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:serviceport_connector_ext",
)
_TARGET_COMPONENT = ElementSpec(m.TargetComponent, [*_REF, attribute("rts:id", supply="0")])
_PRECEDING = ElementSpec(
    m.Preceding,
    [attribute("rts:timeout", WHOLE), attribute("rts:sendingTiming", words=SENDING_TIMINGS)],
    [child("rts:PrecedingComponents", _TARGET_COMPONENT, many=True)],
)
_CONDITION = ElementSpec(
    m.OrderStep,
    [attribute("rts:sequence", WHOLE, required=True)],
    [
        child(
            "rts:WaitTime", ElementSpec(m.WaitTime, [attribute("rts:waitTime", WHOLE, supply="0")])
        ),
        child("rts:Preceding", _PRECEDING),
        child("rts:TargetComponent", _TARGET_COMPONENT, least=1),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:condition_ext",
    rule=rules.precondition,
)
_ORDER = ElementSpec(m.Order, children=[child("rts:targets", _CONDITION, many=True)])
_VARIABLE = ElementSpec(
    m.SystemVariable, [attribute("rtkit:name", required=True), "rtkit:default", "rtkit:description"]
)
_VALUE = ElementSpec(m.IncludedValue, required("rtkit:name", "rtkit:value"))
_INCLUDE = ElementSpec(
    m.IncludedSystem,
    [attribute("rtkit:file", required=True), "rtkit:prefix"],
    [child("rtkit:Value", _VALUE, field="values", many=True)],
)
RTS_PROFILE = ElementSpec(
    m.RtsProfile,
    [
        attribute("rts:id", required=True),
        attribute("rts:version", supply=m.RTS_VERSION),
        "rts:abstract",
        attribute("rts:creationDate", DATE, supply=rules.other_date),
        attribute("rts:updateDate", DATE, supply=rules.other_date),
        "rtsExt:comment",
    ],
    [
        child("rts:Components", _COMPONENT, many=True),
        child("rts:Groups", _GROUP, many=True),
        child("rts:DataPortConnectors", _DATA_CONNECTOR, many=True),
        child("rts:ServicePortConnectors", _SERVICE_CONNECTOR, many=True),
        *(child(f"rts:{name}", _ORDER) for name in rules.ORDERS),
        child("rtsExt:VersionUpLogs", many=True),
        _PROPERTIES,
        child(
            "rtsExt:Systems",
            ElementSpec(m.NestedSystem, [attribute("rtsExt:path", required=True)]),
            many=True,
        ),
        child("rtkit:Variable", _VARIABLE, field="variables", many=True),
        child("rtkit:Include", _INCLUDE, field="includes", many=True),
    ],
    extended_type="rtsExt:rts_profile_ext",
    rule=rules.version_0_1,
    respellings={"Component": "Components", "VersionUpLog": "VersionUpLogs"},
)
