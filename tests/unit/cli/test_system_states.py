"""rtstate as users type it, on the fake world."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

import jsonrecords
import pytest

from rtkit.cli import rtstate
from rtkit.cli.system import following as module
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.world import World
from rtkit.rtc.enums import PortType, ReturnCode
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile
from rtkit.tree.client import Tree
from rtkit.tree.fake import fake_tree

PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts"
  xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
  rts:id="RTSystem:Me:Robot:1.0" rts:version="0.2"
  rts:creationDate="2025-01-01T00:00:00" rts:updateDate="2025-01-01T00:00:00">
{components}
{properties}
</rts:RtsProfile>
"""
COMPONENT = """
<rts:Components rts:id="RTC:Me:test:{0}:1.0" rts:pathUri="localhost/{0}0.rtc"
  rts:instanceName="{0}0" rts:isRequired="true" rts:activeConfigurationSet="default">
 <rts:ConfigurationSets rts:id="default">
  <rts:ConfigurationData rts:name="gain" rts:data="1"/>
 </rts:ConfigurationSets>
 <rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="10.0"/>
 <rtsExt:Properties rtsExt:name="rtkit.create" rtsExt:value="{0}?manager_name={0}"/>
</rts:Components>
"""
PROPERTY = '<rtsExt:Properties rtsExt:name="rtkit.{}" rtsExt:value="{}"/>'
STATES = {
    "states": "standby, explore, degraded",
    "transitions": "standby -start-> explore; explore -motor_lost-> degraded; * -stop-> standby",
    "state.standby": "*=Inactive",
    "state.explore": "Eye0.gain=5",
    "state.degraded": "Motor0=Absent",
    "event.motor_lost": "lost Motor0",
}
KINDS = ("Eye", "Motor")
Following = Callable[[str, Callable[[Tree], object]], tuple[int, str, str]]


class Console:
    """Types rtstate at a world, with a profile in a file."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.world = World(
            ComponentPattern(
                TypeProfile(kind, "Me", "test", "1.0"),
                (PortProfile("out", PortType.OUT),),
                {"default": {"gain": "1"}},
            )
            for kind in KINDS
        )
        self.file = folder / "robot.xml"
        self._capsys = capsys
        self.write()

    def write(self, **changed: str) -> None:
        told = {**STATES, **{key.replace("__", "."): text for key, text in changed.items()}}
        properties = "".join(
            PROPERTY.format(key, text.replace("<", "&lt;").replace(">", "&gt;").replace('"', "'"))
            for key, text in told.items()
            if text
        )
        components = "".join(map(COMPONENT.format, KINDS))
        self.file.write_text(PROFILE.format(components=components, properties=properties))

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
    console.write(**{key.replace(".", "__"): "" for key in STATES})
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


@pytest.fixture
def following(console: Console, monkeypatch: pytest.MonkeyPatch) -> Following:
    """Follow events; when the first state is told, something else is done."""

    def run(line: str, then: Callable[[Tree], object]) -> tuple[int, str, str]:
        tree, todo = fake_tree(console.world), [then]

        def told(self: module.Following, before: str, state: str, event: str) -> None:
            tell(self, before, state, event)
            if todo:
                todo.pop()(tree)

        monkeypatch.setattr(module.Following, "_tell", told)
        return console.run(line, tree)

    tell = module.Following._tell
    return run


def test_events_are_followed(console: Console, following: Following) -> None:
    assert console.run("-g explore")[0] == 0
    status, out, err = following("--follow --json -n 1", lambda _: console.world.kill("Motor"))
    assert (status, err) == (0, "")
    records = list(jsonrecords.checked(out))
    assert {jsonrecords.kind_of(record) for record in records} == {"transition"}
    assert [(r["from"], r["event"], r["to"]) for r in records] == [
        ("", "is so", "explore"),
        ("explore", "motor_lost", "degraded"),
    ]
    # It begins in the first state, and goes where others lead it.
    console.world.perform(act.Delete("Eye0"))
    goto = ["-g", "explore", str(console.file)]
    out = following("--follow -n 2", lambda tree: rtstate.main(goto, tree=tree))[1]
    assert [line.partition("] ")[2] for line in out.splitlines()] == [
        "standby (at first)",
        "standby -by others-> explore",
    ]


def test_a_transition_that_fails_leads_on_or_ends_it(
    console: Console, following: Following
) -> None:
    assert console.run("-g explore")[0] == 0
    console.write(
        transitions="standby -start-> explore; explore -motor_lost-> degraded;"
        " degraded -failed-> standby; * -stop-> standby",
        state__degraded="Motor0=Absent; Eye0.gain=9",
        state__standby="*=Inactive; Motor0=Absent",
    )

    def fault(action: act.Action) -> Result | None:
        bad = isinstance(action, act.SetParameters) and action.values == {"gain": "9"}
        return Result(ReturnCode.ERROR, "refused", "no luck") if bad else None

    console.world.fault = fault
    status, out, err = following("-f -n 1", lambda _: console.world.kill("Motor"))
    assert status == 0
    assert "explore -motor_lost-> degraded: " in err
    assert "no luck" in err
    assert out.splitlines()[-1].endswith("degraded -failed-> standby")
    console.world.fault = lambda _: None
    console.write(state__degraded="Motor0=Absent; Eye0.gain=9")
    assert console.run("-g explore")[0] == 0
    console.world.fault = fault
    status, _, err = following("-f -n 1", lambda _: console.world.kill("Motor"))
    assert status == 1
    assert err.splitlines()[-1].startswith("rtstate: explore -motor_lost-> degraded: ")


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
