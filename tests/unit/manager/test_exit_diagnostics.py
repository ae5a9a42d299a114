"""What is known of a process that ended, from what it left; and that none of it grows for ever."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time

import pytest

from rtkit.cli.observing.unseen import unseen_entries
from rtkit.container.exit_diagnostics import (
    ExitDiagnostics,
    culprits,
    exit_diagnostics,
    log_crash,
)
from rtkit.container.heartbeats import Heartbeats
from rtkit.container.slave_checkpoint import SlaveCheckpoint
from rtkit.link import places
from rtkit.logs import outputs
from rtkit.logs.logbook import Logbook
from rtkit.logs.outputs import cut, forget_old, head
from rtkit.manager.predecessor.crashes import unseen_crashes

CRASH = f"""Fatal Python error: Segmentation fault

Thread 0x00007f0000000001 (most recent call first):
  File "/home/me/other.py", line 3 in wait

Current thread 0x00007f0000000002 (most recent call first):
  File "{os.__file__}", line 9 in string_at
  File "/home/me/arm.py", line 15 in move
  File "/home/me/arm.py", line 11 in on_execute

Extension modules: numpy
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    return tmp_path


def wrote(text, pid=42):
    with open(places.output_file("m", "s"), "w") as file:
        file.write(head("s", pid).decode() + text)


def logged(*records, pid=42):
    with open(places.log_file("m", "s"), "w") as file:
        for level, logger, message in records:
            record = {"level": level, "pid": pid, "logger": logger, "message": message}
            file.write(json.dumps(record) + "\n")


def test_a_crash_is_named_with_its_line(folder):
    wrote(CRASH)
    words = exit_diagnostics("m", "s", 42)
    assert words[:4] == ("arm.py:15 in move", "", 0x7F0000000002, CRASH.strip())
    assert words.output == ()
    assert abs(time.time() - words.time_s) < 10
    assert words.reason("signal 11") == "signal 11 at arm.py:15 in move"


def test_what_was_printed_before_a_crash(folder):
    wrote(f"terminate called after throwing 'X'\n  what():  no \x1b[1m arm\n{CRASH}")
    assert exit_diagnostics("m", "s", 42)[:2] == (
        "arm.py:15 in move",
        "terminate called after throwing 'X'; what(): no \\x1b[1m arm",
    )


@pytest.mark.parametrize(
    "frame",
    [
        "<no Python frame>",
        f'  File "{outputs.__file__}", line 1 in x',
        '  File "<frozen x>", line 8 in x',
    ],
)
def test_a_crash_that_is_not_in_a_component(folder, frame):
    thread = "Current thread 0x0000000000000002 (most recent call first):"
    wrote(f"Fatal Python error: Segmentation fault\n\n{thread}\n{frame}\n")
    assert exit_diagnostics("m", "s", 42)[:2] == ("", "")
    assert ExitDiagnostics().reason("signal 11") == "signal 11"


@pytest.mark.parametrize("instance", ["Arm0", ""])
def test_the_stacks_of_a_crash_are_logged_for_its_component(folder, instance):
    wrote(f"before\n{CRASH}")
    log_crash("m", "s", 42, exit_diagnostics("m", "s", 42), [instance])
    [entry] = Logbook(str(folder), lambda entry: True).there()
    assert entry.message == "Fatal Python error: Segmentation fault at arm.py:15 in move"
    assert (entry.component, entry.process, entry.pid, entry.level) == (instance, "s", 42, "FATAL")
    assert '  File "/home/me/arm.py", line 15 in move\n' in entry.exception
    assert "wait" in entry.exception
    assert "before" not in entry.exception


CODES = {"A": "0 /home/me/arm.py\n1 /home/me/beside.py", "B": "0 /x/leg.py", "C": ""}


@pytest.mark.parametrize(
    ("on_thread", "codes", "wanted"),
    [
        ("B", CODES, ("B",)),
        ("", CODES, ("A",)),
        ("", {"B": "0 /x/leg.py"}, ("B",)),
        ("", {"A": CODES["A"], "A1": CODES["A"], "B": ""}, ("A", "A1")),
        ("", {"B": "0 /x/leg.py", "C": ""}, ()),
        ("", {"D": "0 /home/me/other.py", "C": ""}, ()),  # its thread only waited
        ("", {}, ()),
    ],
)
def test_the_components_whose_code_may_have_crashed(folder, on_thread, codes, wanted):
    wrote(CRASH)
    assert culprits(exit_diagnostics("m", "s", 42), on_thread, codes) == wanted


