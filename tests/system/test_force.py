"""What hangs is named, and there is a way to end it: with its slave, and nobody else's."""

from __future__ import annotations

import os
import re
import select
import signal
from pathlib import Path
from typing import Any

import pytest
from waiting import slave_pid, until

from rtkit.tree.client import Tree

KEEPS_MANAGER = True

MANAGER = "/localhost/manager.mgr"
HANGS = '''
import os
import re
import time
from rtkit.component import Component, Parameter


def note(text):
    with open(os.environ["RTKIT_STATE_DIR"] + "/notes", "a") as file:
        file.write(text + "\\n")


class Hangs(Component):
    """Does not come back from the callback that the option `when` names, as `how` says."""

    rate = 100.0

    def act(self, name):
        if self.options.get("when") == name:
            WAYS[self.options.get("how", "sleep")]()

    def on_initialize(self):
        self.act("on_initialize")

    def on_activated(self, context):
        self.act("on_activated")

    def on_execute(self, context):
        self.act("on_execute")

    def on_finalize(self):
        self.act("on_finalize")
        note("finalised " + self.instance)


def spin():
    while True:
        pass


def wait():
    """Come back when the test says so."""
    while not os.path.exists(os.environ["RTKIT_STATE_DIR"] + "/go"):
        time.sleep(0.01)


WAYS = {
    "sleep": lambda: time.sleep(1e9),
    "spin": spin,
    "lock": lambda: re.match("(a+)+$", "a" * 40 + "b"),
    "wait": wait,
}


def HangsInit(manager):
    manager.register_factory(Hangs)
'''
STUCK = r"is stuck in {} since [\d:]{{8}} \(Hangs\.py:\d+ in {}\)"
LINES = {"sleep": "<lambda>", "spin": "spin", "lock": "<lambda>", "wait": "wait"}


@pytest.fixture
def hangs(manager: Any) -> Any:
    (manager.modules / "Hangs.py").write_text(HANGS)
    return manager


def create(shell: Any, instance: str, place: str, **options: str) -> Any:
    told = "".join(f"&{key}={value}" for key, value in options.items())
    where = f"&manager_name={place}" if place else ""
    timeout_s = 1.5 if options.get("when") == "on_initialize" else 20
    line = f"rtmgr --timeout {timeout_s} {MANAGER} -c 'Hangs?instance_name={instance}{where}{told}'"
    return shell.run(line)


def notes(shell: Any) -> list[str]:
    file = Path(shell.environment["RTKIT_STATE_DIR"]) / "notes"
    return file.read_text().splitlines() if file.exists() else []


class End:
    """The end of a process, waited for without polling."""

    def __init__(self, pid: int) -> None:
        self._pidfd = os.pidfd_open(pid)

    def comes(self, timeout_s: float = 30.0) -> bool:
        return bool(select.select([self._pidfd], [], [], timeout_s)[0])


def remark(tree: Tree, instance: str) -> str | None:
    """Return why a component is a zombie, None when it is gone."""
    return next((row.zombie for row in tree.listing().rows if row.instance == instance), None)


# at the making


@pytest.mark.parametrize("how", ["sleep", "lock"])
def test_a_slave_started_for_one_that_hangs_is_ended_also_where_empty_ones_stay(
    hangs: Any, tree: Tree, how: str
) -> None:
    tree.set("manager.shutdown_on_nortcs", "NO")
    outcome = create(hangs, "H", "s", when="on_initialize", how=how)
    assert outcome.status == 1
    line = STUCK.format("on_initialize", LINES[how])
    assert re.search(rf"H {line}; slave s, started for it, is ended\)", outcome.err), outcome.err
    until(lambda: not tree.listing().slaves, "the end of the slave")
    assert tree.listing().rows == ()


