"""Generates the Python module of a component."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.builder import standard_types
from rtkit.builder.methods import documentation, signature
from rtkit.builder.regions import CODE_STAMP, region
from rtkit.builder.source_layout import (
    CallExpression,
    Node,
    PlainExpression,
    assigned,
    chained,
    constant,
    mapping,
)
from rtkit.builder.source_layout import lines as lines_of
from rtkit.builder.source_text import INDENT, clean, doc_text, docstring, one_line, width
from rtkit.builder.subject import (
    GeneratedComponent,
    GeneratedInterface,
    GeneratedParameter,
    GeneratedPort,
    GeneratedServicePort,
    GeneratedStateMachine,
    StateClass,
)
from rtkit.builder.types_code import TypesCode
from rtkit.component.contexts.owned_contexts import PERIODIC
from rtkit.profile.rtc_model import ActionDoc

BODY = INDENT * 2
SUMMARIES = {
    "on_initialize": "Prepare, once, before anything else.",
    "on_finalize": "Clean up, once, at the end.",
    "on_startup": "React to the start of an execution context.",
    "on_shutdown": "React to the stop of an execution context.",
    "on_activated": "Go from Inactive to Active.",
    "on_deactivated": "Go from Active to Inactive.",
    "on_aborting": "Enter Error, once, after a failure.",
    "on_error": "Wait in Error, every period.",
    "on_reset": "Go from Error to Inactive.",
    "on_execute": "Do the work of one period.",
    "on_state_update": "Publish new state, after all participants executed.",
    "on_rate_changed": "React to a new rate of the execution context.",
    "on_action": "React to a transition of the state machine.",
}
"""Default summary of each callback, used where the profile has none."""

PRECONDITION, POSTCONDITION = "Precondition: ", "Postcondition: "
LABELS = {
    "inout": "Input and output: ",
    "algorithm": "Algorithm: ",
    "creator": "Author: ",
    "license": "License: ",
    "reference": "Reference: ",
}
"""Label that begins each paragraph about a component, by field of the profile."""

_WIDEST_HEAD = 80
_DRIVEN = ("on_activated", "on_execute")
_UNHURRIED = ("on_initialize", "on_finalize")


def neutral(type_name: str) -> str:
    """Return the first line of a component's documentation when it has none of its own."""
    text = f"Component {one_line(type_name)}."
    return text if width(text) <= _WIDEST_HEAD else "A component."


def component_code(subject: GeneratedComponent, types: TypesCode) -> str:
    """Return the source of the module, not yet stamped."""
    lines = [
        *docstring("A component type, made from its RTC profile.", _headline(subject)),
        "",
        CODE_STAMP,
        "",
        "from __future__ import annotations",
        "",
        *_imports(subject),
        "",
        "# isort: split",
        *region("imports", ""),
    ]
    for service in subject.services:
        for offer in service.offers:
            if offer.servant:
                lines += ["", "", *_servant(service, offer, subject, types)]
    for each in subject.machine.classes if subject.machine else ():
        lines += ["", "", *_state_class(each, subject)]
    lines += ["", "", *_class(subject, types)]
    lines += ["", "", *_init(subject), ""]
    return "\n".join(lines)


def _headline(subject: GeneratedComponent) -> str:
    return f"Component type {one_line(subject.type_name)}, made from its RTC profile"


def _imports(subject: GeneratedComponent) -> Iterator[str]:
    typing = ["TYPE_CHECKING"] if subject.has_types else []
    typing += ["Any", "ClassVar"] if subject.machine else []
    if typing:
        yield f"from typing import {', '.join(typing)}"
        yield ""
    yield "from rtkit import component as rt"
    kinds = [each.type for each in subject.ports]
    kinds += [each.type for each in subject.machine.events] if subject.machine else []
    if any(kind.startswith("images.") for kind in kinds):
        yield standard_types.IMAGES
    if subject.has_types:
        yield ""
        yield "if TYPE_CHECKING or not __package__:"
        yield f"{INDENT}import {subject.types_module} as idl"
        yield "else:  # installed, where other packages may have a module of this name"
        yield f"{INDENT}from . import {subject.types_module} as idl"


def _class(subject: GeneratedComponent, types: TypesCode) -> list[str]:
    base = "FsmComponent" if subject.machine else "Component"
    doc = subject.info.doc
    more = [f"{LABELS[key]}{text}" for key in LABELS if (text := clean(doc_text(doc, key)))]
    lines = [f"class {subject.class_name}(rt.{base}):"]
    lines += docstring(
        neutral(subject.type_name),
        subject.info.description,
        [doc_text(doc, "description"), *more],
        INDENT,
    )
    blocks = [
        list(_identity(subject)),
        list(_machine(subject.machine)) if subject.machine else [],
        [line for each in subject.ports for line in _port(each)],
        [line for each in subject.services for line in _service(each)],
        [line for each in subject.settings for line in _setting(each)],
        *_callbacks(subject),
        *_operations(subject, types),
        [*_others(subject), *region("members", INDENT)],
    ]
    for block in blocks:
        lines += ["", *block] if block else []
    return lines


