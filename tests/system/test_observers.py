"""rtwatch, rtvlog and rttop at real managers, slaves and components."""

from __future__ import annotations

import json
import os
import re
import select
import signal
from typing import Any

import jsonrecords
import pytest

MANAGER = "/localhost/manager.mgr"
SOURCE = "/localhost/ConsoleIn0.rtc"
SINK = "/localhost/ConsoleOut0.rtc"
TALKER_PATH = "/localhost/Talker0.rtc"
TALKER = '''
from rtkit.component import Component


class Talker(Component):
    """Say something when it is activated; fail the second time."""

    times = 0

    def on_activated(self, context):
        self.times += 1
        if self.times > 1:
            raise ValueError("once is enough")
        self.logger.info("here I am")
        self.logger.warning("careful")
        print("printed")


def TalkerInit(manager):
    manager.register_factory(Talker)
'''


@pytest.fixture
def system(manager: Any) -> Any:
    """A shell with a manager that knows talkers, and a source and a sink."""
    (manager.modules / "Talker.py").write_text(TALKER)
    return manager


class Watching:
    """An observer that runs, and its lines as they come."""

    def __init__(self, shell: Any, line: str) -> None:
        self.process = shell.open(line)
        self._text = b""

    def until(self, word: str) -> str:
        """Return the next line with a word in it."""
        descriptor = self.process.stdout.fileno()
        while True:
            *lines, rest = self._text.split(b"\n")
            for number, line in enumerate(lines):
                if word.encode() in line:
                    self._text = b"\n".join([*lines[number + 1 :], rest])
                    return line.decode()
            assert select.select([descriptor], [], [], 30.0)[0], f"no {word} in {self._text!r}"
            data = os.read(descriptor, 65536)
            assert data, f"no {word} in {self._text!r}: {self.process.stderr.read()}"
            self._text += data

    def listens(self) -> Watching:
        """Wait until it says that it listens."""
        told = self.process.stderr.readline()
        assert "listening" in told, told + self.process.stderr.read()
        return self

    def end(self) -> tuple[int, str]:
        """Interrupt it and return status and what stderr says."""
        self.process.send_signal(signal.SIGINT)
        _, err = self.process.communicate(timeout=30)
        return self.process.returncode, err


def test_events_as_they_happen(system: Any) -> None:
    everything = Watching(system, "rtwatch / -v").listens()
    system.ok(f"rtmgr {MANAGER} -c ConsoleIn?manager_name=s -c ConsoleOut -c Talker")
    everything.until(f"{MANAGER}/s.mgr PROCESS_STARTED")
    assert "APPEARED (ConsoleIn)" in everything.until(f"{SOURCE} ")
    states = Watching(system, f"rtwatch -v -n 2 -f rtc_status {SOURCE}").listens()
    ports = Watching(system, f"rtwatch -v -n 2 -f Port-Event {SINK}").listens()
    system.ok(f"rtcon {SOURCE}:out {SINK}:in -i wire")
    system.ok(f"rtact {SINK} {SOURCE}")
    system.ok(f"rtconf {SOURCE} set values=7")
    system.ok(f"rtdeact {SOURCE}")
    system.ok(f"rtdis -i wire {SOURCE}")
    for watching, lines in (
        (states, [f"{SOURCE} 0 ACTIVE", f"{SOURCE} 0 INACTIVE"]),
        (
            ports,
            [f"{SINK} in PORT_{word} (ConsoleIn0:out)" for word in ("CONNECT", "DISCONNECT")],
        ),
    ):
        out, err = watching.process.communicate(timeout=30)
        assert (watching.process.returncode, err) == (0, "")
        assert [line.partition("] ")[2] for line in out.splitlines()] == lines
    everything.until(f"{SOURCE} out PORT_CONNECT (ConsoleOut0:in)")
    everything.until(f"{SOURCE} default.values CFG_UPDATE_PARAM (7)")
    system.ok(f"rtact {TALKER_PATH}")
    system.ok(f"rtdeact {TALKER_PATH}")
    assert system.run(f"rtact {TALKER_PATH}").status == 1
    assert "ValueError: once is enough" in everything.until("0 ERROR")
    kill_slave(system, "s")
    everything.until(f"{MANAGER}/s.mgr PROCESS_LOST (signal 9)")
    everything.until(f"{SOURCE} ZOMBIE (signal 9)")
    assert everything.end() == (-signal.SIGINT, "rtwatch: interrupted\n")


def kill_slave(shell: Any, name: str) -> None:
    told = json.loads(shell.ok(f"rtcat --json {MANAGER}/{name}.mgr"))
    os.kill(told["pid"], signal.SIGKILL)


