"""Runs the real core of a manager over simulated processes, whose containers are `FakeManager`s."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any
from unittest import mock

from fake_manager import FakeManager
from fake_shell import FakeCall, FakeShell

from rtkit.container.user_requests import UserRequests
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.facts import Snapshot
from rtkit.errors import Refused
from rtkit.fast_dataclass import replace
from rtkit.manager.core import events as ev
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.state import Process
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.serde import decode, encode

_ENDPOINTS = ("sink", "serve", "offer")
_ENDS = (*_ENDPOINTS, "link", "source", "fetch", "consult", "keep")
_LONG_S = 100.0


class _Shell(FakeShell):
    def __init__(self, world: Managed) -> None:
        super().__init__()
        self._world = world

    def _carry_out(self, instruction: ev.Instruction) -> None:
        super()._carry_out(instruction)
        if isinstance(instruction, ev.SendToContainer) and "call" not in instruction.message:
            self._world.hear(instruction.key, instruction.message)


class Managed(FakeManager):
    """A manager to which a `fake_tree` can be made; its slaves can be killed."""

    def __init__(self, types: Iterable[ComponentPattern]) -> None:
        super().__init__(types)
        self.containers = FakeManager(types)
        self.asked = UserRequests()
        self.ends: dict[tuple[str, str], Any] = {}
        self.memory: dict[str, Any] = {}
        self._slave_pids = itertools.count(20_000)
        self.shell = self._begun()

    def _begun(self) -> FakeShell:
        shell = _Shell(self)
        shell.state.host = self.host
        return shell

    def hear(self, key: int, message: Mapping[str, Any]) -> None:
        """Have a holder do what needs no answer."""
        if message["op"] == "unlink":
            self._end(key, message)
        elif message["op"] == "remember":
            self.memory[message["instance"]] = message["kept"]

    def snapshot(self) -> Snapshot:
        return self.shell.state.snapshot()

    def perform(self, action: Action) -> Result:
        (result,) = self.batch([action])
        return result

    def batch(self, actions: Iterable[Action], is_ordered: bool = True) -> list[Result]:
        asked = self.shell.ask(*actions, ordered=is_ordered)
        self.serve()
        self.changed()
        return list(asked.results)

    def kill(self, process: str, reason: str = "signal 9") -> None:
        """End a slave; nothing else happens yet."""
        (key,) = [p.key for p in self.shell.state.processes.values() if p.name == process]
        for instance in self.shell.state.held_by(key):
            self._drop(instance)
        self.ends = {end: wire for end, wire in self.ends.items() if end[0] != process}
        self.shell.end(key, reason)

    def _drop(self, instance: str) -> None:
        self.containers.components.pop(instance, None)
        self.asked.forget(instance)

    def fail(self, instance: str) -> None:
        """Put a component into Error."""
        self.containers.set_state(instance, LifeCycleState.ERROR, "ValueError: no (a.py:1)")
        self._tell(self.shell.state.containers[instance], instance)

    def lose_power(self) -> None:
        """Have another manager begin with nothing but what this one kept."""
        self.end_slaves()
        self.begin_anew()
        self.settle()

    def end_slaves(self) -> None:
        """End all slaves; no manager hears of it."""
        for instance in list(self.containers.components):
            self._drop(instance)
        self.ends.clear()

    def begin_anew(self) -> None:
        """Have the manager killed and another one begin, to which the slaves come that live.

        They have done by then what they were told. Nothing that it asks for is done yet.
        """
        for call in self.shell.calls:
            if call.key != OWN_PROCESS:
                self._do(call.key, call.message)
        before, self.shell = self.shell, self._begun()
        self.shell.rows = dict(before.rows)
        rows = [(kind, name, text) for (kind, name), text in before.rows.items()]
        self.shell.feed(ev.StoreRead(rows))
        claims = {name: claim.key for name, claim in before.state.claims.items()}
        keys = {**claims, **before.state.containers}
        for instance in list(self.containers.components):
            if keys[instance] == OWN_PROCESS:
                self._drop(instance)
        self.ends = {end: wire for end, wire in self.ends.items() if end[0] != self.manager}
        for process in before.state.processes.values():
            if process.is_slave and process.is_alive and process.pid:
                held = [each for each in self.containers.components if keys[each] == process.key]
                self._come_back(process, held)
        self.shell.feed(ev.RecoveryRequested(self.shell.requests.add(lambda _reply: None)))

    def _come_back(self, process: Process, held: list[str]) -> None:
        wires = [wire for (name, _), wire in self.ends.items() if name == process.name]
        told = [{**self._facts(instance), **self.memory[instance]} for instance in held]
        asked = self.asked.told(held)
        self.shell.feed(ev.SlaveFound(process.pid, process.name, told, wires, asked=asked))

    def settle(self) -> None:
        """Let time pass until nothing is under way any more."""
        until = self.shell.now + _LONG_S
        self.serve()
        while not self.shell.core.is_idle and self.shell.now < until:
            wake_at = self.shell.wake_at
            self.shell.wait(0.0 if wake_at is None else max(0.0, wake_at - self.shell.now))
            self.serve()
        assert self.shell.core.is_idle

    def perform_unrecorded(self, action: Action) -> None:
        """Have an action done, and nothing recorded of it."""
        with mock.patch.object(self.shell, "_keep"):
            self.shell.ask(action)
            self.serve()

    def serve(self, most: int = sys.maxsize) -> None:
        """Do what is asked of zygote and holders until nothing is, or so much of it."""
        while (self.shell.calls or self.shell.spawned) and most > 0:
            most -= 1
            for name in list(self.shell.spawned):
                self.shell.fork(name, next(self._slave_pids))
            if self.shell.calls:
                self._serve(self.shell.calls.pop(0))
            self._end_the_retired()

    def _end_the_retired(self) -> None:
        for key, number in self.shell.signals:
            process = self.shell.state.processes.get(key)
            if process is not None and process.is_alive and key != OWN_PROCESS:
                self.shell.end(key, f"signal {number}")
        self.shell.signals.clear()

    def _serve(self, call: FakeCall) -> None:
        message, instance = call.message, call.message.get("instance", "")
        result = self._do(call.key, message)
        if not result.ok:
            self.shell.refuse(call, Refused(result.why))
            return
        if call.op == "delete":
            self.shell.say(call.key, gone=instance)
        elif call.op in _ACTIONS:
            self._tell(call.key, instance or parse_create(message["create"]).instance_name)
        self.shell.reply(call, "unix/x" if call.op in _ENDPOINTS else "")

    def _do(self, key: int, message: Mapping[str, Any]) -> Result:
        """Do what a holder is asked; nobody is told of it yet."""
        if message["op"] == "delete":
            instance, name = message["instance"], self.shell.state.processes[key].name
            for end, wire in list(self.ends.items()):
                if end[0] == name and instance in [port["instance"] for port in wire["ports"]]:
                    del self.ends[end]
            self._drop(instance)
        elif message["op"] in _ENDS or message["op"] == "unlink":
            self._end(key, message)
        elif message["op"] in _ACTIONS:
            result = self.containers.perform(_ACTIONS[message["op"]](message))
            if message["op"] == "create" and result.ok:
                self.memory[result.value] = message["kept"]
            elif result.ok:
                self.asked.note(message)
            return result
        return Result()

    def _end(self, key: int, message: Mapping[str, Any]) -> None:
        """Have a process hold an end of a connector, or not any more."""
        name = self.shell.state.processes[key].name
        if message["op"] == "unlink":
            self.ends.pop((name, message["connector_id"]), None)
        else:
            self.ends[name, message["connector"]["connector_id"]] = message["connector"]

    def _tell(self, key: int, instance: str) -> None:
        self.shell.say(key, facts=self._facts(instance))

    def _facts(self, instance: str) -> Any:
        return encode(
            replace(self.containers.components[instance], names=(), create="", process="")
        )


def _create(message: Any) -> Action:
    plain = message["pattern"]
    return act.Create(message["create"], (), plain and decode(ComponentPattern, plain))


_ACTIONS: dict[str, Callable[[Any], Action]] = {
    "create": _create,
    "set": lambda m: act.SetParameters(m["instance"], m["set_id"], m["values"]),
    "activate_set": lambda m: act.ActivateSet(m["instance"], m["set_id"]),
    "change_state": lambda m: act.ChangeState(
        m["instance"], m["context"], Transition(m["transition"])
    ),
    "set_rate": lambda m: act.SetRate(m["instance"], m["context"], m["rate"]),
}
