"""Fake shell without processes: feeds a core with events at a fake time, keeps its instructions.

For tests, which play the zygote, the kernel and the containers.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Mapping, Sequence
from typing import Any

from rtkit.deployment.actions import Action, Create, Result
from rtkit.deployment.batch import Batch, results_from_text
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.limits import SlaveLimits
from rtkit.errors import NotFound, RtkitError
from rtkit.manager.core import events as ev
from rtkit.manager.core.core import Core
from rtkit.manager.core.event_ring import EventRing
from rtkit.manager.core.modules import TRIAL
from rtkit.manager.core.requests import PendingRequests
from rtkit.manager.core.state import ManagerState, Process
from rtkit.property.exchange import Reply
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ExecutionKind, PortType
from rtkit.rtc.far_ends import split_far
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    ModuleProfile,
    PortProfile,
    PortRef,
    TypeProfile,
)
from rtkit.rtc.serde import encode

OWN = ev.OWN_PROCESS
PORTS = (
    PortProfile("out", PortType.OUT, {"dataport.data_type": "TimedLong"}),
    PortProfile("in", PortType.IN, {"dataport.data_type": "TimedLong"}),
    PortProfile("text", PortType.IN, {"dataport.data_type": "TimedString"}),
    PortProfile("svc", PortType.SERVICE),
)


class FakeCall:
    """A message to a container that wants an answer."""

    def __init__(self, key: int, message: Mapping[str, Any]) -> None:
        self.key = key
        self.number: int = message["call"]
        self.op: str = message["op"]
        self.message = message

    def __repr__(self) -> str:
        return f"<{self.op} to {self.key}>"


class FakeRequest:
    """A batch that was handed in, and its outcome."""

    def __init__(self) -> None:
        self.replies: list[Reply] = []

    @property
    def is_answered(self) -> bool:
        """Return whether an answer came."""
        return bool(self.replies)

    @property
    def results(self) -> tuple[Result, ...]:
        """The results of its actions, of the one answer that it got."""
        (reply,) = self.replies
        return results_from_text(reply.value())

    @property
    def result(self) -> Result:
        """The result of its only action."""
        (result,) = self.results
        return result


def facts(instance: str, ports: Sequence[PortProfile] = PORTS) -> dict[str, Any]:
    """Return the report of a container about a component."""
    context = ExecutionContextProfile("0", ExecutionKind.PERIODIC, 10.0, instance)
    type_ = TypeProfile("Thing")
    made = ComponentFacts(instance, type_, "", tuple(ports), {"default": {}}, "default", (context,))
    plain: dict[str, Any] = encode(made)
    return plain


def module_of(call: FakeCall, *types: str) -> dict[str, Any]:
    """Return the answer of a container that has loaded a module."""
    path, init = call.message["path"], call.message["init"] or "init"
    profile = ModuleProfile(path, init, tuple(map(TypeProfile, types)))
    return {"module": encode(profile), "fingerprint": 1}


def wire(
    connector_id: str, out: str = "A.out", into: str = "B.in", **properties: str
) -> ConnectorProfile:
    """Return a connector between two ports that are written ``instance.port``."""
    ends = tuple(PortRef(*end.split(".")) for end in (out, into))
    named = {key.replace("__", "."): value for key, value in properties.items()}
    return ConnectorProfile(connector_id, connector_id, ends, named)


class FakeShell:
    """Carries instructions out by noting them.

    Attributes:
        ring: Records its last events, where its size is given.
        requests: Who waits for answers.
        now: The time [s].
        calls: Messages that wait for an answer, in order.
        told: Messages that want none, as (key, message).
        spawned: Keys of the slaves that were asked for, by name, not yet forked.
        adopted: Keys of slaves that were found, by pid.
        signals: What was sent, as (key, number).
        limits: Which limits slaves were given, by key.
        questions: What other managers are asked.
        watched: Which ones are to be watched.
        wake_at: When the core wants a tick.
        is_finished: Whether the core reported that all is done.
        rows: What was kept, by kind and name.
        disk: Why nothing can be kept; empty when it can.
        is_disk_lost: All that was stored is gone, which is reported once.
    """

    def __init__(
        self,
        host: str = "host",
        manager: str = "manager",
        pid: int = 100,
        *,
        ring_size: int = 0,
    ) -> None:
        state = ManagerState(host, manager, pid, "1", names=(f"localhost/{manager}.mgr",))
        state.processes[OWN] = Process(OWN, manager, pid, "up")
        self.core = Core(state)
        self.ring = EventRing(self.core, ring_size) if ring_size else None
        self.requests = PendingRequests()
        self.now = 1000.0
        self.calls: list[FakeCall] = []
        self.told: list[tuple[int, Mapping[str, Any]]] = []
        self.spawned: dict[str, int] = {}
        self.ahead: tuple[str, ...] = ()
        self.adopted: dict[int, int] = {}
        self.signals: list[tuple[int, int]] = []
        self.limits: dict[int, SlaveLimits] = {}
        self.questions: list[ev.AskPeer] = []
        self.watched: tuple[str, ...] = ()
        self.wake_at: float | None = None
        self.is_finished = False
        self.rows: dict[tuple[str, str], str] = {}
        self.disk = ""
        self.is_disk_lost = False

    @property
    def state(self) -> ManagerState:
        """Return the state of the core."""
        return self.core.state

    def feed(self, event: ev.Event) -> list[ev.Instruction]:
        """Hand in one event, check the facts, and note what is to be done."""
        if self.ring is not None:
            self.ring.record(event, self.now)
        instructions = self.core.handle(event, self.now)
        check_facts(self.state)
        self.wake_at = None
        for instruction in instructions:
            self._carry_out(instruction)
        for instruction in instructions:
            if isinstance(instruction, ev.InspectProcess):
                self.feed(ev.ProcessInspected(instruction.key))
            elif isinstance(instruction, ev.StoreRows):
                self._keep(instruction)
        return instructions

    def _keep(self, keep: ev.StoreRows) -> None:
        """Keep rows at once, or fail to."""
        if self.is_disk_lost:
            self.is_disk_lost = False
            self.rows.clear()
            self.feed(ev.RowsStored(keep.number, "the store is gone", True))
            return
        for kind, name, value in () if self.disk else keep.rows:
            if value is None:
                self.rows.pop((kind, name), None)
            else:
                self.rows[kind, name] = value
        self.feed(ev.RowsStored(keep.number, self.disk))

    def _carry_out(self, instruction: ev.Instruction) -> None:
        match instruction:
            case ev.SpawnSlave(key, name, ahead):
                self.spawned[name], self.ahead = key, ahead
            case ev.AdoptSlave(key, pid, _):
                self.adopted[pid] = key
            case ev.SendToContainer(key, message):
                assert self.state.processes[key].is_ready, f"{message} to a lost process"
                if "call" in message:
                    self.calls.append(FakeCall(key, message))
                else:
                    self.told.append((key, message))
            case ev.SignalSlave(key, number):
                self.signals.append((key, number))
            case ev.LimitSlave(key, pid, limits):
                assert pid == self.state.processes[key].pid != 0
                self.limits[key] = limits
            case ev.AnswerClient(request, reply):
                self.requests.answer(request, reply)
            case ev.AskPeer():
                self.questions.append(instruction)
            case ev.WatchPeers(peers):
                self.watched = peers
            case ev.WakeAt(moment):
                self.wake_at = moment if self.wake_at is None else min(moment, self.wake_at)
            case ev.ExitDaemon():
                self.is_finished = True

    # clients

    def ask(
        self,
        *actions: Action,
        ordered: bool = True,
        timeout_s: float = 10.0,
        until: float = math.inf,
        id: str = "",
    ) -> FakeRequest:
        """Hand in a batch, of a client that waits until then."""
        asked = FakeRequest()
        batch = Batch(actions, ordered, timeout_s, id)
        self.feed(ev.BatchRequested(batch, self.requests.add(asked.replies.append), until))
        return asked

    def stop(self) -> None:
        """Ask for the end."""
        self.feed(ev.StopRequested())

    def wait(self, seconds: float) -> None:
        """Let time pass; the core gets a tick when it wanted one, as from the real shell."""
        until = self.now + seconds
        while self.wake_at is not None and self.wake_at <= until:
            self.now = max(self.now, self.wake_at)
            self.feed(ev.TimerExpired())
        self.now = until

    # the zygote and the kernel

    def fork(self, name: str, pid: int = 0) -> int:
        """Have a slave forked and connected; return its key."""
        key = self.spawned.pop(name)
        self.feed(ev.SlaveForked(key, pid or 200 + key))
        self.feed(ev.SlaveReady(key))
        return key

    def find(
        self,
        pid: int,
        name: str,
        instances: Sequence[str] = (),
        wires: Sequence[ConnectorProfile] = (),
    ) -> int:
        """Have a slave of an earlier manager report its components; return its key."""
        held = [{**facts(each), "names": [f"localhost/{each}.rtc"]} for each in instances]
        self.feed(ev.SlaveFound(pid, name, held, [encode(each) for each in wires]))
        return self.adopted[pid]

    def visit(self, pid: int, name: str, instances: Sequence[str]) -> int:
        """Have an attached process report its components; return its key."""
        self.feed(ev.SlaveFound(pid, name, [facts(each) for each in instances], [], is_guest=True))
        return self.adopted[pid]

    def end(self, key: int, reason: str = "signal 9") -> None:
        """Report the end of a slave."""
        self.calls = [call for call in self.calls if call.key != key]
        self.feed(ev.SlaveEnded(key, reason))

    # containers

    def next(self, op: str) -> FakeCall:
        """Take the oldest call, which must be of this operation."""
        assert [each.op for each in self.calls[:1]] == [op], self.calls
        return self.calls.pop(0)

    def reply(self, call: FakeCall, value: Any = "") -> None:
        """Answer a call well."""
        self.feed(ev.ContainerReported(call.key, {"reply": call.number, "value": value}))

    def refuse(
        self, call: FakeCall, error: RtkitError | None = None, code: str = "RTC_ERROR"
    ) -> None:
        """Answer a call with an error."""
        error = error or NotFound("no such thing")
        answer = {"reply": call.number, "code": code, "kind": error.kind, "why": str(error)}
        self.feed(ev.ContainerReported(call.key, answer))

    def say(self, key: int, **message: Any) -> None:
        """Report something unasked."""
        self.feed(ev.ContainerReported(key, message))

    def serve(self, ports: Sequence[PortProfile] = PORTS) -> None:
        """Do what is asked until nothing is, as containers would; modules are tried, too."""
        while self.calls or TRIAL in self.spawned:
            if TRIAL in self.spawned:
                self.fork(TRIAL)
                continue
            call = self.calls.pop(0)
            if call.op == "create":
                instance = parse_create(call.message["create"]).instance_name
                self.say(call.key, facts=facts(instance, ports))
            elif call.op == "delete":
                self.say(call.key, gone=call.message["instance"])
            value: Any = "unix/x" if call.op in ("sink", "serve") else ""
            if call.op == "load":
                value = module_of(call)
            self.reply(call, value)
            if call.op == "load":
                self.end(call.key, "exit status 0")

    # short cuts

    def make(self, instance: str, slave: str = "") -> int:
        """Have a component made; return the key of its process."""
        place = f"&manager_name={slave}" if slave else ""
        asked = self.ask(Create(f"Thing?instance_name={instance}{place}"))
        if slave in self.spawned:
            self.fork(slave)
        self.serve()
        assert asked.result.ok, asked.result
        return self.state.containers[instance]

    def killed(self) -> list[int]:
        """Return the keys of the slaves that got KILL."""
        return [key for key, number in self.signals if number == signal.SIGKILL]


def check_facts(state: ManagerState) -> None:
    """Check that the facts do not contradict each other.

    Raises:
        AssertionError: They do; names the fact.
    """
    own = state.processes[OWN]
    assert own.state == "up", own
    assert state.components.keys() == state.containers.keys(), "component without holder"
    for key, process in state.processes.items():
        assert process.key == key, process
        assert process.is_alive or state.held_by(key), f"empty lost process: {process}"
    for instance, facts in state.components.items():
        container = state.process_of(instance)
        assert facts.instance == instance, facts
        assert container is not None, f"no process holds {instance}"
        assert bool(facts.zombie) is not container.is_alive, f"{instance} in {container}"
    for _, key in state.loose:
        assert state.processes[key].is_alive, "a lost process holds an end"
    names = [name for facts in state.components.values() for name in facts.names]
    names += state.names
    assert len(names) == len(set(names)), f"a name is used twice: {names}"
    for connector_id, connector in state.connectors.items():
        assert connector.connector_id == connector_id, connector
        for end in connector.ports:
            if split_far(end.instance)[0]:
                assert connector_id in state.kept.wires, f"half that is not wanted: {connector}"
                continue
            facts = state.components[end.instance]
            assert not facts.zombie, f"zombie is connected: {connector}"
            assert facts.port(end.port) is not None, f"no such port: {connector}"
