"""Drives the core of supervision through ends of components, recording its reactions."""

from __future__ import annotations

from typing import Any

from fake_shell import FakeShell, facts

from rtkit.deployment import actions as act
from rtkit.manager.core import events as ev
from rtkit.property.exchange import Reply
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState


def make(shell: FakeShell, instance: str, slave: str = "s", **options: str) -> int:
    """Have a component made with these properties; return the key of its process."""
    text = "".join(f"&rtkit.{key}={value}" for key, value in options.items())
    asked = shell.ask(act.Create(f"Thing?instance_name={instance}&manager_name={slave}{text}"))
    if slave in shell.spawned:
        shell.fork(slave)
    shell.serve()
    assert asked.result.ok, asked.result
    return shell.state.containers[instance]


def do(shell: FakeShell, *actions: act.Action) -> None:
    asked = shell.ask(*actions)
    shell.serve()
    assert all(result.ok for result in asked.results), asked.results


def pass_time(shell: FakeShell, at_most_s: float) -> None:
    """Let time pass until a slave is wanted or a holder is asked."""
    until = shell.now + at_most_s
    while not (shell.spawned or shell.calls) and shell.now < until:
        moment = until if shell.wake_at is None else min(shell.wake_at, until)
        shell.wait(max(0.0, moment - shell.now))


def come_back(shell: FakeShell, wait_s: float = 20.0) -> list[str]:
    """Let time pass and holders work; return what they were asked for."""
    pass_time(shell, wait_s)
    for name in list(shell.spawned):
        shell.fork(name)
    ops = []
    while shell.calls:
        call = shell.calls.pop(0)
        ops.append(call.op)
        if call.op == "create":
            made = parse_create(call.message["create"]).instance_name
            shell.say(call.key, facts=facts(made))
        elif call.op == "delete":
            shell.say(call.key, gone=call.message["instance"])
        shell.reply(call, "unix/x" if call.op in ("sink", "serve") else "")
    shell.wait(0.001)
    return ops


def in_error(instance: str, state: LifeCycleState = LifeCycleState.ERROR) -> dict[str, Any]:
    """Return facts of a component that is in Error."""
    told = facts(instance)
    told["contexts"][0]["state"] = state.value
    return {**told, "cause": "ValueError: no (a.py:1)"}


def heir(shell: FakeShell, boot: str = "") -> FakeShell:
    """Return a core that begins with what another one kept, at the same time."""
    other = FakeShell()
    other.now, other.rows = shell.now, dict(shell.rows)
    rows = [(kind, name, text) for (kind, name), text in shell.rows.items()]
    other.feed(ev.StoreRead(rows, boot))
    return other


def restore(shell: FakeShell) -> None:
    """Have a core make again what is missing at once."""
    replies: list[Reply] = []
    shell.feed(ev.RecoveryRequested(shell.requests.add(replies.append)))
    while shell.spawned:
        shell.fork(next(iter(shell.spawned)))
    shell.serve()
    assert len(replies) == 1
