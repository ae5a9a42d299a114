"""Live properties of components and managers: their names, and the action that a SET stands for.

Values of parameters are text: only the component that has them reads them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.property.codes import PropertyError
from rtkit.property.naming import segment_of
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Value, Word
from rtkit.rtc.enums import PortType, Transition
from rtkit.rtc.profiles import ConnectorProfile, ExecutionContextProfile, PortRef

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action

Change = Callable[[Content], "Sequence[Action]"]


class Shown(NamedTuple):
    """One property.

    Attributes:
        change: The action of the manager for a SET; None of what cannot be set.
    """

    name: str
    value: Content
    spec: PropertySpec
    change: Change | None = None


_STATES = (Word("Inactive"), Word("Active"), Word("Error"), Word("Created"), Word("Unknown"))
_TRANSITIONS: Mapping[tuple[str, str], Transition] = {
    ("Inactive", "Active"): Transition.ACTIVATE,
    ("Active", "Inactive"): Transition.DEACTIVATE,
    ("Error", "Inactive"): Transition.RESET,
}


def of_component(
    facts: ComponentFacts,
    connectors: Sequence[ConnectorProfile],
    metrics: ComponentMetrics | None = None,
    ends: Mapping[str, PortRef] | None = None,
) -> list[Shown]:
    """Return what is shown of a component; counters only if its metrics are known.

    Of a composite `ends` states whose ports it shows, by their names on it.
    """
    kind = facts.type
    texts = {
        "type": kind.type_name,
        "vendor": kind.vendor,
        "category": kind.category,
        "version": kind.version,
        "description": kind.description,
        "process": facts.process,
        "cause": facts.cause,
        "trouble": facts.zombie or facts.trouble,
        "waits": facts.waits,
    }
    doc = "Life-cycle state; set to Active or Inactive to change it"
    spec = PropertySpec(parse_type("word"), choices=_STATES, doc=doc)
    shown = [Shown("state", Word(facts.state), spec, _state_change(facts))]
    shown += [_text(name, text) for name, text in texts.items()]
    shown.append(_list("names", facts.names))
    if facts.members:
        shown.append(_list("members", facts.members))
    if facts.fsm_state:
        shown.append(_text("fsm_state", facts.fsm_state))
    shown += _sets(facts)
    shown += _contexts(facts)
    return shown + _ports(facts, connectors, metrics, ends or {})


def _actions() -> Any:
    """Return the actions, which nobody needs who only reads."""
    from rtkit.deployment import actions

    return actions


def _state_change(facts: ComponentFacts) -> Change:
    def change(value: Content) -> Sequence[Action]:
        if value == Word(facts.state):
            return ()
        transition = _TRANSITIONS.get((facts.state, str(value)))
        if transition is None or not facts.contexts:
            raise PropertyError("conflict", f"it is {facts.state}, it cannot become {value!s}")
        return (_actions().ChangeState(facts.instance, facts.contexts[0].id, transition),)

    return change


def _sets(facts: ComponentFacts) -> list[Shown]:
    if not facts.sets:
        return []
    choices = tuple(Word(name) for name in facts.sets)
    spec = PropertySpec(parse_type("any"), doc="The active configuration set")
    shown = [Shown("active_set", _name(facts.active_set), spec, _activation(facts, choices))]
    for set_id, values in facts.sets.items():
        for name, text in values.items():
            path = parameter_path(set_id, name)
            spec = PropertySpec(parse_type("text"), doc=f"Parameter {name} of set {set_id}")
            shown.append(Shown(path, text, spec, _parameter(facts, set_id, name)))
    return shown


def parameter_path(set_id: str, name: str) -> str:
    """Return the property that a configuration parameter is shown as."""
    return f"configuration.{segment_of(set_id)}.{segment_of(name)}"


def _activation(facts: ComponentFacts, choices: Sequence[str]) -> Change:
    def change(value: Content) -> Sequence[Action]:
        if str(value) not in map(str, choices):
            raise PropertyError("bad-value", f"expected one of {' '.join(choices)}")
        return (_actions().ActivateSet(facts.instance, str(value)),)

    return change


def _parameter(facts: ComponentFacts, set_id: str, name: str) -> Change:
    def change(value: Content) -> Sequence[Action]:
        setting = _actions().SetParameters(facts.instance, set_id, {name: str(value)})
        is_active = set_id == facts.active_set
        return (setting, *([_actions().ActivateSet(facts.instance, set_id)] if is_active else ()))

    return change


def _contexts(facts: ComponentFacts) -> list[Shown]:
    shown = []
    for index, context in enumerate(facts.contexts):
        path = f"contexts.{index}"
        spec = PropertySpec(parse_type("number"), unit="Hz", minimum=0.0)
        shown += [
            _text(f"{path}.id", context.id),
            Shown(f"{path}.kind", Word(context.kind.name), _read_only("word")),
            Shown(f"{path}.rate", context.rate, spec, _rate(facts, context)),
            *(_setting(f"{path}.{key}", facts, context, key) for key in _SETTINGS),
            Shown(f"{path}.missed", context.missed, _MISSED),
            _text(f"{path}.trouble", context.trouble),
            Shown(f"{path}.state", Word(context.state.name), _read_only("word")),
            Shown(f"{path}.is_running", context.is_running, _read_only("boolean")),
            _text(f"{path}.owner", context.owner),
            _participants(f"{path}.participants", facts, context),
            Shown(f"{path}.tick", "", _TICK, _tick(facts, context)),
        ]
    return shown


def _setting(name: str, facts: ComponentFacts, context: ExecutionContextProfile, key: str) -> Shown:
    """Return a setting of the thread of a context, which only its owner may change."""
    text = context.properties.get(key, "")
    if context.owner != facts.instance:
        return _text(name, text)

    def change(value: Content) -> Sequence[Action]:
        return (_actions().SetContext(facts.instance, context.id, {key: str(value)}),)

    return Shown(name, text, PropertySpec(parse_type("text"), doc=_SETTINGS[key]), change)


def _participants(name: str, facts: ComponentFacts, context: ExecutionContextProfile) -> Shown:
    """Return the components that a context drives besides its owner, who may change them."""
    value = tuple(_name(each) for each in context.participants)
    if context.owner != facts.instance:
        return Shown(name, value, _read_only("list"))

    def change(asked: Content) -> Sequence[Action]:
        wanted = dict.fromkeys(map(str, asked)) if isinstance(asked, tuple) else {}
        present = context.participants
        here = facts.instance, context.id
        return (
            *(_actions().Detach(*here, each) for each in present if each not in wanted),
            *(_actions().Attach(*here, each) for each in wanted if each not in present),
        )

    doc = "Components of the same process that it drives besides its owner"
    return Shown(name, value, PropertySpec(parse_type("list"), doc=doc), change)


_SETTINGS = {
    "sched_policy": "Scheduling of the thread: other, fifo or rr",
    "priority": "Priority of the thread with fifo or rr, 1 to 99",
    "cpu_affinity": "Processors of the thread, as 0,2-3",
    "memory_lock": "YES: the process stays in RAM while the thread is at work",
    "garbage_collector": "Of the process while the thread is at work: on, frozen, between, off",
}
_MISSED = PropertySpec(
    parse_type("integer"), "r", doc="Periods at which nothing was done, as of the last second"
)
_MOST_CYCLES = 1000
_TICK = PropertySpec(
    parse_type("element"),
    doc="Gives a context that is not periodic cycles; the answer comes when they are over",
    parameters=(RequestParameter("cycles", parse_type("integer"), 1, (), "how many"),),
    is_functional=True,
)


def _tick(facts: ComponentFacts, context: ExecutionContextProfile) -> Change:
    def change(value: Content) -> Sequence[Action]:
        if not isinstance(value, int) or not 1 <= value <= _MOST_CYCLES:
            raise PropertyError("bad-value", f"cycles are 1 to {_MOST_CYCLES}, not {value!s}")
        return (_actions().Tick(facts.instance, context.id),) * value

    return change


def _rate(facts: ComponentFacts, context: ExecutionContextProfile) -> Change:
    return lambda value: (_actions().SetRate(facts.instance, context.id, float(str(value))),)


_DIRECTIONS = {PortType.IN: "in", PortType.OUT: "out", PortType.SERVICE: "service"}


def _ports(
    facts: ComponentFacts,
    connectors: Sequence[ConnectorProfile],
    metrics: ComponentMetrics | None,
    own: Mapping[str, PortRef],
) -> list[Shown]:
    shown = []
    counts = {} if metrics is None else {**metrics.written, **metrics.read}
    for port in facts.ports:
        path = f"ports.{segment_of(port.name)}"
        here = own.get(port.name) or PortRef(facts.instance, port.name)
        ends = [connector.ports for connector in connectors if here in connector.ports]
        others = [str(end) for both in ends for end in both if end != here]
        shown += [
            Shown(f"{path}.direction", Word(_DIRECTIONS[port.port_type]), _read_only("word")),
            _text(f"{path}.type", port.data_type),
            _list(f"{path}.connected", others),
        ]
        if port.port_type is not PortType.SERVICE:
            count = counts.get(port.name, -1)
            doc = "Values that passed, from the beginning of the process; -1 is not known yet"
            spec = PropertySpec(parse_type("integer"), "r", doc=doc)
            shown.append(Shown(f"{path}.count", count, spec))
    return shown


def of_manager(snapshot: Snapshot, settings: Mapping[str, str]) -> list[Shown]:
    """Return what is shown of a manager beside its operations; settings as far as given."""
    slaves = [process.name for process in snapshot.processes if process.is_slave]
    shown = [
        _text("name", snapshot.manager),
        _text("host", snapshot.host),
        _text("version", snapshot.version),
        Shown("pid", snapshot.pid, _read_only("integer")),
        _list("components", [facts.instance for facts in snapshot.components]),
        _list("slaves", slaves),
        _list("modules", [module.path for module in snapshot.modules]),
        _list("connectors", [connector.connector_id for connector in snapshot.connectors]),
    ]
    for key, text in settings.items():
        path = ".".join(map(segment_of, key.split(".")))
        # A key may have keys below it and a value of its own; both are properties.
        shown.append(Shown(f"settings.{path}", text, PropertySpec(parse_type("text"))))
    return shown


def _text(name: str, text: str) -> Shown:
    return Shown(name, text, _read_only("string"))


def _list(name: str, items: Sequence[str]) -> Shown:
    return Shown(name, tuple(_name(item) for item in items), _read_only("list"))


def _name(text: str) -> Value:
    from rtkit.property.writing import write

    word = Word(text)
    return str(text) if write(word).startswith('"') else word


def _read_only(kind: str) -> PropertySpec:
    known = _READ_ONLY.get(kind)
    if known is None:
        known = _READ_ONLY[kind] = PropertySpec(parse_type(kind), "r")
    return known


_READ_ONLY: dict[str, PropertySpec] = {}
