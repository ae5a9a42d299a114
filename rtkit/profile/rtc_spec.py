"""The RTC profile in XML: which class, field and element belong together."""

from __future__ import annotations

from rtkit.fast_dataclass import fields
from rtkit.profile import constraint_model as c
from rtkit.profile import rtc_model as m
from rtkit.profile import rtc_rules as rules
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_rules import other_date, present_version
from rtkit.profile.spec import (
    DATE,
    FLAG,
    REAL,
    WHOLE,
    Child,
    ElementSpec,
    attribute,
    child,
    local_name,
    required,
)

COMPONENT_TYPES = ("STATIC", "UNIQUE", "COMMUTATIVE")
PORT_TYPES = ("DataInPort", "DataOutPort", "EventPort")
POSITIONS = ("LEFT", "RIGHT", "TOP", "BOTTOM")
DIRECTIONS = ("Provided", "Required")
ACTIONS = {item.name: local_name(item.name) for item in fields(m.Actions) if item.name != "foreign"}
"""Name of each callback, ``onInitialize``, by its field."""
COMPARISONS = (
    "propertyIsEqualTo",
    "propertyIsNotEqualTo",
    "propertyIsLessThan",
    "propertyIsGreaterThan",
    "propertyIsLessThanOrEqualTo",
    "propertyIsGreaterThanOrEqualTo",
)
_VARIABLE = {"varname": "variableName"}


def _doc(make: type) -> Child:
    names = [f"rtcDoc:{local_name(item.name)}" for item in fields(make) if item.name != "foreign"]
    return child("rtcDoc:Doc", ElementSpec(make, names, respellings={"occurrence": "occerrence"}))


_PROPERTIES = child(
    "rtcExt:Properties",
    ElementSpec(ExtensionProperty, [attribute("rtcExt:name", required=True), "rtcExt:value"]),
    many=True,
)
_NAMED = ("rtcExt:variableName", "rtcExt:comment")

_CONSTRAINT = ElementSpec(c.Constraint)
_CONSTRAINTS = child("rtc:Constraint", _CONSTRAINT, field="constraints", many=True)
_COMPARISON = ElementSpec(
    c.Comparison,
    [attribute("rtc:matchCase", FLAG, supply="false")],
    [child("rtc:Literal", least=1)],
    tag_field="kind",
)
_LIKE = ElementSpec(
    c.Like,
    [*required("rtc:wildCard", "rtc:singleChar", "rtc:escapeChar")],
    [child("rtc:Literal", least=1)],
    tag_field="kind",
)
_BETWEEN = ElementSpec(
    c.Between,
    children=[child("rtc:LowerBoundary", least=1), child("rtc:UpperBoundary", least=1)],
    tag_field="kind",
)
_NOT = ElementSpec(
    c.Logical,
    children=[child("rtc:Constraint", _CONSTRAINT, field="constraints", many=True, least=1)],
    tag_field="kind",
    rule=rules.only_one,
)
_LOGICAL = ElementSpec(
    c.Logical,
    children=[child("rtc:Constraint", _CONSTRAINT, field="constraints", many=True, least=2)],
    tag_field="kind",
)
_UNIT = ElementSpec(
    c.ConstraintUnit,
    ["rtc:key"],
    [
        child("rtc:Not", _NOT, field="test", least=1),
        *(child(f"rtc:{name}", _LOGICAL, field="test", least=1) for name in ("And", "Or")),
        child(
            "rtc:propertyIsNullType", ElementSpec(c.IsNull, tag_field="kind"), field="test", least=1
        ),
        *(child(f"rtc:{name}", _COMPARISON, field="test", least=1) for name in COMPARISONS),
        child("rtc:propertyIsLike", _LIKE, field="test", least=1),
        child("rtc:propertyIsBetween", _BETWEEN, field="test", least=1),
    ],
    tag_field="kind",
)
_GROUP = ElementSpec(c.ConstraintGroup, children=[_CONSTRAINTS], tag_field="kind")
_CONSTRAINT.add_children(
    [
        child("rtc:ConstraintHashType", _GROUP, field="content", least=1),
        child("rtc:ConstraintListType", _GROUP, field="content", least=1),
        child("rtc:ConstraintUnitType", _UNIT, field="content", least=1),
    ]
)
_ONE_CONSTRAINT = child("rtc:Constraint", _CONSTRAINT)