def test_a_slave_that_was_there_before_is_marked_and_can_be_ended(hangs: Any, tree: Tree) -> None:
    assert create(hangs, "A", "s").status == 0
    end = End(slave_pid(tree, "s"))
    outcome = create(hangs, "H", "s", when="on_initialize")
    assert f"rtexit --force {MANAGER}/s.mgr ends it" in outcome.err
    line = STUCK.format("on_initialize", "<lambda>")
    assert re.search(rf"s\.mgr  \(H {line}\)", hangs.ok(f"rtls -l {MANAGER}"))
    assert re.search(rf"State: up H {line}", hangs.ok(f"rtcat {MANAGER}/s.mgr"))
    assert remark(tree, "A") == ""
    outcome = hangs.run("rtexit --timeout 0.5 /localhost/A.rtc")
    assert re.search(rf"H {line}; the request stays queued .* ends its slave s", outcome.err)
    assert not end.comes(0.0)
    assert hangs.ok(f"rtexit --force {MANAGER}/s.mgr") == ""
    assert end.comes(0.0)
    assert tree.listing().slaves == ()
    assert tree.listing().rows == ()


def test_what_hung_at_its_making_and_comes_back_is_gone_and_no_mark_stays(
    hangs: Any, tree: Tree
) -> None:
    assert create(hangs, "A", "s").status == 0
    assert create(hangs, "H", "s", when="on_initialize", how="wait").status == 1
    assert hangs.run("rtexit --timeout 0.5 /localhost/A.rtc").status == 1
    (Path(hangs.environment["RTKIT_STATE_DIR"]) / "go").touch()
    until(lambda: not tree.listing().slaves, "the end of the slave, which holds nothing now")
    assert sorted(notes(hangs)) == ["finalised A", "finalised H"]
    assert tree.listing().rows == ()


# while it works


@pytest.mark.parametrize("how", ["sleep", "spin", "lock"])
def test_one_that_hangs_while_active_can_be_ended_with_its_slave(
    hangs: Any, tree: Tree, how: str
) -> None:
    for instance in ("A", "B"):
        assert create(hangs, instance, "s").status == 0
    assert create(hangs, "H", "s", when="on_execute", how=how).status == 0
    assert create(hangs, "Elsewhere", "t").status == 0
    end = End(slave_pid(tree, "s"))
    hangs.run("rtact --timeout 1 /localhost/H.rtc")
    outcome = hangs.run("rtexit --timeout 0.5 /localhost/H.rtc")
    line = STUCK.format("on_execute", LINES[how])
    queued = "the request stays queued and is done when that returns"
    helps = "rtexit --force ends its slave s, and with it A, B"
    assert re.search(rf"H {line}; {queued}; {helps}", outcome.err), outcome.err
    outcome = hangs.run("rtexit --force /localhost/H.rtc")
    assert outcome == (0, "", "rtexit: ended with its slave: A, B\n")
    assert end.comes(0.0)
    assert remark(tree, "H") is None
    assert [remark(tree, each) for each in ("A", "B")] == ["ended by force, with H"] * 2
    assert remark(tree, "Elsewhere") == ""
    if how == "sleep":  # the others run no Python while one spins, or holds the lock
        assert sorted(notes(hangs)) == ["finalised A", "finalised B"]


def test_the_request_that_was_given_up_comes_through_when_the_callback_returns(
    hangs: Any, tree: Tree
) -> None:
    assert create(hangs, "H", "s", when="on_execute", how="wait").status == 0
    hangs.ok("rtact /localhost/H.rtc")
    assert hangs.run("rtexit --timeout 0.5 /localhost/H.rtc").status == 1
    (Path(hangs.environment["RTKIT_STATE_DIR"]) / "go").touch()
    until(lambda: remark(tree, "H") is None, "its end")


def test_one_that_hangs_when_it_is_finalised(hangs: Any, tree: Tree) -> None:
    assert create(hangs, "H", "s", when="on_finalize").status == 0
    end = End(slave_pid(tree, "s"))
    outcome = hangs.run("rtexit --timeout 1 /localhost/H.rtc")
    assert re.search(STUCK.format("on_finalize", "<lambda>"), outcome.err), outcome.err
    hangs.ok("rtexit --force /localhost/H.rtc")
    assert end.comes(0.0)
    assert tree.listing().rows == ()


