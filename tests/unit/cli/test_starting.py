"""rtstart and rtstop with orders and preconditions, as users type them, on the fake world: §11."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import rts_text
from fake_manager import FakeManager
from fake_tree import fake_tree
from worlds import things

from rtkit.cli.components import rtact, rtdeact
from rtkit.cli.system import rtcheck, rtresurrect, rtstart, rtstop
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.errors import Unreachable
from rtkit.link.wakeup import Wakeup
from rtkit.rtc.enums import ReturnCode

COMMANDS = {
    "rtact": rtact,
    "rtcheck": rtcheck,
    "rtdeact": rtdeact,
    "rtresurrect": rtresurrect,
    "rtstart": rtstart,
    "rtstop": rtstop,
}
ENTRY = """<rts:targets rts:sequence="{}" xsi:type="rtsExt:condition_ext">{}
 <rts:TargetComponent {}/></rts:targets>
"""
PRECEDING = '<rts:Preceding rts:sendingTiming="{}" rts:timeout="{}">{}</rts:Preceding>'
EC = "in execution context 0"
NO = Result(ReturnCode.ERROR, "refused", "no luck")

Run = Callable[..., tuple[int, str, str]]


def name(instance: str) -> str:
    return f'rts:componentId="RTC:Me:test:Thing:1.0" rts:instanceName="{instance}" rts:id="0"'


def entry(
    instance: str,
    sequence: int,
    wait: int = 0,
    after: str = "",
    timing: str = "SYNC",
    limit: int = 0,
) -> str:
    first = f'<rts:WaitTime rts:waitTime="{wait}"/>'
    if after:
        first = PRECEDING.format(timing, limit, f"<rts:PrecedingComponents {name(after)}/>")
    return ENTRY.format(sequence, first, name(instance))


FOUR_KINDS = (
    entry("A", 1),
    entry("B", 2, wait=20),
    entry("C", 3, after="A", limit=2000),
    entry("D", 4, after="B", timing="ASYNC"),
)


@pytest.fixture
def file(tmp_path: Path) -> Callable[..., str]:
    """Return what writes a profile of the components A to D."""

    def write(*activation: str, deactivation: tuple[str, ...] = (), optional: str = "") -> str:
        parts = [
            rts_text.component(n, type_id="RTC:Me:test:Thing:1.0", required=n not in optional)
            for n in "ABCD"
        ]
        for tag, entries in (("Activation", activation), ("Deactivation", deactivation)):
            if entries:
                parts.append(f"<rts:{tag}>{''.join(entries)}</rts:{tag}>")
        path = tmp_path / "four.xml"
        path.write_text(rts_text.system("Four", *parts), encoding="utf-8")
        return str(path)

    return write


@pytest.fixture
def world() -> FakeManager:
    return things("ABCD")


@pytest.fixture
def run(world: FakeManager, capsys: pytest.CaptureFixture[str]) -> Run:
    def typed(command: str, *arguments: str) -> tuple[int, str, str]:
        status = COMMANDS[command].main(list(arguments), tree=fake_tree(world, 5.0))
        captured = capsys.readouterr()
        return status, captured.out, captured.err.replace("/localhost/", "")

    return typed


def order(world: FakeManager) -> str:
    return "".join(a.instance for a in world.performed if isinstance(a, act.ChangeState))


def test_all_kinds(run: Run, file: Any, world: FakeManager) -> None:
    status, out, err = run("rtstart", file(*FOUR_KINDS))
    assert (status, out) == (0, "")
    assert err.splitlines() == [
        f"Executing {{1}} [Order 1] Activate A.rtc {EC} (Required)",
        f"Executing {{3}} [Order 3/Sync to A.rtc] Activate C.rtc {EC} (Required)",
        f"Executing {{2}} [Order 2/Wait 20ms] Activate B.rtc {EC} (Required)",
        f"Executing {{4}} [Order 4/After B.rtc's action] Activate D.rtc {EC} (Required)",
    ]
    assert order(world) == "ACBD"


def test_a_dry_run(run: Run, file: Any, world: FakeManager) -> None:
    status, out, err = run("rtstart", "--dry-run", file(*FOUR_KINDS, optional="D"))
    assert (status, err) == (0, "")
    assert out.replace("/localhost/", "").splitlines() == [
        *(
            f'Check for required component "RTC:Me:test:Thing:1.0", "{n}" at path {n}.rtc'
            " (Required)"
            for n in "ABC"
        ),
        f"{{1}} [Order 1] Activate A.rtc {EC} (Required)",
        f"{{2}} [Order 2/Wait 20ms] Activate B.rtc {EC} (Required)",
        f"{{3}} [Order 3/Sync to A.rtc] Activate C.rtc {EC} (Required)",
        f"{{4}} [Order 4/After B.rtc's action] Activate D.rtc {EC}",
    ]
    assert not world.performed


def test_a_stop_is_the_reverse_or_as_its_block_says(
    run: Run, file: Any, world: FakeManager
) -> None:
    status, out, _ = run("rtstop", "--dry-run", file(*FOUR_KINDS))
    lines = [line.split()[2] for line in out.splitlines()]
    assert (status, lines) == (0, [f"/localhost/{n}.rtc" for n in "DBCA"])
    own = (entry("C", 1), entry("A", 2, after="C"))
    status, _, err = run("rtstop", file(*FOUR_KINDS, deactivation=own))
    assert status == 0
    assert err.splitlines()[-2:] == [
        f"Executing {{3}} [Order 1] Deactivate C.rtc {EC}",
        f"Executing {{4}} [Order 2/Sync to C.rtc] Deactivate A.rtc {EC}",
    ]
    assert order(world) == "DBCA"


def test_a_graph_needs_no_manager(
    run: Run, file: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def connect(**_: object) -> None:
        raise Unreachable("manager 'manager' is not running")

    monkeypatch.setattr("rtkit.tree.connect.connect", connect)
    assert rtstart.main(["--plan", file(*FOUR_KINDS)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("digraph start {\n")
    assert '  a1 -> a3 [label="Order 3/Sync, at most 2000ms"];\n' in out
    assert out.endswith("}\n")
    assert rtstop.main(["--plan", file(*FOUR_KINDS)]) == 0
    assert capsys.readouterr().out.startswith("digraph stop {\n")


@pytest.mark.parametrize(
    ("entries", "why"),
    [
        (
            [entry("A", 1, after="B"), entry("B", 1, after="A")],
            "conditions in a circle: A waits for B waits for A",
        ),
        (
            [entry("A", 1).replace('rts:id="0"', 'rts:id="Ec7"')],
            "unknown target: execution context Ec7 of component A (it has 0)",
        ),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_done(
    run: Run, file: Any, world: FakeManager, entries: list[str], why: str
) -> None:
    path = file(*entries)
    for option in ("--dry-run", "--plan", "-v"):
        status, out, err = run("rtstart", option, path)
        assert (status, out) == (1, "")
        assert err.splitlines()[-1] == f"rtstart: {path}: Activation: {why}"
    assert run("rtstart", "--exit-detail", path)[0] == 3
    path = file(deactivation=tuple(entries))
    for command in ("rtstart", "rtstop"):
        assert run(command, path) == (1, "", f"{command}: {path}: Deactivation: {why}\n")
    assert not world.performed


def test_an_unknown_component_is_found_with_its_line(run: Run, file: Any) -> None:
    status, _, err = run("rtstart", file(entry("A", 1, after="Z")))
    assert status == 1
    assert "PrecedingComponents names component Z" in err


def test_what_cannot_be_started_as_written_can_be_stopped(
    run: Run, file: Any, world: FakeManager
) -> None:
    path = file(entry("A", 1, after="A"))
    status, _, err = run("rtstop", path)
    assert status == 0
    assert err.splitlines()[0] == (
        f"rtstop: {path}: Activation: conditions in a circle: A waits for A;"
        " stopped in reverse of the order of the components"
    )
    assert order(world) == "DCBA"


def test_who_depends_on_something_optional_is_warned(run: Run, file: Any) -> None:
    path = file(entry("B", 1, after="A"), optional="A")
    warning = (
        "rtstart: warning: action {4} depends on the optional action {1}, which may never be done:"
        " Sync to A.rtc"
    )
    for option in ("--dry-run", "--plan", "--no-wait"):
        assert run("rtstart", option, path)[2].splitlines()[0] == warning
    assert "warning" not in run("rtstop", path)[2]


def test_a_preceding_condition_that_is_not_met_in_time(
    run: Run, file: Any, world: FakeManager
) -> None:
    def fault(action: act.Action) -> Result | None:
        if getattr(action, "instance", "") == "A":
            world.kill("sA")
            return NO
        return None

    world.fault = fault
    path = file(entry("B", 1, after="A", limit=10), entry("D", 2, wait=600_000), optional="A")
    status, out, err = run("rtstart", path)
    assert (status, out) == (1, "")
    assert err.splitlines()[2:] == [
        "rtstart: Action failed: A.rtc: no luck",
        f"Executing {{2}} Activate C.rtc {EC} (Required)",
        "rtstart: Error executing plan: Preceding condition timed out: action {3} waited 10ms for:"
        " Sync to A.rtc (it is zombie (signal 9)); not run: {3}, {4}; active now: C.rtc",
    ]
    assert order(world) == "AC"


def test_a_time_out_bounds_the_whole(run: Run, file: Any, world: FakeManager) -> None:
    path = file(entry("B", 1, wait=600_000), entry("C", 2, after="B"))
    status, _, err = run("rtstart", "--timeout", "0.5", path)
    assert status == 1
    assert err.splitlines()[-1] == (
        "rtstart: Error executing plan: not finished within 0.5 s;"
        " action {4} waits for: Sync to B.rtc (it is Inactive);"
        " not run: {3}, {4}; active now: A.rtc, D.rtc"
    )
    assert order(world) == "AD"


def test_a_required_failure_cancels_the_rest(run: Run, file: Any, world: FakeManager) -> None:
    world.fault = lambda action: NO if getattr(action, "instance", "") == "B" else None
    status, _, err = run("rtstart", file(*FOUR_KINDS))
    assert status == 1
    last = err.splitlines()[-1]
    assert last.startswith("rtstart: Required action failed: B.rtc: no luck; ")
    assert last.endswith("active now: A.rtc, C.rtc, D.rtc")


def test_interrupted_while_it_waits(
    run: Run, file: Any, world: FakeManager, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)

    wait = Wakeup.wait

    def interrupted(wakeup: Wakeup, others: list[int], timeout_s: float | None) -> bool:
        if others:
            raise KeyboardInterrupt
        return wait(wakeup, others, timeout_s)

    monkeypatch.setattr("rtkit.link.wakeup.Wakeup.wait", interrupted)
    path = file(entry("B", 1, wait=600_000), entry("C", 2, after="B"))
    status, _, err = run("rtstart", path)
    assert status == 130
    assert err.splitlines()[-1] == (
        "rtstart: interrupted; not run: {3}, {4}; active now: A.rtc, D.rtc"
    )


def test_contexts_need_not_be_called_0(run: Run, file: Any, world: FakeManager) -> None:
    for instance in "ABCD":
        world.perform(act.Delete(instance))
    path = file(entry("A", 1).replace('rts:id="0"', 'rts:id="Ec1"'))
    text = Path(path).read_text().replace('Contexts rts:id="0"', 'Contexts rts:id="Ec1"')
    Path(path).write_text(text)
    assert run("rtresurrect", "--stand-in", path) == (0, "", "")
    assert run("rtact", "/localhost/A.rtc") == (0, "", "")
    assert run("rtact", "-e", "0", "/localhost/B.rtc") == (0, "", "")
    told = "rtact: Bad execution context index: 1 (B.rtc has 1)\n"
    assert run("rtact", "-e", "1", "/localhost/B.rtc")[2] == told
    assert [world.state_of(n) for n in "ABCD"] == ["Active", "Active", "Inactive", "Inactive"]
    status, _, err = run("rtstart", path)
    assert (status, err.splitlines()[0]) == (
        0,
        "Executing {1} Activate B.rtc in execution context Ec1 (Required)",
    )
    assert run("rtcheck", path) == (0, "", "")
    assert run("rtdeact", "/localhost/A.rtc") == (0, "", "")
    assert world.state_of("A") == "Inactive"


@pytest.mark.parametrize("fault", [NO, None])
def test_a_stop_does_not_hang_on_what_cannot_be_stopped(
    run: Run, file: Any, world: FakeManager, fault: Result | None
) -> None:
    path = file(deactivation=(entry("B", 1, after="A"), entry("C", 2, after="B", timing="ASYNC")))
    run("rtstart", path)
    world.kill("sA")
    world.fault = lambda action: fault if getattr(action, "instance", "") == "B" else None
    world.performed.clear()
    status, _, err = run("rtstop", path)
    assert status == 0
    assert "rtstop: Action failed: Component missing: A.rtc" in err
    assert order(world) == "DBC"
