"""Lockstep on real processes: one trajectory however deployed, and participants that are lost."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from waiting import BOUND_S, facts_of, slave_pid, until

import rtkit
from rtkit.errors import Malformed, NotFound, Partial, Refused
from rtkit.world import Lockstep, ParticipantLost

KEEPS_MANAGER = True
MODULE = """
import os
from rtkit.component import Component, InPort, OutPort, Parameter, TimedDoubleSeq
from rtkit.errors import RtkitError


class Arena(Component):
    '''A body in a room; each of its cycles is one tick of all others.'''

    command = InPort(TimedDoubleSeq)
    ranges = OutPort(TimedDoubleSeq)
    file = Parameter("")
    timeout = Parameter(5.0)
    participants = Parameter("A0,B0,C0,D0")

    def on_activated(self, context):
        from rtkit.world import Body, Lockstep, Noise, Odometry, Polygon, Pose, Scene

        room = [[(-2, -2), (2, -2), (2, 2), (-2, 2)]]
        walls = [Polygon([(-3, -3), (3, -3), (3, 3), (-3, 3)], room)]
        self.body = Body(Scene(walls), Pose(-1, -1, 0.4), 0.1)
        self.noise, self.odometry = Noise(0.02, seed=3), Odometry(self.body.pose, 0.1, seed=4)
        self.lockstep = Lockstep(*self.participants.split(","), timeout_s=self.timeout)
        self.rows = []

    def on_deactivated(self, context):
        self.lockstep.close()

    def on_execute(self, context):
        if len(self.rows) == 60:
            return
        if not self.lockstep.is_under_way:
            self.step()
        try:
            self.lockstep.tick()
        except RtkitError as lost:
            self.report(str(lost))
            return
        if len(self.rows) == 60 and self.file:
            with open(self.file + "~", "w") as rows:
                rows.write("\\n".join(self.rows))
            os.rename(self.file + "~", self.file)

    def step(self):
        if self.rows:
            v, omega = self.command.read().data
            self.body.move(v, 0, omega, 0.2)
        pose = self.body.pose
        self.rows.append(f"{pose} {self.odometry.follow(pose)} {self.body.collisions}")
        seen = self.body.scene.rays(pose[:2], [pose.theta + (i - 5) / 5 for i in range(11)], 4.0)
        self.ranges.write(TimedDoubleSeq(data=self.noise.on(seen, 4.0)))


class Relay(Component):
    '''Passes on, and at the end of the chain drives.'''

    execution_type = "ExtTrigExecutionContext"
    into = InPort(TimedDoubleSeq)
    out = OutPort(TimedDoubleSeq)

    def on_execute(self, context):
        seen = self.into.read().data
        if self.instance == "D0":
            seen = [min(0.4, min(seen) / 2), 0.9 if min(seen[4:7]) < 1 else sum(seen[6:]) / 50]
        self.out.write(TimedDoubleSeq(data=seen))


class Note(Component):
    '''Notes its cycles; while its file is there it waits in them for who opens it.'''

    execution_type = "ExtTrigExecutionContext"

    def on_execute(self, context):
        folder = os.environ["RTKIT_STATE_DIR"]
        diary = os.open(folder + "/diary", os.O_WRONLY)
        os.write(diary, (self.instance + "\\n").encode())
        if os.path.exists(f"{folder}/{self.instance}"):
            open(f"{folder}/{self.instance}").close()
            os.write(diary, (self.instance + " went on\\n").encode())
        os.close(diary)


def SteppedInit(manager):
    for each in (Arena, Relay, Note):
        manager.register_factory(each)
