"""rtstate as users type it, on the fake world."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
import rts_text
import statekit
from fake_tree import fake_tree
from statekit import KINDS, SYSTEM, TOLD

from rtkit.cli.system import rtapply, rtplan, rtresurrect, rtstart, rtstate, rtteardown
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.facts import Followed
from rtkit.deployment.states.states_text import spec_from_text
from rtkit.fast_dataclass import replace
from rtkit.rtc.enums import ReturnCode
from rtkit.tree.client import Tree


class Console:
    """Types rtstate at a world, with a profile in a file."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.world = statekit.make_world()
        self.file = folder / "robot.xml"
        self._capsys = capsys
        self.write()

    def write(self, **changed: str) -> None:
        told = {**TOLD, **{key.replace("__", "."): text for key, text in changed.items()}}
        properties = rts_text.properties({key: text for key, text in told.items() if text})
        components = [
            rts_text.component(
                f"{kind}0", {"create": f"{kind}?manager_name={kind}"}, gain="1", rate=10
            )
            for kind in KINDS
        ]
        self.file.write_text(rts_text.system("Robot", *components, properties))

    def run(self, line: str = "", tree: Tree | None = None) -> tuple[int, str, str]:
        arguments = [*shlex.split(line), str(self.file)]
        status = rtstate.main(arguments, tree=tree or fake_tree(self.world))
        told = self._capsys.readouterr()
        return status, told.out, told.err


@pytest.fixture
def console(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Console:
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path / "state"))
    return Console(tmp_path, capsys)


def test_states_are_shown_with_the_way_to_each(console: Console) -> None:
    status, out, err = console.run()
    assert (status, err) == (1, "")
    assert out == (
        "  standby   6 steps, cost 16\n"
        "  explore   8 steps, cost 18\n"
        "  degraded  4 steps, cost 9\n"
        "between states\n"
    )
    assert console.world.performed == []


def test_a_system_is_led_to_a_state_and_by_its_events(console: Console) -> None:
    status, out, err = console.run("--goto explore")
    assert (status, out) == (0, "")
    assert "set Eye0.gain=5" in err
    status, out, _ = console.run()
    assert (status, out) == (
        0,
        "  standby   3 steps, cost 3\n"
        "* explore   is so\n"
        "  degraded  5 steps, cost 6\n"
        "  -motor_lost-> degraded  lost Motor0\n"
        "  -stop->       standby   on command\n",
    )
    (record,) = jsonrecords.checked(console.run("--json")[1])
    assert jsonrecords.kind_of(record) == "system-state"
    assert record["state"] == "explore"
    assert record["states"][2] == {"name": "degraded", "steps": 5, "cost": 6, "impossible": ""}
    assert record["events"][1] == {"event": "stop", "to": "standby", "when": ""}
    assert console.run("--event stop --dry-run")[1].startswith("plan: 3 steps, cost 3 (optimal)")
    assert console.run("--event stop")[0] == 0
    assert console.run("--json")[1].count('"state": "standby"') == 1
    assert console.run("-g standby") == (0, "", "")


def test_what_is_no_state_or_event_is_told(console: Console) -> None:
    for line, why in (
        ("-g explor", "no state explor (did you mean explore?); there are standby, explore"),
        ("-e start", "the system is in none of its states"),
    ):
        status, out, err = console.run(line)
        assert (status, out) == (1, "")
        assert why in err
    assert console.run("-g standby")[0] == 0
    assert "event tired leads nowhere from standby; events: start" in console.run("-e tired")[2]
    for bad in ("-g a -e b", "-f -g a", "-n 1", "--json -g a", "-f --dry-run"):
        assert console.run(bad)[0] == 2
    console.write(state__degraded="Motr0=Absent")
    assert "Motr0 (did you mean Motor0?)" in console.run()[2]
    console.write(**{key.replace(".", "__"): "" for key in TOLD})
    assert "it tells no states (rtkit.states of the system)" in console.run()[2]


def test_a_value_that_led_to_a_state_is_not_set_back_by_it(console: Console) -> None:
    console.write(
        event__motor_lost="Motor0.configuration.default.gain > 5",
        state__degraded="Eye0=Inactive",
    )
    assert console.run("-g explore")[0] == 0
    set_gain = act.SetParameters("Motor0", "default", {"gain": "9"})
    assert console.world.perform(set_gain).ok
    assert '"state": "explore"' in console.run("--json")[1]
    assert console.run("-e motor_lost")[0] == 0
    assert console.world.components["Motor0"].sets["default"]["gain"] == "9"
    assert '"state": "degraded"' in console.run("--json")[1]
    # What a state itself wishes is reached, and what is made anew is as the profile says.
    console.world.perform(act.Delete("Motor0"))
    assert console.run("-g explore")[0] == 0
    assert console.world.components["Motor0"].sets["default"]["gain"] == "1"


