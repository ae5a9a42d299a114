"""The system commands as users type them, on the fake world: rows of §10 and §23."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import jsonrecords
import pytest
import rts_text
from fake_tree import fake_tree
from lxml import etree
from worlds import pattern, source_and_sink

from rtkit.cli.system import rtcheck, rtcryo, rtresurrect, rtstart, rtstop, rtteardown
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.errors import Refused, Unreachable
from rtkit.profile.read import read_rts
from rtkit.profile.words import property_value
from rtkit.rtc.enums import LifeCycleState, PortType, ReturnCode
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ConnectorProfile, PortRef, TypeProfile
from rtkit.tree.client import Tree

COMMANDS = {
    "rtcheck": rtcheck,
    "rtcryo": rtcryo,
    "rtresurrect": rtresurrect,
    "rtstart": rtstart,
    "rtstop": rtstop,
    "rtteardown": rtteardown,
}
SOURCE, SINK = "/localhost/Source0.rtc", "/localhost/Sink0.rtc"
SOURCE_OUT, SINK_IN = PortRef("Source0", "out"), PortRef("Sink0", "in")


def component(instance, create="", required=True, folder="localhost"):
    told = {"create": f"{create}?manager_name=s"} if create else {}
    port = "in" if instance == "Sink0" else "out"
    return rts_text.component(instance, told, port=port, gain="2", required=required, folder=folder)


def document(required=True, create=True, host="localhost", sink="Sink"):
    creates = {"Source0": "Source", "Sink0": sink}
    parts = [component(name, kind * create, required, host) for name, kind in creates.items()]
    wire = rts_text.wire("wire", "Source0.out", "Sink0.in")
    return rts_text.system("Pair", *parts, wire, abstract="A pair")


@pytest.fixture
def world():
    return source_and_sink(sets={"default": {"gain": "1"}})


@pytest.fixture
def file(tmp_path):
    def write(**how):
        path = tmp_path / "pair.xml"
        path.write_text(document(**how), encoding="utf-8")
        return str(path)

    return write


@pytest.fixture
def run(world, capsys):
    def typed(name, *arguments, tree=None):
        status = COMMANDS[name].main(list(arguments), tree=tree or fake_tree(world))
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return typed


@pytest.fixture
def absent(monkeypatch, tmp_path):
    """No manager runs, and none can be started."""

    def connect(*_, **__):
        raise Unreachable("manager 'manager' is not running")

    def start(*_, **__):
        raise Refused("no memory")

    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path / "runtime"))
    monkeypatch.setattr("rtkit.tree.connect.connect", connect)
    monkeypatch.setattr("rtkit.manager.launch.start", start)


def executing(verb, *turns):
    return "".join(f"Executing {{{n}}} {verb} {turn}\n" for n, turn in enumerate(turns, 1))


START = executing(
    "Activate",
    f"{SOURCE} in execution context 0 (Required)",
    f"{SINK} in execution context 0 (Required)",
)
STOP = executing("Deactivate", f"{SINK} in execution context 0", f"{SOURCE} in execution context 0")


def test_what_a_system_is_brought_up_by(run, file, world, monkeypatch):
    asked, send = [], Tree._send

    def noted(self, key, *more):
        asked.append(key.rpartition("/")[2])
        return send(self, key, *more)

    monkeypatch.setattr(Tree, "_send", noted)
    making, wiring = ["lease", "snapshot", "lacking", "batch"], ["snapshot", "batch", "batch"]
    assert run("rtresurrect", file()) == (0, "", "")
    assert asked == [*making, *wiring, "lease"]  # connectors first, then values
    asked.clear()
    assert run("rtresurrect", file()) == (0, "", "")
    assert asked == ["lease", "snapshot", "lease"]


def test_from_nothing_and_back(run, file, world, tmp_path):
    path, saved = file(), str(tmp_path / "saved.xml")
    assert run("rtresurrect", path) == (0, "", "")
    assert run("rtresurrect", path) == (0, "", "")
    assert run("rtstart", path) == (0, "", START)
    assert run("rtcheck", path) == (0, "", "")
    assert run("rtcryo", "-o", saved) == (0, "", "")
    assert run("rtstop", path) == (0, "", STOP)
    assert run("rtcheck", "-s", "inactive", saved) == (0, "", "")
    assert run("rtteardown", path) == (0, "", "")
    assert sorted(world.components) == ["Sink0", "Source0"]
    assert run("rtteardown", "--exit", path)[0] == 0
    assert not world.components
    assert run("rtresurrect", saved) == (0, "", "")
    assert run("rtcheck", "-s", "Inactive", path) == (0, "", "")


def test_stdin_is_read_when_no_file_is_named(run, monkeypatch, world):
    for name in ("", "-"):
        stream = io.TextIOWrapper(io.BytesIO(document().encode()))
        monkeypatch.setattr(sys, "stdin", stream)
        assert run("rtresurrect", *([name] if name else [])) == (0, "", "")
    assert len(world.components) == 2


@pytest.mark.parametrize("name", ["rtresurrect", "rtstart", "rtstop", "rtteardown", "rtcheck"])
def test_bad_command_lines(run, name, file, tmp_path):
    status, out, err = run(name, "a", "b")
    assert (status, out) == (1, "")
    assert err.startswith(f"Usage: {name}")
    assert run(name, "--json5", "a")[0] == 2
    assert run(name, "no-such-file") == (
        1,
        "",
        f"{name}: cannot read no-such-file: No such file or directory\n",
    )
    bad = tmp_path / "bad.xml"
    bad.write_text("<a/>")
    status, out, err = run(name, str(bad))
    assert (status, out) == (1, "")
    assert err.startswith(f"{name}: {bad}:1: root is a")
    assert run(name, "--exit-detail", str(bad))[0] == 3
    assert run(name, "--map", "x", file())[0] == 2


@pytest.mark.parametrize("name", ["rtresurrect", "rtstart", "rtstop", "rtteardown", "rtcheck"])
def test_dry_runs_change_nothing_and_need_no_manager(run, name, file, world, absent, capsys):
    path = file()
    status, out, err = run(name, "--dry-run", path)
    assert (status, err) == (0, "")
    assert not world.performed
    assert COMMANDS[name].main(["--dry-run", path]) == 0
    captured = capsys.readouterr()
    assert captured.out == out
    assert captured.err == f"{name}: manager 'manager' is not running; shown as if nothing lived\n"
    assert COMMANDS[name].main([path]) == 1


def test_dry_run_of_start_and_stop(run, file):
    path = file()
    assert run("rtstart", "--dry-run", path)[1].splitlines() == [
        f'Check for required component "RTC:Me:test:Source:1.0", "Source0" at path {SOURCE}'
        " (Required)",
        f'Check for required component "RTC:Me:test:Sink:1.0", "Sink0" at path {SINK} (Required)',
        f"{{1}} Activate {SOURCE} in execution context 0 (Required)",
        f"{{2}} Activate {SINK} in execution context 0 (Required)",
    ]
    assert run("rtstop", "--dry-run", path)[1].splitlines() == [
        f"{{1}} Deactivate {SINK} in execution context 0",
        f"{{2}} Deactivate {SOURCE} in execution context 0",
    ]


def test_components_must_be_there_without_creation(run, file, world):
    for arguments in (["rtresurrect", "--no-create"], ["rtstart"]):
        status, out, err = run(*arguments, file())
        assert (status, out) == (1, "")
        assert err.splitlines() == [
            f"{arguments[0]}: Required action failed: Required component missing: {path}"
            for path in (SOURCE, SINK)
        ]
    assert run("rtresurrect", "--no-create", "--stand-in", file())[0] == 2
    assert not world.performed


def test_without_a_hint_of_how_to_make_it(run, file, monkeypatch):
    status, out, err = run("rtresurrect", file(create=False))
    assert (status, out) == (1, "")
    assert err.splitlines() == [
        f"rtresurrect: Required action failed: Required component missing: {path}"
        " (nothing tells how to make it; --stand-in generates it)"
        for path in (SOURCE, SINK)
    ]


def test_loaded_modules_tell_how_to_make_a_component(run, file, world):
    world.modules["/m.py"] = tuple(world.types.values())
    world.types = {}
    world.perform(act.Load("/m.py", "init"))
    assert run("rtresurrect", file(create=False)) == (0, "", "")
    assert world.components["Sink0"].create == "RTC:Me:test:Sink:Python:1.0?instance_name=Sink0"


def test_known_component_profiles_tell_how(run, tmp_path, world, monkeypatch):
    ports = pattern("Sensor", "out", PortType.OUT).ports
    world.types = {}
    kind = ComponentPattern(TypeProfile("Sensor", "rtkit", "example", "1.0"), ports)
    world.modules["Sensor.py"] = (kind,)
    path = tmp_path / "sensor.xml"
    text = rts_text.system("Pair", component("Sensor0"))
    path.write_text(text.replace("RTC:Me:test", "RTC:rtkit:example"), encoding="utf-8")
    assert run("rtresurrect", str(path)) == (
        0,
        "",
        "rtresurrect: Action failed: No such configuration parameter: gain"
        " (on /localhost/Sensor0.rtc)\n",
    )
    assert [type(action) for action in world.performed] == [act.Load, act.Create]


def test_stand_ins_need_no_modules(run, file, world):
    world.types = {}
    path = file(create=False, host="10.0.0.9")
    status, out, err = run("rtresurrect", path)
    assert (status, out) == (1, "")
    assert "Required component missing: /10.0.0.9/Source0.rtc" in err
    assert run("rtresurrect", "--stand-in", "--transmit", path) == (0, "", "")
    assert all(c.is_stand_in for c in world.components.values())
    assert "standin.transmit=default" in world.components["Sink0"].create
    assert run("rtstart", path)[0] == 0
    assert run("rtcheck", path) == (0, "", "")
    status, out, err = run("rtcryo")
    saved = read_rts(out.encode())
    assert saved.notes == ()
    assert {c.path_uri for c in saved.profile.components} == {
        "10.0.0.9/Source0.rtc",
        "10.0.0.9/Sink0.rtc",
    }
    world.kill("stand-ins")
    assert run("rtresurrect", path) == (0, "", "")
    assert run("rtcheck", "-s", "Inactive", path) == (0, "", "")


def test_hosts_that_nobody_knows(run, file, world):
    path = file(host="10.0.0.9")
    assert run("rtresurrect", path) == (
        1,
        "",
        "rtresurrect: no such host: 10.0.0.9 (component Source0);"
        " --map 10.0.0.9=localhost makes it here\n",
    )
    assert not world.performed
    assert run("rtresurrect", "--map", "10.0.0.9=localhost", path) == (0, "", "")
    assert world.components["Sink0"].names == ("10.0.0.9/Sink0.rtc",)
    assert run("rtstop", path)[0] == 0
    assert run("rtresurrect", "--map", "10.0.0.9=other", path)[2] == (
        "rtresurrect: cannot map 10.0.0.9 to other: no manager is known on other\n"
    )


def test_nothing_half_made(run, file, world):
    before = world.snapshot()
    assert run("rtresurrect", file(sink="Nobody")) == (
        1,
        "",
        f"rtresurrect: Required action failed: {SINK}: component type Nobody is not known;"
        " removed again: Source0\n",
    )
    assert world.snapshot() == before


def test_optional_failures_are_told_and_forgiven(run, file, world):
    status, out, err = run("rtresurrect", file(sink="Nobody", required=False))
    assert (status, out) == (0, "")
    assert err.splitlines() == [
        f"rtresurrect: Action failed: {SINK}: component type Nobody is not known",
        f"rtresurrect: Action failed: Destination component missing: {SINK}",
        f"rtresurrect: Action failed: Component missing: {SINK}",
    ]
    assert list(world.components) == ["Source0"]


def test_start_tells_the_truth(run, file, world):
    path = file()
    run("rtresurrect", path)
    world.set_state("Sink0", LifeCycleState.ERROR)
    status, out, err = run("rtstart", path)
    assert (status, out) == (1, "")
    assert err == START + (
        f"rtstart: Required action failed: {SINK}: precondition not met (state is Error): Sink0;"
        f" active now: {SOURCE}\n"
    )
    run("rtstop", path)
    status, out, err = run("rtstop", path)
    assert (status, out) == (0, "")
    told = f"rtstop: Action failed: {SINK}: precondition not met (state is Error): Sink0"
    assert err.splitlines()[1] == told


def test_start_and_stop_may_not_wait(run, file, world):
    path = file()
    run("rtresurrect", path)
    for name in ("rtstart", "rtstop"):
        world.performed.clear()
        assert run(name, "--no-wait", path)[0] == 0
        assert not any(action.wait for action in world.performed)
        world.performed.clear()
        assert run(name, path)[0] == 0
        assert all(action.wait for action in world.performed)


def test_stop_and_teardown_forgive_what_is_missing(run, file):
    path = file()
    assert run("rtstop", path) == (
        0,
        "",
        f"rtstop: Action failed: Component missing: {SINK}\n"
        f"rtstop: Action failed: Component missing: {SOURCE}\n",
    )
    assert run("rtteardown", path) == (
        0,
        "",
        f"rtteardown: Action failed: Source component missing: {SOURCE}\n",
    )


def test_check_tells_every_deviation(run, file, world):
    path = file()
    run("rtresurrect", path)
    world.perform(act.Disconnect("wire"))
    world.perform(act.SetParameters("Sink0", "default", {"gain": "7"}))
    wire = f"No connection between {SOURCE}:out and {SINK}:in"
    gain = f"Configuration parameter gain in set default on component {SINK} is incorrect"
    state = "Component {} is in incorrect state Inactive; wanted: Active"
    states = [state.format(path) for path in (SOURCE, SINK)]
    assert run("rtcheck", path) == (
        1,
        "",
        "\n".join([wire, f"{gain} (value: 7); wanted: 2", *states, ""]),
    )
    status, out, err = run("rtcheck", "-s", "INACTIVE", "--json", path)
    assert (status, err) == (1, "")
    assert jsonrecords.checked(out) == [
        {
            "schema": "rtkit.deviation/1",
            "kind": "connection",
            "path": f"{SOURCE}:out {SINK}:in",
            "text": wire,
            "required": True,
            "item": "",
            "wanted": "wire",
            "found": "",
        },
        {
            "schema": "rtkit.deviation/1",
            "kind": "parameter",
            "path": SINK,
            "text": f"{gain} (value: 7)",
            "required": True,
            "item": "default.gain",
            "wanted": "2",
            "found": "7",
        },
    ]
    assert run("rtcheck", "-s", "Sleepy", path)[0] == 2
    assert run("rtcheck", "--exit-detail", path)[0] == 1


def test_check_for_build_servers(run, file, world):
    path = file()
    run("rtresurrect", path)
    world.perform(act.SetParameters("Sink0", "default", {"gain": "7"}))
    status, out, err = run("rtcheck", "-s", "inactive", "--junit", path)
    assert (status, err) == (1, "")
    (suite,) = etree.fromstring(out.encode())
    cases = {case.get("name"): case.find("failure") for case in suite.iter("testcase")}
    assert list(cases) == [SOURCE, SINK, f"{SOURCE}:out {SINK}:in"]
    assert [name for name, failure in cases.items() if failure is not None] == [SINK]
    assert cases[SINK].get("message").endswith("is incorrect (value: 7); wanted: 2")
    status, out, _ = run("rtcheck", "-s", "inactive", "--format", "github", path)
    assert (status, out.count("::error file=")) == (1, 1)
    status, out, _ = run("rtcheck", "-s", "inactive", "--format", "sarif", path)
    assert (status, json.loads(out)["runs"][0]["results"][0]["ruleId"]) == (1, "live-parameter")
    assert run("rtcheck", "--diff", "--junit", path)[0] == 2
    status, out, _ = run("rtcheck", "-s", "inactive", "--diff", "--json", path)
    (found,) = map(json.loads, out.splitlines())
    assert (status, found["wanted"], found["found"]) == (1, "2", "7")
    assert run("rtcheck", "--ignore", "x", path)[0] == 2


def test_check_shows_both_sides(run, file, world):
    path = file()
    run("rtresurrect", path)
    assert run("rtcheck", "--diff", "-s", "inactive", path) == (0, "", "")
    world.perform(act.Disconnect("wire"))
    world.perform(act.Connect(ConnectorProfile("w2", "w", (SOURCE_OUT, SINK_IN), {})))
    world.perform(act.SetParameters("Sink0", "default", {"gain": "7"}))
    world.perform(act.Create("Sink?instance_name=More"))
    world.perform(act.Connect(ConnectorProfile("w3", "w", (SOURCE_OUT, PortRef("More", "in")), {})))
    world.set_state("Source0", LifeCycleState.ACTIVE)
    assert run("rtcheck", "--diff", path) == (
        1,
        f"-{SOURCE}:out {SINK}:in  wire\n+{SOURCE}:out {SINK}:in  w2\n"
        f"-{SINK} default.gain  2\n+{SINK} default.gain  7\n"
        f"-{SINK} state  Active\n+{SINK} state  Inactive\n"
        "+/localhost/More.rtc  RTC:Me:test:Sink:1.0\n"
        f"+{SOURCE}:out /localhost/More.rtc:in  w3\n",
        "",
    )
    world.perform(act.Delete("Sink0"))
    out = run("rtcheck", "--diff", path)[1]
    assert out.startswith(f"-{SINK}  RTC:Me:test:Sink:1.0\n-{SOURCE}:out {SINK}:in  wire\n")
    world.update("Source0", type=TypeProfile("Other"), active_set="x", trouble="stopped")
    out = run("rtcheck", "--diff", path)[1]
    assert f"-{SOURCE}  RTC:Me:test:Source:1.0\n+{SOURCE}  RTC:::Other:\n" in out
    assert f"+{SOURCE}  stopped\n" in out


def test_surplus_is_no_deviation(run, file, world):
    path = file()
    run("rtresurrect", path)
    world.perform(act.Create("Sink?instance_name=More"))
    more = "+/localhost/More.rtc  RTC:Me:test:Sink:1.0\n"
    assert run("rtcheck", "--diff", "-s", "inactive", path) == (0, more, "")


def test_check_forgives_what_is_optional(run, file):
    path = file(required=False)
    status, out, err = run("rtcheck", path)
    assert (status, out) == (0, "")
    assert err.splitlines()[0] == f"Component missing: {SOURCE}"


def test_cryo_options(run, file):
    run("rtresurrect", file())
    status, out, err = run("rtcryo", "-a", "Abs", "-n", "Name", "-v", "3", "-e", "Vend", "-x")
    assert (status, err) == (0, "")
    assert out.startswith("<?xml")
    profile = read_rts(out.encode(), strict=True).profile
    assert (profile.id, profile.abstract) == ("RTSystem:Vend:Name:3", "Abs")
    sink = profile.components[0]
    assert property_value(sink.properties, "rtkit.create") == "Sink?manager_name=s&" + (
        "instance_name=Sink0"
    )
    assert run("rtcryo", "--json5")[0] == 2
    assert run("rtcryo", "-a", "a\x01b")[0] == 1


def test_cryo_servers(run, file):
    run("rtresurrect", file())
    for server, count in (("localhost", 2), ("/localhost:2809/", 2), ("box", 2)):
        status, out, _ = run("rtcryo", server)
        assert (status, len(read_rts(out.encode()).profile.components)) == (0, count)
    assert run("rtcryo", "/elsewhere") == (
        1,
        "",
        "rtcryo: /elsewhere: no such host: elsewhere (add it: rthost add elsewhere USER@ADDRESS)\n",
    )


def test_cryo_says_what_it_leaves_out(run, file, world):
    run("rtresurrect", file())
    world.update("Source0", trouble="stopped")
    world.perform(act.Create("Sink?instance_name=Zombie0&manager_name=z"))
    world.kill("z")
    status, out, err = run("rtcryo")
    assert status == 0
    assert err.splitlines() == [
        "rtcryo: saved as last reported (stopped): Source0",
        "rtcryo: not saved, zombie (signal 9): Zombie0",
    ]
    assert len(read_rts(out.encode()).profile.components) == 2


def test_cryo_tells_that_it_saves_nothing(run, world):
    world.perform(act.Create("Sink"))
    told = "rtcryo: note: no component is connected, so none is saved (--all saves them, too)\n"
    status, out, err = run("rtcryo")
    assert (status, err) == (0, told)
    assert read_rts(out.encode()).profile.components == ()
    assert run("rtcryo", "--all")[2] == ""


def test_cryo_leaves_an_old_file_when_it_cannot_write(run, file, tmp_path):
    run("rtresurrect", file())
    target = tmp_path / "no" / "such" / "dir.xml"
    status, out, err = run("rtcryo", "-o", str(target))
    assert (status, out) == (1, "")
    assert err.startswith(f"rtcryo: cannot write {target}: No such file")


def test_interrupted(run, file, world, monkeypatch):
    path = file()
    before = world.snapshot()
    monkeypatch.setattr("signal.signal", lambda *_: None)
    made = []

    def fault(action):
        if isinstance(action, act.Connect) and not made:
            made.append(action)
            raise KeyboardInterrupt
        return None

    world.fault = fault
    status, out, err = run("rtresurrect", path)
    assert (status, out) == (130, "")
    assert err == "rtresurrect: interrupted; removed again: Sink0, Source0\n"
    assert world.snapshot() == before


def test_interrupted_at_the_start_of_a_system(run, file, world, monkeypatch):
    path = file()
    run("rtresurrect", path)
    monkeypatch.setattr("signal.signal", lambda *_: None)

    def fault(action):
        if getattr(action, "instance", "") == "Sink0":
            raise KeyboardInterrupt
        return None

    world.fault = fault
    status, _, err = run("rtstart", path)
    assert status == 130
    assert err == START + f"rtstart: interrupted; no answer to: {{2}}; active now: {SOURCE}\n"
    status, _, err = run("rtteardown", "--exit", path)
    assert status == 130
    assert err == f"rtteardown: interrupted; left now: {SOURCE}, {SINK}\n"


def test_a_manager_that_goes_away(run, file, world):
    lost = Result(ReturnCode.ERROR, "unreachable", "slave s ended: signal 9")
    world.fault = lambda action: lost if isinstance(action, act.Connect) else None
    status, _, err = run("rtresurrect", file())
    assert status == 1
    where = f"{SOURCE}:out to {SINK}:in"
    assert f"Required action failed: {where}: slave s ended: signal 9; removed again" in err


def test_notes_only_when_verbose(run, file, world):
    assert run("rtresurrect", file())[2] == ""
    status, out, err = run("rtteardown", "-v", "--exit", file())
    assert (status, out) == (0, "")
    assert "xsi:type" in err
    told = err.splitlines()[-5:]
    assert [each for each in told if not each.startswith("done: ")] == [
        "disconnect: 1 of 1 to be done",
        "exit: 2 of 2 to be done",
    ]
    assert [each.split()[1] for each in told if each.startswith("done: ")] == [
        "Disconnect", "Exit", "Exit",
    ]  # fmt: skip
    assert run("rtresurrect", "--strict", file())[0] == 1


def test_what_makes_no_sense_is_named_with_its_line(run, tmp_path, world):
    source = " ".join(component("Source0").split())
    other = source.replace("RTC:Me:test:Source", "RTC:Me:test:Other")
    path = tmp_path / "twice.xml"
    text = rts_text.system("Pair", f"{source}\n{other}")
    path.write_text(text, encoding="utf-8")
    line = text[: text.index(other)].count("\n") + 1
    why = "two components are named Source0; instance names must differ within one manager"
    for command in ("rtresurrect", "rtstart", "rtcheck", "rtteardown"):
        assert run(command, str(path)) == (1, "", f"{command}: {path}:{line}: {why}\n")
        assert run(command, "--exit-detail", str(path))[0] == 3
    assert world.performed == []


def test_each_problem_of_a_profile_is_a_line(run, file):
    path = Path(file())
    text = path.read_text(encoding="utf-8").replace('isRequired="true"', 'isRequired="maybe"')
    path.write_text(text, encoding="utf-8")
    status, _, err = run("rtcheck", str(path))
    lines = err.splitlines()
    assert (status, len(lines)) == (1, 2)
    assert all(line.startswith(f"rtcheck: {path}:") for line in lines)


def test_names_that_none_may_bear_are_named_with_their_line(run, tmp_path):
    text = rts_text.system("Pair", component("Source0", "Source"))
    path = tmp_path / "star.xml"
    path.write_text(text.replace('instanceName="Source0"', 'instanceName="*S"'), encoding="utf-8")
    status, _, err = run("rtresurrect", str(path))
    assert status == 1
    assert err.startswith(f"rtresurrect: {path}:")
    assert err.endswith(": instance name begins with *, the mark of zombies: *S\n")
