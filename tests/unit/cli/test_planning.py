"""rtplan and rtapply as users type them, on the fake world."""

from __future__ import annotations

import json
import os
import shlex
from dataclasses import replace
from pathlib import Path

import jsonrecords
import pytest
import rts_text
from fake_tree import fake_tree
from worlds import source_and_sink

from rtkit.cli.system import rtapply, rtplan, rtresurrect, rtstart, rtstop, rtteardown
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.planning.measured_times import (
    ENOUGH,
    Mean,
    Times,
    times_from_text,
    times_to_text,
)
from rtkit.errors import Unreachable
from rtkit.manager.core.state import Process
from rtkit.rtc.enums import LifeCycleState, ReturnCode
from rtkit.rtc.profiles import ConnectorProfile, PortRef

SETS = {"default": {"gain": "1", "mode": "a"}}


class Console:
    """Types commands at a world, with a profile in a file."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.world = source_and_sink(sets=SETS)
        self._file = folder / "pair.xml"
        self._capsys = capsys
        self.write()

    def write(
        self,
        *,
        slave: str = "s",
        gain: str = "2",
        hot: str = "",
        create: bool = True,
        cost: str = "",
    ):
        told = {key: text for key, text in (("hot", hot), ("cost", cost)) if text}
        creates = {"Source": f"Source?manager_name={slave}", "Sink": "Sink"}
        gains, ports = {"Source": gain, "Sink": "1"}, {"Source": "out", "Sink": "in"}
        parts = [
            rts_text.component(
                f"{kind}0",
                {**({"create": how} if create else {}), **told},
                port=ports[kind],
                gain=gains[kind],
            )
            for kind, how in creates.items()
        ]
        wire = rts_text.wire("wire", "Source0.out", "Sink0.in")
        self._file.write_text(rts_text.system("Pair", *parts, wire))

    def change(self, old: str, new: str) -> None:
        """Change the profile."""
        text = self._file.read_text()
        assert old in text
        self._file.write_text(text.replace(old, new))

    def run(self, line: str, file: Path | None = None) -> tuple[int, str, str]:
        name, *options = shlex.split(line)
        commands = (rtplan, rtapply, rtresurrect, rtstart, rtstop, rtteardown)
        main = {each.main.name: each.main for each in commands}[name]
        status = main([*options, str(file or self._file)], tree=fake_tree(self.world))
        told = self._capsys.readouterr()
        return status, told.out, told.err

    def up(self) -> None:
        status, out, _ = self.run("rtapply")
        assert (status, out) == (0, "")
        self.world.performed.clear()

    def steps(self) -> list[str]:
        status, out, _ = self.run("rtplan --json")
        assert status == 0
        return [step["text"] for step in json.loads(out)["steps"]]


@pytest.fixture
def console(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Console:
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path / "state"))
    return Console(tmp_path, capsys)


def test_a_plan_is_shown_with_costs_changes_and_what_is_done_at_once(console):
    assert console.run("rtplan") == (
        0,
        "plan: 9 steps, cost 16 (optimal)\n"
        "  1  create Source0 on manager in slave s    6  absent -> manager:slave/s\n"
        "  2  create Sink0 on manager                 3  absent -> manager:inproc\n"
        "  3  set Source0.gain=2                      1  ? -> 2\n"
        "  4  set rate of Source0=1000                1  ? -> 1000\n"
        "  5  set Sink0.gain=1                        1  ? -> 1\n"
        "  6  set rate of Sink0=1000                  1  ? -> 1000\n"
        "  7  connect Source0.out to Sink0.in (wire)  1\n"
        "  8  activate Source0                        1  Source0 inactive -> active\n"
        "  9  activate Sink0                          1  Sink0 inactive -> active\n"
        "at once: 1-2; 3-7; 8-9\n"
        "kept: 1 manager\n",
        "",
    )
    assert console.world.performed == []


def test_apply_does_it_and_then_there_is_nothing_to_do(console):
    status, out, err = console.run("rtapply")
    assert (status, out) == (0, "")
    # What a component has by itself is not set again.
    assert err.splitlines() == [
        "[1/3] create Source0 on manager in slave s",
        "[1/3] create Sink0 on manager",
        "[2/3] connect Source0.out to Sink0.in (wire)",
        "[2/3] set Source0.gain=2",
        "[3/3] activate Source0",
        "[3/3] activate Sink0",
    ]
    nothing = (
        "nothing to do: everything is as wanted\nkept: 1 manager, 2 components, 1 connection\n"
    )
    console.world.performed.clear()
    assert console.run("rtplan --detailed-exitcode") == (0, nothing, "")
    assert console.run("rtapply --dry-run") == (0, nothing, "")
    assert console.run("rtapply") == (0, "", "")
    assert console.world.performed == []


def test_status_2_says_that_something_is_to_be_changed(console):
    assert console.run("rtplan --detailed-exitcode")[0] == 2
    assert console.run("rtplan")[0] == 0


def test_a_changed_parameter_stops_that_component_and_no_other(console):
    console.up()
    console.write(gain="5")
    assert console.steps() == ["deactivate Source0", "set Source0.gain=5", "activate Source0"]
    assert console.run("rtapply")[0] == 0
    done = [type(action).__name__ for action in console.world.performed]
    assert done == ["ChangeState", "SetParameters", "ActivateSet", "ChangeState"]
    assert all(action.instance == "Source0" for action in console.world.performed)


def test_a_hot_parameter_is_set_without_a_stop(console):
    console.up()
    console.write(gain="5", hot="mode, gain")
    assert console.steps() == ["set Source0.gain=5"]
    assert console.run("rtapply") == (0, "", "[1/1] set Source0.gain=5\n")
    assert console.world.components["Source0"].sets["default"]["gain"] == "5"


def test_a_set_of_the_profile_that_the_component_has_not_is_added_and_made_active(console):
    console.up()
    default = rts_text.SET.format("2")
    console.change(default, default + default.replace("default", "race").replace("2", "7"))
    head = 'instanceName="Source0" rts:isRequired="true" rts:activeConfigurationSet='
    console.change(f'{head}"default"', f'{head}"race"')
    assert console.steps() == [
        "deactivate Source0",
        "set Source0.gain=7",
        "use set of Source0: race",
        "activate Source0",
    ]
    assert console.run("rtapply")[0] == 0
    assert console.world.components["Source0"].sets["race"] == {"gain": "7"}
    assert console.world.components["Source0"].active_set == "race"
    assert console.steps() == []


def test_an_added_set_moves_with_its_component(console):
    console.up()
    console.world.perform(act.SetParameters("Source0", "race", {"gain": "9"}, act.NEW))
    console.write(slave="other")
    assert console.run("rtapply")[0] == 0
    assert console.world.components["Source0"].sets["race"] == {"gain": "9"}


def test_one_that_moves_is_made_anew_with_its_connections_and_values(console):
    console.up()
    console.world.perform(act.SetParameters("Source0", "default", {"mode": "z"}))
    console.world.performed.clear()
    console.write(slave="other")
    assert console.steps() == [
        "deactivate Source0",
        "disconnect Source0.out to Sink0.in (wire)",
        "delete Source0",
        "create Source0 on manager in slave other",
        "set Source0.gain=2",
        "set Source0.mode=z",
        "set rate of Source0=1000",
        "connect Source0.out to Sink0.in (wire)",
        "activate Source0",
    ]
    assert console.run("rtapply")[0] == 0
    assert console.world.components["Source0"].process == "other"
    assert console.world.components["Source0"].sets["default"] == {"gain": "2", "mode": "z"}
    touched = [a for a in console.world.performed if getattr(a, "instance", "") == "Sink0"]
    assert touched == []


def test_a_component_in_error_is_reset(console):
    console.up()
    console.world.set_state("Sink0", LifeCycleState.ERROR)
    assert console.steps() == ["reset Sink0", "activate Sink0"]
    assert console.run("rtapply")[0] == 0


def test_state_says_how_far_it_goes(console):
    assert not any("activate" in step for step in json_steps(console, "-s inactive"))
    console.up()
    assert json_steps(console, "-s inactive") == ["deactivate Sink0", "deactivate Source0"]
    assert json_steps(console, "-s any") == []


def json_steps(console: Console, options: str) -> list[str]:
    return [s["text"] for s in json.loads(console.run(f"rtplan --json {options}")[1])["steps"]]


def test_costs_may_be_set(console):
    console.up()
    console.write(gain="5")
    assert "cost 1002 (optimal)" in console.run("rtplan --cost Source0=1000")[1]
    assert "cost 12 (optimal)" in console.run("rtplan --cost configure=10")[1]
    assert "cost 12 (optimal)" in console.run("rtplan --cost 'activate Source0=10'")[1]
    for bad in ("Source0", "Source0=0", "Source0=x", "Nobody=1", "=1"):
        status, out, err = console.run(f"rtplan --cost {bad}")
        assert (status, out) == (2, "")
        assert "--cost" in err


def test_costs_of_what_there_is_not_are_refused_with_the_nearest(console):
    console.up()
    console.write(gain="5")
    for bad, why in {
        "'delete Sourc0=4'": "nothing to delete is called Sourc0 (did you mean Source0?)",
        "'connect zz=4'": "nothing to connect is called zz",
        "'configure Source0.default.gian=4'": "(did you mean Source0.default.gain or",
        "delte=4": "(did you mean delete?)",
        "'start_manager manger=4'": "(did you mean manager?)",
    }.items():
        status, out, err = console.run(f"rtplan --cost {bad}")
        assert (status, out) == (2, "")
        assert why in err
    assert "cost 12 (opt" in console.run("rtplan --cost 'configure Source0.default.gain=10'")[1]


def test_a_component_may_say_what_interrupting_it_costs(console):
    console.up()
    console.write(gain="5", cost="1000")
    assert "cost 1002 (optimal)" in console.run("rtplan")[1]
    assert "costs: table: configure, activate; profile: deactivate\n" in console.run("rtplan")[1]
    assert "cost 9 (optimal)" in console.run("rtplan --cost Source0=7")[1]
    console.write(gain="5", cost="configure=20, activate=4")
    assert "cost 25 (optimal)" in console.run("rtplan")[1]
    for bad in ("x", "0", "fly=3", "activate="):
        console.write(cost=bad)
        status, _, err = console.run("rtplan")
        assert status == 1
        assert "pair.xml:8: Source0: rtkit.cost: no" in err


def measured(console: Console, times: dict[str, float], steps: int = ENOUGH) -> Path:
    path = Path(os.environ["RTKIT_STATE_DIR"], "step-times.json")
    path.parent.mkdir(mode=0o700, exist_ok=True)
    path.write_text(times_to_text(Times({n: Mean(steps, s) for n, s in times.items()})))
    return path


def test_costs_are_what_steps_took_here_once_enough_were_measured(console):
    console.up()
    console.write(gain="5")
    times = {"deactivate": 0.01, "configure": 0.03, "activate": 0.02, "activate Source": 0.04}
    measured(console, times, ENOUGH - 1)
    assert "cost 3 (optimal)" in console.run("rtplan")[1]
    path = measured(console, times)
    out = console.run("rtplan")[1]
    # In sum as dear as in the table, rounded to preferred numbers.
    assert "cost 4.17 (optimal)" in out
    assert "costs: measured: deactivate, configure, activate\n" in out
    (record,) = jsonrecords.checked(console.run("rtplan --json")[1])
    assert [(s["cost"], s["cost_from"]) for s in record["steps"]] == [
        (0.47, "measured"),
        (1.5, "measured"),
        (2.2, "measured"),
    ]
    assert "cost 3 (optimal)" in console.run("rtplan --costs table")[1]
    assert "cost 12.17 (optimal)" in console.run("rtplan --cost activate=10.2")[1]
    path.write_text('{"version": 1, "means": {"activate": [20')
    status, out, err = console.run("rtplan")
    assert status == 0
    assert "cost 3 (optimal)" in out
    assert err.startswith(f"rtplan: {path} is damaged and not used; steps cost what the table says")
    assert err.count("\n") == 1


def test_apply_notes_what_steps_took(console):
    perform = console.world.perform
    console.world.perform = lambda action: replace(perform(action), took_s=0.5)
    path = measured(console, {"connect": 1.0}, 1)
    assert console.run("rtapply")[0] == 0
    means = times_from_text(path.read_text()).means
    assert means["connect"] == Mean(2, 0.75)
    assert means["create_slave Source"] == means["activate Sink"] == Mean(1, 0.5)
    path.unlink()
    path.mkdir()
    console.world.perform(act.Disconnect("wire"))
    status, _, err = console.run("rtapply")
    assert status == 0
    assert "rtapply: what steps took is not kept: " in err


def test_json_tells_what_must_be_done_before(console):
    (record,) = jsonrecords.checked(console.run("rtplan --json")[1])
    assert record["schema"] == "rtkit.plan/1"
    assert (record["cost"], record["optimal"], record["gap"]) == (16, True, 0)
    assert record["kept"] == {"managers": 1, "components": 0, "connections": 0}
    assert [step["layer"] for step in record["steps"]] == [1, 1, 2, 2, 2, 2, 2, 3, 3]
    assert record["steps"][6]["after"] == [1, 2]
    assert record["steps"][2]["subject"] == "Source0.default.gain"


def told(out: str) -> tuple[list[str], list[tuple[int, str]]]:
    """Return the steps of the plan that comes first, and what became of which."""
    plan, *steps = jsonrecords.checked(out)
    assert plan["schema"] == "rtkit.plan/1"
    assert {each["schema"] for each in steps} == {"rtkit.step/1"}
    texts = [each["text"] for each in plan["steps"]]
    assert all(texts[each["number"] - 1] == each["text"] for each in steps)
    return texts, [(each["number"], each["state"]) for each in steps]


def test_apply_tells_each_step_as_json(console):
    perform = console.world.perform
    console.world.perform = lambda action: replace(perform(action), took_s=0.5)
    shown = jsonrecords.checked(console.run("rtapply --dry-run --json")[1])
    assert shown == jsonrecords.checked(console.run("rtplan --json")[1])
    status, out, err = console.run("rtapply --json")
    assert (status, err) == (0, "")
    texts, steps = told(out)
    assert texts == [each["text"] for each in shown[0]["steps"]]
    for number, text in enumerate(texts, 1):
        is_made = "=1" in text  # what is created has these values already
        states = ["held"] if is_made else ["begun", "done"]
        assert [state for n, state in steps if n == number] == states
    assert {each["took_s"] for each in jsonrecords.checked(out)[1:]} == {None, 0.5, 1.0}
    assert [each["steps"] for each in jsonrecords.checked(console.run("rtapply --json")[1])] == [[]]


def test_apply_tells_what_failed_and_the_way_back_as_json(console):
    no = Result(ReturnCode.ERROR, "refused", "no luck")
    perform = console.world.perform
    console.world.perform = lambda a: no if isinstance(a, act.Connect) else perform(a)
    status, out, err = console.run("rtapply --rollback --json")
    assert status == 1
    assert "everything is as it was before" in err
    _, *steps = jsonrecords.checked(out)
    (failed,) = [each for each in steps if each.get("state") == "failed"]
    assert (failed["kind"], failed["subject"], failed["why"]) == ("connect", "wire", "no luck")
    (back,) = [each for each in steps if each["schema"] == "rtkit.plan/1"]
    assert back["reason"] == "way back"
    done = [each["text"] for each in steps[steps.index(back) + 1 :] if each["state"] == "done"]
    assert sorted(done) == sorted(each["text"] for each in back["steps"])


@pytest.mark.parametrize("verb", ["rtresurrect", "rtstart", "rtstop", "rtteardown --exit"])
def test_other_plans_are_told_as_json_as_a_dry_run_shows_them(console, verb):
    assert console.run("rtapply")[0] == 0
    if verb == "rtresurrect":
        assert console.run("rtteardown --exit")[0] == 0
    lines = console.run(f"{verb} --dry-run")[1].splitlines()
    (plan,) = jsonrecords.checked(console.run(f"{verb} --dry-run --json")[1])
    shown = [f"{e['text']}{' (Required)' if e['required'] else ''}" for e in plan["steps"]]
    checks = [f"{e['text']}{' (Required)' if e['required'] else ''}" for e in plan["checks"]]
    assert sorted(checks + shown) == sorted(lines)
    assert plan["cost"] == sum(each["cost"] for each in plan["steps"]) > 0
    layers = [each["layer"] for each in plan["steps"]]
    assert layers == sorted(layers)
    status, out, err = console.run(f"{verb} --json")
    assert (status, err) == (0, "")
    texts, steps = told(out)
    assert texts == [each["text"] for each in plan["steps"]]
    held = {each["number"] for each in plan["steps"] if each["holds"]}
    # What is created has most values already.
    done = {n for n, state in steps if state == "done"}
    assert {each["number"] for each in plan["steps"] if each["kind"] != "configure"} - held <= done
    assert {n for n, state in steps if state == "held"} == set(range(1, len(texts) + 1)) - done
    assert not held & done


def test_what_fails_in_a_restore_is_told_with_its_reason_as_json(console):
    no = Result(ReturnCode.ERROR, "refused", "no luck")
    perform = console.world.perform
    console.world.perform = lambda a: no if isinstance(a, act.Connect) else perform(a)
    status, out, err = console.run("rtresurrect --json")
    assert status == 1
    assert "removed again: " in err
    (failed,) = [e for e in jsonrecords.checked(out) if e.get("state") == "failed"]
    assert (failed["kind"], failed["why"]) == ("connect", "no luck")
    assert console.run("rtstart --plan --json")[0] == 2


def test_parts_are_left_out_of_a_plan(console):
    out = console.run("rtplan --without Sink0 --without 'Source0.*'")[1]
    assert "create Source0" in out
    assert not any(word in out for word in ("Sink0", "connect", "gain"))
    assert console.run("rtplan --without wire")[1].count("connect ") == 0
    status, _, err = console.run("rtapply --prune --without Sink0")
    assert (status, err) == (
        2,
        "rtapply: --prune would end what --without leaves out: give one of them\n",
    )
    assert console.run("rtapply --place Sink0=localhost/manager.mgr/t.mgr")[0] == 0
    assert console.world.snapshot().component("Sink0").process == "t"


def test_a_saved_plan_keeps_what_was_left_out(console, tmp_path):
    saved = tmp_path / "saved.json"
    assert console.run(f"rtplan --without Sink0 --out {saved}")[0] == 0
    assert console.run("rtapply", saved)[0] == 0
    assert console.world.snapshot().component("Sink0") is None
    assert console.run("rtapply --without Sink0", saved)[0] == 2


def test_dot_is_a_graph(console):
    status, out, _ = console.run("rtplan --dot")
    assert status == 0
    lines = out.splitlines()
    assert lines[0] == "digraph plan {"
    # What follows from other edges has none of its own: s8 is also after s1.
    told = ["s1 -> s3", "s1 -> s4", "s2 -> s5", "s2 -> s6", "s1 -> s7", "s2 -> s7"]
    told += ["s3 -> s8", "s4 -> s8", "s7 -> s8", "s5 -> s9", "s6 -> s9", "s7 -> s9"]
    assert [each for each in lines if "->" in each] == [f"  {e};" for e in told]
    assert lines[-1] == "}"
    assert console.run("rtplan --dot --json")[0] == 2


def test_what_nobody_can_make_is_told_with_its_wish(console):
    console.write(create=False)
    status, out, err = console.run("rtplan --exit-detail")
    assert (status, out) == (7, "")
    assert err.startswith("rtplan: impossible: ")
    assert "nothing tells how to make it; --stand-in generates it" in err
    assert console.run("rtplan")[0] == 1
    assert console.run("rtapply")[0] == 1
    assert console.world.performed == []


def test_ports_of_types_that_do_not_fit_are_told(console):
    console.world = source_and_sink("IDL:RTC/TimedString:1.0", SETS)
    console.world.perform(act.Create("Source?instance_name=Source0&manager_name=s"))
    console.world.perform(act.Create("Sink?instance_name=Sink0"))
    status, _, err = console.run("rtplan")
    assert status == 1
    assert "impossible: connection Source0.out to Sink0.in (wire) cannot be" in err
    assert "data type" in err.lower()


def test_what_the_manager_does_not_find_is_told_before_anything_is_done(console):
    console.world.lacking = {"Source": "no module Source.py (looked in /x)", "Sink": "no Sink"}
    status, _, err = console.run("rtapply")
    assert status == 1
    assert err == (
        "rtapply: impossible: Source0 cannot be (/localhost/Source0.rtc: no module"
        " Source.py (looked in /x)); moreover: /localhost/Sink0.rtc: no Sink\n"
    )
    assert console.world.performed == []
    console.world.lacking = {}
    console.up()
    console.world.lacking = {"Source": "no module Source.py"}
    assert console.steps() == []
    console.write(slave="elsewhere")
    assert "Source0.rtc: no module Source.py)" in console.run("rtplan")[2]


def test_rtresurrect_tells_all_that_is_not_found_and_makes_nothing(console: Console) -> None:
    console.world.lacking = {"Source": "no module Source.py (looked in /x)", "Sink": "no Sink"}
    told = [f"{kind}0.rtc: {why}" for kind, why in console.world.lacking.items()]
    said = "".join(f"rtresurrect: Required action failed: /localhost/{each}\n" for each in told)
    assert console.run("rtresurrect") == (1, "", said)
    assert console.world.performed == []


@pytest.mark.parametrize("how", ["manager_address=localhost:2811", "members=Source0"])
def test_who_is_made_where_the_manager_chooses_stays_there(console: Console, how: str) -> None:
    console.change('"Sink"/>', f'"Sink?{how}"/>')
    assert "create Sink0 on manager" in console.steps()
    for kind, process in (("Source", "s"), ("Sink", "manager_2811")):
        create = f"{kind}?instance_name={kind}0&manager_name={process}"
        console.world.perform(act.Create(create, (f"localhost/{kind}0.rtc",)))
    assert not any("Sink0" in step for step in console.steps() if "create" in step)
    assert not any("delete" in step for step in console.steps())


def test_ports_of_types_that_do_not_fit_are_told_before_they_live(console):
    console.world = source_and_sink("IDL:RTC/TimedString:1.0", SETS)
    for kind in ("Source", "Sink"):
        console.world.perform(act.Create(f"{kind}?instance_name=Other{kind}"))
    status, _, err = console.run("rtplan")
    assert status == 1
    assert "impossible: connection Source0.out to Sink0.in (wire) cannot be" in err


def test_another_component_in_the_place_is_not_replaced(console):
    console.world.perform(act.Create("Sink?instance_name=Source0", ("localhost/Source0.rtc",)))
    status, _, err = console.run("rtapply")
    assert status == 1
    assert err == (
        "rtapply: ID of component at /localhost/Source0.rtc is RTC:Me:test:Sink:1.0,"
        " not RTC:Me:test:Source:1.0; --replace makes it again\n"
    )


def failing(kind: type, count: int = 1):
    left = count

    def fault(action: act.Action) -> Result | None:
        nonlocal left
        if not isinstance(action, kind) or not left:
            return None
        left -= 1
        return Result(ReturnCode.ERROR, "refused", "no luck")

    return fault


def test_after_a_failure_it_stops_tells_what_is_left_and_goes_on_when_run_again(console):
    console.world.fault = failing(act.Connect)
    status, _, err = console.run("rtapply")
    assert status == 1
    assert "left: 3 steps, cost 3 (optimal)" in err
    assert "no luck" in err.splitlines()[-1]
    assert err.endswith("; 3 steps left; run it again to go on\n")
    assert console.world.state_of("Source0") == "Inactive"
    console.up()
    assert console.world.state_of("Source0") == "Active"


def test_rollback_leads_back_and_shows_the_way(console):
    console.up()
    before = console.world.snapshot()
    console.write(slave="other", gain="7")
    console.world.fault = failing(act.Connect)
    status, _, err = console.run("rtapply --rollback")
    assert status == 1
    assert "way back: " in err
    assert err.endswith("; everything is as it was before\n")
    now = console.world.snapshot()
    assert now.connectors == before.connectors
    assert now.component("Source0").sets == before.component("Source0").sets
    assert now.component("Source0").process == "s"
    assert now.component("Source0").state == "Active"


def test_a_component_in_error_does_not_end_the_way_back(console):
    console.up()
    console.world.set_state("Source0", LifeCycleState.ERROR, "ValueError: no")
    console.write(gain="7")
    console.world.fault = failing(act.ActivateSet)
    status, _, err = console.run("rtapply --rollback")
    assert status == 1
    assert err.endswith("; everything is as it was before, but Source0 is inactive (was error)\n")
    assert console.world.components["Source0"].sets["default"]["gain"] == "2"


def test_what_fails_on_the_way_back_is_told_and_the_rest_goes_back(console):
    console.up()
    console.write(gain="7")
    console.change('rts:data="1"', 'rts:data="8"')
    ill: list[act.Action] = []

    def fault(action: act.Action) -> Result | None:
        if isinstance(action, act.ActivateSet) and not ill:
            ill.append(action)
        elif not ill or getattr(action, "instance", "") != "Source0":
            return None
        return Result(ReturnCode.ERROR, "refused", "no luck")

    console.world.fault = fault
    status, _, err = console.run("rtapply --rollback --parallel 1")
    assert status == 1
    assert "way back: Required action failed: set Source0.gain=2: no luck; going on with" in err
    assert err.endswith(
        "; everything is as it was before, but Source0 is inactive (was active),"
        " Source0.gain=7 (was 2)\n"
    )
    assert console.world.state_of("Sink0") == "Active"
    assert console.world.components["Sink0"].sets["default"]["gain"] == "1"


def test_what_turns_out_to_be_another_is_taken_back(console):
    source = console.world.types["Source"]
    console.world.types["Source"] = replace(source, type=replace(source.type, version="2.0"))
    status, _, err = console.run("rtapply --rollback")
    assert status == 1
    assert "is RTC:Me:test:Source:2.0, not RTC:Me:test:Source:1.0" in err
    assert err.endswith("; everything is as it was before\n")
    assert not console.world.components


def test_what_becomes_impossible_on_the_way_is_told_and_taken_back(console):
    def fault(action: act.Action) -> Result | None:
        if not isinstance(action, act.Create) or "Sink0" not in action.create:
            return None
        console.world.fault = lambda _: None
        console.world.perform(act.Create("Sink?instance_name=Other", ("localhost/Sink0.rtc",)))
        return Result()

    console.world.fault = fault
    status, _, err = console.run("rtapply --rollback --exit-detail --parallel 1")
    assert status == 7
    assert "Instance name of component at /localhost/Sink0.rtc is Other, not Sink0" in err
    assert err.endswith("; everything is as it was before\n")
    assert list(console.world.components) == ["Other"]


def test_what_dies_meanwhile_is_planned_anew(console):
    connected = []

    def fault(action: act.Action) -> Result | None:
        if isinstance(action, act.Connect) and not connected:
            connected.append(action)
            console.world.kill("s")
            return Result(ReturnCode.ERROR, "refused", "zombie")
        return None

    console.up()
    console.world.perform(act.Disconnect("wire"))
    console.world.fault = fault
    status, _, err = console.run("rtapply")
    assert status == 1
    assert "create Source0 on manager in slave s" in err
    console.up()


def test_no_more_than_so_many_at_once(console):
    assert console.run("rtapply --parallel 1")[0] == 0
    assert console.run("rtapply --parallel 0")[0] == 2


def test_without_a_manager_a_plan_begins_with_it(console, monkeypatch):
    tree = fake_tree(console.world)

    def silent() -> None:
        raise Unreachable("nobody answers")

    monkeypatch.setattr(tree, "snapshot", silent)
    status = rtplan.main([str(console._file)], tree=tree)
    told = console._capsys.readouterr()
    assert status == 0
    assert "start manager manager" in told.out
    assert "shown as if nothing lived" in told.err
    assert rtapply.main([str(console._file)], tree=tree) == 1


class Saving:
    """A plan in a file."""

    def __init__(self, console: Console, folder: Path) -> None:
        self.console = console
        self.file = folder / "pair.plan"

    def save(self, options: str = "") -> str:
        status, out, err = self.console.run(f"rtplan --out {self.file} {options}")
        assert (status, err) == (0, "")
        return out

    def apply(self, options: str = "") -> tuple[int, str, str]:
        return self.console.run(f"rtapply {options}", file=self.file)


@pytest.fixture
def saving(console: Console, tmp_path: Path) -> Saving:
    return Saving(console, tmp_path)


def test_a_saved_plan_is_carried_out_as_it_is(saving):
    console = saving.console
    shown = saving.save("--cost connect=3")
    # The profile may change meanwhile, and go: the plan holds what it was made from.
    console.write(gain="9")
    status, out, err = saving.apply("--dry-run")
    assert (status, err) == (0, "")
    assert out == shown
    assert saving.apply("--parallel 1")[:2] == (0, "")
    assert console.world.components["Source0"].sets["default"]["gain"] == "2"
    assert console.world.state_of("Source0") == "Active"
    performed = len(console.world.performed)
    status, _, err = saving.apply()
    assert status == 1
    assert "changed since: Source0 is there\n" in err
    assert err.splitlines()[-1].endswith("; what it leads to is so already")
    assert len(console.world.performed) == performed


def test_what_has_changed_since_a_plan_was_saved_is_told_and_nothing_is_done(saving):
    console = saving.console
    console.up()
    console.write(gain="7")
    saving.save()
    console.world.perform(act.Disconnect("wire"))
    console.world.set_state("Sink0", LifeCycleState.ERROR, "ValueError: no")
    console.world.perform(act.SetParameters("Source0", "default", {"mode": "z"}))
    before = console.world.snapshot()
    status, out, err = saving.apply()
    assert (status, out) == (1, "")
    *told, last = err.splitlines()
    assert told == [
        "rtapply: changed since: Sink0 is error (was active)",
        "rtapply: changed since: Source0.mode=z (was a)",
        "rtapply: changed since: connection Source0.out to Sink0.in (wire) is not there",
    ]
    assert f"{saving.file}: not carried out, as 3 things have changed since it was made, " in last
    assert last.endswith(f"; make it anew with: rtplan --out {saving.file} PROFILE")
    assert console.world.snapshot() == before


def test_a_saved_plan_that_does_not_fit_on_the_way_is_not_made_anew(saving):
    console = saving.console
    saving.save()

    def fault(_action: act.Action) -> None:
        if "Source0" in console.world.components:
            console.world.fault = lambda _: None
            console.world.kill("s")

    console.world.fault = fault
    status, _, err = saving.apply("--parallel 1 --rollback")
    assert status == 1
    assert "rtapply: not as planned: " in err
    assert "; the rest of the saved plan is left; everything is as it was before" in err
    assert console.world.state_of("Sink0") if "Sink0" in console.world.components else True


@pytest.mark.parametrize(
    ("options", "named"), [("-s Any", "--state"), ("--cost connect=2 -x", "--cost, --xml")]
)
def test_what_was_settled_with_a_saved_plan_cannot_be_asked_otherwise(saving, options, named):
    saving.save()
    status, _, err = saving.apply(options)
    assert status == 2
    assert f"{named}: settled already where the plan is a saved one" in err


def test_only_a_saved_plan_is_replaced_and_only_rtapply_takes_one(saving, tmp_path):
    console = saving.console
    saving.save()
    saving.save()
    precious = tmp_path / "precious"
    precious.write_text("data")
    status, _, err = console.run(f"rtplan --out {precious}")
    assert (status, precious.read_text()) == (1, "data")
    assert "is there already, and is no saved plan" in err
    assert console.run("rtplan --out -")[0] == 2
    for name in ("rtplan", "rtresurrect"):
        status, _, err = console.run(name, file=saving.file)
        assert status == 1
        assert err == f"{name}: {saving.file}: is a saved plan; only rtapply takes it\n"
    saving.file.write_text(saving.file.read_text()[:200])
    status, _, err = saving.apply("--exit-detail")
    assert status == 3
    assert f"rtapply: {saving.file}: the saved plan is cut or damaged: " in err
    saving.file.write_text('{"rtkit": 1}')
    assert saving.apply()[0] == 1
    assert not console.world.components


def test_drift_of_rate_and_policy_is_planned_and_reached_without_a_stop(console):
    console.up()
    console.world.perform(act.SetRate("Source0", "0", 50.0))
    console.world.perform(act.SetPolicy("Sink0", {"rtkit.restart": "always"}))
    assert "set rate of Source0=1000  1  50 -> 1000\n" in console.run("rtplan")[1]
    assert console.steps() == ["set rate of Source0=1000", "set policy of Sink0=none"]
    console.world.performed.clear()
    assert console.run("rtapply")[0] == 0
    assert [type(each) for each in console.world.performed] == [act.SetRate, act.SetPolicy]
    assert console.steps() == []


def test_what_cannot_be_changed_in_place_is_made_again_on_request_only(console):
    console.up()
    console.change("Source?manager_name=s", "Source?manager_name=s&amp;speed=9")
    why = (
        "/localhost/Source0.rtc cannot be changed in place: its create string is Source,"
        " not Source?speed=9; --replace makes it again\n"
    )
    for name in ("rtplan", "rtapply"):
        assert console.run(f"{name} --exit-detail") == (7, "", f"{name}: {why}")
    assert console.world.performed == []
    told = console.run("rtplan --replace")[1]
    assert "replace: its create string is Source, not Source?speed=9\n" in told
    assert console.run("rtapply --replace")[0] == 0
    assert "speed=9" in console.world.components["Source0"].create
    assert console.run("rtplan --replace")[1].startswith("nothing to do")


def test_a_component_of_another_type_is_replaced_on_request(console):
    console.world.perform(act.Create("Sink?instance_name=Source0", ("localhost/Source0.rtc",)))
    assert console.run("rtapply --replace")[0] == 0
    assert console.world.components["Source0"].type.type_name == "Source"
    assert console.run("rtplan")[1].startswith("nothing to do")


def test_what_the_profile_does_not_name_goes_on_request_only(console):
    console.up()
    console.world.perform(act.Create("Sink?instance_name=Extra0"))
    wire = console.world.connectors["wire"]
    ends = (wire.ports[0], PortRef("Extra0", "in"))
    console.world.perform(act.Connect(ConnectorProfile("more", "more", ends)))
    assert console.steps() == []
    (record,) = jsonrecords.checked(console.run("rtplan --prune --json")[1])
    assert [s["text"] for s in record["steps"]] == [
        "disconnect Source0.out to Extra0.in (more)",
        "delete Extra0",
    ]
    assert console.run("rtapply --prune")[0] == 0
    assert list(console.world.components) == ["Source0", "Sink0"]
    assert list(console.world.connectors) == ["wire"]


def test_a_name_that_was_taken_away_is_given_back(console):
    console.up()
    console.world.perform(act.Unregister("localhost/Sink0.rtc"))
    assert console.steps() == ["register Sink0 as /localhost/Sink0.rtc"]
    assert console.run("rtapply")[0] == 0
    assert console.world.components["Sink0"].names == ("localhost/Sink0.rtc",)


def test_a_parameter_that_there_is_not_is_told_and_decides_the_status(console):
    console.change('rts:name="gain" rts:data="2"', 'rts:name="gian" rts:data="2"')
    status, _, err = console.run("rtapply")
    assert status == 1
    where = "(on /localhost/Source0.rtc) (did you mean gain?)"
    told = f"No such configuration parameter: gian {where}\n"
    assert err.count(told) == 1
    assert console.world.state_of("Source0") == "Active"
    for _ in range(2):
        assert console.run("rtapply") == (1, "", f"rtapply: {told}")


def test_a_value_that_a_component_would_refuse_is_told_before_anything_is_done(console):
    console.up()
    console.world.update(
        "Source0",
        sets={**console.world.components["Source0"].sets, "__constraints__": {"gain": "0<=x<=3"}},
    )
    console.write(gain="9")
    console.world.performed.clear()
    for name in ("rtplan", "rtapply"):
        status, out, err = console.run(f"{name} --exit-detail")
        assert (status, out) == (7, "")
        assert "/localhost/Source0.rtc: default.gain cannot be '9': " in err
    assert console.world.performed == []


TYPE = """<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
  rtc:id="RTC:Me:test:Source:1.0" rtc:version="0.3">
 <rtc:BasicInfo rtc:name="Source" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
  rtc:componentKind="DataFlowComponent" rtc:category="test" rtc:vendor="Me" rtc:version="1.0"
  rtc:creationDate="2025-01-01T00:00:00" rtc:updateDate="2025-01-01T00:00:00"/>
 <rtc:ConfigurationSet>
  <rtc:Configuration rtc:name="gain" rtc:type="double" rtc:defaultValue="1"/>
 </rtc:ConfigurationSet>
 <rtc:DataPorts rtc:portType="DataOutPort" rtc:name="out" rtc:type="RTC::TimedLong"/>
 <rtc:Language rtc:kind="Python"/>
