"""Derives the RTC profile of an existing component.

The code gives identity, ports, parameters, callbacks, states, and documentation in the places
where `rtkit.builder.component_code` puts it. Facts that no code has (component and activity type,
number of instances, positions of an editor) get the usual values.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping
from typing import Any

from rtkit.builder.component_code import LABELS, POSTCONDITION, PRECONDITION, SUMMARIES, neutral
from rtkit.builder.machine_of_profile import INITIAL
from rtkit.builder.settings import WIDGET
from rtkit.builder.source_text import sentence
from rtkit.component.base import Component
from rtkit.component.configuration.kinds import kind_of
from rtkit.component.configuration.parameter import Parameter
from rtkit.component.contexts.owned_contexts import kind_named
from rtkit.component.describe import describe
from rtkit.component.fsm import EventPort, FsmComponent
from rtkit.errors import Malformed
from rtkit.profile import rtc_model as rtc
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.constraint_model import Constraint
from rtkit.profile.constraint_text import parse_constraint
from rtkit.profile.words import SET
from rtkit.rtc.data_types import scoped_name
from rtkit.rtc.enums import ExecutionKind, PortType
from rtkit.rtc.profiles import PortProfile

_ACTIVITIES = {
    ExecutionKind.PERIODIC: "PERIODIC",
    ExecutionKind.EVENT_DRIVEN: "EVENTDRIVEN",
    ExecutionKind.OTHER: "SPORADIC",
}
_UNIT = re.compile(r"(.*?) ?\[([^\[\]]+)\]", re.DOTALL)
_FSM_ONLY = "on_action"


def profile_of(component: Component, date: str, properties: Mapping[str, str]) -> rtc.RtcProfile:
    """Return the RTC profile of a component.

    Args:
        component: An instance of it. Ports that it adds in on_initialize are included only
            where the instance is initialised.
        date: When the profile is made, ``xs:dateTime``.
        properties: Extension properties of the profile.
    """
    ports = describe(component).ports
    settings = tuple(map(_configuration, component.parameters_declared.values()))
    return rtc.RtcProfile(
        id=component.type.id,
        version=rtc.RTC_VERSION,
        basic_info=_basic_info(component, date, properties),
        actions=_actions(component),
        configuration_set=rtc.DeclaredParameters(settings) if settings else None,
        data_ports=tuple(
            _data_port(component, port) for port in ports if port.port_type is not PortType.SERVICE
        ),
        service_ports=tuple(
            _service_port(port) for port in ports if port.port_type is PortType.SERVICE
        ),
        language=rtc.Language("Python"),
    )


def _basic_info(component: Component, date: str, properties: Mapping[str, str]) -> rtc.BasicInfo:
    type, kind = component.type, kind_named(component.execution_type)
    description, doc = _documentation(component)
    return rtc.BasicInfo(
        name=type.type_name,
        component_type="STATIC",
        activity_type=_ACTIVITIES[kind],
        component_kind="DataFlowComponent",
        category=type.category,
        vendor=type.vendor,
        version=type.version,
        execution_type=component.execution_type,
        execution_rate=component.rate if kind is ExecutionKind.PERIODIC else None,
        max_instances=0,
        creation_date=date,
        update_date=date,
        description=description,
        doc=doc,
        properties=tuple(ExtensionProperty(name, value) for name, value in properties.items()),
    )


def _paragraphs(text: str | None) -> list[str]:
    return [part for part in re.split(r"\n\s*\n", inspect.cleandoc(text or "").strip()) if part]


def _labelled(part: str, label: str) -> str | None:
    """Return what a paragraph says behind its label, after which its line may have been cut."""
    head = label.rstrip()
    rest = part.removeprefix(head)
    return rest.lstrip() if part.startswith(head) and rest[:1].isspace() else None


def _documentation(component: Component) -> tuple[str, rtc.BasicDoc | None]:
    """Return the description in the docstring of the class, and its labelled paragraphs."""
    plain: list[str] = []
    fields: dict[str, Any] = {}
    for part in _paragraphs(vars(type(component)).get("__doc__")):
        found = {field: _labelled(part, label) for field, label in LABELS.items()}
        labelled = {field: text for field, text in found.items() if text is not None}
        fields |= labelled
        if not labelled:
            plain.append(part)
    if plain[:1] == [neutral(component.type.type_name)]:
        del plain[0]
    description = sentence(" ".join(plain[0].split())) if plain else ""
    if plain[1:]:
        fields["description"] = "\n\n".join(plain[1:])
    return description, rtc.BasicDoc(**fields) if fields else None


def _actions(component: Component) -> rtc.Actions:
    cls = type(component)
    base = FsmComponent if isinstance(component, FsmComponent) else Component
    fields: dict[str, Any] = {}
    for name in SUMMARIES:
        if name != _FSM_ONLY or base is FsmComponent:
            # Of one that holds an object of another class, the callbacks are those of the object.
            own = vars(component).get(name) or getattr(cls, name)
            is_own = own is not getattr(base, name)
            doc = _action_doc(name, own.__doc__) if is_own else None
            fields[name] = rtc.ActionStatus(is_own, doc)
    return rtc.Actions(**fields)


def _action_doc(name: str, text: str | None) -> rtc.ActionDoc | None:
    plain: list[str] = []
    fields: dict[str, Any] = {}
    for part in _paragraphs(text):
        if (before := _labelled(part, PRECONDITION)) is not None:
            fields["pre_condition"] = before
        elif (after := _labelled(part, POSTCONDITION)) is not None:
            fields["post_condition"] = after
        elif part != SUMMARIES[name]:
            plain.append(part)
    if plain:
        text = "\n\n".join(plain)
        fields["description"] = text if "\n" in text else sentence(text)
    return rtc.ActionDoc(**fields) if fields else None


def _configuration(parameter: Parameter[object]) -> rtc.ConfigurationParameter:
    kind = kind_of(parameter.default)  # type: ignore[arg-type]
    constraint, words = _constraint(parameter.constraint)
    doc = rtc.ConfigurationDoc(description=parameter.doc or None, constraint=words or None)
    return rtc.ConfigurationParameter(
        name=parameter.name,
        type=kind.name,
        default_value=kind.write(parameter.default),
        unit=parameter.unit or None,
        constraint=constraint,
        doc=doc if parameter.doc or words else None,
        properties=(
            *((ExtensionProperty(WIDGET, parameter.widget),) if parameter.widget else ()),
            *(ExtensionProperty(f"{SET}{name}", text) for name, text in parameter.sets.items()),
        ),
    )


def _constraint(text: str) -> tuple[Constraint | None, str]:
    """Return a constraint as far as it can be read, and the words of one that cannot."""
    try:
        return parse_constraint(text), ""
    except Malformed:
        return None, text


def _data_port(component: Component, port: PortProfile) -> rtc.DataPortDeclaration:
    is_event_port = isinstance(component.ports.get(port.name), EventPort)
    kind = "EventPort" if is_event_port else port.port_type.value
    text = port.properties.get("description", "")
    found = _UNIT.fullmatch(text)
    text, unit = (found[1], found[2]) if found else (text, "")
    events = tuple(_events(component, port.name)) if is_event_port else ()
    return rtc.DataPortDeclaration(
        port_type=kind,
        name=port.name,
        type=scoped_name(port.data_type) or "Any",
        position="RIGHT" if port.port_type is PortType.OUT else "LEFT",
        unit=unit or None,
        events=events,
        doc=rtc.DataPortDoc(description=text) if text else None,
    )


def _events(component: Component, port: str) -> Iterator[rtc.FsmTransition]:
    if not isinstance(component, FsmComponent) or component.event_port != port:
        return
    described = describe(component)
    states = component.states
    first = next(iter(states))
    yield rtc.FsmTransition("", INITIAL, first)
    for state, moves in states.items():
        for event, target in moves.items():
            kind = described.fsm_events.get(event, "Any")
            yield rtc.FsmTransition(event, state, target, type=kind)


def _service_port(port: PortProfile) -> rtc.ServicePortDeclaration:
    text = port.properties.get("description", "")
    return rtc.ServicePortDeclaration(
        name=port.name,
        position="RIGHT",
        service_interfaces=tuple(
            rtc.ServiceInterface(
                name=each.instance_name,
                direction=each.polarity.value,
                type=each.type_name,
                instance_name=each.instance_name,
            )
            for each in port.interfaces
        ),
        doc=rtc.ServicePortDoc(description=text) if text else None,
    )
