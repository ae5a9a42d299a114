"""The real core of a manager over simulated processes: what holders do, a `World` knows."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.world import World
from rtkit.errors import Refused
from rtkit.manager.core import events as ev
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.fake import Call, FakeShell
from rtkit.property.exchange import Reply
from rtkit.records import replace
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.plain import decode, encode

_ENDPOINTS = ("sink", "serve", "offer")
_LONG_S = 100.0


class Managed(World):
    """A manager to which a `fake_tree` can be made; its slaves can be killed."""

    def __init__(self, types: Iterable[ComponentPattern]) -> None:
        super().__init__(types)
        self.holders = World(types)
        self.shell = self._begun()

    def _begun(self) -> FakeShell:
        shell = FakeShell()
        shell.state.host = self.host
        return shell

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
            self.holders.components.pop(instance, None)
        self.shell.end(key, reason)

    def fail(self, instance: str) -> None:
        """Put a component into Error."""
        self.holders.set_state(instance, LifeCycleState.ERROR, "ValueError: no (a.py:1)")
        self._tell(self.shell.state.holders[instance], instance)

    def lose_power(self) -> None:
        """Have another manager begin with nothing but what this one kept."""
        before, self.shell = self.shell, self._begun()
        self.holders.components.clear()
        self.shell.rows = dict(before.rows)
        rows = [(kind, name, text) for (kind, name), text in before.rows.items()]
        self.shell.feed(ev.Remembered(rows))
        replies: list[Reply] = []
        self.shell.feed(ev.RestoreAsked(replies.append))
        self.settle()
        assert len(replies) == 1

    def settle(self) -> None:
        """Let time pass until nothing is under way any more."""
        until = self.shell.now + _LONG_S
        self.serve()
        while not self.shell.core.is_idle and self.shell.now < until:
            wake_at = self.shell.wake_at
            self.shell.wait(0.0 if wake_at is None else max(0.0, wake_at - self.shell.now))
            self.serve()
        assert self.shell.core.is_idle

    def serve(self) -> None:
        """Do what is asked of zygote and holders until nothing is."""
        while self.shell.calls or self.shell.spawned:
            for name in list(self.shell.spawned):
                self.shell.fork(name)
            if self.shell.calls:
                self._serve(self.shell.calls.pop(0))
            self._end_the_retired()

    def _end_the_retired(self) -> None:
        for key, number in self.shell.signals:
            process = self.shell.state.processes.get(key)
            if process is not None and process.is_alive and key != OWN_PROCESS:
                self.shell.end(key, f"signal {number}")
        self.shell.signals.clear()

    def _serve(self, call: Call) -> None:
        message, instance = call.message, call.message.get("instance", "")
        if call.op == "delete":
            self.holders.components.pop(instance, None)
            self.shell.say(call.key, gone=instance)
        elif call.op in _ACTIONS:
            result = self.holders.perform(_ACTIONS[call.op](message))
            if not result.ok:
                self.shell.refuse(call, Refused(result.why))
                return
            self._tell(call.key, instance or parse_create(message["create"]).instance_name)
        self.shell.reply(call, "unix/x" if call.op in _ENDPOINTS else "")

    def _tell(self, key: int, instance: str) -> None:
        facts = replace(self.holders.components[instance], names=(), create="", process="")
        self.shell.say(key, facts=encode(facts))


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