def _identity(subject: GeneratedComponent) -> Iterator[str]:
    info = subject.info
    texts = {"vendor": info.vendor, "category": info.category, "version": info.version}
    if subject.type_name != subject.class_name:
        texts = {"type_name": subject.type_name, **texts}
    if subject.execution_type != PERIODIC or subject.machine:
        texts["execution_type"] = subject.execution_type
    for name, text in texts.items():
        if text:
            yield from assigned(name, text)
    if subject.rate:
        yield f"{INDENT}rate = {subject.rate!r}  # Hz"


def _machine(machine: GeneratedStateMachine) -> Iterator[str]:
    yield from assigned("event_port", machine.port)
    yield from mapping("states: ClassVar", dict(machine.states))
    if machine.events:
        events = {each.name: PlainExpression(each.type) for each in machine.events}
        yield from mapping("events: ClassVar", events)
    classes = {each.state: PlainExpression(each.name) for each in machine.classes}
    yield from mapping("state_classes: ClassVar", classes)


def _named(attribute: str, name: str) -> list[tuple[str, Node]]:
    """Return the argument that says the name, unless the attribute says it already."""
    return [] if attribute.rstrip("_") == name else [("name", name)]


def port_doc(port: GeneratedPort) -> str:
    """Return the purpose of a data port, with its unit."""
    profile = port.profile
    text = one_line(doc_text(profile.doc, "description") or profile.comment)
    unit = one_line(profile.unit or doc_text(profile.doc, "unit"))
    return f"{text} [{unit}]".strip() if unit and f"[{unit}]" not in text else text


def _port(port: GeneratedPort) -> list[str]:
    given: list[tuple[str, Node]] = (
        [] if port.kind == "EventPort" else [("", PlainExpression(port.type))]
    )
    given += _named(port.attribute, port.name)
    if port.type == "bytes" and port.type_name != "any":
        given.append(("properties", {"dataport.data_type": port.type_name}))
    text = port_doc(port)
    given += [("doc", text)] if text else []
    return assigned(port.attribute, CallExpression(f"rt.{port.kind}", given))


def service_doc(service: GeneratedServicePort) -> str:
    """Return the purpose of a service port."""
    profile = service.profile
    texts = [doc_text(profile.doc, "description"), doc_text(profile.doc, "ifdescription")]
    texts += [doc_text(each.doc, "description") for each in profile.service_interfaces]
    return next(filter(None, map(one_line, [*texts, profile.comment])), "")


def _service(service: GeneratedServicePort) -> list[str]:
    text = service_doc(service)
    named = _named(service.attribute, service.name)
    doc: list[tuple[str, Node]] = [("doc", text)] if text else []
    called = [each for each in service.offers if each.protocol]
    described = [each for each in service.offers if not each.protocol]
    if len(service.offers) == 1 and called:
        kind = "provided" if called[0].is_provided else "required"
        given = [*_offer(called[0], service.name), *named, *doc]
        return assigned(service.attribute, CallExpression(f"rt.ServicePort.{kind}", given))
    if described:
        named = [*named, ("interfaces", tuple(_described(each) for each in described))]
    steps = [
        CallExpression(
            f".{'provide' if each.is_provided else 'require'}", _offer(each, service.name)
        )
        for each in called
    ]
    return chained(service.attribute, [CallExpression("rt.ServicePort", [*named, *doc]), *steps])


def _offer(offer: GeneratedInterface, port: str) -> list[tuple[str, Node]]:
    given: list[tuple[str, Node]] = [("", PlainExpression(offer.protocol))]
    if offer.name and offer.name != port:
        given.append(("", offer.name))
    if offer.servant:
        given.append(("implementation", PlainExpression(offer.servant)))
    if offer.type_name != offer.protocol.removeprefix("idl."):
        given.append(("type_name", offer.type_name))
    return given


def _described(offer: GeneratedInterface) -> Node:
    """Return an interface known by name only, whose operations no definition declares."""
    polarity = PlainExpression(f"rt.Polarity.{'PROVIDED' if offer.is_provided else 'REQUIRED'}")
    given: list[tuple[str, Node]] = [("", offer.name), ("", offer.type_name), ("", polarity)]
    return CallExpression("rt.PortInterfaceProfile", given)


def _setting(setting: GeneratedParameter) -> list[str]:
    given = [("", constant(setting.default)), *_named(setting.attribute, setting.name)]
    for keyword in ("unit", "doc", "constraint", "widget"):
        text = getattr(setting, keyword)
        given += [(keyword, text)] if text else []
    sets = {name: constant(value) for name, value in setting.sets.items()}
    given += [("sets", sets)] if sets else []
    return assigned(setting.attribute, CallExpression("rt.Parameter", given))


def _callbacks(subject: GeneratedComponent) -> Iterator[list[str]]:
    for each in subject.callbacks:
        given = "" if each.name in _UNHURRIED else ", context: str"
        is_driven = subject.machine is not None and each.name in _DRIVEN
        yield [
            f"{INDENT}def {each.name}(self{given}) -> None:",
            *callback_doc(each.name, each.status.doc),
            *region(each.name, BODY, _beginning(subject, each.name)),
            *([f"{BODY}super().{each.name}(context)"] if is_driven else []),
        ]
    if subject.machine:
        yield from _machine_callbacks(subject.machine)


