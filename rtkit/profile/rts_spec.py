"""The RTS profile in XML: which class, field and element belong together."""

from __future__ import annotations

from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as m
from rtkit.profile import rts_rules as rules
from rtkit.profile.common import NO_FOREIGN, ExtensionProperty, Foreign
from rtkit.profile.spec import DATE, FLAG, REAL, WHOLE, ElementSpec, attribute, child

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
ORDERS = (
    ("start_up", "StartUp"),
    ("shut_down", "ShutDown"),
    ("activation", "Activation"),
    ("deactivation", "Deactivation"),
    ("resetting", "Resetting"),
    ("initializing", "Initializing"),
    ("finalizing", "Finalizing"),
)
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
    ExtensionProperty,
    [
        attribute("name", "rtsExt:name", required=True),
        attribute("value", "rtsExt:value"),
    ],
)
_PROPERTIES = child("properties", "rtsExt:Properties", _PROPERTY, many=True)
_SEEN = (
    attribute("visible", "rtsExt:visible", FLAG),
    attribute("comment", "rtsExt:comment"),
)
_REF = (
    attribute("component_id", "rts:componentId", required=True),
    attribute("instance_name", "rts:instanceName", required=True),
)
_COMPONENT_REF = ElementSpec(m.ComponentRef, _REF)
_PARTICIPANTS = ElementSpec(
    _only,
    children=[child("participant", "rts:Participant", _COMPONENT_REF, least=1)],
    wraps="participant",
)
_PORT = (attribute("name", "rts:name", required=True), *_SEEN)
_DATA_PORT = ElementSpec(m.InstancePort, _PORT, [_PROPERTIES], xsi_type="rtsExt:dataport_ext")
_SERVICE_PORT = ElementSpec(m.InstancePort, _PORT, [_PROPERTIES], xsi_type="rtsExt:serviceport_ext")
_CONFIGURATION_SET = ElementSpec(
    m.ConfigurationSet,
    [attribute("id", "rts:id", required=True)],
    [
        child(
            "data",
            "rts:ConfigurationData",
            ElementSpec(
                m.ConfigurationData,
                [attribute("name", "rts:name", required=True), attribute("data", "rts:data")],
            ),
            many=True,
        )
    ],
)
_EXECUTION_CONTEXT = ElementSpec(
    m.OwnedContext,
    [
        attribute("id", "rts:id", supply=rules.position_among_siblings),
        attribute("kind", "rts:kind", supply="PERIODIC"),
        attribute("rate", "rts:rate", REAL),
    ],
    [
        child("participants", "rts:Participants", _PARTICIPANTS, many=True),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:execution_context_ext",
)
_LOCATION = ElementSpec(
    m.Location,
    [
        attribute("x", "rtsExt:x", WHOLE, supply="0"),
        attribute("y", "rtsExt:y", WHOLE, supply="0"),
        attribute("height", "rtsExt:height", WHOLE, supply="-1"),
        attribute("width", "rtsExt:width", WHOLE, supply="-1"),
        attribute("direction", "rtsExt:direction", words=DIRECTIONS, supply="DOWN"),
    ],
)
_COMPONENT = ElementSpec(
    m.ComponentInstance,
    [
        attribute("id", "rts:id", required=True),
        attribute("path_uri", "rts:pathUri", supply=""),
        attribute("instance_name", "rts:instanceName", required=True),
        attribute("is_required", "rts:isRequired", FLAG, supply="true"),
        attribute("active_configuration_set", "rts:activeConfigurationSet"),
        attribute(
            "composite_type",
            "rts:compositeType",
            words=COMPOSITE_TYPES,
            respellings=_OLD_COMPOSITES,
        ),
        *_SEEN,
    ],
    [
        child("data_ports", "rts:DataPorts", _DATA_PORT, many=True),
        child("service_ports", "rts:ServicePorts", _SERVICE_PORT, many=True),
        child("configuration_sets", "rts:ConfigurationSets", _CONFIGURATION_SET, many=True),
        child("execution_contexts", "rts:ExecutionContexts", _EXECUTION_CONTEXT, many=True),
        child("participants", "rts:Participants", _PARTICIPANTS, many=True),
        child("location", "rtsExt:Location", _LOCATION),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:component_ext",
)
_GROUP = ElementSpec(
    m.ComponentGroup,
    [attribute("group_id", "rts:groupId", required=True)],
    [child("members", "rts:Members", _COMPONENT_REF, many=True, least=1), _PROPERTIES],
)
_TARGET_PORT = ElementSpec(
    m.TargetPort,
    [*_REF, attribute("port_name", "rts:portName", required=True)],
    [_PROPERTIES],
    xsi_type="rtsExt:target_port_ext",
)
_CONNECTOR = (
    attribute("connector_id", "rts:connectorId", supply=rules.position_among_siblings),
    attribute("name", "rts:name", supply=""),
)
_DATA_CONNECTOR = ElementSpec(
    m.DataPortConnector,
    [
        *_CONNECTOR,
        attribute("data_type", "rts:dataType", supply=rules.property_or_empty("data_type")),
        attribute(
            "interface_type", "rts:interfaceType", supply=rules.property_or_empty("interface_type")
        ),
        attribute(
            "dataflow_type", "rts:dataflowType", supply=rules.property_or_empty("dataflow_type")
        ),
        attribute("subscription_type", "rts:subscriptionType"),
        attribute("push_interval", "rts:pushInterval", REAL),
        *_SEEN,
    ],
    [
        child("source", "rts:sourceDataPort", _TARGET_PORT, least=1),
        child("target", "rts:targetDataPort", _TARGET_PORT, least=1),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:dataport_connector_ext",
)
_SERVICE_CONNECTOR = ElementSpec(
    m.ServicePortConnector,
    [*_CONNECTOR, attribute("trans_method", "rts:transMethod"), *_SEEN],
    [
        child("source", "rts:sourceServicePort", _TARGET_PORT, least=1),
        child("target", "rts:targetServicePort", _TARGET_PORT, least=1),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:serviceport_connector_ext",
)
_TARGET_COMPONENT = ElementSpec(m.TargetComponent, [*_REF, attribute("id", "rts:id", supply="0")])
_PRECEDING = ElementSpec(
    m.Preceding,
    [
        attribute("timeout", "rts:timeout", WHOLE),
        attribute("sending_timing", "rts:sendingTiming", words=SENDING_TIMINGS),
    ],
    [child("preceding_components", "rts:PrecedingComponents", _TARGET_COMPONENT, many=True)],
)
_CONDITION = ElementSpec(
    m.OrderStep,
    [attribute("sequence", "rts:sequence", WHOLE, required=True)],
    [
        child(
            "wait_time",
            "rts:WaitTime",
            ElementSpec(m.WaitTime, [attribute("wait_time", "rts:waitTime", WHOLE, supply="0")]),
        ),
        child("preceding", "rts:Preceding", _PRECEDING),
        child("target_component", "rts:TargetComponent", _TARGET_COMPONENT, least=1),
        _PROPERTIES,
    ],
    xsi_type="rtsExt:condition_ext",
    rule=rules.precondition,
)
_ORDER = ElementSpec(m.Order, children=[child("targets", "rts:targets", _CONDITION, many=True)])
RTS_PROFILE = ElementSpec(
    m.RtsProfile,
    [
        attribute("id", "rts:id", required=True),
        attribute("version", "rts:version", supply=m.RTS_VERSION),
        attribute("abstract", "rts:abstract"),
        attribute("creation_date", "rts:creationDate", DATE, supply=rules.other_date),
        attribute("update_date", "rts:updateDate", DATE, supply=rules.other_date),
        attribute("comment", "rtsExt:comment"),
    ],
    [
        child("components", "rts:Components", _COMPONENT, many=True),
        child("groups", "rts:Groups", _GROUP, many=True),
        child("data_port_connectors", "rts:DataPortConnectors", _DATA_CONNECTOR, many=True),
        child(
            "service_port_connectors", "rts:ServicePortConnectors", _SERVICE_CONNECTOR, many=True
        ),
        *(child(field, f"rts:{name}", _ORDER) for field, name in ORDERS),
        child("version_up_logs", "rtsExt:VersionUpLogs", many=True),
        _PROPERTIES,
        child(
            "systems",
            "rtsExt:Systems",
            ElementSpec(m.NestedSystem, [attribute("path", "rtsExt:path", required=True)]),
            many=True,
        ),
    ],
    extended_type="rtsExt:rts_profile_ext",
    rule=rules.version_0_1,
    respellings={"Component": "Components", "VersionUpLog": "VersionUpLogs"},
)
