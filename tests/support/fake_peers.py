"""Managers of one host without processes: cores that ask each other, over a wire that loses.

Slaves are models that know what they hold; they outlive their manager.
"""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

from fake_shell import OWN, FakeCall, FakeRequest, FakeShell, facts

from rtkit.deployment.actions import Action, Connect, Create
from rtkit.errors import RtkitError, Unreachable
from rtkit.manager.core import events as ev
from rtkit.property.exchange import Reply
from rtkit.rtc.far_ends import far_name
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.rtc.serde import decode, encode


class FakeSlave:
    """A process: its components, and its ends of connectors."""

    def __init__(self, pid: int, name: str) -> None:
        self.pid = pid
        self.name = name
        self.endpoint = f"unix/{pid}"
        self.instances: list[str] = []
        self.ends: dict[str, ConnectorProfile] = {}
        self.opened: set[str] = set()
        self.reached: dict[str, str] = {}

    def unlink(self, connector_id: str) -> None:
        """Close what it holds of a connector."""
        self.ends.pop(connector_id, None)
        self.opened.discard(connector_id)
        self.reached.pop(connector_id, None)


class _Letter(NamedTuple):
    """A question under way, or the answer to one."""

    sender: FakeShell
    asked: ev.AskPeer
    until: float
    reply: Reply | None = None


