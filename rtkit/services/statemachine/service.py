"""State machine service: a machine that reads and sets properties of any services while it runs."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Collection
from functools import partial
from itertools import islice
from typing import Any, Final, Literal

import rtkit
from rtkit import init_of
from rtkit.services.statemachine.expressions import Plain
from rtkit.services.statemachine.interpreter import Interpreter, MachineEvent, OutgoingSet
from rtkit.services.statemachine.links import ServiceLink, ServiceNames, service_of
from rtkit.services.statemachine.model import Machine, MachineState, hint, is_in
from rtkit.services.statemachine.rdf import write_machine
from rtkit.services.statemachine.texts import as_rdf_xml, is_xml, read_text

_RETRY_S = 1.0
_NOTHING = Machine("machine", "nothing", {"nothing": MachineState("nothing")})
_COMMANDS = ("start", "stop", "pause", "step")


class StateMachine(rtkit.Names):
    """Runs a machine of states with guards on properties of any service; takes edits meanwhile.

    ``machine`` is its text, ``machine.STATE`` that of a state with all inside it; a SET of either
    is one edit, in force between two steps or refused whole.

    Args:
        machine: Text of the machine: Turtle, RDF/XML or SCXML.
        source: Property that it is got from instead, e.g. of a storage service.
        names: Names of services in it, ``NAME=SERVICE`` each: ``robots/r1=/h2/robots/r1``.
        start: Whether it runs at once.
        timeout: Bound on each request to another service [s].
        length: Entries of the log that are kept.
        logs_all: Log events and values that lead to nothing, too.

    Attributes:
        state: Path of the innermost active state.
        edits: Edits that are in force.
    """

    type: Final = ("statemachine",)
    version: Final = "1.0"
    state: Final = ""
    edits: Final = 0

    def __init__(
        self,
        machine: str = "",
        source: str = "",
        *,
        names: str = "",
        start: bool = False,
        timeout: float = 2.0,
        length: int = 1000,
        logs_all: bool = False,
    ) -> None:
        self._trouble = ""
        self._source, self._is_autostarted, self._timeout = source, start, timeout
        first = read_text(machine) if machine else _NOTHING
        self._interpreter = Interpreter(first, length, logs_all=logs_all)
        self._text = machine if machine and not is_xml(machine) else ""
        self._names, self._services = _names(first), ServiceNames(names)
        self._offset = time.time() - time.monotonic()
        self._client: rtkit.Client | None = None
        self._links: dict[str, ServiceLink] = {}
        self._wanted: frozenset[str] = frozenset()
        self._news: deque[tuple[str, Any]] = deque()
        self._edits = 0
        self._publish: Any = partial(setattr, self)
        self._edit_lock, self._publish_lock = threading.Lock(), threading.RLock()
        self._changed = threading.Condition(threading.Lock())

    def __served__(self, publish: Any) -> None:
        self._publish = publish

    def __enter__(self) -> StateMachine:
        if self._client is None:
            self._client = rtkit.Client(self._timeout)
            is_ready = self._begin()
            threading.Thread(target=self._work, args=(is_ready,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._client is None:
            return
        if self._interpreter.state:
            self.set_run("stop")
        client, self._client = self._client, None
        with self._changed:
            links, self._links = list(self._links.values()), {}
            self._changed.notify()
        until = time.monotonic() + self._timeout
        for link in links:
            link.close(max(0.0, until - time.monotonic()))
        client.close()

    # Properties

    def names(self) -> Collection[str]:
        """Return ``machine``, its states and its variables."""
        return self._names

    def hint(self, name: str) -> Any:
        """Return the kind of a variable's present value; all else is text."""
        if not name.startswith("variables."):
            return rtkit.Text
        value = self._interpreter.variables.get(name.partition(".")[2], "")
        return str if isinstance(value, str) else bool if isinstance(value, bool) else int | float

    def stamp(self, name: str) -> object:
        """Return what stays equal while a text or variable does, so that ``if=REVISION`` holds."""
        head, _, rest = name.partition(".")
        machine = self._interpreter.machine
        if head == "variables":
            value = self._interpreter.variables.get(rest)
            return type(value), value
        if not rest:
            return machine, self._text
        inside = tuple(state for path, state in machine.states.items() if is_in(path, rest))
        return inside, machine.variables

    def get(self, name: str, form: Literal["turtle", "xml", "scxml"] = "turtle") -> Any:
        """Return the text of the machine or of a state, or a variable."""
        head, _, rest = name.partition(".")
        machine, variables = self._interpreter.machine, self._interpreter.variables
        if head == "variables" and rest in variables:
            return variables[rest]
        if head != "machine" or (rest and rest not in machine.states):
            known = machine.states if head == "machine" else variables
            raise rtkit.PropertyError("unknown", f"no such property: {name}{hint(rest, known)}")
        if form == "scxml":
            from rtkit.services.statemachine.scxml import write_scxml

            if rest:
                raise rtkit.PropertyError("bad-parameter", "only a whole machine is SCXML")
            return write_scxml(machine)
        text = self._text if not rest and self._text else write_machine(machine, rest)
        return text if form == "turtle" else as_rdf_xml(text)

    def set(
        self, name: str, value: Any, goto: str = "", delete: bool = False, edits: int = -1
    ) -> None:
        """Edit the machine or a state of it, or set a variable.

        Args:
            name: Of the property; a state that is not there is put in.
            value: Text.
            goto: State to enter where the active one would be gone.
            delete: Take the state off instead.
            edits: Only if the machine has had so many edits; any number when negative.
        """
        head, _, rest = name.partition(".")
        if head == "variables":
            self._assign(rest, value)
        elif head != "machine" or (delete and rest not in self._interpreter.machine.states):
            raise rtkit.PropertyError("unknown", f"no such property: {name}")
        else:
            with self._edit_lock:
                if 0 <= edits != self._edits:  # `if` knows of edits of this name only
                    why = f"it has been edited since: {self._edits} edits, not {edits}"
                    raise rtkit.PropertyError("conflict", why)
                now = self._interpreter.machine  # changed by edits only, so this may take time
                if delete:
                    machine = now.without(rest).check()
                else:
                    machine = read_text(value, now if rest else None, rest)
                text = "" if rest or is_xml(value) else value
                self._done(self._edited, machine, goto, text)

    def _edited(self, now: float, machine: Machine, goto: str, text: str) -> list[OutgoingSet]:
        shown = text or write_machine(machine)
        try:
            sends = self._interpreter.edit(machine, now, goto, shown)
        except ValueError as error:
            raise rtkit.PropertyError("conflict", str(error)) from None
        self._text, self._names = text, _names(machine)
        self._edits += 1
        self._news.append(("edits", self._edits))
        return sends

    def _assign(self, name: str, value: Plain) -> None:
        if name not in self._interpreter.variables:
            near = hint(name, self._interpreter.variables)
            raise rtkit.PropertyError("unknown", f"no variable {name}{near}")
        self._done(lambda now: self._interpreter.assign(name, value, now))

    def get_run(self) -> str:
        """``stopped``, ``running``, ``paused`` or ``done``; SET to ``start stop pause step``."""
        return self._interpreter.run

    def set_run(self, word: str) -> None:
        """Carry out ``start``, ``stop``, ``pause``, or ``step``: one transition while paused."""
        if word not in _COMMANDS:
            raise ValueError(f"expected one of {' '.join(_COMMANDS)}{hint(word, _COMMANDS)}")
        self._asked()
        try:
            self._done(lambda now: self._interpreter.command(word, now))
        except ValueError as error:
            raise rtkit.PropertyError("conflict", str(error)) from None

    def set_event(self, name: str) -> None:
        """Have the machine take a named event."""
        if not name:
            raise ValueError("an event has a name")
        self._done(lambda now: self._interpreter.take(MachineEvent(name), now))

    @property
    def status(self) -> str:
        """State of the run, why it is paused, or the reason why there is no machine yet."""
        with self._changed:
            made = self._interpreter
            reason = f"paused in {made.state}: {made.why}"
            return self._trouble or (reason if made.run == "paused" else made.run)

    def get_source(self) -> str:
        """Property that the machine was got from; a SET gets it from there."""
        return self._source

    def set_source(self, target: str, goto: str = "") -> None:
        """Get the machine from a property of another service, and put it in force."""
        try:
            text = self._asked().get_bytes(self._services.resolved(target)).decode()
        except UnicodeDecodeError:
            raise rtkit.PropertyError("bad-value", f"{target}: expected a text") from None
        self.set("machine", text, goto)
        self._source = target

    def save(self, target: str = "") -> str:
        """Put the text of the machine into a property, by default where it was got from."""
        target = target or self._source
        if not target:
            raise ValueError("save where? It was not got from a property")
        self._asked().set_bytes(self._services.resolved(target), self.get("machine").encode())
        self._source = target
        return target

    def get_log(self, n: int = 100, since: int = -1, detail: bool = False) -> list[tuple[Any, ...]]:
        """Return ``(number time kind text)`` of the last ``n`` things that happened.

        Args:
            n: How many at most.
            since: The first ``n`` behind that number instead: page after page.
            detail: With values and machines.
        """
        n = max(0, n)
        with self._changed:
            log = self._interpreter.log
            behind = len(log) - n if since < 0 else since + 1 - (log[0].number if log else 0)
            found = list(islice(log, max(0, behind), max(0, behind) + n))
        return [
            (each.number, each.time + self._offset, each.kind, each.text)
            + ((each.detail,) if detail else ())
            for each in found
        ]

    def get_graph(self) -> rtkit.Text:
        """Return the picture of the machine [SVG], the active states in green."""
        from rtkit.services.statemachine.picture import draw_machine

        return rtkit.Text(draw_machine(self._interpreter.machine, self._interpreter.state))

    def gui(self) -> rtkit.Gui:
        """Return the widget of the service: its graph."""
        return rtkit.Gui(html=str(self.get_graph()))

    def gui_run(self) -> rtkit.Gui:
        """Return the widget of ``run``: what it may be SET to."""
        return rtkit.Gui("choice", choices=tuple(map(rtkit.Word, _COMMANDS)))

    # Work

    def _asked(self) -> rtkit.Client:
        if self._client is None:
            raise rtkit.PropertyError("conflict", "the service is not active")
        return self._client

    def _done(self, work: Any, *args: Any) -> None:
        """Have the interpreter do something, send what it wants sent, tell what has changed."""
        with self._changed:
            sends = work(time.monotonic(), *args)
            self._news.append(("state", self._interpreter.state))
            self._changed.notify()
            full = [each for each in sends if not self._link(each).send(each)]
            self._watch()
        for each in full:
            self._failed(each.target, "busy: very many SETs wait")
        with self._publish_lock:  # one at a time, so that listeners hear of states in their order
            while self._news:
                name, value = self._news.popleft()
                if value != getattr(self, name):
                    self._publish(name, value)

    def _link(self, send: OutgoingSet) -> ServiceLink:
        is_own = send.target.startswith("variables.")
        return self._link_to(service_of(send.get if is_own else send.target))

    def _link_to(self, service: str) -> ServiceLink:
        if service not in self._links:
            callbacks = (self._received, self._got, self._failed)
            self._links[service] = ServiceLink(self._asked(), self._services, *callbacks)
        return self._links[service]

    def _watch(self) -> None:
        """Listen to the properties that the active states look at, and to no others."""
        wanted = self._interpreter.wanted()
        if wanted == self._wanted or self._client is None:
            return
        services = {service_of(each) for each in wanted | self._wanted}
        self._wanted = wanted
        for service in services:
            of = frozenset(each for each in wanted if service_of(each) == service)
            self._link_to(service).want(of)

    def _begin(self) -> bool:
        """Get the machine from its source, and start it if it is to be; return whether it could."""
        try:
            if self._source:
                self.set_source(self._source)
            if self._is_autostarted:
                self.set_run("start")
        except (rtkit.PropertyError, ValueError) as error:
            self._trouble = f"failed: {error}"
        else:
            self._trouble = ""
        return not self._trouble

    def _work(self, is_ready: bool) -> None:
        while self._client is not None and not is_ready:
            with self._changed:
                self._changed.wait(_RETRY_S)
            is_ready = self._client is None or self._begin()
        while self._client is not None:
            with self._changed:
                at = self._interpreter.next_time()
                wait = None if at is None else at - time.monotonic()
                if wait is None or wait > 0:
                    self._changed.wait(wait)
                    continue
            self._done(self._interpreter.tick)

    def _received(self, event: MachineEvent) -> None:
        self._done(lambda now: self._interpreter.take(event, now))

    def _got(self, name: str, value: Any) -> None:
        if not isinstance(value, Plain):
            self._failed(f"variables.{name}", f"bad-value: no single value: {value}"[:200])
        elif name in self._interpreter.variables:
            self._assign(name, value)

    def _failed(self, target: str, why: str, is_known: bool = False) -> None:
        self._done(lambda now: self._interpreter.fail(target, why, now, is_known=is_known))


StateMachineInit = init_of(StateMachine)


def _names(machine: Machine) -> tuple[str, ...]:
    states = (f"machine.{path}" for path in machine.states)
    return ("machine", *states, *(f"variables.{name}" for name in machine.variables))