def _beginning(subject: GeneratedComponent, callback: str) -> list[str]:
    return [BODY + line for line in subject.working] if callback == "on_execute" else []


def _others(subject: GeneratedComponent) -> Iterator[str]:
    """Yield the callbacks that the profile does not ask for, as comments to copy from."""
    there = {each.name for each in subject.callbacks}
    if subject.machine:
        there |= {*_DRIVEN}
    names = [name for name in SUMMARIES if name not in there]
    if subject.machine is None:
        names.remove("on_action")
    yield f"{INDENT}# Callbacks that the profile does not ask for, to be copied between the marks:"
    for name in names:
        given = "" if name in _UNHURRIED else ", context: str"
        yield f"{INDENT}# def {name}(self{given}) -> None: ..."


def callback_doc(name: str, doc: ActionDoc | None) -> list[str]:
    """Return the docstring of a callback."""
    before, after = clean(doc_text(doc, "pre_condition")), clean(doc_text(doc, "post_condition"))
    more = [f"{PRECONDITION}{before}"] if before else []
    more += [f"{POSTCONDITION}{after}"] if after else []
    return docstring(SUMMARIES[name], doc_text(doc, "description"), more, BODY)


def _machine_callbacks(machine: GeneratedStateMachine) -> Iterator[list[str]]:
    conditions = ["Conditions of the profile:\n" + "\n".join(machine.conditions)]
    for name, summary in (("on_entry", "Enter a state."), ("on_exit", "Leave a state.")):
        yield [
            f"{INDENT}def {name}(self, state: str) -> None:",
            f'{BODY}"""{summary}"""',
            *region(name, BODY),
            f"{BODY}super().{name}(state)",
        ]
    yield [
        f"{INDENT}def on_event(self, event: str, value: Any) -> str | None:",
        *docstring(
            "Take an event; return another state than the table says, or None.",
            "",
            conditions if machine.conditions else [],
            BODY,
        ),
        *region("on_event", BODY, [f"{BODY}return super().on_event(event, value)"]),
    ]


def _state_class(each: StateClass, subject: GeneratedComponent) -> Iterator[str]:
    events = subject.machine.events if subject.machine else ()
    types = {event.name: event.type for event in events}
    yield f"class {each.name}(rt.State):"
    yield from docstring("What is done in a state.", f"State {one_line(each.state)}", (), INDENT)
    yield ""
    yield f"{INDENT}component: {subject.class_name}"
    for name, summary in (("on_entry", "Enter the state."), ("on_exit", "Leave the state.")):
        yield ""
        yield f"{INDENT}def {name}(self) -> None:"
        yield f'{BODY}"""{summary}"""'
        yield from region(f"{each.name}.{name}", BODY)
    for name, event, target in each.moves:
        yield ""
        yield from lines_of("@", CallExpression("rt.takes", [("", event)]))
        yield f"{INDENT}def {name}(self, value: {types[event]}) -> str | None:"
        yield from docstring(
            "Take an event.", f"Take {one_line(event)}, which leads to {one_line(target)}", (), BODY
        )
        yield from region(f"{each.name}.{name}", BODY, [f"{BODY}return None"])


def _operations(subject: GeneratedComponent, types: TypesCode) -> Iterator[list[str]]:
    for service in subject.services:
        for offer in service.offers:
            if offer.is_provided and not offer.servant:
                yield from _methods(service, offer, types)


def _methods(
    service: GeneratedServicePort, offer: GeneratedInterface, types: TypesCode
) -> Iterator[list[str]]:
    owner = offer.servant or service.attribute
    for method in offer.methods:
        yield [
            *signature(method, "idl.", INDENT),
            *documentation(method, lambda path: f"idl.{types.name(path)}", BODY),
            *region(f"{owner}.{method.name}", BODY, [f"{BODY}raise NotImplementedError"]),
        ]


def _servant(
    service: GeneratedServicePort,
    offer: GeneratedInterface,
    subject: GeneratedComponent,
    types: TypesCode,
) -> Iterator[str]:
    yield f"class {offer.servant}:"
    yield f'{INDENT}"""Operations of a service port; `component` is the one that it is part of."""'
    yield ""
    yield f"{INDENT}def __init__(self, component: {subject.class_name}) -> None:"
    yield f"{BODY}self.component = component"
    for method in _methods(service, offer, types):
        yield ""
        yield from method


def _init(subject: GeneratedComponent) -> list[str]:
    return [
        f"def {subject.init}(manager: rt.Manager) -> None:",
        f'{INDENT}"""Register the component type of this module."""',
        f"{INDENT}manager.register_factory({subject.class_name})",
        "",
        "",
        'if __name__ == "__main__":',
        f"{INDENT}import rtkit",
        "",
        f"{INDENT}rtkit.run({subject.class_name})",
    ]
