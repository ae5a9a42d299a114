"""The RTC profile in XML: which class, field and element belong together."""

from __future__ import annotations

from rtkit.profile import constraint_model as c
from rtkit.profile import rtc_doc_model as d
from rtkit.profile import rtc_model as m
from rtkit.profile import rtc_rules as rules
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_rules import other_date, present_version
from rtkit.profile.spec import DATE, FLAG, REAL, WHOLE, Attr, Child, ElementSpec, attribute, child

COMPONENT_TYPES = ("STATIC", "UNIQUE", "COMMUTATIVE")
PORT_TYPES = ("DataInPort", "DataOutPort", "EventPort")
POSITIONS = ("LEFT", "RIGHT", "TOP", "BOTTOM")
DIRECTIONS = ("Provided", "Required")
ACTIONS = (
    ("on_initialize", "OnInitialize"),
    ("on_finalize", "OnFinalize"),
    ("on_startup", "OnStartup"),
    ("on_shutdown", "OnShutdown"),
    ("on_activated", "OnActivated"),
    ("on_deactivated", "OnDeactivated"),
    ("on_aborting", "OnAborting"),
    ("on_error", "OnError"),
    ("on_reset", "OnReset"),
    ("on_execute", "OnExecute"),
    ("on_state_update", "OnStateUpdate"),
    ("on_rate_changed", "OnRateChanged"),
    ("on_action", "OnAction"),
    ("on_mode_changed", "OnModeChanged"),
)
COMPARISONS = (
    "propertyIsEqualTo",
    "propertyIsNotEqualTo",
    "propertyIsLessThan",
    "propertyIsGreaterThan",
    "propertyIsLessThanOrEqualTo",
    "propertyIsGreaterThanOrEqualTo",
)
_VARIABLE = {"varname": "variableName"}


def _texts(namespace: str, **names: str) -> list[Attr]:
    return [attribute(field, f"{namespace}:{name}") for field, name in names.items()]


def _doc(make: type, **names: str) -> Child:
    spec = ElementSpec(make, _texts("rtcDoc", **names), respellings={"occurrence": "occerrence"})
    return child("doc", "rtcDoc:Doc", spec)


_PROPERTIES = child(
    "properties",
    "rtcExt:Properties",
    ElementSpec(
        ExtensionProperty,
        [attribute("name", "rtcExt:name", required=True), attribute("value", "rtcExt:value")],
    ),
    many=True,
)
_VARIABLE_NAME = attribute("variable_name", "rtcExt:variableName")
_COMMENT = attribute("comment", "rtcExt:comment")

_CONSTRAINT = ElementSpec(c.Constraint)
_CONSTRAINTS = child("constraints", "rtc:Constraint", _CONSTRAINT, many=True)
_COMPARISON = ElementSpec(
    c.Comparison,
    [attribute("match_case", "rtc:matchCase", FLAG, supply="false")],
    [child("literal", "rtc:Literal", least=1)],
    tag_field="kind",
)
_LIKE = ElementSpec(
    c.Like,
    [
        attribute("wild_card", "rtc:wildCard", required=True),
        attribute("single_char", "rtc:singleChar", required=True),
        attribute("escape_char", "rtc:escapeChar", required=True),
    ],
    [child("literal", "rtc:Literal", least=1)],
    tag_field="kind",
)
_BETWEEN = ElementSpec(
    c.Between,
    children=[
        child("lower_boundary", "rtc:LowerBoundary", least=1),
        child("upper_boundary", "rtc:UpperBoundary", least=1),
    ],
    tag_field="kind",
)
_NOT = ElementSpec(
    c.Logical,
    children=[child("constraints", "rtc:Constraint", _CONSTRAINT, many=True, least=1)],
    tag_field="kind",
    rule=rules.only_one,
)
_LOGICAL = ElementSpec(
    c.Logical,
    children=[child("constraints", "rtc:Constraint", _CONSTRAINT, many=True, least=2)],
    tag_field="kind",
)
_UNIT = ElementSpec(
    c.ConstraintUnit,
    [attribute("key", "rtc:key")],
    [
        child("test", "rtc:Not", _NOT, least=1),
        *(child("test", f"rtc:{name}", _LOGICAL, least=1) for name in ("And", "Or")),
        child("test", "rtc:propertyIsNullType", ElementSpec(c.IsNull, tag_field="kind"), least=1),
        *(child("test", f"rtc:{name}", _COMPARISON, least=1) for name in COMPARISONS),
        child("test", "rtc:propertyIsLike", _LIKE, least=1),
        child("test", "rtc:propertyIsBetween", _BETWEEN, least=1),
    ],
    tag_field="kind",
)
_GROUP = ElementSpec(c.ConstraintGroup, children=[_CONSTRAINTS], tag_field="kind")
_CONSTRAINT.add_children(
    [
        child("content", "rtc:ConstraintHashType", _GROUP, least=1),
        child("content", "rtc:ConstraintListType", _GROUP, least=1),
        child("content", "rtc:ConstraintUnitType", _UNIT, least=1),
    ]
)
_ONE_CONSTRAINT = child("constraint", "rtc:Constraint", _CONSTRAINT)