def test_records_are_as_their_schemas_say(system: Any) -> None:
    system.ok(f"rtmgr {MANAGER} -c ConsoleIn?manager_name=s -c ConsoleOut -c Talker")
    system.ok(f"rtcon {SOURCE}:out {SINK}:in")
    system.ok(f"rtact {SINK} {SOURCE} {TALKER_PATH}")
    heartbeats = jsonrecords.checked(system.ok(f"rtwatch --json -n 4 -f HEARTBEAT {MANAGER}"))
    assert {jsonrecords.kind_of(record) for record in heartbeats} == {"event"}
    assert {record["event"] for record in heartbeats} == {"RTC_HEARTBEAT", "EC_HEARTBEAT"}
    logged = jsonrecords.checked(system.ok("rtvlog --json --no-follow /"))
    assert {jsonrecords.kind_of(record) for record in logged} == {"log-record"}
    rows = jsonrecords.checked(system.ok("rttop --once --json"))
    assert {jsonrecords.kind_of(record) for record in rows} == {"activity"}
    source, sink, talker = rows
    assert [row["path"] for row in rows] == [SOURCE, SINK, TALKER_PATH]
    assert source["asked_hz"] == sink["asked_hz"] == 10.0
    assert source["reached_hz"] > 0
    assert source["written_hz"]["out"] > 0
    assert sink["read_hz"]["in"] > 0
    assert source["memory_bytes"] > 1_000_000
    assert (talker["state"], talker["reached_hz"]) == ("Active", None)


def test_a_manager_that_comes_back_is_followed(system: Any) -> None:
    system.ok(f"rtmgr {MANAGER} -c ConsoleOut?manager_name=s")
    watching = Watching(system, f"rtwatch -v {MANAGER}").listens()
    status = json.loads(system.ok("rtmgr status --json"))
    os.kill(status["pid"], signal.SIGKILL)
    assert "was killed; waiting" in watching.process.stderr.readline()
    system.ok("rtmgr start")
    assert "'manager' is back" in watching.process.stderr.readline()
    system.ok(f"rtact {SINK}")
    watching.until(f"{SINK} 0 ACTIVE")
    system.ok("rtmgr restart")
    assert "'manager' ends; waiting" in watching.process.stderr.readline()
    assert "'manager' is back" in watching.process.stderr.readline()
    system.ok(f"rtmgr {MANAGER} -c ConsoleIn")
    watching.until(f"{SOURCE} APPEARED")
    watching.end()


def test_it_ends_as_soon_as_nobody_reads(system: Any) -> None:
    for line in ("rtwatch /", "rtvlog -n 0 /", "rttop"):
        process = system.open(line)
        process.stdout.close()
        process.stdout = None
        _, err = process.communicate(timeout=30)
        assert (process.returncode, err) == (141, ""), line


def test_a_listener_that_stands_still_holds_up_nobody(system: Any) -> None:
    still = Watching(system, "rtwatch / -v").listens()
    os.kill(still.process.pid, signal.SIGSTOP)
    another = Watching(system, f"rtwatch -v -f rtc_status {MANAGER}").listens()
    system.ok(f"rtmgr {MANAGER} -c ConsoleOut")
    for _ in range(3):
        system.ok(f"rtact {SINK}")
        another.until(" ACTIVE")
        system.ok(f"rtdeact {SINK}")
        another.until(" INACTIVE")
    os.kill(still.process.pid, signal.SIGCONT)
    still.until("APPEARED")
    still.end()
    another.end()


def test_several_managers_are_watched(system: Any) -> None:
    system.ok("rtmgr start other")
    watching = Watching(system, "rtwatch / -v").listens()
    listing = Watching(system, "rtls -lR --watch=0.05 /")
    system.ok("rtmgr /localhost/other.mgr -c ConsoleOut")
    watching.until("/localhost/other.mgr/ConsoleOut0.rtc APPEARED")
    system.ok("rtmgr start late -o manager.components.precreate:ConsoleIn")
    watching.until("/localhost/late.mgr PROCESS_STARTED")
    watching.until("/localhost/late.mgr/ConsoleIn0.rtc APPEARED")
    listing.until("./localhost/late.mgr:")
    system.ok("rtmgr stop late")
    watching.end()
    listing.end()
    system.ok(f"rtmgr {MANAGER} -c ConsoleIn")
    paths = [record["path"] for record in jsonrecords.checked(system.ok("rttop --once --json"))]
    assert paths == [SOURCE, "/localhost/other.mgr/ConsoleOut0.rtc"]