_BASIC_INFO = ElementSpec(
    m.BasicInfo,
    [
        attribute("rtc:name", required=True),
        attribute("rtc:componentType", words=COMPONENT_TYPES, supply="STATIC"),
        attribute("rtc:activityType", words=rules.ACTIVITY_TYPES, supply="PERIODIC"),
        attribute("rtc:componentKind", supply="DataFlowComponent"),
        "rtc:rtcType",
        attribute("rtc:category", supply=""),
        attribute("rtc:vendor", supply=""),
        attribute("rtc:version", supply=""),
        "rtc:description",
        "rtc:abstract",
        "rtc:hardwareProfile",
        attribute("rtc:executionType", supply="PeriodicExecutionContext"),
        attribute("rtc:executionRate", REAL),
        attribute("rtc:maxInstances", WHOLE),
        attribute("rtc:creationDate", DATE, supply=other_date),
        attribute("rtc:updateDate", DATE, supply=other_date),
        "rtcExt:comment",
        "rtcExt:saveProject",
    ],
    [_doc(m.BasicDoc), child("rtcExt:VersionUpLogs", many=True), _PROPERTIES],
    xsi_type="rtcExt:basic_info_ext",
    also_types=["rtcDoc:basic_info_doc"],
    rule=rules.basic_info,
    respellings={"VersionUpLog": "VersionUpLogs"},
)
_ACTION = ElementSpec(
    m.ActionStatus,
    [attribute("rtc:implemented", FLAG, supply="false")],
    [_doc(m.ActionDoc)],
    xsi_type="rtcDoc:action_status_doc",
)
_CONFIGURATION = ElementSpec(
    m.ConfigurationParameter,
    [
        *required("rtc:name", "rtc:type"),
        attribute("rtc:defaultValue", supply=""),
        "rtc:unit",
        *_NAMED,
    ],
    [_ONE_CONSTRAINT, _doc(m.ConfigurationDoc), _PROPERTIES],
    xsi_type="rtcExt:configuration_ext",
    also_types=["rtcDoc:configuration_doc"],
    rule=rules.fragment_configuration,
    respellings=_VARIABLE,
)
_EVENT = ElementSpec(
    m.FsmTransition,
    [*required("rtc:name", "rtc:source", "rtc:target"), "rtc:condition", "rtc:type"],
    [_doc(m.EventDoc)],
    xsi_type="rtcDoc:event_doc",
)
_DATA_PORT = ElementSpec(
    m.DataPortDeclaration,
    [
        attribute(
            "rtc:portType",
            words=PORT_TYPES,
            required=True,
            respellings={"in": "DataInPort", "out": "DataOutPort", "event": "EventPort"},
        ),
        *required("rtc:name", "rtc:type"),
        "rtc:idlFile",
        "rtc:interfaceType",
        "rtc:dataflowType",
        "rtc:subscriptionType",
        "rtc:unit",
        attribute("rtcExt:position", words=POSITIONS, supply=rules.usual_position),
        *_NAMED,
    ],
    [
        _ONE_CONSTRAINT,
        child("rtc:Event", _EVENT, field="events", many=True),
        _doc(m.DataPortDoc),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:dataport_ext",
    also_types=["rtcDoc:dataport_doc"],
    respellings=_VARIABLE | {"subscriprionType": "subscriptionType"},
)
_SERVICE_INTERFACE = ElementSpec(
    m.ServiceInterface,
    [
        attribute("rtc:name", required=True),
        attribute("rtc:direction", words=DIRECTIONS, required=True),
        attribute("rtc:type", required=True),
        "rtc:instanceName",
        "rtc:idlFile",
        "rtc:path",
        *_NAMED,
    ],
    [_doc(m.ServiceInterfaceDoc), _PROPERTIES],
    xsi_type="rtcExt:serviceinterface_ext",
    also_types=["rtcDoc:serviceinterface_doc"],
    respellings=_VARIABLE,
)
_SERVICE_PORT = ElementSpec(
    m.ServicePortDeclaration,
    [
        attribute("rtc:name", required=True),
        attribute("rtcExt:position", words=POSITIONS, supply="LEFT"),
        "rtcExt:comment",
    ],
    [
        child("rtc:ServiceInterface", _SERVICE_INTERFACE, field="service_interfaces", many=True),
        child(
            "rtc:TransMethods",
            ElementSpec(m.TransMethod, [attribute("rtc:kind", required=True)]),
            many=True,
        ),
        _doc(m.ServicePortDoc),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:serviceport_ext",
    also_types=["rtcDoc:serviceport_doc"],
)
_LIBRARY = ElementSpec(
    m.Library, [attribute("rtcExt:name", required=True), "rtcExt:version", "rtcExt:other"]
)
_TARGET = ElementSpec(
    m.TargetEnvironment,
    ["rtcExt:langVersion", "rtcExt:os", "rtcExt:other", "rtcExt:cpuOther"],
    [
        child("rtcExt:osVersions", many=True),
        child("rtcExt:cpus", many=True),
        child("rtcExt:libraries", _LIBRARY, many=True),
    ],
)
_LANGUAGE = ElementSpec(
    m.Language,
    [attribute("rtc:kind", supply="")],
    [child("rtcExt:targets", _TARGET, many=True), _PROPERTIES],
    xsi_type="rtcExt:language_ext",
    rule=rules.nested_language,
)
RTC_PROFILE = ElementSpec(
    m.RtcProfile,
    [attribute("rtc:id", supply=rules.composed_id), attribute("rtc:version", supply=m.RTC_VERSION)],
    [
        child("rtc:BasicInfo", _BASIC_INFO),
        child(
            "rtc:Actions",
            ElementSpec(
                m.Actions,
                children=[child(f"rtc:O{name[1:]}", _ACTION) for name in ACTIONS.values()],
            ),
        ),
        child(
            "rtc:ConfigurationSet",
            ElementSpec(
                m.DeclaredParameters,
                children=[
                    child("rtc:Configuration", _CONFIGURATION, field="configurations", many=True)
                ],
            ),
        ),
        child("rtc:DataPorts", _DATA_PORT, many=True),
        child("rtc:ServicePorts", _SERVICE_PORT, many=True),
        child(
            "rtc:Parameters",
            ElementSpec(
                m.SystemParameter, [attribute("rtc:name", required=True), "rtc:defaultValue"]
            ),
            many=True,
        ),
        child("rtc:Language", _LANGUAGE),
    ],
    rule=present_version,
)
