"""rtprint and rtinject at ports of real components in real processes."""

from __future__ import annotations

import json
import os
import select
import shutil
import signal
import subprocess
import time
from datetime import datetime
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

KEEPS_MANAGER = True

EXAMPLES = Path(__file__).parents[2] / "examples" / "basic"
DOUBLER = "/localhost/Doubler0.rtc"


@pytest.fixture
def doubler(manager: Any) -> Any:
    """A shell with an active component, in a slave, that writes twice each number."""
    shutil.copy(EXAMPLES / "Doubler.py", manager.modules)
    manager.ok("rtmgr localhost/manager.mgr -c Doubler?manager_name=s")
    manager.ok(f"rtact {DOUBLER}")
    return manager


def connected(shell: Any, line: str) -> Any:
    """Start a data tool and wait until it is connected."""
    process = shell.open(f"{line} -v")
    told = process.stderr.readline()
    while "warning: " in told:
        told = process.stderr.readline()
    if "is connected" not in told:
        process.kill()
        pytest.fail(told + process.communicate()[1] + shell.log())
    return process


def wait_for_bytes(file: Path, size: int) -> None:
    """Wait until a recorder has written so much, by looking at its file now and then."""
    deadline = time.monotonic() + 30.0
    with select.epoll() as soon:
        while file.stat().st_size < size:
            assert time.monotonic() < deadline, f"{file}: no {size} bytes"
            soon.poll(0.05)


def test_every_value_that_is_injected_is_printed(doubler: Any) -> None:
    lines = "".join(f"{number}\n" for number in range(1000))
    printing = connected(doubler, f"rtprint --lossless --json -n 1000 {DOUBLER}:out")
    assert doubler.run(f"rtinject --lossless {DOUBLER}:in", text=lines) == (0, "", "")
    out, err = printing.communicate(timeout=30)
    assert (printing.returncode, err) == (0, "")
    records = jsonrecords.checked(out)
    assert [record["value"]["data"] for record in records] == [2 * n for n in range(1000)]


def test_a_single_value_arrives_although_the_tool_is_gone_by_then(doubler: Any) -> None:
    printing = connected(doubler, f"rtprint -f data -n 20 {DOUBLER}:out")
    for number in range(20):
        assert doubler.run(f"rtinject -c {number} {DOUBLER}:in") == (0, "", "")
    out, _ = printing.communicate(timeout=30)
    assert [int(line) for line in out.split()] == [2 * number for number in range(20)]


def test_tools_leave_nothing_in_the_tree(doubler: Any) -> None:
    before = doubler.ok("rtls -lR")
    printing = connected(doubler, f"rtprint {DOUBLER}:out")
    assert "rtprint_reader0.rtc" in doubler.ok("rtls localhost")
    another = connected(doubler, f"rtprint {DOUBLER}:out")
    assert "rtprint_reader1.rtc" in doubler.ok("rtls localhost")
    printing.kill()
    printing.communicate(timeout=30)
    another.send_signal(signal.SIGINT)
    _, err = another.communicate(timeout=30)
    assert (another.returncode, err.strip()) == (-signal.SIGINT, "rtprint: interrupted")
    assert doubler.ok("rtls -lR") == before
    assert doubler.run(f"rtinject -c 1 {DOUBLER}:in").status == 0


def test_a_reader_notices_that_its_component_is_gone(doubler: Any) -> None:
    printing = connected(doubler, f"rtprint {DOUBLER}:out")
    doubler.ok(f"rtexit {DOUBLER}")
    _, err = printing.communicate(timeout=30)
    assert printing.returncode == 1
    assert "no connection is left" in err


def test_a_reader_runs_on_while_the_manager_is_killed_and_started_again(doubler: Any) -> None:
    printing = connected(doubler, f"rtprint -f data -n 1 {DOUBLER}:out")
    status = json.loads(doubler.ok("rtmgr status --json"))
    os.kill(status["pid"], signal.SIGKILL)
    doubler.ok("rtmgr start")
    assert doubler.run(f"rtinject -c 21 {DOUBLER}:in") == (0, "", "")
    out, err = printing.communicate(timeout=30)
    assert (printing.returncode, out.strip()) == (0, "42"), err


