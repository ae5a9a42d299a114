"""The core and limits: who has which, whether the host has as much, what is ended for one."""

from __future__ import annotations

import subprocess
import sys

from endings import come_back, make
from fake_shell import FakeShell, facts

from rtkit.deployment import actions as act
from rtkit.deployment.limits import NO_LIMITS, Capacity, SlaveLimits
from rtkit.errors import RtkitError
from rtkit.manager.core import events as ev
from rtkit.manager.core.deletion import HANGING_S
from rtkit.rtc.enums import LifeCycleState

MIB = 1 << 20
WHY = "memory limit of 100 MiB reached (104 MiB)"


class Shell(FakeShell):
    """Notes in which order slaves are limited and told something."""

    def __init__(self) -> None:
        super().__init__()
        self.order: list[str] = []

    def _carry_out(self, instruction: ev.Instruction) -> None:
        if isinstance(instruction, ev.LimitSlave):
            self.order.append("limit")
        elif isinstance(instruction, ev.SendToContainer):
            self.order.append("send")
        super()._carry_out(instruction)


def limited(shell: Shell, instance: str, slave: str = "s", **more: str) -> int:
    return make(shell, instance, slave, **{"limit.memory": "100M", **more})


def refusal(shell: Shell, *actions: act.Action) -> str:
    asked = shell.ask(*actions)
    shell.serve()
    (result,) = asked.results
    assert not result.ok
    return result.why


def test_limits_of_the_components_of_a_slave_add_up_and_go_with_them() -> None:
    shell = Shell()
    key = limited(shell, "A")
    assert shell.limits == {key: SlaveLimits(memory=100 * MIB)}
    limited(shell, "B", **{"limit.processes": "3"})
    assert shell.limits[key] == SlaveLimits(memory=200 * MIB, processes=3)
    make(shell, "C")
    shell.ask(act.Delete("B"))
    shell.serve()
    assert shell.limits[key] == SlaveLimits(memory=100 * MIB)
    shell.ask(act.Delete("A"))
    shell.serve()
    assert shell.limits[key] == NO_LIMITS
    assert shell.state.processes[key].is_alive


def test_a_slave_is_limited_before_a_component_is_made_in_it() -> None:
    shell = Shell()
    shell.ask(act.Create("Thing?instance_name=A&manager_name=s&rtkit.limit.memory=100M"))
    key = shell.fork("s")
    assert shell.limits == {key: SlaveLimits(memory=100 * MIB)}
    assert [call.op for call in shell.calls] == ["create"]
    assert shell.order == ["limit", "send"]
    shell.refuse(shell.next("create"))
    assert "A" not in shell.state.limits


def test_only_a_slave_can_be_limited() -> None:
    shell = Shell()
    create = "Thing?instance_name=A&rtkit.limit.memory=100M"
    why = "A has limits, and only a slave can be limited, not the manager itself"
    assert why in refusal(shell, act.Create(create))
    shell.make("A")
    assert why in refusal(shell, act.SetPolicy("A", {"rtkit.limit.memory": "100M"}))
    assert "rtkit.limit" not in shell.state.components["A"].create
    assert not shell.limits


def test_nonsense_is_refused_before_anything_is_made() -> None:
    shell = Shell()
    create = "Thing?instance_name=A&manager_name=s&rtkit.limit.memory=much"
    assert "rtkit.limit.memory: not an amount" in refusal(shell, act.Create(create))
    assert not shell.spawned


def test_more_than_the_host_has_is_refused() -> None:
    shell = Shell()
    shell.state.capacity = lambda: Capacity(memory=250 * MIB)
    limited(shell, "A")
    limited(shell, "B", "t")
    create = "Thing?instance_name=C&manager_name=u&rtkit.limit.memory=100M"
    assert refusal(shell, act.Create(create)) == (
        "rtkit.limit.memory: 300 MiB in all (A 100 MiB, B 100 MiB, C 100 MiB),"
        " but this host has 250 MiB"
    )
    assert "u" not in shell.spawned
    why = refusal(shell, act.SetPolicy("A", {"rtkit.limit.memory": "200M"}))
    assert why.startswith("rtkit.limit.memory: 300 MiB in all")
    shell.end(shell.state.containers["B"])  # who is dead reserves nothing
    limited(shell, "C", "u")


def test_who_reaches_a_limit_is_ended_with_that_reason_and_comes_back_by_its_policy() -> None:
    shell = Shell()
    key = limited(shell, "A", restart="on-failure")
    other = make(shell, "B", "t")
    shell.feed(ev.SlaveOverLimit(key, WHY))
    assert shell.signals == [(key, 15)]
    shell.wait(HANGING_S)
    assert shell.killed() == [key]
    shell.end(key)
    told = shell.state.components["A"]
    assert told.zombie == WHY
    assert shell.state.processes[other].is_alive
    assert "create" in come_back(shell)
    assert shell.state.components["A"].restart_status.why == WHY
    assert shell.limits[shell.state.containers["A"]] == SlaveLimits(memory=100 * MIB)


def test_one_that_is_being_ended_already_is_not_ended_again() -> None:
    shell = Shell()
    key = limited(shell, "A")
    shell.feed(ev.SlaveOverLimit(key, WHY))
    shell.feed(ev.SlaveOverLimit(key, "limit of 3 processes reached (4)"))
    shell.feed(ev.SlaveOverLimit(99, WHY))
    assert shell.signals == [(key, 15)]
    shell.end(key)
    assert shell.state.components["A"].zombie == WHY


def failed(instance: str, cause: str) -> dict[str, object]:
    told = facts(instance)
    told["contexts"][0]["state"] = LifeCycleState.ERROR.value
    return {**told, "cause": cause}


def test_a_callback_that_gets_no_more_memory_has_reached_the_limit() -> None:
    shell = Shell()
    key = limited(shell, "A")
    shell.say(key, facts=failed("A", "ValueError: no (a.py:1)"))
    assert not shell.signals
    shell.say(key, facts=failed("A", "MemoryError (a.py:1 in on_execute)"))
    assert shell.signals == [(key, 15)]
    shell.end(key, "exit status 0")
    why = "memory limit of 100 MiB reached (MemoryError (a.py:1 in on_execute))"
    assert shell.state.components["A"].zombie == why


def test_limits_change_without_a_stop() -> None:
    shell = Shell()
    key = limited(shell, "A")
    shell.ask(act.SetPolicy("A", {"rtkit.limit.memory": "50M"}))
    assert shell.limits[key] == SlaveLimits(memory=50 * MIB)
    shell.ask(act.SetPolicy("A", {}))
    assert shell.limits[key] == NO_LIMITS


def test_slaves_of_an_earlier_manager_have_their_limits_again() -> None:
    shell = Shell()
    told = {**facts("A"), "create": "Thing?instance_name=A&rtkit.limit.memory=100M"}
    shell.feed(ev.SlaveFound(321, "s", [told], []))
    assert shell.limits == {shell.adopted[321]: SlaveLimits(memory=100 * MIB)}


def test_a_manager_without_limits_loads_nothing_of_what_keeps_them() -> None:
    code = (
        "import sys, rtkit.manager.daemon, rtkit.manager.loop, rtkit.manager.slaves.zygote\n"
        "names = ('limiter', 'control_groups', 'capacity')\n"
        "print([n for n in names if f'rtkit.manager.limits.{n}' in sys.modules])"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout == "[]\n"


def test_without_limits_nothing_is_told_and_the_host_is_not_asked() -> None:
    shell = Shell()

    def ask() -> Capacity:
        raise RtkitError("asked")

    shell.state.capacity = ask
    make(shell, "A")
    assert not shell.limits
