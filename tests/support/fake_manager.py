"""Fake manager: the real core over fake containers, without a process, a socket or a clock."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any
from unittest import mock

from fake_containers import FakeContainers, code_of
from fake_shell import FakeCall, FakeShell

from rtkit.deployment.actions import Action, Result
from rtkit.deployment.facts import ComponentFacts, Followed, ProcessFacts, Snapshot
from rtkit.deployment.plan_lock import PlanLock
from rtkit.errors import RtkitError, Unreachable
from rtkit.manager.core import events as ev
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.state import Process
from rtkit.property.exchange import Reply
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ConnectorProfile, ModuleProfile

_OF_MANAGER = {"names", "create", "zombie", "trouble", "process"}
"""Facts of a component that its container does not know."""
_LONG_S = 100.0


class _Shell(FakeShell):
    def __init__(self, world: FakeManager) -> None:
        super().__init__(world.host, world.manager, os.getpid())
        self._world = world

    def _carry_out(self, instruction: ev.Instruction) -> None:
        super()._carry_out(instruction)
        if isinstance(instruction, ev.SendToContainer) and "call" not in instruction.message:
            self._world.hear(instruction.key, instruction.message)
        elif isinstance(instruction, ev.Publish):
            self._world.publish(instruction)


class Immortal:
    """A life without end: of a lease holder that nobody watches."""

    is_over = False

    def close(self) -> None:
        """Do nothing."""


class FakeManager:
    """A manager with its slaves, components and connectors.

    Attributes:
        types: What can be created, by implementation id.
        modules: What a module offers once it is loaded, by path.
        fault: Called before each action; a returned result is its outcome (to make it fail).
        lacking: Why nothing can be made of a type, by implementation id; others may be made.
        gone: Why it answers nobody; empty when it does.
        loadable: The modules that could be loaded, as told to clients.
        performed: Every action performed, in order.
        peers: The other managers of its host, by name.
        changed: Called after facts of a component changed.
        publish: Receives what is published.
        plan_lock: Who carries a plan out.
        shell: The core, and what it wants done.
    """

    def __init__(
        self,
        types: Iterable[ComponentPattern] = (),
        *,
        host: str = "box",
        manager: str = "manager",
        modules: Mapping[str, Iterable[ComponentPattern]] | None = None,
    ) -> None:
        self.host = host
        self.manager = manager
        self.containers = FakeContainers(types, modules)
        self.types, self.modules = self.containers.types, self.containers.modules
        self.lacking: dict[str, str] = {}
        self.loadable = ""
        self.gone = ""
        self.fault: Callable[[Action], Result | None] = _no_fault
        self.performed: list[Action] = []
        self.peers: Mapping[str, FakeManager] = {}
        self.changed: Callable[[], object] = _nothing
        self.publish: Callable[[ev.Publish], object] = _nothing
        self.plan_lock = PlanLock(lambda _pid: Immortal())
        self._pids = itertools.count(1001)
        self.shell: FakeShell = _Shell(self)
        self.properties["manager.instance_name"] = manager

    @property
    def components(self) -> dict[str, ComponentFacts]:
        """The components as the manager knows them."""
        return self.shell.state.components

    @property
    def connectors(self) -> dict[str, ConnectorProfile]:
        """The connectors."""
        return self.shell.state.connectors

    @property
    def processes(self) -> dict[str, ProcessFacts]:
        """The processes, by name."""
        return {process.name: process for process in self.snapshot().processes}

    @property
    def loaded(self) -> dict[str, ModuleProfile]:
        """The modules that are loaded."""
        return self.shell.state.modules

    @property
    def properties(self) -> dict[str, str]:
        """Properties that the manager has of itself."""
        return self.shell.state.properties

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the manager itself."""
        return self.shell.state.names

    @names.setter
    def names(self, names: tuple[str, ...]) -> None:
        self.shell.state.names = names

    @property
    def systems(self) -> tuple[Followed, ...]:
        """What is reported of systems that the manager follows; nobody follows them here."""
        return tuple(self.shell.state.kept.reached.values())

    @systems.setter
    def systems(self, systems: tuple[Followed, ...]) -> None:
        self.shell.state.kept.reached = {each.system: each for each in systems}
        self._notify()

    def snapshot(self) -> Snapshot:
        """Return everything that is known."""
        return self.shell.state.snapshot()

    def perform(self, action: Action) -> Result:
        """Perform one action and return its outcome."""
        self.performed.append(action)
        planned = self.fault(action)
        if planned is not None:
            return planned
        asked = self.shell.ask(action)
        self._wait(lambda: asked.is_answered)
        self.changed()
        return asked.result

    def batch(self, actions: Iterable[Action], is_ordered: bool = True) -> list[Result]:
        """Perform actions one after the other; in order, the first failure ends the batch."""
        results = []
        for action in actions:
            results.append(self.perform(action))
            if is_ordered and not results[-1].ok:
                break
        return results

    def kill(self, process: str, reason: str = "signal 9") -> None:
        """End a slave as the kernel would; nothing else happens yet."""
        named = [p for p in self.shell.state.processes.values() if p.name == process]
        self._end(named[-1], reason)
        self.changed()

    def update(self, instance: str, **changes: object) -> None:
        """Replace facts of a component, as if its container had reported them."""
        if instance in self.containers.components:
            reported = {key: changes.pop(key) for key in changes.keys() - _OF_MANAGER}
            self.containers.put(instance, **reported)
            self._tell(self.shell.state.containers[instance], instance)
        self.shell.state.update(instance, **changes)
        self._notify()

    def state_of(self, instance: str) -> str:
        """Return the merged state of a component."""
        return self.components[instance].state

    def set_state(self, instance: str, state: LifeCycleState, cause: str = "") -> None:
        """Put a component into a state, as if something had happened to it."""
        self.containers.set_state(instance, state, cause)
        self._tell(self.shell.state.containers[instance], instance)
        self.changed()

    def _notify(self) -> None:
        """Have the core look at what was changed behind its back."""
        self.shell.feed(ev.TimerExpired())
        self.changed()

    def hear(self, key: int, message: Mapping[str, Any]) -> None:
        """Have a container do what needs no answer."""
        self._do(key, message)

    # lives of managers

    def lose_power(self) -> None:
        """Have another manager begin with nothing but what this one kept."""
        self.end_slaves()
        self.begin_anew()
        self.settle()

    def end_slaves(self) -> None:
        """End all slaves; no manager hears of it."""
        for instance in list(self.containers.components):
            self.containers.drop(instance)
        self.containers.ends.clear()

    def go(self, why: str) -> None:
        """Have the manager end, and the others of its host notice; `why` is what clients hear."""
        self.gone = why
        for peer in self.peers.values():
            if peer is not self:
                peer.shell.feed(ev.PeerLost(self.manager, why))

    def come_back(self) -> None:
        """Have another manager begin with what one kept that went, and be found by the others."""
        self.gone = ""
        self.begin_anew()
        for peer in (self, *self.peers.values()):
            peer.settle()

    def begin_anew(self) -> None:
        """Have the manager killed and another one begin, to which the slaves come that live.

        They have done by then what they were told. Nothing that it asks for is done yet.
        """
        for call in self.shell.calls:
            if call.key != OWN_PROCESS:
                with suppress(RtkitError):
                    self.containers.do(self._pid(call.key), call.message)
        before, self.shell = self.shell, _Shell(self)
        self.shell.rows = dict(before.rows)
        rows = [(kind, name, text) for (kind, name), text in before.rows.items()]
        self.shell.feed(ev.StoreRead(rows))
        self.containers.end_process(before.state.pid)
        for process in before.state.processes.values():
            if process.is_slave and process.is_alive and process.pid:
                self._come_back(process)
        self.shell.feed(ev.RecoveryRequested(self.shell.requests.add(_nothing)))

    def _come_back(self, process: Process) -> None:
        held = self.containers.held_by(process.pid)
        wires = [wire for (pid, _), wire in self.containers.ends.items() if pid == process.pid]
        told = [{**self.containers.told(each), **self.containers.memory[each]} for each in held]
        asked = self.containers.asked.by_component(held)
        self.shell.feed(ev.SlaveFound(process.pid, process.name, told, wires, asked=asked))

    def settle(self) -> None:
        """Let time pass until nothing is under way any more."""
        self._wait(lambda: self.shell.core.is_idle)

    def _wait(self, is_so: Callable[[], bool]) -> None:
        """Serve, and let time pass, until something is so."""
        until = self.shell.now + _LONG_S
        self.serve()
        while not is_so() and self.shell.now < until:
            wake_at = self.shell.wake_at
            self.shell.wait(0.0 if wake_at is None else max(0.0, wake_at - self.shell.now))
            self.serve()
        assert is_so()

    def perform_unrecorded(self, action: Action) -> None:
        """Have an action done, and nothing recorded of it."""
        with mock.patch.object(self.shell, "_keep"):
            self.shell.ask(action)
            self.serve()

    def serve(self, most: int = sys.maxsize) -> None:
        """Do what is asked of zygote and containers until nothing is, or so much of it."""
        self._find_peers()
        while most > 0 and (
            self.shell.calls or self.shell.spawned or self.shell.signals or self.shell.questions
        ):
            most -= 1
            self._ask_peers()
            self._find_peers()
            for name in list(self.shell.spawned):
                self.shell.fork(name, next(self._pids))
            if self.shell.calls:
                self._serve(self.shell.calls.pop(0))
            self._end_the_retired()

    def _find_peers(self) -> None:
        """Tell of the managers that are watched for and run, as the runtime folder does."""
        for name in self.shell.watched:
            peer = self.peers.get(name)
            if peer is not None and not peer.gone and name not in self.shell.state.peers:
                self.shell.feed(ev.PeerFound(name))

    def _ask_peers(self) -> None:
        """Bring questions to other managers, and their answers back."""
        while self.shell.questions:
            asked = self.shell.questions.pop(0)
            peer, shell = self.peers.get(asked.peer), self.shell

            def answer(reply: Reply, number: int = asked.number, shell: FakeShell = shell) -> None:
                shell.feed(ev.PeerAnswered(number, reply.text, reply.error))

            if peer is None or peer.gone:
                answer(Reply(f"manager {asked.peer} is not running", Unreachable.kind))
                continue
            if asked.peer not in shell.state.peers:
                shell.feed(ev.PeerFound(asked.peer))
            peer.shell.feed(ev.PeerAsked(asked.text, peer.shell.requests.add(answer)))
            peer.serve()

    def _end_the_retired(self) -> None:
        for key, number in self.shell.signals:
            process = self.shell.state.processes.get(key)
            if process is not None and process.is_alive and key != OWN_PROCESS:
                self._end(process, f"signal {number}")
        self.shell.signals.clear()

    def _end(self, process: Process, reason: str) -> None:
        self.containers.end_process(process.pid)
        self.shell.end(process.key, reason)

    def _serve(self, call: FakeCall) -> None:
        try:
            value = self._do(call.key, call.message)
        except RtkitError as error:
            self.shell.refuse(call, error, code_of(error))
        else:
            self.shell.reply(call, value)

    def _do(self, key: int, message: Mapping[str, Any]) -> Any:
        """Have a container do what it is asked, and report what changed; return its answer."""
        before = dict(self.containers.components)
        answer = self.containers.do(self._pid(key), message)
        now = self.containers.components
        for instance in [name for name in now if now[name] is not before.get(name)]:
            self._tell(key, instance)
        for instance in before.keys() - now.keys():
            self.shell.say(key, gone=instance)
        return answer

    def _pid(self, key: int) -> int:
        return self.shell.state.processes[key].pid

    def _tell(self, key: int, instance: str) -> None:
        self.shell.say(key, facts=self.containers.told(instance))


def meet(managers: Mapping[str, FakeManager]) -> None:
    """Have managers of one host reach each other."""
    for each in managers.values():
        each.peers = managers
        each.shell.feed(ev.RecoveryRequested(each.shell.requests.add(_nothing)))


def _nothing(*_: object) -> None:
    """Do nothing."""


def _no_fault(_action: Action) -> Result | None:
    return None