def test_a_tool_ends_with_the_reader_of_its_pipe(doubler: Any) -> None:
    for line in ("rtprint", "rtlog -l text -f -"):
        process = connected(doubler, f"{line} {DOUBLER}:out")
        assert doubler.run(f"rtinject -c 1 {DOUBLER}:in").status == 0
        assert process.stdout.readline()
        process.stdout.close()
        assert process.wait(30) == 141  # though no further value comes
        process.stderr.close()


def test_several_ports_are_told_apart(doubler: Any) -> None:
    doubler.ok("rtmgr localhost/manager.mgr -c Doubler")
    doubler.ok("rtact /localhost/Doubler1.rtc")
    other = DOUBLER.replace("0", "1")
    printing = connected(doubler, f"rtprint -f data -n 2 {DOUBLER}:out {other}:out")
    assert doubler.run(f"rtinject -c 1 {DOUBLER}:in").status == 0
    assert doubler.run(f"rtinject -c 2 {other}:in").status == 0
    out, _ = printing.communicate(timeout=30)
    assert out == f"{DOUBLER}:out  2\n{other}:out  4\n"


def test_what_is_wrong_is_told_before_anything_is_connected(doubler: Any) -> None:
    for line, told in (
        (f"rtprint --stats -f daat {DOUBLER}:out", "no field daat: TimedLong has tm, data"),
        (f"rtinject -c '{{daat: 1}}' {DOUBLER}:in", "-c {daat: 1}: TimedLong: no field daat"),
        (f"rtprint --plot --json {DOUBLER}:out", "--plot draws: no --json"),
    ):
        done = doubler.run(line)
        assert done.status in (1, 2)
        assert told in done.err


def test_a_recording_goes_through_a_pipe(doubler: Any) -> None:
    line = doubler.command(f"rtlog -i -e 2 -v -f - {DOUBLER}:out")
    with open(doubler.folder / "x.mcap", "wb") as file:
        cat = subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=file)
        recording = subprocess.Popen(
            line, stdout=cat.stdin, stderr=subprocess.PIPE, text=True, env=doubler.environment
        )
        assert cat.stdin is not None
        cat.stdin.close()
    assert recording.stderr is not None
    assert "is connected" in recording.stderr.readline()
    assert doubler.run(f"rtinject -c 1 -n 2 -r 100 {DOUBLER}:in").status == 0
    _, err = recording.communicate(timeout=30)
    assert (recording.returncode, cat.wait(30)) == (0, 0), err
    told = json.loads(doubler.ok("rtlog --info --json -f x.mcap"))
    assert (told["entries"], told["is_whole"]) == (2, True)


def test_a_recording_of_nothing_is_told(doubler: Any) -> None:
    done = doubler.run(f"rtlog -t 0.2 -f none.mcap {DOUBLER}:out")
    assert (done.status, done.err.splitlines()[1:]) == (
        1,
        ["rtlog: nothing was recorded: no value came, none.mcap has no entries"],
    )
    assert json.loads(doubler.ok("rtlog --info --json -f none.mcap"))["is_whole"]


def test_nothing_came(doubler: Any) -> None:
    assert doubler.run(f"rtprint -t 0.2 {DOUBLER}:out") == (1, "", "")


def test_a_saved_system_does_not_have_the_tool_in_it(doubler: Any) -> None:
    printing = connected(doubler, f"rtprint {DOUBLER}:out")
    saved = doubler.ok("rtcryo --all")
    printing.kill()
    printing.communicate(timeout=30)
    assert "Doubler0" in saved
    assert "rtprint" not in saved


def test_statistics_of_what_came(doubler: Any) -> None:
    printing = connected(doubler, f"rtprint --stats --json -n 50 --lossless {DOUBLER}:out")
    assert doubler.run(f"rtinject --lossless -c 1 -n 50 -r 500 {DOUBLER}:in") == (0, "", "")
    out, _ = printing.communicate(timeout=30)
    (told,) = jsonrecords.checked(out)
    assert (told["values"], told["size_bytes"]["most"]) == (50, 16)
    assert told["interval_s"]["mean"] > 0
    assert told["latency_s"]["median"] > 0