def test_a_state_that_cannot_be_says_why(console: Console) -> None:
    console.world.lacking = {"Motor": "no module Motor.py"}
    (record,) = jsonrecords.checked(console.run("--json")[1])
    told = {state["name"]: state for state in record["states"]}
    assert told["degraded"]["steps"] == 4
    assert told["explore"]["steps"] is None
    assert "no module Motor.py" in told["explore"]["impossible"]
    assert "no module Motor.py" in console.run("-g explore")[2]
    assert console.run("-g degraded")[0] == 0


def test_a_state_chart_may_tell_states_and_transitions(console: Console) -> None:
    chart = (
        '<scxml xmlns="http://www.w3.org/2005/07/scxml" initial="rest">'
        '<state id="rest"><transition event="go" target="work"/></state>'
        '<state id="work"><transition event="rest" target="rest"/></state></scxml>'
    )
    (console.file.parent / "robot.scxml").write_text(chart)
    gone = {"states": "", "transitions": "", "state__standby": "", "state__explore": ""}
    gone |= {"state__degraded": "", "event__motor_lost": "", "state__rest": "*=Inactive"}
    console.write(**gone, **{"state-chart": "robot.scxml"})
    assert console.run("-g rest")[0] == 0
    assert "* rest  is so\n" in console.run()[1]
    assert console.run("-e go")[0] == 0
    console.write(**gone, **{"state-chart": "nowhere.scxml"})
    assert "the state chart: " in console.run()[2]


class Manager:
    """Plays a manager that follows a system as soon as it is asked to."""

    def __init__(self, console: Console, monkeypatch: pytest.MonkeyPatch) -> None:
        self.world = console.world
        self.tree = fake_tree(self.world)
        self.asked: list[dict[str, Any]] = []
        self.then: list[Followed | None] = []
        ask = Tree.set
        told = f"{SYSTEM} is followed"

        def asked(tree: Tree, name: str, value: str, *, timeout_s: float | None = None) -> str:
            if name != "rtkit.follow":
                return ask(tree, name, value, timeout_s=timeout_s)
            self.asked.append(json.loads(value))
            for each in self.then:
                self.world.systems = () if each is None else (each,)
                self.world.changed()
            return told

        monkeypatch.setattr(Tree, "set", asked)


@pytest.fixture
def following(console: Console, monkeypatch: pytest.MonkeyPatch) -> Manager:
    return Manager(console, monkeypatch)


def test_the_manager_is_asked_to_follow_and_watched(console: Console, following: Manager) -> None:
    following.then = [
        Followed(SYSTEM),
        Followed(SYSTEM, "explore", "", "is so", 1, 5.0),
        Followed(SYSTEM, "degraded", "explore", "motor_lost", 1, 5.5, is_led=True),
        Followed(SYSTEM, "degraded", "explore", "motor_lost", 2, 6.0),
    ]
    status, out, err = console.run("--follow --json -n 1", following.tree)
    assert (status, err) == (0, "")
    records = list(jsonrecords.checked(out))
    assert {jsonrecords.kind_of(record) for record in records} == {"transition"}
    assert [(r["from"], r["event"], r["to"]) for r in records] == [
        ("", "is so", "explore"),
        ("explore", "motor_lost", "degraded"),
    ]
    (asked,) = following.asked
    states, rolls_back = spec_from_text(json.dumps(asked["start"]))
    assert (states.name, list(states.machine.table)) == (SYSTEM, ["standby", "explore", "degraded"])
    assert not rolls_back
    assert [c.instance for c in states.base.system.components] == ["Eye0", "Motor0"]
    assert console.world.performed == []


def test_who_watches_what_is_followed_already_is_told_the_last_transition(
    console: Console, following: Manager
) -> None:
    following.world.systems = (Followed(SYSTEM, "explore", "standby", "start", 4, 5.0),)
    following.then = [Followed(SYSTEM, "standby", "explore", "by others", 5, 6.0)]
    out = console.run("--follow -n 1", following.tree)[1]
    assert [line.partition("] ")[2] for line in out.splitlines()] == [
        "standby -start-> explore",
        "explore -by others-> standby",
    ]


def test_a_transition_that_fails_is_told_or_ends_the_watching(
    console: Console, following: Manager
) -> None:
    why = "explore -motor_lost-> degraded: no luck"
    led = Followed(SYSTEM, "degraded", "explore", "motor_lost", 1, 5.0, is_led=True, why=why)
    following.world.systems = (Followed(SYSTEM, "explore", "", "is so", 1, 5.0),)
    following.then = [
        led,
        replace(led, state="standby", before="degraded", event="failed", count=2),
    ]
    status, out, err = console.run("-f -n 1", following.tree)
    assert (status, err) == (0, f"rtstate: {why}\n")
    assert out.splitlines()[-1].endswith("degraded -failed-> standby")
    following.world.systems = (Followed(SYSTEM, "explore", "", "is so", 1, 5.0),)
    following.then = [replace(led, is_over=True, is_led=False, kind="impossible")]
    status, _, err = console.run("-f --exit-detail", following.tree)
    assert (status, err) == (7, f"rtstate: {why}\n")
    following.world.systems = (Followed(SYSTEM, "explore", "", "is so", 1, 5.0),)
    following.then = [None]
    status, _, err = console.run("-f", following.tree)
    assert (status, err) == (1, f"rtstate: {SYSTEM} is followed no more\n")


