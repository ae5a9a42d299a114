"""Writes machines as SCXML as far as it can say them, and reads a subset of it.

Read are ``state``, ``final``, ``initial``, ``transition`` with ``event``, ``cond`` and one target,
``onentry`` and ``onexit`` with ``send``, ``raise``, ``assign`` and ``cancel``, and ``datamodel``.
Conditions and values are those of `rtkit.services.statemachine.expressions`, so documents with some
state the data model ``rtkit``. A SET is a ``send`` of the type `SET`; a time-out is a delayed event
that only its own state takes. Anything else is refused with its line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from rtkit.services.paths import RESERVED
from rtkit.services.statemachine.expressions import (
    VARIABLES,
    Expression,
    Plain,
    plain_of,
    written,
)
from rtkit.services.statemachine.model import (
    BadMachine,
    GuardedTransition,
    Machine,
    MachineAction,
    MachineState,
    by_outer,
    hint,
)

NAMESPACE = "http://www.w3.org/2005/07/scxml"
SET = "urn:rtkit:set"
"""Type of a ``send`` that is a SET: ``target`` is the property, ``content`` the value."""

_TAG = f"{{{NAMESPACE}}}"
_DELAY = re.compile(r"(\d+(?:\.\d+)?|\.\d+)(ms|s)")
_PLACE = re.compile(r"(?: line (\d+)(?=, line \1,))?, line \d+, column \d+$")
"""Where a parser found an error, behind its text."""
_ID = re.compile(r"[A-Za-z_][\w.-]*", re.ASCII)
_DONE, _DONE_STATE = "done.", "done.state."
_EVENTS = ("", "scxml", "http://www.w3.org/TR/scxml/#SCXMLEventProcessor")
"""Types of a ``send`` that is an event."""
_ACTIONS = "send raise assign cancel"
_READ = {
    "scxml": ("datamodel state final initial", "version name initial datamodel"),
    "datamodel": ("data", ""),
    "data": ("", "id expr"),
    "state": ("state final initial transition onentry onexit", "id initial"),
    "final": ("", "id"),
    "initial": ("transition", ""),
    "transition": (_ACTIONS, "event cond target type"),
    "onentry": (_ACTIONS, ""),
    "onexit": (_ACTIONS, ""),
    "send": ("content", "event id delay type target"),
    "content": ("", "expr"),
    "raise": ("", "event"),
    "assign": ("", "location expr"),
    "cancel": ("", "sendid"),
}
"""Elements that are read, with what may be in them, and their attributes."""
_WRONG = {
    "send": f"a send is a SET (type {SET}), or a delayed event in onentry",
    "raise": "a raise has an event",
    "cancel": "a cancel of a delayed event is in onexit",
}


def write_scxml(machine: Machine) -> str:
    """Return a machine as SCXML; what that cannot say stands in comments."""
    from lxml import etree

    about = {"version": "1.0", "name": machine.name, "initial": machine.initial}
    root = etree.Element(f"{_TAG}scxml", {**about, "datamodel": "rtkit"}, {None: NAMESPACE})  # type: ignore[dict-item]
    if machine.variables:
        data = etree.SubElement(root, f"{_TAG}datamodel")
        for name, value in machine.variables.items():
            _added(data, "data", id=name, expr=written(value))
    made = {"": root}
    for path, state in machine.states.items():
        kind = "final" if state.is_final else "state"
        node = _added(made[path.rpartition(".")[0]], kind, id=path, initial=state.initial)
        made[path] = node
        for each in state.do:
            _noted(node, f"do {each.target} every {each.every:g} s")
        _write_state(machine, node, state)
    etree.indent(root, "    ")
    return etree.tostring(root, encoding="unicode") + "\n"


def _event(machine: Machine, event: str) -> str:
    """Return an event as SCXML calls it: there states end with ``done.state.ID``."""
    ended = event.removeprefix(_DONE)
    return _DONE_STATE + ended if ended != event and ended in machine.states else event


def _write_state(machine: Machine, node: Any, state: MachineState) -> None:
    timers = {f"after.{state.path}.{index}": way for index, way in enumerate(state.transitions)
              if way.after is not None}  # fmt: skip
    for word, actions in (("onentry", state.entry), ("onexit", state.exit)):
        if actions or timers:
            block = _added(node, word)
            _write_actions(machine, block, actions)
            for name, way in timers.items():
                if word == "onentry":
                    _added(block, "send", event=name, id=name, delay=f"{way.after:g}s")
                else:
                    _added(block, "cancel", sendid=name)
    for index, way in enumerate(state.transitions):
        name = f"after.{state.path}.{index}"
        if way.after is not None and (way.on or way.when):
            _noted(node, f"{way.cause}: here asked only when the time is over")
        event = name if name in timers else _event(machine, way.on)
        cond = way.when.text if way.when else ""
        made = _added(node, "transition", event=event, cond=cond, target=way.to)
        _write_actions(machine, made, way.actions)


def _write_actions(machine: Machine, block: Any, actions: tuple[MachineAction, ...]) -> None:
    for each in actions:
        computed = each.expression.text if each.expression else ""
        if each.get:
            _noted(block, f"{each.target} = GET {each.get}")
        elif each.kind == "raise":
            _added(block, "raise", event=_event(machine, each.target))
        elif each.kind == "assign":
            value = computed or written(plain_of(each.value))
            _added(block, "assign", location=each.target, expr=value)
        else:
            send = _added(block, "send", type=SET, target=each.target)
            _added(send, "content", expr=computed).text = None if computed else each.value


def _noted(outer: Any, text: str) -> None:
    from lxml import etree

    outer.append(etree.Comment(f" {text.replace('--', '- -')} "))


def _added(outer: Any, tag: str, **attributes: str) -> Any:
    from lxml import etree

    given = {name: value for name, value in attributes.items() if value}
    return etree.SubElement(outer, _TAG + tag, given)


def read_scxml(text: str) -> Machine:
    """Read a machine.

    Raises:
        BadMachine: It is none, or says what is not in the subset; with its line.
    """
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root: Any = etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError as error:
        raise BadMachine(_PLACE.sub("", error.msg), error.lineno or 0) from None
    if root.getroottree().docinfo.doctype:
        raise BadMachine("a DOCTYPE is refused", 1)
    if root.tag != f"{_TAG}scxml":
        raise BadMachine(f'the root is not scxml of xmlns="{NAMESPACE}"', root.sourceline)
    _check(root)
    return _Reader(root).machine()


def _check(root: Any) -> None:
    """Refuse what is not in the subset: it would mean something else without it."""
    for node in root.iter("{*}*"):
        word, outer = node.tag.removeprefix(_TAG), node.getparent()
        known = _READ[outer.tag.removeprefix(_TAG)][0].split() if outer is not None else [word]
        if word not in known:
            raise BadMachine(f"not read here: {word}{hint(word, known)}", node.sourceline)
        known = _READ[word][1].split()
        for each, value in node.attrib.items():
            if each not in known and not each.startswith("{"):
                why = f"not read here: {word} with {each}{hint(each, known)}"
                raise BadMachine(why, node.sourceline)
            if word == "transition" and each == "type" and value != "external":
                raise BadMachine(f"not read here: a transition of type {value}", node.sourceline)


def _children(node: Any, *words: str) -> Iterator[tuple[str, Any]]:
    """Yield the elements in another one, or those with one of some names, with these."""
    for each in node.iterchildren(f"{_TAG}*"):
        word = each.tag.removeprefix(_TAG)
        if word in (words or (word,)):
            yield word, each


class _Reader:
    def __init__(self, root: Any) -> None:
        self._root = root
        self._paths: dict[str, str] = {}
        self._nodes: dict[str, Any] = {}
        self._inside: dict[str, list[str]] = {}
        self._lines: dict[tuple[str, str], int] = {("", ""): root.sourceline}

    def machine(self) -> Machine:
        self._place(self._root)
        self._inside = by_outer(self._nodes)
        variables: dict[str, Plain] = {}
        for _, datamodel in _children(self._root, "datamodel"):
            for _, each in _children(datamodel):
                name = each.get("id") or ""
                if not _ID.fullmatch(name) or "." in name or name in variables:
                    why = f"not a new id of a variable: {name or 'none'}"
                    raise BadMachine(why, each.sourceline)
                variables[name] = self._constant(each)
        states = {path: self._state(node, path) for path, node in self._nodes.items()}
        name = self._root.get("name") or "machine"
        return Machine(name, self._initial(self._root, ""), states, variables).check(self._lines)

    def _constant(self, node: Any) -> Plain:
        text = node.get("expr") or (node.text or "").strip() or "0"
        value = _read(text, node).value(lambda _: None)
        if value is None:
            raise BadMachine(f"not a number, true, false or a text: {text}", node.sourceline)
        return value

    def _place(self, root: Any) -> None:
        waiting = [(root, "")]
        while waiting:
            node, outer = waiting.pop()
            for _, each in _children(node, "state", "final"):
                id_ = each.get("id") or ""
                name = id_.removeprefix(f"{outer}.").replace(".", "_")
                path = f"{outer}.{name}".lstrip(".")
                is_known = id_ in self._paths or path in self._nodes
                if not _ID.fullmatch(id_) or name in RESERVED or is_known:
                    raise BadMachine(f"not a new id of a state: {id_ or 'none'}", each.sourceline)
                self._paths[id_], self._nodes[path] = path, each
                self._lines[path, ""] = each.sourceline
                waiting.append((each, path))

    def _initial(self, node: Any, path: str) -> str:
        way = node.find(f"{_TAG}initial/{_TAG}transition")
        if way is not None and (len(way) or way.get("cond") or way.get("event")):
            raise BadMachine("an initial transition has a target only", way.sourceline)
        named = node.get("initial") if way is None else way.get("target")
        return self._paths.get(named, named) if named else self._inside.get(path, [""])[0]

    def _state(self, node: Any, path: str) -> MachineState:
        blocks: dict[str, list[MachineAction]] = {"onentry": [], "onexit": []}
        timers: dict[str, float] = {}
        for word, each in _children(node, *blocks):
            blocks[word] += self._actions(each, timers)
        ways = [way for _, each in _children(node, "transition")
                for way in self._transitions(each, path, timers)]  # fmt: skip
        taken = {way.get("event") for _, way in _children(node, "transition")}
        if lost := timers.keys() - {each for events in taken for each in (events or "").split()}:
            why = f"no transition of {path} takes the delayed event {min(lost)}"
            raise BadMachine(why, node.sourceline)
        is_final = node.tag == f"{_TAG}final"
        entry, exit_ = map(tuple, blocks.values())
        return MachineState(
            path, self._initial(node, path), is_final, entry, exit_, (), tuple(ways)
        )

    def _transitions(
        self, node: Any, path: str, timers: dict[str, float]
    ) -> list[GuardedTransition]:
        target = node.get("target", "")
        to = self._paths.get(target, target)
        self._lines[path, f"to {to}"] = node.sourceline
        cond = node.get("cond")
        when = self._expression(cond, node) if cond else None
        actions = tuple(self._actions(node, {}))
        events = (node.get("event") or "").split() or [""]
        made = []
        for each in events:
            after = timers.get(each)
            on = "" if after is not None else self._event(each)
            if not (to or on or actions):
                raise BadMachine("a transition has a target, an event or actions", node.sourceline)
            made.append(GuardedTransition(to, on, when, after, actions))
        return made

    def _event(self, name: str) -> str:
        name = name.removesuffix(".*").removesuffix(".")
        ended = name.removeprefix(_DONE_STATE)
        return name if ended == name else _DONE + self._paths.get(ended, ended)

    def _expression(self, text: str, node: Any) -> Expression:
        if self._root.get("datamodel") != "rtkit":
            raise BadMachine('expressions are read where datamodel="rtkit"', node.sourceline)
        return _read(text, node)

    def _actions(self, node: Any, timers: dict[str, float]) -> list[MachineAction]:
        """Return what a block does; note the delayed events that it sends."""
        made = []
        for word, each in _children(node):
            event, target = each.get("event", ""), each.get("target", "")
            delay = _DELAY.fullmatch(each.get("delay", ""))
            if word == "assign":
                value = self._expression(each.get("expr", ""), each)
                location = each.get("location", "").removeprefix(VARIABLES)
                made.append(MachineAction("assign", location, "", value))
            elif word == "raise" and event:
                made.append(MachineAction("raise", self._event(event)))
            elif word == "send" and each.get("type") == SET and target and not each.get("delay"):
                made.append(self._set(each, target))
            elif word == "send" and event and delay and self._is_timer(node, each):
                if event in timers:
                    raise BadMachine(f"the delayed event {event} is there twice", each.sourceline)
                timers[event] = float(delay[1]) * (0.001 if delay[2] == "ms" else 1.0)
            elif word != "cancel" or node.tag != f"{_TAG}onexit":
                raise BadMachine(_WRONG[word], each.sourceline)
        return made

    @staticmethod
    def _is_timer(block: Any, send: Any) -> bool:
        is_plain = not send.get("target") and not len(send) and send.get("type", "") in _EVENTS
        return is_plain and block.tag == f"{_TAG}onentry"

    def _set(self, node: Any, target: str) -> MachineAction:
        kind = "assign" if target.startswith(VARIABLES) else "set"
        target = target.removeprefix(VARIABLES)
        for _, content in _children(node):
            if computed := content.get("expr"):
                return MachineAction(kind, target, "", self._expression(computed, node))
            return MachineAction(kind, target, content.text or "")
        return MachineAction(kind, target)


def _read(text: str, node: Any) -> Expression:
    try:
        return Expression(text)
    except ValueError as error:
        raise BadMachine(str(error), node.sourceline) from None