def test_what_is_recorded_is_played_again(doubler: Any) -> None:
    recording = connected(doubler, f"rtlog -i -e 100 -f run.mcap --lossless {DOUBLER}:out")
    lines = "".join(f"{number}\n" for number in range(100))
    assert doubler.run(f"rtinject --lossless -r 500 {DOUBLER}:in", text=lines).status == 0
    _, err = recording.communicate(timeout=30)
    assert recording.returncode == 0, err
    told = json.loads(doubler.ok("rtlog -d --json -f run.mcap"))
    assert (told["entries"], told["is_whole"]) == (100, True)
    assert told["channels"][0]["name"] == "Doubler0_out"
    printing = connected(doubler, f"rtprint --lossless -f data -n 98 {DOUBLER}:out")
    played = doubler.run(f"rtlog -p -i -s 2 -r 5 --lossless -f run.mcap {DOUBLER}:in")
    assert (played.status, played.err) == (0, "Playing from entry 2.\nEnd of log reached.\n")
    out, _ = printing.communicate(timeout=30)
    assert [int(line) for line in out.split()] == [4 * number for number in range(2, 100)]


def test_a_recording_survives_the_death_of_the_recorder(doubler: Any) -> None:
    recording = connected(doubler, f"rtlog -f run.mcap {DOUBLER}:out")
    injecting = doubler.open(f"rtinject -c 1 -n -1 -r 200 {DOUBLER}:in")
    wait_for_bytes(doubler.folder / "run.mcap", 4000)
    recording.kill()
    recording.communicate(timeout=30)
    died = time.time()
    injecting.send_signal(signal.SIGINT)
    injecting.communicate(timeout=30)
    told = json.loads(doubler.ok("rtlog -d --json -f run.mcap"))
    assert not told["is_whole"]
    assert told["entries"] > 0
    last = datetime.fromisoformat(told["last"]).timestamp()
    assert died - last < 10  # ten times what is promised


def test_a_recorder_that_is_asked_to_end_finishes_its_file(doubler: Any) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        name = f"{number.name}.mcap"
        recording = connected(doubler, f"rtlog -f {name} {DOUBLER}:out")
        before = (doubler.folder / name).stat().st_size
        assert doubler.run(f"rtinject -c 1 {DOUBLER}:in").status == 0
        wait_for_bytes(doubler.folder / name, before + 1)  # it is at the port, not yet recorded
        recording.send_signal(number)
        recording.communicate(timeout=30)
        assert recording.returncode == -number
        told = json.loads(doubler.ok(f"rtlog -d --json -f {name}"))
        assert (told["entries"], told["is_whole"]) == (1, True)


ROVER = """
from dataclasses import dataclass
from enum import Enum

from rtkit.component import Component, InPort, OutPort

Mode = Enum("Mode", "IDLE DRIVING")


@dataclass(frozen=True)
class Spot:
    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True)
class Path:
    mode: Mode = Mode.IDLE
    spots: tuple[Spot, ...] = ()
    pairs: tuple[tuple[Spot, Spot], ...] = ()


@dataclass(frozen=True)
class Odd:
    pair: tuple[int, str] = (0, "")


class Rover(Component):
    \"\"\"Hand paths on.\"\"\"

    rate = 100.0
    into = InPort(Path)
    out = OutPort(Path)
    odd = OutPort(Odd)

    def on_execute(self, context):
        for path in self.into.read_all():
            self.odd.write(Odd((1, "odd")))
            self.out.write(path)


def RoverInit(manager):
    manager.register_factory(Rover)
"""