def test_who_follows_is_shown_with_what_failed(console: Console) -> None:
    assert console.run("-g explore")[0] == 0
    why = "explore -motor_lost-> degraded: no luck"
    told = Followed(SYSTEM, "degraded", "explore", "motor_lost", 2, 5.0, why=why)
    console.world.systems = (Followed("Other"), told)
    assert console.run()[1].endswith(
        f"followed by its manager: explore -motor_lost-> degraded\n  failed: {why}\n"
    )
    (record,) = jsonrecords.checked(console.run("--json")[1])
    assert record["followed"] == {
        "state": "degraded",
        "from": "explore",
        "event": "motor_lost",
        "transitions": 2,
        "time": "1970-01-01T00:00:05.000000000Z",
        "is_led": False,
        "waits_for": "",
        "error": why,
        "is_over": False,
    }
    console.world.systems = (replace(told, is_over=True, waits="rtapply a.xml"),)
    assert "\nnot followed any more: explore" in console.run()[1]
    assert "\n  waits for rtapply a.xml\n" in console.run()[1]


def test_following_is_ended_by_name(
    console: Console, following: Manager, capsys: pytest.CaptureFixture[str]
) -> None:
    console.world.systems = (Followed(SYSTEM), Followed("RTSystem:You:Robot2:1"))
    for name, status in ((SYSTEM, 0), ("Robot", 0), ("Robott", 1)):
        assert rtstate.main(["--unfollow", name], tree=following.tree) == status
    assert "does not follow Robott; it follows RTSystem:Me:Robot:1.0, " in capsys.readouterr().err
    assert following.asked == [{"stop": SYSTEM}] * 2
    console.world.systems = (Followed(SYSTEM), Followed("RTSystem:You:Robot:1"))
    assert rtstate.main(["--unfollow", "Robot"], tree=following.tree) == 1
    assert "several systems have that name" in capsys.readouterr().err
    assert console.run("--unfollow Robot")[0] == 2


def test_a_system_in_several_managers_is_followed_by_none(
    console: Console, following: Manager
) -> None:
    text = console.file.read_text().replace("localhost/Motor0.rtc", "localhost/m1.mgr/Motor0.rtc")
    console.file.write_text(text)
    status, _, err = console.run("--follow", following.tree)
    assert status == 1
    assert f"no manager can follow {SYSTEM}: its components are in several (manager, m1)" in err
    assert following.asked == []


def test_a_profile_that_wants_it_is_followed_once_it_is_up(
    console: Console, following: Manager, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(console.file)
    assert rtapply.main([file], tree=following.tree) == 0
    assert following.asked == []
    console.write(follow="true")
    assert rtapply.main(["--dry-run", file], tree=following.tree) == 0
    assert following.asked == []
    for command in (rtapply, rtresurrect, rtstart):
        assert command.main([file], tree=following.tree) == 0
        assert [*following.asked.pop()] == ["start"]
    saved = f"{file}.plan"
    assert rtplan.main(["--out", saved, file], tree=following.tree) == 0
    assert rtapply.main([saved], tree=following.tree) == 0
    states, _ = spec_from_text(json.dumps(following.asked.pop()["start"]))
    assert states.base.state == "Active"
    assert rtteardown.main([file], tree=following.tree) == 0
    assert following.asked == []
    console.world.systems = (Followed(SYSTEM),)
    assert rtteardown.main(["--dry-run", file], tree=following.tree) == 0
    assert following.asked == []
    assert rtteardown.main([file], tree=following.tree) == 0
    assert following.asked == [{"stop": SYSTEM}]
    console.write(follow="perhaps")
    assert rtapply.main([file], tree=following.tree) == 1
    assert "rtkit.follow: neither true nor false: perhaps" in capsys.readouterr().err
    console.write(follow="true", states="")
    capsys.readouterr()
    assert rtapply.main([file], tree=following.tree) == 1
    assert "rtkit.states names no state" in capsys.readouterr().err


@pytest.mark.parametrize("line", ["-e hurt", "-g degraded"])
def test_what_fails_on_command_leads_on_as_it_does_for_who_follows(console, line) -> None:
    assert console.run("-g explore")[0] == 0
    console.write(
        transitions="standby -start-> explore; explore -motor_lost-> degraded;"
        " degraded -failed-> standby; explore -hurt-> degraded",
        state__degraded="Motor0=Absent; Eye0.gain=9",
        state__standby="*=Inactive; Motor0=Absent",
    )

    def fault(action: act.Action) -> Result | None:
        bad = isinstance(action, act.SetParameters) and action.values == {"gain": "9"}
        return Result(ReturnCode.ERROR, "refused", "no luck") if bad else None

    console.world.fault = fault
    status, out, err = console.run(line)
    assert (status, out) == (1, "")
    assert f"rtstate: explore -{'hurt' if line[1] == 'e' else 'goto'}-> degraded: " in err
    assert err.endswith("rtstate: degraded was not reached; the system was led to standby\n")
    assert console.run("")[1].splitlines()[0].startswith("* standby")