def test_a_crash_that_no_manager_saw_is_found_until_it_is_logged(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    tmp_path.chmod(0o700)
    wrote(CRASH)
    with open(places.output_file("m"), "w") as file:
        file.write(head("m", 43).decode() + "last words\n" + CRASH)
    beats = Heartbeats(str(tmp_path / "m.43.beats"))
    slot = beats.slot()
    monkeypatch.setattr(threading, "get_ident", lambda: 0x7F0000000002)
    slot.watch("Own0", "on_execute")
    dead = {42: SlaveCheckpoint("s", [{"instance": "Arm0", "code": "0 /home/me/arm.py"}])}
    found = unseen_crashes("m", dead)
    assert [(each.slave, each.pid, each.instances) for each in found] == [
        ("s", 42, ("Arm0",)),
        ("", 43, ("Own0",)),
    ]
    assert [(each.component, each.file) for each in unseen_entries("m")] == [("Own0", "m")]
    for each in found:
        each.log("m")
    assert unseen_crashes("m", dead) == []
    entries = Logbook(str(folder), lambda entry: True).there()
    assert [(each.component, each.process, each.pid) for each in entries] == [
        ("Arm0", "s", 42),
        ("Own0", "m", 43),
    ]
    assert unseen_crashes("m", {44: SlaveCheckpoint("s", [])}) == []  # another process of the name


def test_the_last_lines_that_were_printed(folder):
    wrote("one\n\n two \nthree\nfour")
    logged(("ERROR", "A", "not this"))
    assert exit_diagnostics("m", "s", 42).text == "two; three; four"


def test_else_what_was_logged_as_worth_a_warning(folder):
    wrote("")
    logged(
        ("INFO", "A", "all is well"),
        ("INFO", "stdout", "printed"),
        ("WARN", "A", "warned"),
        ("ERROR", "A", "no\nlicence"),
    )
    assert exit_diagnostics("m", "s", 42).text == "printed; warned; no licence"


def test_words_of_another_process_are_not_its_own(folder):
    wrote(CRASH, pid=43)
    logged(("ERROR", "A", "not this"), pid=43)
    assert exit_diagnostics("m", "s", 42) == ExitDiagnostics()
    wrote("")
    assert exit_diagnostics("m", "s", 42)[:4] == ExitDiagnostics()[:4]


@pytest.mark.parametrize("left", ["nothing", "folders", "rubbish"])
def test_what_cannot_be_read_says_nothing(folder, left):
    paths = [places.output_file("m", "s"), places.log_file("m", "s")]
    for path in paths if left != "nothing" else ():
        if left == "folders":
            os.mkdir(path)
        else:
            with open(path, "wb") as file:
                file.write(b"\xff\xfe{\n[]\n3\nnull\n" * 9000)
    assert exit_diagnostics("m", "s", 42) == ExitDiagnostics()
    if left == "rubbish":
        wrote("")
        assert exit_diagnostics("m", "s", 42)[:4] == ExitDiagnostics()[:4]


def test_long_words_are_cut_at_their_beginning(folder):
    wrote("x" * 100_000 + "\nthe end\n")
    text = exit_diagnostics("m", "s", 42).text
    assert len(text) == 300
    assert text.startswith("…x")
    assert text.endswith("x; the end")


def run(script):
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    assert done.stderr == b""
    return done


def test_a_process_begins_its_output_anew(folder):
    script = "from rtkit.logs.outputs import redirect; import os; redirect({!r}, 's');"
    script = script.format(places.output_file("m", "s")) + "os.system('echo {}; echo e >&2')"
    for text in ("one", "two"):
        assert run(script.format(text)).stdout == b""
    found = {each.name: each.read_text().splitlines()[1:] for each in folder.iterdir()}
    assert found == {"m.s.out": ["two", "e"], "m.s.out.1": ["one", "e"]}
    assert {each.stat().st_mode & 0o777 for each in folder.iterdir()} == {0o600}


def test_output_that_cannot_be_kept_goes_where_it_went(folder):
    os.mkdir(places.output_file("m", "s"))
    (folder / "m.s.out" / "x").write_text("")
    os.mkdir(places.output_file("m", "s") + ".1")
    (folder / "m.s.out.1" / "x").write_text("")
    path = places.output_file("m", "s")
    script = f"from rtkit.logs.outputs import redirect; redirect({path!r}, 's')"
    assert run(f"{script}; import os; os.write(1, b'here')").stdout == b"here"


def test_output_is_cut_when_it_grows(folder):
    wrote("")
    path = places.output_file("m", "s")
    writer = os.open(path, os.O_WRONLY | os.O_APPEND)
    os.write(writer, b"0123456789" * 20)
    cut(path, 1000)
    assert os.path.getsize(path) > 200
    os.write(writer, b"0123456789" * 90)
    cut(path, 1000)
    assert (folder / "m.s.out").read_text().startswith("== s, pid 42, ")
    assert os.path.getsize(path) == len(head("s", 42))
    assert (folder / "m.s.out.1").read_bytes() == b"0123456789" * 50
    os.write(writer, b"more")
    assert (folder / "m.s.out").read_bytes().endswith(b"Z\nmore")
    os.close(writer)
    cut(str(folder / "nothing"))


def test_logs_of_slaves_that_no_later_one_continues_are_forgotten(folder, monkeypatch):
    alive = os.getpid()
    dead = [pid for pid in range(4_194_000, 4_194_200) if not os.path.exists(f"/proc/{pid}")][:5]
    for age, pid in enumerate([*dead, alive]):
        for suffix in ("log", "log.1", "out"):
            file = folder / f"m.manager_{pid}.{suffix}"
            file.write_text("")
            os.utime(file, (1000 - age, 1000 - age))
    others = {"m.log", "m.s.log", f"n.manager_{dead[4]}.log", f"m.manager_{dead[4]}x.log"}
    for name in others:
        (folder / name).write_text("")
        os.utime(folder / name, (0, 0))
    forget_old("m", kept=2)
    left = {each.name for each in folder.iterdir()} - others
    kept = {f"m.manager_{pid}.{s}" for pid in (*dead[:2], alive) for s in ("log", "log.1", "out")}
    assert left == kept
    monkeypatch.setenv("RTKIT_STATE_DIR", str(folder / "nothing"))
    forget_old("m")
    assert outputs.KEPT > 0