def test_types_that_only_the_component_knows(manager: Any) -> None:
    """Tools build them from what ports tell, and from what a recording carries."""
    (manager.modules / "Rover.py").write_text(ROVER)
    manager.ok("rtmgr localhost/manager.mgr -c Rover?manager_name=s")
    rover = "/localhost/Rover0.rtc"
    manager.ok(f"rtact {rover}")
    printing = connected(manager, f"rtprint -n 1 {rover}:out")
    recording = manager.open(f"rtlog -v -i -e 2 -f run.mcap {rover}:out.a {rover}:odd.b")
    warned = recording.stderr.readline()
    assert warned.startswith(f"rtlog: warning: Type not found: IDL:Rover/Odd:1.0 of {rover}:odd")
    assert "is connected" in recording.stderr.readline()
    (page,) = jsonrecords.checked(manager.ok("rttype show --json Rover::Path"))
    assert page["example"]["pairs"] == [[{"x": 0.0, "y": 0.0}] * 2]
    assert page["ports"] == [f"{rover}:into", f"{rover}:out"]
    value = "{mode: DRIVING, spots: [{x: 1.5}, {y: 2}], pairs: [[{x: 3}, {}]]}"
    assert manager.run(f"rtinject -c '{value}' {rover}:into").status == 0
    shown = (
        "Path(mode=DRIVING, spots=[Spot(x=1.5, y=0.0), Spot(x=0.0, y=2.0)],"
        " pairs=[[Spot(x=3.0, y=0.0), Spot(x=0.0, y=0.0)]])\n"
    )
    assert printing.communicate(timeout=30)[0] == shown
    assert recording.wait(timeout=30) == 0
    manager.ok("rtmgr stop")
    assert page["definition"] in manager.ok("rttype show -f run.mcap Rover::Path")
    exported = manager.run("rtlog --export json -f run.mcap")
    assert exported.err.count("of stream b") == 1
    values = {each["stream"]: each["value"] for each in jsonrecords.checked(exported.out)}
    assert values["a"]["spots"] == [{"x": 1.5, "y": 0.0}, {"x": 0.0, "y": 2.0}]
    assert bytes(values["b"])[-4:-1] == b"odd"


def test_all_ports_are_recorded_also_those_that_come_and_come_back(manager: Any) -> None:
    shutil.copy(EXAMPLES / "Doubler.py", manager.modules)
    recording = manager.open("rtlog -a -v -i -e 3 -f all.mcap")

    def told(text: str) -> None:
        for line in recording.stderr:
            if text in line:
                return
        pytest.fail(f"no {text!r}: {manager.log()}")

    told("is connected")
    for name in ("Doubler0", "Doubler0", "Doubler1"):
        manager.ok(f"rtmgr localhost/manager.mgr -c 'Doubler?instance_name={name}&manager_name=s'")
        manager.ok(f"rtact /localhost/{name}.rtc")
        told(f"/localhost/{name}.rtc:out is recorded as {name}_out")
        injected = manager.run(f"rtinject -c {name[-1]} /localhost/{name}.rtc:in")
        assert injected == (0, "", "")
        if name == "Doubler0":
            manager.ok("rtexit /localhost/Doubler0.rtc")
    assert recording.wait(timeout=30) == 0
    recording.communicate(timeout=30)
    values = jsonrecords.checked(manager.ok("rtlog --export json -f all.mcap"))
    assert [(each["stream"], each["value"]["data"]) for each in values] == [
        *[("Doubler0_out", 0)] * 2,
        ("Doubler1_out", 2),
    ]


def test_a_pattern_of_ports_that_are_not_there_is_told(doubler: Any) -> None:
    done = doubler.run("rtprint -n 1 'Doubblr*:out'")
    assert (done.status, done.err) == (1, "rtprint: No output port matches: Doubblr*:out\n")
    printing = connected(doubler, "rtprint -f data -n 1 'Doub*:out'")
    assert doubler.run(f"rtinject -c 4 {DOUBLER}:in").status == 0
    assert printing.communicate(timeout=30)[0] == "8\n"


def test_a_chart_on_a_terminal_is_drawn_in_place(doubler: Any) -> None:
    master, slave = os.openpty()
    doubler.environment["TERM"] = "xterm"
    line = doubler.command(f"rtprint --plot -v -n 60 {DOUBLER}:out")
    with subprocess.Popen(
        line,
        stdout=slave,
        stderr=subprocess.PIPE,
        text=True,
        env=doubler.environment,
        cwd=doubler.folder,
    ) as process:
        os.close(slave)
        assert process.stderr is not None
        assert "is connected" in process.stderr.readline()
        assert doubler.run(f"rtinject -c 21 -n 60 -r 100 {DOUBLER}:in").status == 0
        text = ""
        while piece := read_terminal(master):
            text += piece
        assert process.wait(30) == 0
    os.close(master)
    first, *again = text.split("\x1b[16A")
    assert again  # drawn anew over what was there
    assert "* data 42" in first
    assert again[-1].rstrip().endswith("* data 42\x1b[0m\x1b[K")


def read_terminal(master: int) -> str:
    try:
        return os.read(master, 65536).decode()
    except OSError:  # nobody has the other end any more
        return ""