</rtc:RtcProfile>
"""


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('rts:data="2"', 'rts:data="much"', "default.gain cannot be 'much': it is no number"),
        ("Source0.out", "Source0.aus", "/localhost/Source0.rtc:aus (its type has none)"),
    ],
)
def test_what_a_type_cannot_have_is_told_before_anything_is_made(
    console, tmp_path, monkeypatch, old, new, why
):
    (tmp_path / "types").mkdir()
    (tmp_path / "types" / "Source.xml").write_text(TYPE)
    monkeypatch.setenv("RTKIT_PROFILE_PATH", str(tmp_path / "types"))
    assert console.run("rtplan")[0] == 0
    console.change(old, new)
    for name in ("rtplan", "rtapply"):
        status, out, err = console.run(f"{name} --exit-detail")
        assert (status, out) == (7, "")
        assert why in err
    assert console.world.performed == []


def test_a_parameter_that_a_type_does_not_have_is_told_before_it_is_made(
    console, tmp_path, monkeypatch
):
    (tmp_path / "types").mkdir()
    (tmp_path / "types" / "Source.xml").write_text(TYPE)
    monkeypatch.setenv("RTKIT_PROFILE_PATH", str(tmp_path / "types"))
    console.change('rts:name="gain" rts:data="2"', 'rts:name="gian" rts:data="2"')
    status, out, err = console.run("rtplan")
    assert status == 0
    assert "parameter: gian (on /localhost/Source0.rtc) (did you mean gain?)" in err
    assert "gian" not in out


def test_changed_code_is_told_and_replaced_with_all_that_shares_its_slave(console, tmp_path):
    file = tmp_path / "Source.py"
    file.write_text("edited since")
    console.change('"Sink"/>', '"Sink?manager_name=s"/>')
    console.up()
    console.world.update("Source0", code=f"00000000 {file}")
    told = (
        f"rtplan: /localhost/Source0.rtc: its code has changed since it was loaded ({file});"
        " --replace makes it again\n"
    )
    status, out, err = console.run("rtplan")
    assert (status, err) == (0, told)
    assert out.startswith("nothing to do")
    (record,) = jsonrecords.checked(console.run("rtplan --replace --json")[1])
    layer_of = {step["text"]: step["layer"] for step in record["steps"]}
    made = [layer for text, layer in layer_of.items() if text.startswith("create")]
    ended = [layer for text, layer in layer_of.items() if text.startswith("delete")]
    assert (len(made), len(ended)) == (2, 2)
    assert max(ended) < min(made)
    assert console.run("rtapply --replace")[0] == 0
    assert console.run("rtplan --replace")[1].startswith("nothing to do")


def test_a_plan_that_reserves_more_than_the_host_has_is_refused(console):
    console.change("Source?manager_name=s", "Source?manager_name=s&amp;rtkit.limit.memory=900T")
    why = "rtkit.limit.memory: 900 TiB in all (Source0 900 TiB), but this host has "
    for name in ("rtplan", "rtapply", "rtresurrect"):
        status, out, err = console.run(f"{name} --exit-detail")
        assert (status, out) == (7, "")
        assert err.startswith(f"{name}: {why}")
    assert console.world.performed == []


@pytest.mark.parametrize("where", ["manager", "shared"])
def test_changed_code_that_cannot_be_replaced_says_what_helps(console, tmp_path, where):
    file = tmp_path / "Sink.py"
    file.write_text("edited since")
    console.up()
    instance = "Sink0" if where == "manager" else "Source0"
    console.world.perform(act.Create("Sink?instance_name=Stranger&manager_name=s"))
    console.world.update(instance, code=f"00000000 {file}")
    helps = {
        "manager": "rtmgr restart loads it anew",
        "shared": "its slave s holds Stranger, too: not in the profile",
    }
    for options in ("", " --replace"):
        status, out, err = console.run(f"rtplan{options}")
        assert status == 0
        assert helps[where] in err
        assert out.startswith("nothing to do")


def test_one_run_by_hand_stays_where_it_is_and_is_not_replaced(console, tmp_path):
    file = tmp_path / "Sink.py"
    file.write_text("edited since")
    console.up()
    console.change('"Sink"/>', '"Sink?manager_name=s"/>')
    assert "deactivate Sink0" in console.run("rtplan")[1]
    visitor = Process(300, "Sink_300", 300, "up", is_guest=True)
    console.world.shell.state.processes[visitor.key] = visitor
    console.world.update("Sink0", process="Sink_300", code=f"00000000 {file}")
    status, out, err = console.run("rtplan --replace")
    assert (status, out.splitlines()[0]) == (0, "nothing to do: everything is as wanted")
    assert "it was started by hand: start it again" in err