_BASIC_INFO = ElementSpec(
    m.BasicInfo,
    [
        attribute("name", "rtc:name", required=True),
        attribute("component_type", "rtc:componentType", words=COMPONENT_TYPES, supply="STATIC"),
        attribute(
            "activity_type", "rtc:activityType", words=rules.ACTIVITY_TYPES, supply="PERIODIC"
        ),
        attribute("component_kind", "rtc:componentKind", supply="DataFlowComponent"),
        attribute("rtc_type", "rtc:rtcType"),
        attribute("category", "rtc:category", supply=""),
        attribute("vendor", "rtc:vendor", supply=""),
        attribute("version", "rtc:version", supply=""),
        *_texts(
            "rtc",
            description="description",
            abstract="abstract",
            hardware_profile="hardwareProfile",
        ),
        attribute("execution_type", "rtc:executionType", supply="PeriodicExecutionContext"),
        attribute("execution_rate", "rtc:executionRate", REAL),
        attribute("max_instances", "rtc:maxInstances", WHOLE),
        attribute("creation_date", "rtc:creationDate", DATE, supply=other_date),
        attribute("update_date", "rtc:updateDate", DATE, supply=other_date),
        _COMMENT,
        attribute("save_project", "rtcExt:saveProject"),
    ],
    [
        _doc(
            d.BasicDoc,
            description="description",
            inout="inout",
            algorithm="algorithm",
            creator="creator",
            license="license",
            reference="reference",
        ),
        child("version_up_logs", "rtcExt:VersionUpLogs", many=True),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:basic_info_ext",
    also_types=["rtcDoc:basic_info_doc"],
    rule=rules.basic_info,
    respellings={"VersionUpLog": "VersionUpLogs"},
)
_ACTION = ElementSpec(
    m.ActionStatus,
    [attribute("implemented", "rtc:implemented", FLAG, supply="false")],
    [
        _doc(
            d.ActionDoc,
            description="description",
            pre_condition="preCondition",
            post_condition="postCondition",
        )
    ],
    xsi_type="rtcDoc:action_status_doc",
)
_CONFIGURATION = ElementSpec(
    m.ConfigurationParameter,
    [
        attribute("name", "rtc:name", required=True),
        attribute("type", "rtc:type", required=True),
        attribute("default_value", "rtc:defaultValue", supply=""),
        attribute("unit", "rtc:unit"),
        _VARIABLE_NAME,
        _COMMENT,
    ],
    [
        _ONE_CONSTRAINT,
        _doc(
            d.ConfigurationDoc,
            dataname="dataname",
            default_value="defaultValue",
            description="description",
            unit="unit",
            range="range",
            constraint="constraint",
        ),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:configuration_ext",
    also_types=["rtcDoc:configuration_doc"],
    rule=rules.fragment_configuration,
    respellings=_VARIABLE,
)
_EVENT = ElementSpec(
    m.FsmTransition,
    [
        attribute("name", "rtc:name", required=True),
        attribute("source", "rtc:source", required=True),
        attribute("target", "rtc:target", required=True),
        *_texts("rtc", condition="condition", type="type"),
    ],
    [
        _doc(
            d.EventDoc,
            description="description",
            type="type",
            number="number",
            semantics="semantics",
            unit="unit",
            operation="operation",
        )
    ],
    xsi_type="rtcDoc:event_doc",
)
_DATA_PORT = ElementSpec(
    m.DataPortDeclaration,
    [
        attribute(
            "port_type",
            "rtc:portType",
            words=PORT_TYPES,
            required=True,
            respellings={"in": "DataInPort", "out": "DataOutPort", "event": "EventPort"},
        ),
        attribute("name", "rtc:name", required=True),
        attribute("type", "rtc:type", required=True),
        *_texts(
            "rtc",
            idl_file="idlFile",
            interface_type="interfaceType",
            dataflow_type="dataflowType",
            subscription_type="subscriptionType",
            unit="unit",
        ),
        attribute("position", "rtcExt:position", words=POSITIONS, supply=rules.usual_position),
        _VARIABLE_NAME,
        _COMMENT,
    ],
    [
        _ONE_CONSTRAINT,
        child("events", "rtc:Event", _EVENT, many=True),
        _doc(
            d.DataPortDoc,
            description="description",
            type="type",
            number="number",
            semantics="semantics",
            unit="unit",
            occerrence="occerrence",
            operation="operation",
        ),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:dataport_ext",
    also_types=["rtcDoc:dataport_doc"],
    respellings=_VARIABLE | {"subscriprionType": "subscriptionType"},
)
_SERVICE_INTERFACE = ElementSpec(
    m.ServiceInterface,
    [
        attribute("name", "rtc:name", required=True),
        attribute("direction", "rtc:direction", words=DIRECTIONS, required=True),
        attribute("type", "rtc:type", required=True),
        *_texts("rtc", instance_name="instanceName", idl_file="idlFile", path="path"),
        _VARIABLE_NAME,
        _COMMENT,
    ],
    [
        _doc(
            d.ServiceInterfaceDoc,
            description="description",
            doc_argument="docArgument",
            doc_return="docReturn",
            doc_exception="docException",
            doc_pre_condition="docPreCondition",
            doc_post_condition="docPostCondition",
        ),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:serviceinterface_ext",
    also_types=["rtcDoc:serviceinterface_doc"],
    respellings=_VARIABLE,
)
_SERVICE_PORT = ElementSpec(
    m.ServicePortDeclaration,
    [
        attribute("name", "rtc:name", required=True),
        attribute("position", "rtcExt:position", words=POSITIONS, supply="LEFT"),
        _COMMENT,
    ],
    [
        child("service_interfaces", "rtc:ServiceInterface", _SERVICE_INTERFACE, many=True),
        child(
            "trans_methods",
            "rtc:TransMethods",
            ElementSpec(m.TransMethod, [attribute("kind", "rtc:kind", required=True)]),
            many=True,
        ),
        _doc(d.ServicePortDoc, description="description", ifdescription="ifdescription"),
        _PROPERTIES,
    ],
    xsi_type="rtcExt:serviceport_ext",
    also_types=["rtcDoc:serviceport_doc"],
)
_LIBRARY = ElementSpec(
    m.Library,
    [
        attribute("name", "rtcExt:name", required=True),
        *_texts("rtcExt", version="version", other="other"),
    ],
)
_TARGET = ElementSpec(
    m.TargetEnvironment,
    _texts("rtcExt", lang_version="langVersion", os="os", other="other", cpu_other="cpuOther"),
    [
        child("os_versions", "rtcExt:osVersions", many=True),
        child("cpus", "rtcExt:cpus", many=True),
        child("libraries", "rtcExt:libraries", _LIBRARY, many=True),
    ],
)
_LANGUAGE = ElementSpec(
    m.Language,
    [attribute("kind", "rtc:kind", supply="")],
    [child("targets", "rtcExt:targets", _TARGET, many=True), _PROPERTIES],
    xsi_type="rtcExt:language_ext",
    rule=rules.nested_language,
)
RTC_PROFILE = ElementSpec(
    m.RtcProfile,
    [
        attribute("id", "rtc:id", supply=rules.composed_id),
        attribute("version", "rtc:version", supply=m.RTC_VERSION),
    ],
    [
        child("basic_info", "rtc:BasicInfo", _BASIC_INFO),
        child(
            "actions",
            "rtc:Actions",
            ElementSpec(
                m.Actions,
                children=[child(field, f"rtc:{name}", _ACTION) for field, name in ACTIONS],
            ),
        ),
        child(
            "configuration_set",
            "rtc:ConfigurationSet",
            ElementSpec(
                m.DeclaredParameters,
                children=[child("configurations", "rtc:Configuration", _CONFIGURATION, many=True)],
            ),
        ),
        child("data_ports", "rtc:DataPorts", _DATA_PORT, many=True),
        child("service_ports", "rtc:ServicePorts", _SERVICE_PORT, many=True),
        child(
            "parameters",
            "rtc:Parameters",
            ElementSpec(
                m.SystemParameter,
                [
                    attribute("name", "rtc:name", required=True),
                    attribute("default_value", "rtc:defaultValue"),
                ],
            ),
            many=True,
        ),
        child("language", "rtc:Language", _LANGUAGE),
    ],
    rule=present_version,
)
