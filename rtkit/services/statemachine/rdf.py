"""Reads and writes machines as RDF: Turtle, or RDF/XML.

The vocabulary is ``schemas/statemachine.ttl``. A document is read whole or refused with the line of
what is wrong. States are told apart by their IRIs; the last part of an IRI, behind ``#``, ``/`` or
a dot, is the name. A state that a document does not describe is named by its path in the machine
that the document is put into.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import quote, unquote

from rtkit.errors import Refused
from rtkit.extras import how_to_get
from rtkit.services.paths import RESERVED
from rtkit.services.statemachine.expressions import (
    VARIABLES,
    Expression,
    Plain,
    plain_of,
    written,
)
from rtkit.services.statemachine.model import (
    EVERY_S,
    BadMachine,
    GuardedTransition,
    Machine,
    MachineAction,
    MachineState,
    by_outer,
    hint,
    is_in,
)

NAMESPACE = "urn:rtkit:statemachine#"
_BASE = "file:///machine"
_RDF = "http://www.w3.org/1999/02/22-rdf-syntax-ns#"
_COMMENT = "http://www.w3.org/2000/01/rdf-schema#comment"
STATE_NAME = re.compile(r"[A-Za-z_][\w-]*", re.ASCII)
"""Names that states and variables may have."""
_NO_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
"""Characters that XML cannot hold."""
DEEPEST = 30
"""States that may be inside each other."""


def seconds_of(text: str) -> float:
    """Return the time that a text says.

    Raises:
        ValueError: It says none.
    """
    seconds = plain_of(text)
    if isinstance(seconds, bool | str) or not 0 <= seconds < float("inf"):
        raise ValueError(f"expected seconds, found {text or 'nothing'}")
    return float(seconds)


_NODE, _NODES, _LIST = "node", "nodes", "list"
_ACTIONS = {"entry": _LIST, "exit": _LIST, "do": _LIST}
_WORDS: dict[str, dict[str, Any]] = {
    "Machine": {"initial": _NODE, "substate": _NODES, "variable": _NODES},
    "State": {
        "initial": _NODE, "substate": _NODES, "variable": _NODES, **_ACTIONS, "transition": _LIST
    },
    "Final": {},
    "transition": {
        "to": _NODE, "on": str, "when": Expression, "after": seconds_of, "action": _LIST
    },
    "action": {
        "set": str, "value": str, "expression": Expression, "get": str, "raise": str,
        "every": seconds_of
    },
    "variable": {"name": str, "value": str},
}  # fmt: skip
"""Words that may be used of each kind of thing, and what they say."""


def read_machine(text: str, machine: Machine | None = None, at: str = "") -> Machine:
    """Read a machine; or a state with all inside it, and return a machine that has it.

    Args:
        text: Turtle, or RDF/XML where it begins with ``<?xml`` or ``<rdf:RDF``.
        machine: Machine that the state is put into.
        at: Path that the state gets; one that is there with all inside it is replaced.

    Raises:
        BadMachine: It is none; nothing of it is taken.
        Refused: rdflib is not there.
    """
    return _Reader(text).machine(machine, at)


class _Statements:
    """The statements of a document: of each node predicate, object and line, in their order."""

    def __init__(self, text: str) -> None:
        try:
            from rdflib import Graph
        except ImportError as error:
            raise Refused(f"state machines need rdflib: {how_to_get('rdf')}") from error

        found: dict[Any, list[tuple[str, Any, int]]] = {}

        class Lines(Graph):
            def add(graph, triple: Any) -> Any:  # noqa: N805
                line = self.line()
                if _NO_TEXT.search(f"{triple[0]}{triple[2]}"):
                    raise BadMachine("control characters are refused", line)
                found.setdefault(triple[0], []).append((str(triple[1]), triple[2], line))
                return graph

        self.of = found
        self.line: Callable[[], int] = int
        is_xml = re.match(r"\ufeff?\s*<(\?xml|rdf:RDF)", text)
        try:
            (self._read_xml if is_xml else self._read_turtle)(text, Lines())
        except BadMachine:
            raise
        except Exception as error:  # whatever the parser of a library meets in rubbish
            of_python = type(error).__module__ == "builtins"
            form = "RDF/XML" if is_xml else "Turtle"
            why = f"not {form}" if of_python or not str(error) else str(error)
            raise BadMachine(why, self.line()) from None

    def _read_turtle(self, text: str, graph: Any) -> None:
        from rdflib.plugins.parsers.notation3 import BadSyntax, RDFSink, SinkParser

        class Sink(RDFSink):
            def newGraph(self, identifier: Any) -> Any:  # noqa: N802
                return graph

        parser = SinkParser(Sink(graph), baseURI=_BASE, turtle=True)
        self.line = lambda: int(parser.lines) + 1
        try:
            parser.loadBuf(text)
        except BadSyntax as error:
            why = str(error).partition("(")[2].partition(") at ^")[0]
            raise BadMachine(why, error.lines + 1) from None

    def _read_xml(self, text: str, graph: Any) -> None:
        from io import BytesIO
        from xml.sax import SAXParseException
        from xml.sax.xmlreader import InputSource

        from rdflib.plugins.parsers.rdfxml import create_parser

        if "<!DOCTYPE" in text:  # entities, and all that they could reach
            raise BadMachine("a DOCTYPE is refused", text.partition("<!DOCTYPE")[0].count("\n") + 1)
        source = InputSource(_BASE)
        source.setPublicId(_BASE)
        source.setByteStream(BytesIO(text.encode()))
        source.setEncoding("utf-8")
        reader: Any = create_parser(source, graph)  # type: ignore[arg-type]
        self.line = reader.getLineNumber
        try:
            reader.parse(source)
        except SAXParseException as error:
            raise BadMachine(error.getMessage(), error.getLineNumber() or 0) from None

    def line_of(self, node: Any) -> int:
        """Return the line at which a node is begun to be described, else where it is named."""
        if node in self.of:
            return self.of[node][0][2]
        return next(
            (line for facts in self.of.values() for *_, each, line in facts if each == node), 0
        )

    def items(self, node: Any) -> list[Any]:
        """Return the items of a list, of anything else itself."""
        found: list[Any] = []
        while str(node) != _RDF + "nil":
            cell = {predicate: each for predicate, each, _ in self.of.get(node, ())}
            if _RDF + "first" not in cell or len(found) > len(self.of):
                return [*found, node]  # none, or one without end: the rest is nothing that is known
            found.append(cell[_RDF + "first"])
            node = cell.get(_RDF + "rest")
        return found


class _Reader:
    """Reads one document."""

    def __init__(self, text: str) -> None:
        self._statements = _Statements(text)
        self._kinds: dict[Any, str] = {}
        for node, facts in self._statements.of.items():
            for predicate, each, line in facts:
                kind = str(each).removeprefix(NAMESPACE)
                if predicate == _RDF + "type" and kind != str(each):
                    if kind not in ("Machine", "State", "Final") or node in self._kinds:
                        raise BadMachine(f"not expected here: sm:{kind}", line)
                    self._kinds[node] = kind
        self._facts: dict[Any, dict[str, Any]] = {}
        self._where: dict[tuple[Any, str], int] = {}
        self._lines: dict[tuple[str, str], int] = {}
        self._paths: dict[Any, str] = {}
        self._inside: dict[str, list[str]] = {}
        self._moved: dict[str, str] = {}

    def machine(self, machine: Machine | None, at: str) -> Machine:
        """Return the machine that the document describes, or what it makes of another one."""
        root, states = self._root(bool(at))
        self._place(root, at, states)
        if at:
            self._moved = {_fragment_of(node): path for node, path in self._paths.items()}
        self._inside = by_outer(filter(None, self._paths.values()))
        made = {path: self._state(node, path) for node, path in self._paths.items() if path}
        variables: dict[str, Plain] = {}
        for node in (each for of in self._paths for each in self._of(of).get("variable", ())):
            name, value = self._variable(node)
            if name in variables:
                line = self._statements.line_of(node)
                raise BadMachine(f"variable {name} is there twice", line)
            variables[name] = value
        self._refuse_unused()
        self._lines["", ""] = self._statements.line_of(root)
        if machine is None or not at:
            initial = self._initial(root, "")
            doc = self._doc(root)
            return Machine(unquote(_name_of(root)), initial, made, variables, doc).check(
                self._lines
            )
        outer = at.rpartition(".")[0]
        if outer and outer not in machine.states:
            raise BadMachine(f"no state {outer} to put it into{hint(outer, machine.states)}")
        whole = machine.replaced(at, made)
        if outer and not whole.states[outer].initial:
            around = whole.states[outer]._replace(initial=at)
            whole = whole._replace(states={**whole.states, outer: around})
        return whole._replace(variables={**variables, **whole.variables}).check(self._lines)

    def _root(self, is_part: bool) -> tuple[Any, list[Any]]:
        """Return what all is inside of, and all states."""
        states = [each for each, kind in self._kinds.items() if kind != "Machine"]
        tops = [each for each, kind in self._kinds.items() if kind == "Machine"]
        if not tops and is_part:
            inside = {each for node in states for each in self._of(node).get("substate", ())}
            tops = [each for each in states if each not in inside]
        if len(tops) != 1:
            what = "one state with all inside it, or one machine" if is_part else "one sm:Machine"
            line = self._statements.line_of(tops[1]) if tops else 1
            raise BadMachine(f"expected {what}, found {len(tops)}", line)
        return tops[0], states

    def _of(self, node: Any, kind: str = "") -> dict[str, Any]:
        """Return what is facts of a node, by word; refuse what is not known of its kind."""
        if node in self._facts:
            return self._facts[node]
        words = _WORDS[kind or self._kinds[node]]
        facts: dict[str, Any] = {
            word: [] if how in (_NODES, _LIST) else None for word, how in words.items()
        }
        self._facts[node] = facts
        for predicate, each, line in self._statements.of.get(node, ()):
            word = predicate.removeprefix(NAMESPACE)
            if word == predicate:
                continue  # of another vocabulary
            if word not in words:
                raise BadMachine(f"not known here: sm:{word}{hint(word, words)}", line)
            if facts[word] and words[word] != _NODES:
                why = ": write one list ( … ), since order counts" * (words[word] == _LIST)
                raise BadMachine(f"sm:{word} is there twice{why}", line)
            self._where[node, word] = line
            value = self._value(word, words[word], each, line)
            facts[word] = facts[word] + value if words[word] == _NODES else value
        return facts

    def _value(self, word: str, how: Any, each: Any, line: int) -> Any:
        from rdflib import Literal

        if how in (_NODES, _LIST):
            return self._statements.items(each)
        if isinstance(each, Literal) == (how == _NODE):
            raise BadMachine(f"sm:{word}: expected a {'state' if how == _NODE else 'value'}", line)
        try:
            return each if how == _NODE else how(str(each))
        except ValueError as error:
            raise BadMachine(f"sm:{word}: {error}", line) from None

    def _place(self, root: Any, at: str, states: list[Any]) -> None:
        """Give each state its path, outer ones first."""
        inside = {each for node in (root, *states) for each in self._of(node).get("substate", ())}
        outermost = [each for each in states if each not in inside and each != root]
        waiting = [(root, at)]
        while waiting:
            node, path = waiting.pop()
            name, line = path.rpartition(".")[2], self._statements.line_of(node)
            if path and (not STATE_NAME.fullmatch(name) or name in RESERVED):
                raise BadMachine(f"not a name of a state: {name}", line)
            if node in self._paths or (path, "") in self._lines or path.count(".") > DEEPEST:
                raise BadMachine(f"state {path} is there twice, or nested too deep", line)
            self._paths[node] = path
            self._lines[path, ""] = line
            children = [*self._of(node).get("substate", ()), *outermost]
            outermost = []
            for each in children:
                if self._kinds.get(each) not in ("State", "Final"):
                    raise BadMachine(
                        f"{_name_of(each)} is no sm:State", self._where[node, "substate"]
                    )
            waiting += [(e, f"{path}.{_name_of(e)}".lstrip(".")) for e in reversed(children)]
        if lost := [each for each in states if each not in self._paths]:
            line = self._statements.line_of(lost[0])
            raise BadMachine(f"state {_name_of(lost[0])} is inside itself", line)

    def _target(self, node: Any, path: str, word: str) -> str:
        found = self._of(node)[word]
        if found is None:
            return ""
        target = self._paths.get(found, _fragment_of(found))
        what = word if word == "initial" else f"{word} {target}"
        self._lines[path, what] = self._where[node, word]
        return target

    def _initial(self, node: Any, path: str) -> str:
        inside = self._inside.get(path, [])
        return self._target(node, path, "initial") or (inside[0] if len(inside) == 1 else "")

    def _doc(self, node: Any) -> str:
        facts = self._statements.of[node]
        return next((str(each) for predicate, each, _ in facts if predicate == _COMMENT), "")

    def _state(self, node: Any, path: str) -> MachineState:
        facts, doc = self._of(node), self._doc(node)
        if self._kinds[node] == "Final":
            return MachineState(path, is_final=True, doc=doc)
        entry, exit_, do = (self._actions(node, path, each) for each in _ACTIONS)
        ways = tuple(self._transition(each, path) for each in facts.get("transition", ()))
        return MachineState(path, self._initial(node, path), False, entry, exit_, do, ways, doc)

    def _transition(self, node: Any, path: str) -> GuardedTransition:
        facts = self._of(node, "transition")
        to = self._target(node, path, "to")
        if not (to or facts["on"] or facts["action"]):
            line = self._statements.line_of(node)
            raise BadMachine("a transition says sm:to, sm:action, or sm:on an event", line)
        self._note_variables(node, path, "when")
        actions = self._actions(node, path, "action")
        on = self._event(facts["on"] or "")
        return GuardedTransition(to, on, facts["when"], facts["after"], actions)

    def _event(self, name: str) -> str:
        """Return an event as it is called where the document is put: ends of states have paths."""
        ended = name.removeprefix("done.")
        return f"done.{self._moved[ended]}" if ended != name and ended in self._moved else name

    def _note_variables(self, node: Any, path: str, word: str) -> None:
        expression: Expression | None = self._of(node)[word]
        for each in expression.variables if expression else ():
            self._lines.setdefault((path, VARIABLES + each), self._where[node, word])

    def _actions(self, node: Any, path: str, word: str) -> tuple[MachineAction, ...]:
        return tuple(self._action(each, path) for each in self._of(node).get(word, ()))

    def _action(self, node: Any, path: str) -> MachineAction:
        facts = self._of(node, "action")
        target, event, expression = facts["set"], facts["raise"], facts["expression"]
        values = [each for each in (facts["value"], expression, facts["get"]) if each is not None]
        if bool(target) == bool(event) or len(values) != bool(target):
            why = "an action is sm:set with sm:value, sm:expression or sm:get; or sm:raise"
            raise BadMachine(why, self._statements.line_of(node))
        if facts["every"] == 0:
            raise BadMachine("sm:every: expected more than 0 s", self._where[node, "every"])
        self._note_variables(node, path, "expression")
        kind = "raise" if event else "assign" if target.startswith(VARIABLES) else "set"
        target = self._event(event) if event else target.removeprefix(VARIABLES)
        made = MachineAction(kind, target, facts["value"] or "",
                             expression, facts["get"] or "", facts["every"] or EVERY_S)  # fmt: skip
        for each in made.variables():
            self._lines.setdefault((path, VARIABLES + each), self._statements.line_of(node))
        return made

    def _variable(self, node: Any) -> tuple[str, Plain]:
        facts = self._of(node, "variable")
        if not STATE_NAME.fullmatch(facts["name"] or "") or facts["value"] is None:
            why = "a variable has sm:name and sm:value"
            raise BadMachine(why, self._statements.line_of(node))
        return facts["name"], plain_of(facts["value"])

    def _refuse_unused(self) -> None:
        """Refuse what nothing refers to: somebody meant something by it."""
        for node, facts in self._statements.of.items():
            for predicate, _, line in facts:
                if predicate.startswith(NAMESPACE) and node not in self._facts:
                    word = predicate.replace(NAMESPACE, "sm:")
                    raise BadMachine(f"{word} of nothing that belongs to the machine", line)


def _fragment_of(node: Any) -> str:
    """Return what an IRI says behind ``#`` or ``/``: a name, or the path of a state elsewhere."""
    return re.split(r"[#/]", str(node))[-1]


