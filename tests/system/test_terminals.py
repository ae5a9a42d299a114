"""Components that read from stdin: they wait, are shown to wait, and are answered."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import jsonrecords
import pytest
from terminal import Terminal, opened
from waiting import facts_of, told_pid, until

from rtkit.api.data_tree import DataTree
from rtkit.errors import Malformed, Refused
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
ASKS = '''
import getpass, os, select, sys, termios
from rtkit.component import Component


class Asks(Component):
    """Asks for a line, in the way that its parameter says."""

    rate = 1000.0

    def on_execute(self, context):
        print("welcome to", self.instance)
        said = getattr(self, HOW)()
        print("got", repr(said))

    def input(self):
        return input("number: ")

    def readline(self):
        sys.stdout.write("line: ")
        return sys.stdin.readline()

    def lines(self):
        return [line for line in sys.stdin]

    def one(self):
        return sys.stdin.read(1)

    def password(self):
        return getpass.getpass("secret: ")

    def selected(self):
        if not select.select([sys.stdin], [], [], 0.05)[0]:
            return ""
        return os.read(sys.stdin.fileno(), 100)

    def tty(self):
        size = os.get_terminal_size(sys.stdin.fileno())
        input("go: ")
        return sys.stdin.isatty(), tuple(os.get_terminal_size(sys.stdin.fileno()))

    def stubborn(self):
        try:
            return input("again: ")
        except Exception as error:
            return "caught"


def AsksInit(manager):
    manager.register_factory(Asks)
'''
WAITS = "waiting for input since"


def asks(manager: Any, how: str = "input", process: str = "s", name: str = "Asks0") -> str:
    """Make and activate a component that asks; return its path."""
    file = f"{how.capitalize()}{process}.py"
    code = ASKS.replace("HOW", repr(how)).replace("Asks", f"Asks{how}{process}")
    (manager.modules / file).write_text(code)
    manager.ok(f"rtmgr /localhost/manager.mgr -l {file}:Asks{how}{process}Init")
    place = f"&manager_name={process}" if process else ""
    create = f"Asks{how}{process}?instance_name={name}{place}"
    manager.ok(f"rtmgr /localhost/manager.mgr -c '{create}'")
    manager.ok(f"rtact /localhost/{name}.rtc")
    return f"/localhost/{name}.rtc"


def await_question(tree: Tree, instance: str = "Asks0") -> None:
    until(lambda: facts_of(tree, instance).waits, f"{instance} never waited")


def shown(manager: Any, path: str) -> str:
    return manager.run(f"rtattach --show {path}").out


@contextmanager
def attached(manager: Any, path: str) -> Iterator[Terminal]:
    environment = {**manager.environment, "TERM": "xterm"}
    command = manager.command(f"rtattach {path}")
    with opened(command, environment, manager.folder) as terminal:
        terminal.until(r"Ctrl-\] leaves it")
        yield terminal


@pytest.mark.parametrize("process", ["s", ""])
def test_a_question_waits_is_shown_and_is_answered(manager: Any, tree: Tree, process: str) -> None:
    path = asks(manager, process=process)
    await_question(tree)
    assert WAITS in manager.ok("rtls -l /localhost")
    assert WAITS in manager.ok(f"rtcat {path}")
    status = manager.run(f"rtstatus {path}")
    assert f"rtattach {path} gives it some" in status.out + status.err
    assert shown(manager, path).splitlines() == ["welcome to Asks0", "number: "]
    assert manager.ok(f"rtattach --send 12 {path}") == ""
    until(lambda: "got '12'" in shown(manager, path), "no answer was printed")
    assert "number: 12\ngot '12'" in shown(manager, path)


def test_what_is_shown_is_told_to_programs(manager: Any, tree: Tree) -> None:
    path = asks(manager)
    await_question(tree)
    (record,) = jsonrecords.checked(manager.ok(f"rtattach --show --json {path}"))
    assert jsonrecords.kind_of(record) == "terminal"
    assert record["lines"] == ["welcome to Asks0", "number: "]
    assert record["waits"].startswith(WAITS)
    assert (record["unread_bytes"], record["attached"]) == (0, 0)
    assert manager.ok(f"rtget {path}.waits").strip().strip('"') == record["waits"]


def test_no_callback_counts_as_stuck_while_it_waits(manager: Any, tree: Tree) -> None:
    code = ASKS.replace("HOW", "'input'")
    (manager.modules / "Asks.py").write_text(code)
    manager.ok("rtmgr /localhost/manager.mgr -l Asks.py:AsksInit")
    options = "rtkit.health.stuck=0.1&exec_cxt.callback_deadline=0.05"
    manager.ok(f"rtmgr /localhost/manager.mgr -c 'Asks?manager_name=s&{options}'")
    manager.ok("rtact /localhost/Asks0.rtc")
    await_question(tree)
    pid = told_pid(manager, "s")
    for number in range(5):  # each answer is a new wait, all together last longer than the bound
        manager.ok(f"rtattach --send {number} /localhost/Asks0.rtc")
        await_question(tree)
    facts = facts_of(tree, "Asks0")
    assert (facts.trouble, facts.restart_status.restarts) == ("", 0)
    assert told_pid(manager, "s") == pid
    assert facts.contexts[0].missed == 0


@pytest.mark.parametrize(
    ("how", "sent", "got"),
    [
        ("readline", "5", "got '5\\n'"),
        ("one", "x", "got 'x'"),
        ("password", "hush", "got 'hush'"),
        ("selected", "now", "got b'now\\n'"),
    ],
)
def test_stdin_is_read_in_every_way(manager: Any, how: str, sent: str, got: str) -> None:
    path = asks(manager, how)
    manager.ok(f"rtattach --send {sent} {path}")
    until(lambda: got in shown(manager, path), shown(manager, path))
    assert ("hush" in shown(manager, path).replace("got 'hush'", "")) is False


def test_lines_of_stdin_are_sent_up_to_the_end_that_is_typed(manager: Any) -> None:
    path = asks(manager, "lines")
    assert manager.run(f"rtattach {path}", "a\nb\nc").status == 0
    with attached(manager, path) as terminal:
        terminal.type("\x04")
        terminal.until(re.escape(r"got ['a\n', 'b\n', 'c\n']"))


def test_a_script_answers(manager: Any, tree: Tree) -> None:
    path = asks(manager)
    with_methods = DataTree(tree.link, tree.host, tree.manager)
    with_methods.answer(path, "1", "2")
    until(lambda: "got '2'" in shown(manager, path), "it never answered")
    with pytest.raises(Malformed, match="a terminal takes 4094"):
        with_methods.answer(path, "x" * 5000)
    manager.ok(f"rtdeact {path}")
    with pytest.raises(Refused, match="has not read it"):
        with_methods.answer(path, "3", timeout_s=0.01)


def test_many_lines_all_arrive_in_their_order(manager: Any) -> None:
    path = asks(manager)
    text = "".join(f"line {number} {'x' * 50}\n" for number in range(400))
    outcome = manager.run(f"rtattach -t 40 {path}", text)
    assert outcome == (0, "", "")
    log = manager.ok(f"rtvlog --no-follow -n 2000 {path}")
    numbers = [int(each) for each in re.findall(r"got 'line (\d+) ", log)]
    assert numbers == list(range(400))


def test_a_line_longer_than_a_terminal_takes_is_refused(manager: Any) -> None:
    outcome = manager.run(f"rtattach --send {'x' * 5000} {asks(manager)}")
    assert outcome.status == 1
    assert "a line of 5000 bytes: a terminal takes 4094" in outcome.err


def test_what_nobody_reads_in_time_is_told_and_stays(manager: Any, tree: Tree) -> None:
    path = asks(manager)
    await_question(tree)
    manager.ok(f"rtdeact {path}")
    outcome = manager.run(f"rtattach --send 7 -t 0.1 {path}")
    assert outcome.status == 1
    assert "Asks0 has not read it within 0.1 s: 2 bytes of it stay there" in outcome.err
    manager.ok(f"rtact {path}")
    until(lambda: "got '7'" in shown(manager, path), "what had been sent was not read")


def test_a_user_answers_at_the_own_terminal(manager: Any, tree: Tree) -> None:
    path = asks(manager)
    await_question(tree)
    with attached(manager, path) as terminal:
        terminal.until("number: ")
        terminal.type("4")
        terminal.until("4")
        terminal.type("2x\x7f\r")
        terminal.until("got '42'")
        terminal.type("no\x03yes\r")
        terminal.until("got 'yes'")
        terminal.type("\x1d")
        terminal.until(r"left .*, which goes on")
        assert terminal.status() == 0
    await_question(tree)


def test_the_size_of_the_window_is_that_of_the_user(manager: Any, tree: Tree) -> None:
    path = asks(manager, "tty")
    await_question(tree)
    with attached(manager, path) as terminal:
        terminal.type("\r")
        terminal.until(re.escape("got (True, (80, 24))"))
        terminal.resize(100, 30)
        # The size goes another way than what is typed, so it may come a line later.
        while "(100, 30)" not in terminal.seen:
            terminal.type("\r")
            terminal.until("got ")
            terminal.more()


def test_two_who_are_attached_see_the_same(manager: Any, tree: Tree) -> None:
    path = asks(manager)
    await_question(tree)
    environment = {**manager.environment, "TERM": "xterm"}
    with attached(manager, path) as first:
        first.until("number: ")
        command = manager.command(f"rtattach {path}")
        with opened(command, environment, manager.folder) as second:
            second.until("1 other is there, too")
            second.type("9\r")
            second.until("got '9'")
            first.until("got '9'")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_killed_command_leaves_the_terminal_as_it_was(
    manager: Any, tree: Tree, number: signal.Signals
) -> None:
    path = asks(manager)
    await_question(tree)
    with attached(manager, path) as terminal:
        terminal.until("number: ")
        raw = terminal.modes()
        os.kill(terminal.pid, number)
        assert terminal.status() == -number
        assert terminal.modes() != raw


def test_the_end_of_the_component_ends_the_command_with_the_reason(
    manager: Any, tree: Tree
) -> None:
    path = asks(manager)
    await_question(tree)
    with attached(manager, path) as terminal:
        os.kill(told_pid(manager, "s"), signal.SIGKILL)
        terminal.until("signal 9")
        assert terminal.status() == 1
    assert manager.run(f"rtattach --send 1 {path}").status == 1


def test_a_stopped_process_is_told_and_goes_on(manager: Any, tree: Tree) -> None:
    path = asks(manager)
    await_question(tree)
    pid = told_pid(manager, "s")
    with attached(manager, path) as terminal:
        os.kill(pid, signal.SIGSTOP)
        try:
            until(lambda: facts_of(tree, "Asks0").trouble, "it was never told to be stopped")
            terminal.until("no answer: .*stopped")
        finally:
            os.kill(pid, signal.SIGCONT)
        terminal.until("it answers again")
        terminal.type("8\r")
        terminal.until("got '8'")


def test_it_survives_the_end_of_the_manager(shell: Any) -> None:
    shell.ok("rtmgr start")
    path = asks(shell)
    until(lambda: WAITS in shell.ok("rtls -l /localhost"), "it never waited")
    with attached(shell, path) as terminal:
        terminal.until("number: ")
        os.kill(told_pid(shell), signal.SIGKILL)
        terminal.until("no answer: ")
        shell.ok("rtmgr start")
        terminal.until("it answers again")
        assert WAITS in shell.ok("rtls -l /localhost")
        terminal.type("3\r")
        terminal.until("got '3'")
    shell.ok("rtmgr stop")


@pytest.mark.parametrize("how", ["input", "stubborn", "lines"])
def test_who_waits_is_deactivated_and_activated_again(manager: Any, tree: Tree, how: str) -> None:
    path = asks(manager, how)
    await_question(tree)
    manager.ok(f"rtdeact {path}")
    facts = facts_of(tree, "Asks0")
    assert (facts.state, facts.waits, facts.cause) == ("Inactive", "", "")
    manager.ok(f"rtact {path}")
    await_question(tree)
    manager.ok(f"rtexit {path}")


def test_the_manager_ends_though_components_wait(shell: Any) -> None:
    shell.ok("rtmgr start")
    for process, name in (("s", "A0"), ("", "A1")):
        asks(shell, process=process, name=name)
    until(lambda: shell.ok("rtls -l /localhost").count(WAITS) == 2, "they never waited")
    shell.ok("rtmgr stop")
    assert "is not finalised" not in shell.log()


def test_reading_while_it_is_made_is_refused_with_what_to_do(manager: Any) -> None:
    code = ASKS.replace("HOW", "'input'").replace(
        "on_execute(self, context)", "on_initialize(self)"
    )
    (manager.modules / "Early.py").write_text(code.replace("Asks", "Early"))
    manager.ok("rtmgr /localhost/manager.mgr -l Early.py:EarlyInit")
    outcome = manager.run("rtmgr /localhost/manager.mgr -c 'Early?manager_name=s'")
    assert outcome.status == 1
    assert "reads stdin while it is made, or ends" in outcome.err
    assert "let it read while it is active" in outcome.err


def test_a_component_that_runs_by_hand_or_is_none_is_refused(manager: Any) -> None:
    assert "No such object" in manager.run("rtattach /localhost/Nobody0.rtc").err
    assert manager.run("rtattach").status == 1
    asks(manager)
    assert manager.run("rtattach --send 1 --show /localhost/Asks0.rtc").status == 2


def test_a_breakpoint_asks_at_the_terminal(manager: Any, tree: Tree) -> None:
    code = ASKS.replace("HOW", "'stop'").replace(
        "    def readline(self)",
        "    def stop(self):\n        breakpoint()\n\n    def readline(self)",
    )
    (manager.modules / "Stops.py").write_text(code.replace("Asks", "Stops"))
    manager.ok("rtmgr /localhost/manager.mgr -l Stops.py:StopsInit")
    manager.ok("rtmgr /localhost/manager.mgr -c 'Stops?manager_name=s'")
    manager.ok("rtact /localhost/Stops0.rtc")
    await_question(tree, "Stops0")
    manager.ok("rtattach --send 'p self.instance' /localhost/Stops0.rtc")
    path = "/localhost/Stops0.rtc"
    until(lambda: "'Stops0'" in shown(manager, path), "the debugger never answered")
    manager.ok(f"rtdeact {path}")
    assert facts_of(tree, "Stops0").state == "Inactive"
