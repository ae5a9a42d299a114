"""Components, managers and the host answer as live properties, where other commands find them."""

from __future__ import annotations

import json
from typing import Any

from rtkit.deployment.extension import FOLLOW
from rtkit.manager.core import operations
from rtkit.tree import live_properties as live

IN0 = "/localhost/In0.rtc"
MANAGER = "/localhost/manager.mgr"

KEEPS_MANAGER = True


def test_the_operations_are_those_of_the_manager() -> None:
    assert {*live.READ, FOLLOW} == {*operations.READ, "get_loadable_modules"}
    among_managers = {"expect", "expect_no_more"}
    assert set(live.DO) == {*operations.DO, "shutdown", "restart"} - among_managers


def test_components_are_got_and_set(manager: Any) -> None:
    manager.ok(f"rtset {MANAGER}.create_component ConsoleIn?instance_name=In0")
    assert manager.ok(f"rtget {IN0}.state {IN0}/type {MANAGER}/In0.rtc.ports.out.direction") == (
        'Inactive\n"ConsoleIn"\nout\n'
    )
    manager.ok(f"rtset {IN0}.configuration.default.values 1,2,3")
    assert manager.ok(f"rtconf {IN0} get values") == "1,2,3\n"
    manager.ok(f"rtset {IN0} contexts.0.rate 20")
    listening = manager.open(f"rtlisten -n 3 {IN0}.state")
    assert listening.stdout.readline() == "Inactive\n"
    manager.ok(f"rtset {IN0}.state Active")
    assert listening.stdout.readline() == "Active\n"
    counting = manager.open(f"rtlisten -n 3 {IN0}.ports.out.count")
    counts = [int(counting.stdout.readline()) for _ in range(3)]
    assert counts == sorted(set(counts)), "values pass while it is active"
    assert counting.communicate(timeout=30)[1] == ""
    assert manager.ok(f"rtset --echo {IN0}.state Inactive") == "Inactive\n"
    assert listening.stdout.readline() == "Inactive\n"
    assert listening.communicate(timeout=30)[1] == ""
    assert "state" in manager.ok(f"rtget {IN0}")
    for line, error in (
        (f"rtset {IN0}.state Error", "conflict: it is Inactive, it cannot become Error"),
        (f"rtset {IN0}.contexts.0.rate -1", "bad-value: -1 is below 0.0"),
        (f"rtset {IN0}.type x", "read-only: cannot be set: type"),
        (f"rtget {IN0}.nope", "unknown: no such property: nope"),
        (
            "rtget /localhost/No0.rtc.state",
            "unknown: No such object: /localhost/No0.rtc (did you mean /localhost/In0.rtc?)",
        ),
        (
            f"rtset {MANAGER}.delete_component No0",
            "unknown: no component named No0 (did you mean In0?)",
        ),
        (f"rtset {MANAGER}.pid 3", "read-only: cannot be set: pid"),
    ):
        outcome = manager.run(line)
        name, target = line.split()[:2]
        assert (outcome.status, outcome.err) == (1, f"{name}: {target}: {error}\n")


def test_managers_and_hosts_answer_too(manager: Any) -> None:
    pid = json.loads(manager.ok(f"rtget --json {MANAGER}.pid"))["value"]
    assert manager.ok(f"rtget --raw {MANAGER}.settings.manager.pid") == str(pid)
    manager.ok(f"rtset {MANAGER}.settings.logger.log_level DEBUG")
    assert manager.ok(f"rtconf {MANAGER} get logger.log_level") == "DEBUG\n"
    assert manager.ok(f"rtset --echo {MANAGER}.get_components_by_name Nobody") == (
        '<call state="done"><result/></call>\n'
    )
    assert manager.ok("rtget localhost.managers /localhost/services") == "(manager)\n()\n"
    assert "managers" in manager.ok("rtget localhost.properties")
    for wrong, told in (
        ("localhost.manager", "unknown: no such property: manager (this host has name system "),
        ("/localhost/manger", "no-service: no service named manger (there is none; this host has "),
    ):
        assert told in manager.run(f"rtget {wrong}").err
    listening = manager.open(f"rtlisten -n 2 {MANAGER}.components")
    assert listening.stdout.readline() == "()\n"
    manager.ok(f"rtset {MANAGER}.create_component ConsoleOut?instance_name=Out0")
    assert listening.stdout.readline() == "(Out0)\n"
    assert listening.communicate(timeout=30)[1] == ""


def test_a_served_object_is_listed(manager: Any) -> None:
    process = manager.open("rtserve statistics:NormalDist lab/noise -a 10 -a 2")
    process.stdout.readline()
    assert manager.ok("rtls /localhost") == "lab/\nmanager.mgr/\n"
    assert manager.ok("rtls /localhost/lab") == "noise/\n"
    assert "mean" in manager.ok("rtls lab/noise").splitlines()
    lines = [line.split() for line in manager.ok("rtls -l /localhost/lab/noise").splitlines()]
    assert ["number", "r", "-", "good", "stdev", "2.0"] in lines
    records = [json.loads(line) for line in manager.ok("rtls --json lab/noise").splitlines()]
    assert {"lab/noise.mean": 10.0}.items() <= {r["target"]: r["value"] for r in records}.items()
    process.terminate()
    process.communicate(timeout=30)
    assert manager.ok("rtls /localhost") == "manager.mgr/\n"


STUCK = """
import threading


class Odd:
    def get_quick(self) -> float:
        return 4.5

    def get_stuck(self) -> float:
        threading.Event().wait()
"""


def test_a_listing_has_the_values_that_come_quickly(shell: Any) -> None:
    (shell.folder / "odd.py").write_text(STUCK)
    process = shell.open("rtserve odd:Odd odd")
    process.stdout.readline()
    lines = [line.split() for line in shell.ok("rtls -l odd").splitlines()]
    head = ["number", "r", "-", "good"]
    assert lines == [[*head, "quick", "4.5"], [*head, "stuck"]]
    process.terminate()
    process.communicate(timeout=30)