def _name_of(node: Any) -> str:
    return re.split(r"[#/.]", str(node))[-1]


def write_machine(machine: Machine, at: str = "") -> str:
    """Return a machine, or a state with all inside it and the variables it uses, as Turtle."""
    blocks = [f"@prefix sm: <{NAMESPACE}> .\n@prefix rdfs: <{_COMMENT[:-7]}> .\n"]
    states = {path: state for path, state in machine.states.items() if is_in(path, at)}
    used = {name for state in states.values() for name in state.variables()}
    variables = [
        f"sm:variable [ sm:name {_text(name)} ; sm:value {_text(bare(value))} ]"
        for name, value in machine.variables.items()
        if not at or name in used
    ]
    if not at:
        about, facts = f"<../{_escaped(machine.name)}>", [f"sm:initial {_iri(machine.initial)}"]
        blocks.append(_block(about, "sm:Machine", machine.doc, facts + variables))
    for path, state in states.items():
        kind = "sm:Final" if state.is_final else "sm:State"
        more = variables if path == at else ()
        blocks.append(_block(_iri(path), kind, state.doc, (*more, *_facts(machine, state))))
    return "\n".join(blocks)


def _escaped(name: str) -> str:
    """Return the name of a machine as the last part of an IRI."""
    return quote(name, safe="").replace(".", "%2E")