def test_logs_of_several_processes_are_merged_by_time(system: Any) -> None:
    system.ok(f"rtmgr {MANAGER} -c Talker?manager_name=a -c Talker?manager_name=b -c Talker")
    for number in (2, 0, 1):
        system.ok(f"rtact /localhost/Talker{number}.rtc")
    out = system.ok("rtvlog --no-follow -f Talker0 -f talker1 -f Talker2 /localhost")
    said = [line.split("> ")[1] for line in out.splitlines()]
    assert said == ["here I am", "careful", "printed"] * 3
    assert [line.split()[0] for line in out.splitlines()[::3]] == [
        "[Talker2",
        "[Talker0",
        "[Talker1",
    ]
    out = system.ok(f"rtvlog --no-follow -l WARN {TALKER_PATH} /localhost/Talker1.rtc")
    assert [line.split("] ")[1] for line in out.splitlines()] == [
        "WARN  <Talker0> careful",
        "WARN  <Talker1> careful",
    ]
    out = system.ok(f"rtvlog --no-follow -f stdout {MANAGER}/a.mgr")
    assert re.fullmatch(r"\[Talker0 [\d:.]+\] INFO  <stdout> printed\n", out)
    assert system.ok("rtvlog --no-follow --since 600 --grep printed /").count("printed\n") == 3
    assert system.ok("rtvlog --no-follow --since 0.001 /") == ""


def test_the_stacks_of_a_crash_are_in_the_log_of_its_component(system: Any) -> None:
    crash = TALKER.replace('print("printed")', "__import__('ctypes').string_at(0)")
    (system.modules / "Talker.py").write_text(crash)
    system.ok(f"rtmgr {MANAGER} -c Talker?manager_name=a -c Talker?manager_name=a")
    died = system.run(f"rtact {TALKER_PATH}").err
    assert "signal 11 at Talker.py:16 in on_activated" in died
    shown = system.run(f"rtcat {TALKER_PATH}").err
    assert f"rtvlog {TALKER_PATH} shows what it logged" in shown
    out = system.ok(f"rtvlog --no-follow -l FATAL {TALKER_PATH}")
    assert "FATAL <rtkit> Fatal Python error: Segmentation fault at Talker.py:16" in out
    assert 'Talker.py", line 16 in on_activated' in out
    assert system.ok("rtvlog --no-follow -l FATAL /localhost/Talker1.rtc") == ""


def test_a_crash_that_ended_its_manager_is_in_the_log_of_its_component(system: Any) -> None:
    crash = TALKER.replace('print("printed")', "__import__('ctypes').string_at(0)")
    (system.modules / "Talker.py").write_text(crash)
    system.ok(f"rtmgr {MANAGER} -c Talker")
    assert system.run(f"rtact {TALKER_PATH}").status == 1
    line = f"rtvlog --no-follow -l FATAL {TALKER_PATH}"
    before = system.run(line).out
    assert "FATAL <rtkit> Fatal Python error: Segmentation fault at Talker.py:16" in before
    (system.modules / "Talker.py").write_text(TALKER)
    system.ok("rtmgr start")
    assert system.ok(line) == before


def test_threads_of_a_component_print_under_its_name(system: Any) -> None:
    thread = "__import__('threading').Thread(target=print, args=('threaded',)).start()"
    (system.modules / "Talker.py").write_text(TALKER.replace('print("printed")', thread))
    system.ok(f"rtmgr {MANAGER} -c Talker -c Talker?manager_name=a")
    for path in (TALKER_PATH, "/localhost/Talker1.rtc"):
        system.ok(f"rtact {path}")
        out = system.ok(f"rtvlog --no-follow -f stdout {path}")
        assert re.fullmatch(r"\[Talker\d [\d:.]+\] INFO  <stdout> threaded\n", out)


def test_logs_are_followed(system: Any) -> None:
    following = Watching(system, f"rtvlog {MANAGER}")
    following.until("begins")
    system.ok(f"rtmgr {MANAGER} -c Talker?manager_name=late")
    system.ok(f"rtact {TALKER_PATH}")
    following.until("[Talker0 ")
    system.ok(f"rtdeact {TALKER_PATH}")
    assert system.run(f"rtact {TALKER_PATH}").status == 1
    following.until("ERROR <Talker0> on_activated failed: ValueError")
    following.until("    Traceback")
    assert following.end() == (-signal.SIGINT, "rtvlog: interrupted\n")


def test_logs_without_a_manager(system: Any) -> None:
    system.ok(f"rtmgr {MANAGER} -c Talker?manager_name=a")
    system.ok(f"rtact {TALKER_PATH}")
    kill_slave(system, "a")
    assert "careful" in system.ok(f"rtvlog --no-follow {TALKER_PATH}")
    system.ok("rtmgr stop")
    done = system.run(f"rtvlog --no-follow -l warn {TALKER_PATH}")
    assert done.status == 0
    assert "careful" in done.out
    assert "logs are looked for by name" in done.err