"""


@pytest.fixture
def api(manager: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[rtkit.Tree]:
    """A connection of a script, and the module is loaded."""
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, manager.environment[key])
    (manager.modules / "Stepped.py").write_text(MODULE)
    with rtkit.connect() as tree:
        tree.load("Stepped.py")
        yield tree


def notes_of(tree: rtkit.Tree, *places: str) -> list[str]:
    """Make components that note their cycles, each where its create string says."""
    paths = [
        tree.create("&".join(filter(None, (f"Note?instance_name={name}", place))))
        for name, place in zip("ABC", places, strict=False)
    ]
    for path in paths:
        tree.activate(path)
    return paths


def held_up(manager: Any, instance: str) -> Path:
    """Have a component wait in its next cycle, until somebody opens that file for writing."""
    path = Path(manager.environment["RTKIT_STATE_DIR"]) / instance
    os.mkfifo(path)
    return path


def go_on(path: Path) -> None:
    writer = os.open(path, os.O_WRONLY)
    path.unlink()
    os.close(writer)


def trajectory(tree: rtkit.Tree, folder: Path, places: list[str], rate: int) -> str:
    file = folder / "rows"
    wires = [("Arena0:ranges", "A0:into"), ("A0:out", "B0:into"), ("B0:out", "C0:into")]
    wires += [("C0:out", "D0:into"), ("D0:out", "Arena0:command")]
    arena = tree.create(f"Arena?exec_cxt.periodic.rate={rate}{places[0]}&instance_name=Arena0")
    others = [
        tree.create(f"Relay?instance_name={name}0{place}")
        for name, place in zip("ABCD", places[1:], strict=True)
    ]
    for wire in wires:
        ends = [f"/localhost/{end.replace(':', '.rtc:')}" for end in wire]
        tree.connect(
            *ends,
            dataport__buffer__read__empty_policy="block",
            dataport__buffer__read__timeout=BOUND_S,
        )
    tree.configure(arena, file=str(file), timeout=BOUND_S)
    for path in (*others, arena):
        tree.activate(path)
    rows = until(lambda: file.exists() and file.read_text(), "the run has ended")
    file.unlink()
    for path in (arena, *others):
        tree.delete(path)
    return rows


def test_a_trajectory_is_the_same_in_one_process_and_in_five(
    api: rtkit.Tree, tmp_path: Path
) -> None:
    five = [f"&manager_name=s{number}" for number in range(5)]
    first = trajectory(api, tmp_path, five, 1000)
    assert len(set(first.splitlines())) == 60
    assert trajectory(api, tmp_path, ["&manager_name=one"] * 5, 1000) == first
    assert trajectory(api, tmp_path, [""] * 5, 100) == first  # in the process of the manager


def test_a_property_gives_a_cycle(api: rtkit.Tree, manager: Any, notes: Any) -> None:
    (path,) = notes_of(api, "manager_name=far")
    manager.ok(f"rtset {path}.contexts.0.tick 1")
    manager.ok(f"rtset {path}.contexts.0.tick 2")
    assert notes.next(3) == ["A", "A", "A"]
    assert notes.nothing()
    other = api.create("Note?instance_name=P&execution_contexts=Periodic")
    for target, error in (
        (f"{path}.contexts.0.tick 0", "bad-value: cycles are 1 to 1000, not 0"),
        (f"{path}.contexts.0.tick x", "bad-value: cycles: expected integer, found word x"),
        (
            f"{other}.contexts.0.tick 1",
            "conflict: execution context 0 is periodic, it ticks by itself: P",
        ),
    ):
        outcome = manager.run(f"rtset {target}")
        assert (outcome.status, outcome.err) == (1, f"rtset: {target.split()[0]}: {error}\n")
    shown = manager.ok(f"rtget {path}.contexts.0.tick")
    assert shown == '<call state="idle"/>\n'


def test_a_script_gives_cycles_in_its_order(api: rtkit.Tree, notes: Any) -> None:
    a, b, c = notes_of(api, "", "manager_name=far", "manager_name=far")
    api.tick(c, a, b)
    api.tick(a)
    assert notes.next(4) == ["C", "A", "B", "A"]
    with pytest.raises(NotFound, match="No such object: /localhost/No0"):
        api.tick(a, "/localhost/No0.rtc")
    periodic = api.create("Note?instance_name=P&execution_contexts=Periodic")
    with pytest.raises(Refused, match="it ticks by itself: P"):
        api.tick(periodic)
    with pytest.raises(Partial, match=f"{periodic}: .* it ticks by itself: P") as partial:
        api.tick(a, periodic, b)
    assert [name for name, _ in partial.value.failures] == [periodic]
    assert notes.next(1) == ["A"]
    api.delete(b)
    with pytest.raises(NotFound):
        api.tick(b)
    assert notes.nothing()


def test_a_participant_is_named_once() -> None:
    for names in ((), ("A", "/localhost/A.rtc")):
        with pytest.raises(Malformed, match="named once"):
            Lockstep(*names)


def test_one_that_is_stopped_in_its_cycle_is_named_and_has_only_that_cycle(
    api: rtkit.Tree, manager: Any, notes: Any
) -> None:
    _, b, _ = notes_of(api, "manager_name=s", "manager_name=far", "")
    gate = held_up(manager, "B")
    with Lockstep("A", "B", "C", timeout_s=0.5) as lockstep:
        with pytest.raises(ParticipantLost, match=r"0\.5 s") as late:
            lockstep.tick()
        assert notes.next(2) == ["A", "B"]
        pid = slave_pid(api, "far")
        os.kill(pid, signal.SIGSTOP)
        until(lambda: "stopped" in facts_of(api, "B").trouble, "the manager knows")
        with pytest.raises(ParticipantLost, match=f"{b}: .*stopped") as late:
            lockstep.tick()
        assert late.value.participants == (b,)
        assert notes.nothing()
        os.kill(pid, signal.SIGCONT)
        go_on(gate)
        lockstep.timeout_s = BOUND_S
        lockstep.tick()
        assert notes.next(2) == ["B went on", "C"]
        lockstep.tick()
        assert notes.next(3) == ["A", "B", "C"]


def test_one_that_is_killed_in_its_cycle_is_named_and_its_successor_goes_on(
    api: rtkit.Tree, manager: Any, notes: Any
) -> None:
    _, b, _ = notes_of(api, "", "manager_name=far", "")
    gate = held_up(manager, "B")
    with Lockstep("A", "B", "C", timeout_s=0.2) as lockstep:
        with pytest.raises(ParticipantLost):
            lockstep.tick()
        lockstep.timeout_s = BOUND_S
        assert notes.next(2) == ["A", "B"]
        os.kill(slave_pid(api, "far"), signal.SIGKILL)
        for _ in range(2):
            with pytest.raises(ParticipantLost, match=f"no cycle of {b}: ") as lost:
                lockstep.tick()
            assert lost.value.participants == (b,)
        api.delete(b)
        gate.unlink()
        with pytest.raises(ParticipantLost, match=f"no cycle of {b}: No such object"):
            lockstep.tick()
        notes_of(api, "", "manager_name=again")  # A is there already
        lockstep.tick()
        lockstep.tick()
    assert notes.next(5) == ["B", "C", "A", "B", "C"]


def test_one_that_is_not_active_or_fails_is_named_and_awaited(
    api: rtkit.Tree, manager: Any, notes: Any
) -> None:
    _, b, _ = notes_of(api, "manager_name=far", "", "manager_name=far")
    api.deactivate(b)
    with Lockstep("A", "B", "C", timeout_s=BOUND_S) as lockstep:
        for is_new in (True, False):
            with pytest.raises(ParticipantLost, match=f"no cycle of {b}: B is Inactive") as lost:
                lockstep.tick()
            assert (lost.value.participants, lost.value.is_new) == ((b,), is_new)
        api.activate(b)
        lockstep.tick()
        assert notes.next(3) == ["A", "B", "C"]
        (Path(manager.environment["RTKIT_STATE_DIR"]) / "B").mkdir()  # cannot be opened
        with pytest.raises(ParticipantLost, match=f"no cycle of {b}: B is in Error: .*B'"):
            lockstep.tick()
        (Path(manager.environment["RTKIT_STATE_DIR"]) / "B").rmdir()
        assert notes.next(2) == ["A", "B"]
        api.reset(b)
        api.activate(b)
        lockstep.tick()
        assert notes.next(2) == ["B", "C"]


def test_a_world_is_deactivated_while_a_participant_does_not_answer(
    api: rtkit.Tree, manager: Any, notes: Any
) -> None:
    for place in ("", "&manager_name=far"):
        notes_of(api, "manager_name=far")
        arena = api.create(f"Arena?instance_name=Arena0&exec_cxt.periodic.rate=10{place}")
        api.configure(arena, participants="A", timeout=0.5)
        gate = held_up(manager, "A")
        api.activate(arena)
        assert notes.next(1) == ["A"]
        began = time.monotonic()
        api.deactivate(arena)
        assert time.monotonic() - began < 5
        assert "no end of a cycle within 0.5 s" in manager.ok(
            "rtvlog --no-follow /localhost/Arena0.rtc"
        )
        go_on(gate)
        assert notes.next(1) == ["A went on"]
        for path in (arena, "/localhost/A.rtc"):
            api.delete(path)


def test_a_world_is_killed_in_its_tick(api: rtkit.Tree, manager: Any, notes: Any) -> None:
    notes_of(api, "manager_name=far", "")
    arena = api.create("Arena?instance_name=Arena0&manager_name=world")
    api.configure(arena, participants="A,B")
    gate = held_up(manager, "A")
    api.activate(arena)
    assert notes.next(1) == ["A"]
    os.kill(slave_pid(api, "world"), signal.SIGKILL)
    until(lambda: facts_of(api, "Arena0").zombie, "the manager knows")
    go_on(gate)
    assert notes.next(2) == ["A went on", "B"]
    with Lockstep("A", "B", timeout_s=BOUND_S) as lockstep:  # a successor
        lockstep.tick()
    assert notes.next(2) == ["A", "B"]


def test_a_world_that_ticks_itself_is_refused_by_time(
    api: rtkit.Tree, manager: Any, notes: Any
) -> None:
    options = "execution_contexts=ExtTrig&instance_name=Arena0"
    arena = api.create(f"Arena?{options}&manager_name=far")
    api.configure(arena, participants="Arena0", timeout=0.2)
    api.activate(arena)
    api.tick(arena, timeout_s=BOUND_S)
    log = manager.ok(f"rtvlog --no-follow {arena}")
    assert "no end of a cycle within 0.2 s: /localhost/Arena0.rtc" in log