def bare(value: Plain) -> str:
    """Return a value as `plain_of` reads it: texts without quotes."""
    return value if isinstance(value, str) else written(value)


def _facts(machine: Machine, state: MachineState) -> Iterator[str]:
    if state.initial:
        yield f"sm:initial {_iri(state.initial)}"
        yield f"sm:substate {', '.join(map(_iri, machine.below(state.path)))}"
    for word, actions in (("entry", state.entry), ("exit", state.exit), ("do", state.do)):
        if actions:
            yield f"sm:{word} {_list(map(_action_text, actions), ' ' * 8)}"
    if state.transitions:
        yield f"sm:transition {_list(map(_transition_text, state.transitions), ' ' * 8)}"


def _transition_text(way: GuardedTransition) -> str:
    facts = {
        "on": way.on and _text(way.on),
        "when": way.when and _text(way.when.text),
        "after": "" if way.after is None else _text(repr(way.after)),
        "to": way.to and _iri(way.to),
        "action": way.actions and _list(map(_action_text, way.actions), " " * 12),
    }
    return f"[ {' ; '.join(f'sm:{word} {text}' for word, text in facts.items() if text)} ]"


def _action_text(action: MachineAction) -> str:
    if action.kind == "raise":
        return f"[ sm:raise {_text(action.target)} ]"
    target = VARIABLES * (action.kind == "assign") + action.target
    value = f"sm:get {_text(action.get)}" if action.get else f"sm:value {_text(action.value)}"
    if action.expression:
        value = f"sm:expression {_text(action.expression.text)}"
    every = "" if action.every == EVERY_S else f" ; sm:every {_text(repr(action.every))}"
    return f"[ sm:set {_text(target)} ; {value}{every} ]"


def _block(about: str, kind: str, doc: str, facts: Any) -> str:
    lines = [f"{about} a {kind}", *([f"rdfs:comment {_text(doc)}"] if doc else []), *facts]
    return " ;\n    ".join(lines) + " .\n"


def _list(items: Any, margin: str) -> str:
    return f"( {f'{chr(10)}{margin}'.join(items)} )"


def _iri(path: str) -> str:
    return f"<#{path}>"


def _text(text: str) -> str:
    from rdflib import Literal

    value = plain_of(text)
    is_plain = not isinstance(value, str) and str(value) == text
    return text if is_plain else str(Literal(text).n3())
