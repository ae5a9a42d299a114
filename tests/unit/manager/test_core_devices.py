"""The core and devices: what ends with one, waits for it, and is made again when it appears."""

from __future__ import annotations

from endings import come_back, do, heir, make, restore
from fake_shell import FakeShell, wire

from rtkit.deployment import actions as act
from rtkit.errors import Refused
from rtkit.manager.core import events as ev
from rtkit.rtc.enums import Transition

CAMERA = "/dev/video0"
WHY = f"no {CAMERA}"


def seen(shell: FakeShell, *absent: str) -> None:
    shell.feed(ev.DevicesSeen(absent))


def bound(shell: FakeShell, instance: str, **options: str) -> int:
    """Have a component made that requires a camera; return the key of its process."""
    told = {f"place.{key}": text for key, text in {"device": CAMERA, **options}.items()}
    return make(shell, instance, instance.lower(), **told)


def ended(shell: FakeShell, key: int) -> None:
    """Have a holder end what it is asked to end, and its empty process, too."""
    call = shell.next("delete")
    shell.say(call.key, gone=call.message["instance"])
    shell.reply(call)
    assert key in {each.key for each in shell.state.processes.values()}
    shell.end(key, "exit status 0")


def test_who_requires_a_device_ends_and_comes_back_with_it(shell: FakeShell) -> None:
    shell.make("B", "t")
    key = bound(shell, "A")
    do(
        shell,
        act.SetParameters("A", "default", {"p": "1"}),
        act.Connect(wire("w")),
        act.ChangeState("A", "0", Transition.ACTIVATE),
    )
    assert shell.state.bound == {"A": (CAMERA,)}
    seen(shell, "/dev/other")
    assert not shell.calls
    seen(shell, CAMERA)
    ended(shell, key)
    shown = shell.state.components["A"]
    assert (shown.zombie, shown.restart_status.returning) == (WHY, WHY)
    assert shell.state.is_in_hand("A")
    assert not shell.state.connectors
    seen(shell)
    assert come_back(shell) == ["create", "set", "sink", "source", "change_state"]
    shown = shell.state.components["A"]
    assert (shown.zombie, shown.restart_status.restarts, shown.restart_status.why) == ("", 1, WHY)
    assert list(shell.state.connectors) == ["w"]
    assert not shell.state.returning


def test_a_policy_that_keeps_lets_it_live(shell: FakeShell) -> None:
    bound(shell, "A", device_policy="keep")
    seen(shell, CAMERA)
    assert not shell.calls
    assert not shell.state.components["A"].zombie


def test_a_changed_policy_holds_at_once(shell: FakeShell) -> None:
    bound(shell, "A", device_policy="keep")
    seen(shell, CAMERA)
    do(shell, act.SetPolicy("A", {"rtkit.place.device": CAMERA}))
    assert shell.state.components["A"].zombie == WHY


def test_what_a_user_ends_while_it_waits_stays_ended(shell: FakeShell) -> None:
    key = bound(shell, "A")
    seen(shell, CAMERA)
    ended(shell, key)
    do(shell, act.Delete("A"))
    assert "A" not in shell.state.components
    seen(shell)
    assert come_back(shell) == []


def test_devices_of_what_is_no_more_are_not_looked_at(shell: FakeShell) -> None:
    key = bound(shell, "A")
    bound(shell, "B", device="/dev/other")
    shell.ask(act.Delete("A"))
    ended(shell, key)
    assert shell.state.bound == {"B": ("/dev/other",)}
    before = shell.state.bound
    seen(shell)
    assert shell.state.bound is before


def test_one_that_is_made_is_judged_by_the_next_look(shell: FakeShell) -> None:
    other = bound(shell, "B")
    seen(shell, CAMERA)
    ended(shell, other)
    before = shell.state.bound
    key = bound(shell, "A")  # the camera may have come meanwhile
    assert shell.state.bound is not before
    assert not shell.calls
    assert not shell.state.components["A"].zombie
    seen(shell, CAMERA)
    ended(shell, key)
    assert shell.state.components["A"].zombie == WHY


def test_one_that_died_of_it_waits_for_it_and_uses_up_no_restart(shell: FakeShell) -> None:
    key = make(shell, "A", "s", **{"place.device": CAMERA, "restart": "on-failure"})
    shell.end(key, "exit status 3")
    seen(shell, CAMERA)
    assert come_back(shell, 100.0) == []
    assert shell.state.components["A"].zombie == WHY
    seen(shell)
    assert come_back(shell) == ["create"]
    assert not shell.state.components["A"].zombie


def test_one_that_cannot_be_made_again_is_a_zombie_with_the_reason(shell: FakeShell) -> None:
    key = bound(shell, "A")
    seen(shell, CAMERA)
    ended(shell, key)
    seen(shell)
    for name in list(shell.spawned):
        shell.fork(name)
    shell.refuse(shell.next("create"), Refused("cannot open it"))
    shell.wait(0.1)
    told = shell.state.components["A"]
    assert "cannot open it" in told.zombie
    assert not told.restart_status.returning


def test_the_next_manager_waits_for_it_too(shell: FakeShell) -> None:
    key = bound(shell, "A")
    seen(shell, CAMERA)
    ended(shell, key)
    for boot in ("", "another"):
        other = heir(shell, boot)
        assert other.state.bound == {"A": (CAMERA,)}
        seen(other, CAMERA)
        restore(other)
        assert come_back(other, 30.0) == []
        assert other.state.components["A"].zombie == WHY
        seen(other)
        assert come_back(other) == ["create"]
        assert not other.state.components["A"].zombie


def test_what_lives_without_its_device_ends_under_the_next_manager(shell: FakeShell) -> None:
    bound(shell, "A")
    other = heir(shell)
    seen(other, CAMERA)
    other.find(100, "a", ["A"])
    restore(other)
    assert other.state.components["A"].zombie == WHY


def test_a_critical_one_stops_the_system(shell: FakeShell) -> None:
    shell.make("B", "t")
    do(shell, act.ChangeState("B", "0", Transition.ACTIVATE))
    make(shell, "A", "s", **{"place.device": CAMERA, "critical": "yes"})
    seen(shell, CAMERA)
    assert shell.state.watched("A").halted == WHY