class FakeHost:
    """Managers of these names, each killed and started at any time."""

    def __init__(self, *names: str) -> None:
        self.shells: dict[str, FakeShell] = {}
        self.slaves: dict[str, dict[int, FakeSlave]] = {name: {} for name in names}
        self.rows: dict[str, dict[tuple[str, str], str]] = {name: {} for name in names}
        self.known: dict[str, set[str]] = {}
        self.now = 0.0
        self.missed: set[tuple[str, str]] = set()
        self.letters: list[_Letter] = []
        self._numbers = itertools.count(1)
        for name in names:
            self.start(name)

    # managers

    def start(self, name: str) -> None:
        """Start a manager: it reads its store and finds its slaves, as they are."""
        number = next(self._numbers)
        shell = FakeShell(manager=name, pid=10_000 + number)
        self.shells[name], self.known[name] = shell, set()
        self.missed = {each for each in self.missed if name not in each}
        rows = [(kind, row, text) for (kind, row), text in self.rows[name].items()]
        shell.rows = self.rows[name]
        shell.feed(ev.StoreRead(rows, "boot", "", f"life-{number}"))
        for slave in self.slaves[name].values():
            held = [{**facts(each), "names": []} for each in slave.instances]
            ends = [encode(each) for each in slave.ends.values()]
            shell.feed(ev.SlaveFound(slave.pid, slave.name, held, ends))
        shell.feed(ev.RecoveryRequested(shell.requests.add(lambda _reply: None)))
        self.settle()

    def kill(self, name: str) -> None:
        """Kill a manager; its slaves live on, whoever waits for its answers is told."""
        shell = self.shells.pop(name)
        self.letters = [each for each in self.letters if each.sender is not shell]
        for other in list(self.shells.values()):
            if name in self.known[other.state.name]:
                self.known[other.state.name].discard(name)
                other.feed(ev.PeerLost(name, f"manager {name} is not running"))
        self.settle()

    def forget(self, name: str) -> None:
        """Stop a manager for good: its slaves end, its store goes."""
        self.slaves[name].clear()
        self.rows[name] = {}
        self.kill(name)

    def end_slave(self, name: str, pid: int) -> None:
        """Kill a slave."""
        del self.slaves[name][pid]
        shell = self.shells.get(name)
        key = shell.adopted.get(pid) if shell is not None else None
        if shell is not None and key is not None:
            shell.end(key)
            self.settle()

    # clients

    def ask(self, name: str, *actions: Action, timeout_s: float = 10.0) -> FakeRequest:
        """Have a manager asked for something."""
        asked = self.shells[name].ask(*actions, timeout_s=timeout_s)
        self.settle()
        return asked

    def make(self, name: str, instance: str, slave: str) -> FakeRequest:
        """Ask for a component in a slave."""
        return self.ask(name, Create(f"Thing?instance_name={instance}&manager_name={slave}"))

    def connector(self, id: str, maker: str, flow: str = "push") -> Connect:
        """Return what is asked of `maker`, whose A sends to the B of the other manager."""
        (other,) = (name for name in self.slaves if name != maker)
        ends = (PortRef("A", "out"), PortRef(far_name("B", other), "in"))
        return Connect(ConnectorProfile(id, id, ends, {"dataport.dataflow_type": flow}))

    # what goes on by itself

    def deliver(self, is_lost: bool = False, *, does_settle: bool = True) -> None:
        """Bring the oldest letter to its receiver, or lose it."""
        letter = self.letters.pop(0)
        sender, asked, until, reply = letter
        if sender is not self.shells.get(sender.state.name):
            return
        if is_lost:
            self._answer(sender, asked, Reply("no answer", Unreachable.kind))
        elif reply is not None:
            self._answer(sender, asked, reply)
        else:
            receiver = self.shells.get(asked.peer)
            if receiver is None or self.now > until:
                self._answer(sender, asked, Reply("not running", Unreachable.kind))
            else:
                self._hand_in(receiver, letter)
        if does_settle:
            self.settle()

    def _hand_in(self, receiver: FakeShell, letter: _Letter) -> None:
        sender, asked, until, _ = letter
        self._find(sender, asked.peer)

        def answer(reply: Reply) -> None:
            self.letters.append(_Letter(sender, asked, until, reply))

        receiver.feed(ev.PeerAsked(asked.text, receiver.requests.add(answer)))

    def _answer(self, shell: FakeShell, asked: ev.AskPeer, reply: Reply) -> None:
        shell.feed(ev.PeerAnswered(asked.number, reply.text, reply.error))

    def _find(self, shell: FakeShell, peer: str) -> None:
        if peer not in self.known[shell.state.name]:
            self.known[shell.state.name].add(peer)
            shell.feed(ev.PeerFound(peer))

    def settle(self) -> None:
        """Let slaves do what they are asked, and managers see who is there."""
        for _ in range(10_000):
            if not self._work():
                return
        raise AssertionError("it never ends")

    def _work(self) -> bool:
        for name, shell in list(self.shells.items()):
            while shell.spawned:
                slave, _ = shell.spawned.copy().popitem()
                pid = 100 * next(self._numbers)
                self.slaves[name][pid] = FakeSlave(pid, slave)
                shell.adopted[pid] = shell.fork(slave, pid)
                return True
            if shell.questions:
                for asked in shell.questions:
                    self.letters.append(_Letter(shell, asked, self.now + asked.timeout_s))
                shell.questions.clear()
            self.known[name].intersection_update(shell.watched)
            for peer in shell.watched:
                if peer not in self.shells and (name, peer) not in self.missed:
                    self.missed.add((name, peer))
                    shell.feed(ev.PeerLost(peer, f"manager {peer} is not running"))
                    return True
                if peer in self.shells and peer not in self.known[name]:
                    self._find(shell, peer)
                    return True
            if shell.told:
                self._told(name, shell, *shell.told.pop(0))
                return True
            if shell.calls:
                self._called(name, shell, shell.calls.pop(0))
                return True
            for key, number in list(shell.signals):
                shell.signals.remove((key, number))
                pids = [p for p in self.slaves[name] if shell.adopted.get(p) == key]
                for pid in pids:
                    self.end_slave(name, pid)
                return True
        return False

    def _slave(self, name: str, shell: FakeShell, key: int) -> FakeSlave | None:
        return next(
            (s for s in self.slaves[name].values() if shell.adopted.get(s.pid) == key), None
        )

    def _told(self, name: str, shell: FakeShell, key: int, message: Any) -> None:
        slave = self._slave(name, shell, key)
        if slave is not None and message["op"] == "unlink":
            slave.unlink(message["connector_id"])

    def _called(self, name: str, shell: FakeShell, call: FakeCall) -> None:
        if call.key == OWN:
            shell.reply(call, [] if call.op == "neighbours" else "")
            return
        slave = self._slave(name, shell, call.key)
        if slave is None:
            return
        try:
            value = self._do(slave, call.op, call.message, shell)
        except RtkitError as error:
            shell.refuse(call, error)
        else:
            shell.reply(call, value)

    def _do(self, slave: FakeSlave, op: str, message: Any, shell: FakeShell) -> Any:
        if op == "create":
            instance = message["create"].partition("instance_name=")[2].partition("&")[0]
            slave.instances.append(instance)
            shell.say(shell.adopted[slave.pid], facts=facts(instance))
        elif op == "delete":
            instance = message["instance"]
            slave.instances.remove(instance)
            for id, end in list(slave.ends.items()):
                if any(each.instance == instance for each in end.ports):
                    slave.unlink(id)
            shell.say(shell.adopted[slave.pid], gone=instance)
        elif op == "unlink":
            slave.unlink(message["connector_id"])
        elif op in ("sink", "serve", "source", "fetch"):
            connector = decode(ConnectorProfile, message["connector"])
            slave.ends[connector.connector_id] = connector
            if op in ("sink", "serve"):
                slave.opened.add(connector.connector_id)
                return slave.endpoint
            self._reach(slave, connector.connector_id, message["endpoint"])
        return ""

    def _reach(self, slave: FakeSlave, connector_id: str, endpoint: str) -> None:
        living = [each for slaves in self.slaves.values() for each in slaves.values()]
        if not any(s.endpoint == endpoint and connector_id in s.opened for s in living):
            slave.unlink(connector_id)
            raise Unreachable(f"nobody takes data at {endpoint}")
        slave.reached[connector_id] = endpoint

    def calm(self, seconds: float = 30.0) -> None:
        """Let all letters arrive, and time pass, until nothing goes on any more."""
        count = 0
        for _ in range(int(seconds / 0.5)):
            while self.letters:
                self.deliver()
                count += 1
                assert count < 40 * seconds, "they never have done with each other"
            self.wait(0.5)

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.now += seconds
        for shell in list(self.shells.values()):
            shell.wait(seconds)
        self.settle()

    # what is there

    def trouble(self, name: str, connector_id: str) -> str | None:
        """Return why a manager shows half a connector, "" if it is whole; None if not at all."""
        known = self.shells[name].state.connectors.get(connector_id)
        return None if known is None else known.trouble

    def is_joined(self, connector_id: str) -> bool:
        """Return whether two slaves are really connected."""
        living = [each for slaves in self.slaves.values() for each in slaves.values()]
        opened = {each.endpoint for each in living if connector_id in each.opened}
        return any(each.reached.get(connector_id) in opened for each in living)