@pytest.mark.parametrize("when", ["on_activated"])
def test_the_manager_is_not_ended_for_a_component_of_its_own(
    hangs: Any, tree: Tree, when: str
) -> None:
    assert create(hangs, "H", "", when=when).status == 0
    assert create(hangs, "A", "").status == 0
    hangs.run("rtact --timeout 1 /localhost/H.rtc")
    outcome = hangs.run("rtexit --force /localhost/H.rtc")
    line = STUCK.format(when, "<lambda>")
    own = "it is in the manager's own process, which is not ended by force"
    helps = "only rtmgr restart or rtmgr stop ends it"
    assert re.search(rf"H {line}; {own}; {helps}", outcome.err), outcome.err
    assert re.search(rf"H\.rtc  \({line[3:]}\)", hangs.ok("rtls -l /localhost"))
    hangs.ok("rtact /localhost/A.rtc")
    hangs.ok("rtexit /localhost/A.rtc")
    # It makes it again: that it exists is still wished for.
    hangs.ok("rtmgr --timeout 40 restart")
    assert hangs.ok("rtls /localhost") == "H.rtc\nmanager.mgr/\n"


def test_force_is_no_harm_to_who_ends_by_itself(hangs: Any, tree: Tree) -> None:
    for instance in ("A", "B"):
        assert create(hangs, instance, "s").status == 0
    pid = slave_pid(tree, "s")
    assert create(hangs, "C", "").status == 0
    hangs.ok("rtexit --force /localhost/A.rtc")
    hangs.ok("rtexit --force /localhost/C.rtc")
    assert (remark(tree, "A"), remark(tree, "B"), remark(tree, "C")) == (None, "", None)
    assert slave_pid(tree, "s") == pid
    assert notes(hangs) == ["finalised A", "finalised C"]


# slaves


def test_a_slave_is_ended_with_all_that_it_holds(hangs: Any, tree: Tree) -> None:
    for instance in ("A", "B"):
        assert create(hangs, instance, "s").status == 0
    end = End(slave_pid(tree, "s"))
    hangs.ok(f"rtexit {MANAGER}/s.mgr")
    assert end.comes(0.0)
    assert notes(hangs) == ["finalised B", "finalised A"]
    assert tree.listing().rows == ()
    assert hangs.run(f"rtexit {MANAGER}/s.mgr").err == f"rtexit: No such object: {MANAGER}/s.mgr\n"


def test_a_stopped_slave_is_ended_by_force(hangs: Any, tree: Tree) -> None:
    assert create(hangs, "A", "s").status == 0
    pid = slave_pid(tree, "s")
    end = End(pid)
    os.kill(pid, signal.SIGSTOP)
    until(lambda: any(row.trouble for row in tree.listing().rows), "the mark")
    outcome = hangs.run(f"rtexit {MANAGER}/s.mgr")
    assert outcome.err.endswith("does not answer: it is stopped; rtexit --force ends it\n")
    hangs.ok(f"rtexit --force {MANAGER}/s.mgr")
    assert end.comes(0.0)
    assert notes(hangs) == ["finalised A"]  # it is let go on, to end in order


def test_a_term_finalises_all_but_those_that_hang(hangs: Any, tree: Tree) -> None:
    for instance in ("A", "B"):
        assert create(hangs, instance, "s").status == 0
    assert create(hangs, "H", "s", when="on_execute").status == 0
    hangs.ok("rtact /localhost/H.rtc")
    pid = slave_pid(tree, "s")
    end = End(pid)
    os.kill(pid, signal.SIGTERM)
    assert end.comes()
    assert notes(hangs) == ["finalised B", "finalised A"]
    assert until(lambda: remark(tree, "A"), "a zombie") == "exit status 0"
