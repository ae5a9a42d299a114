"""Each row of the table of exit statuses, provoked: with ``--exit-detail`` and without."""

from __future__ import annotations

import select
import signal
import subprocess
from typing import Any, NamedTuple

import pytest

from rtkit.cli.help.topics import DETAILS, STATUSES
from rtkit.resources import resource

KEEPS_MANAGER = True
SYSTEM = resource("profiles", "systems", "sensor-controller-motor.xml")
OUT, IN = "/localhost/ConsoleOut0.rtc", "/localhost/ConsoleIn0.rtc"
BY_NO_COMMAND = {"8", "70"}
"""A search without bounds and a fault of rtkit; `tests/unit/cli/test_app.py` has both."""


class Case(NamedTuple):
    """What is typed, the status without and with --exit-detail, and a part of the reason."""

    line: str
    plain: int
    detail: int
    why: str


CASES = (
    Case("rtls /localhost", 0, 0, ""),
    Case(f"rtwait {IN} {OUT} active -t 0.1", 1, 6, f"{OUT} is Inactive, not Active"),
    Case(f"rtcon {IN}:out {IN}:out", 1, 1, "Wrong port type"),
    Case("rtls --no-such-option", 2, 2, "No such option"),
    Case("rtls '/localhost/a b:::'", 1, 2, "rtls: "),
    Case("rtprofile validate bad.xml", 1, 3, "bad.xml:"),
    Case("rtcat /localhost/Nobody0.rtc", 1, 4, "No such object"),
    Case("rtls /localhost:1", 1, 5, "rtls: "),
    Case("rtplan impossible.xml", 1, 7, "rtkit.limit.processor: "),
)


@pytest.fixture
def system(manager: Any) -> Any:
    manager.ok("rtmgr -c ConsoleOut -c ConsoleIn /localhost/manager.mgr")
    (manager.folder / "bad.xml").write_text("<nothing>")
    manager.ok(f"rtprofile set {SYSTEM} Motor0:rtkit.limit.processor=4000 -o impossible.xml")
    return manager


def test_each_row_is_met(system: Any) -> None:
    for case in CASES:
        name, _, rest = case.line.partition(" ")
        for line, status in (
            (case.line, case.plain),
            (f"{name} --exit-detail {rest}", case.detail),
        ):
            done = system.run(line)
            assert (done.status, case.why in done.out + done.err) == (status, True), (line, done)
    met = {str(case.plain) for case in CASES} | {"130", "141"}
    assert met == set(STATUSES)
    assert {str(case.detail) for case in CASES} - {"0"} == set(DETAILS) - BY_NO_COMMAND


def test_what_ends_a_command_from_outside_is_its_status(system: Any) -> None:
    """A shell shows 130 for the signal."""
    for end, status in ((_interrupt, -signal.SIGINT), (_stop_reading, 141)):
        with subprocess.Popen(
            system.command("rtwatch --json /localhost"),
            env=system.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        ) as process:
            assert process.stdout is not None
            while not select.select([process.stdout], [], [], 0)[0]:
                system.ok(f"rtact {OUT}")  # an event, as soon as it listens
                system.ok(f"rtdeact {OUT}")
            end(process)
            system.ok(f"rtact {OUT}")
            assert process.wait(30) == status
        system.ok(f"rtdeact {OUT}")


def _interrupt(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGINT)


def _stop_reading(process: subprocess.Popen[bytes]) -> None:
    assert process.stdout is not None
    process.stdout.close()
