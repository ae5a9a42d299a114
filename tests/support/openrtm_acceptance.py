"""Acceptance of components as they lie: each is loaded, wired, driven, saved and brought up again.

The same steps for every component; none knows of a certain one. A partner is made of each, with
ports the other way round, in a process of its own. What its author has it refuse is no failure:
a callback that returns RTC_ERROR, an operation that raises NO_IMPLEMENT.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from waiting import until

from rtkit.api.attaching import TerminalClient
from rtkit.api.connect import connect
from rtkit.api.system_profiles import SystemProfile
from rtkit.api.tree import Tree
from rtkit.component.standin import TRANSMIT
from rtkit.component.values.type_layout import zero
from rtkit.deployment.actions import ActivateSet, Create, SetParameters
from rtkit.errors import RtkitError
from rtkit.openrtm.migrate.files import migrate, plan_migration
from rtkit.probe.calling import ProvidedOperation, operations_at
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.names import parse_path
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import DEFINITION, PortProfile, TypeProfile
from rtkit.testing.realm import own_manager

_BOUND_S = 20.0
_EVENT = re.compile(r"say fsm_event_name=NAME \(events: (\w+)")
_SLOW = ContextPattern(rate=50.0)
_OF_DATA = ("dataport.data_type", DEFINITION)
"""Properties of a port that are those of its partner, too."""
_OTHER = {PortType.IN: PortType.OUT, PortType.OUT: PortType.IN, PortType.SERVICE: PortType.SERVICE}
_POLES = {Polarity.PROVIDED: Polarity.REQUIRED, Polarity.REQUIRED: Polarity.PROVIDED}


@dataclass
class Acceptance:
    """What became of the component types of one file.

    Attributes:
        file: The module.
        types: Names of the types that it registers.
        steps: Names of the steps that went well.
        failures: Step and reason of those that did not.
        partners: Actions that make the partners again.
    """

    file: Path
    types: list[str] = field(default_factory=list)
    steps: list[str] = field(default_factory=list)
    failures: dict[str, str] = field(default_factory=dict)
    partners: list[Create] = field(default_factory=list)

    def step(self, name: str, work: Callable[[], object]) -> bool:
        """Do one step; return whether it went well."""
        try:
            work()
        except (RtkitError, AssertionError) as error:
            self.failures[name] = str(error)
            return False
        self.steps.append(name)
        return True


def accept(file: Path, init: str = "") -> Acceptance:
    """Take the components of a file through everything, in managers of their own.

    Files in Python 2 are migrated before, where they lie.
    """
    migrate(plan_migration([str(file)]))
    found = Acceptance(file)
    saved: list[SystemProfile] = []
    with own_manager(file.parent) as tree:
        if not found.step("load", lambda: tree.load(str(file), init)):
            return found
        found.types = [
            kind.type_name for module in tree.snapshot().modules for kind in module.types
        ]
        found.step("offer a type", lambda: _claim(bool(found.types), "none was registered"))
        for kind in found.types:
            _Subject(tree, kind, found).take_through()
        found.step("save", lambda: saved.append(tree.save(unconnected=True)))
        before = _outside(tree)
    if saved:
        with own_manager(file.parent) as tree:
            tree.load(str(file), init)
            for partner in found.partners:
                tree.perform(partner)
            found.step("bring up what was saved", lambda: tree.bring_up(saved[0]))
            found.step("be as before", lambda: _same(before, _outside(tree)))
    return found


class _Subject:
    """One component of a type, and its partner."""

    def __init__(self, tree: Tree, kind: str, found: Acceptance) -> None:
        self._tree = tree
        self._kind = kind
        self._found = found

    def take_through(self) -> None:
        """Do all steps; those that need one that failed are left out."""
        if not self._step("create", self._create):
            return
        for port in self._facts.ports:
            self._step(f"connect {port.name}", partial(self._connect, port))
        for name in filter(_is_shown, self._facts.sets):
            self._step(f"take set {name}", partial(self._configure, name))
        self._step("take the first set again", partial(self._configure, self._facts.active_set))
        self._tree.activate(self._partner)
        if self._step("activate", self._activate):
            for port in self._facts.ports:
                if port.port_type is PortType.IN:
                    self._step(f"get values at {port.name}", partial(self._await_values, port))
        for operation in self._operations():
            self._step(f"answer {operation.label}", partial(self._call, operation))
        self._step("be alive", self._stay)
        self._step("deactivate", self._deactivate)
        self._step("activate again", self._activate)

    def _step(self, name: str, work: Callable[[], object]) -> bool:
        return self._found.step(f"{self._kind}: {name}", work)

    def _create(self) -> None:
        self._path = self._tree.create(self._kind)
        self._facts = self._tree.component(self._path)
        name = f"{self._kind}Partner"
        ports = tuple(map(_other_way_round, self._facts.ports))
        pattern = ComponentPattern(TypeProfile(name), ports, contexts=(_SLOW,))
        create = f"{name}?instance_name={name}&manager_name=partner&{TRANSMIT}=default"
        partner = Create(create, pattern=pattern)
        self._tree.perform(partner)
        self._found.partners.append(partner)
        self._partner = f"/localhost/{name}.rtc"

    def _connect(self, port: PortProfile) -> None:
        ends = f"{self._path}:{port.name}", f"{self._partner}:{port.name}"
        try:
            self._tree.connect(*ends)
        except RtkitError as error:
            event = _EVENT.search(str(error))  # a port for events has to be told which
            if event is None:
                raise
            self._tree.connect(*ends, fsm_event_name=event[1])

    def _activate(self) -> None:
        before_s, self._tree.timeout_s = self._tree.timeout_s, _BOUND_S
        try:
            with self._answering():
                self._tree.activate(self._path)
        except RtkitError as error:
            if "returned RTC_ERROR" not in str(error):
                raise
        finally:
            self._tree.timeout_s = before_s

    @contextmanager
    def _answering(self) -> Iterator[None]:
        """Answer what it asks its user meanwhile."""
        is_over = threading.Event()

        def answer() -> None:
            with connect() as tree:
                terminal = TerminalClient(tree, self._facts.instance)
                while not is_over.wait(0.2):
                    if terminal.look().waits:
                        terminal.send([b"1\n"], _BOUND_S)

        user = threading.Thread(target=answer)
        user.start()
        try:
            yield
        finally:
            is_over.set()
            user.join()

    def _configure(self, name: str) -> None:
        values = self._facts.sets[name]
        self._tree.perform(SetParameters(self._facts.instance, name, values))
        self._tree.perform(ActivateSet(self._facts.instance, name))
        now = self._tree.component(self._path)
        _claim(now.active_set == name, f"{now.active_set} is the active set")
        _claim(now.sets[name] == values, f"{now.sets[name]} are its values, not {values}")

    def _await_values(self, port: PortProfile) -> None:
        self._tree.wait(f"{self._partner}:{port.name}", state="data", timeout_s=_BOUND_S)

    def _operations(self) -> Iterator[ProvidedOperation]:
        for port in self._facts.ports:
            if any(each.polarity is Polarity.PROVIDED for each in port.interfaces):
                operations: list[ProvidedOperation] = []
                find = partial(self._find_operations, port, operations)
                self._step(f"tell the operations of {port.name}", find)
                yield from operations

    def _find_operations(self, port: PortProfile, found: list[ProvidedOperation]) -> None:
        found += operations_at(self._tree, parse_path(f"{self._path}:{port.name}"))[0]

    def _call(self, operation: ProvidedOperation) -> None:
        method = operation.interface.interface.methods[operation.operation.name]
        arguments = [zero(layout) for layout in method.layouts.values()]
        try:
            operation.call(self._tree, arguments, _BOUND_S)
        except RtkitError as error:
            if "NO_IMPLEMENT" not in str(error):
                raise

    def _stay(self) -> None:
        # One whose callback took its time was told to be stuck, and is not when it has returned.
        until(lambda: "stuck in" not in self._tree.component(self._path).trouble, "it is back")
        facts = self._tree.component(self._path)
        _claim(not facts.zombie, f"its process has ended: {facts.zombie}")
        _claim(not facts.trouble, facts.trouble)

    def _deactivate(self) -> None:
        try:
            self._tree.deactivate(self._path)
        except RtkitError as error:
            if "state is Error" not in str(error):
                raise
            self._tree.reset(self._path)


def _other_way_round(port: PortProfile) -> PortProfile:
    interfaces = tuple(replace(each, polarity=_POLES[each.polarity]) for each in port.interfaces)
    kept = {key: port.properties[key] for key in _OF_DATA if key in port.properties}
    return PortProfile(port.name, _OTHER[port.port_type], kept, interfaces)


def _is_shown(set_id: str) -> bool:
    return not set_id.startswith("__")


def _outside(tree: Tree) -> dict[tuple[str, str], object]:
    """Return what of each component is to be the same after it was saved and brought up."""
    found: dict[tuple[str, str], object] = {}
    snapshot = tree.snapshot()
    for facts in snapshot.components:
        found |= {
            (facts.instance, "type"): facts.type,
            (facts.instance, "ports"): {(each.name, each.port_type) for each in facts.ports},
            (facts.instance, "active set"): facts.active_set,
        }
        for name, values in facts.sets.items():
            found |= {(facts.instance, f"{name}.{key}"): value for key, value in values.items()}
    return {
        **found,
        ("connectors", ""): sorted(sorted(map(str, each.ports)) for each in snapshot.connectors),
    }


def _same(before: dict[tuple[str, str], object], after: dict[tuple[str, str], object]) -> None:
    differing = [
        f"{' '.join(key)} was {value}, and is {after.get(key)}"
        for key, value in before.items()
        if after.get(key) != value
    ]
    _claim(not differing, "; ".join(differing))


def _claim(holds: bool, why: str) -> None:
    if not holds:
        raise AssertionError(why)
