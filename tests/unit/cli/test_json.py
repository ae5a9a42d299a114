"""The records of ``--json``: each is as its schema says, and each schema is met by one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import jsonrecords
import pytest
from fake_manager import FakeManager

from rtkit.cli.shared import json_records
from rtkit.cli.shared.commands import COMMANDS, load
from rtkit.component import Time, TimedDouble, TimedLong
from rtkit.component.geometry import Point2D, Pose2D, TimedPose2D
from rtkit.component.values.codec import codec_for
from rtkit.component.values.literal import Literal
from rtkit.probe.tap import Arrival
from rtkit.recording.entries import RecordedStream, RecordedValue
from rtkit.recording.mcap_file import RecordingWriter

Run = Callable[[str], Any]
ROOT = Path(__file__).parents[3]
CASES = Path(__file__).parent / "cases"
STD = "/localhost/Std0.rtc"
MANAGER = "/localhost/manager.mgr"
ASKED = {
    "rtls --json /": "entry",
    "rtls -R --json /": "entry",
    "rtls --json /localhost": "entry",
    f"rtls --json {STD}": "entry",
    "rtfind --json /": "entry",
    "rtfind --json /localhost -t z": "entry",
    f"rtcat --json {STD}": "component",
    "rtcat --json /localhost/Err0.rtc": "component",
    "rtcat --json /localhost/Input0.rtc": "component",
    f"rtcat --json {STD}:in": "port",
    "rtcat --json /localhost/User0.rtc:need": "port",
    f"rtcat --json {MANAGER}": "manager",
    f"rtcat --json {MANAGER}/slave2.mgr": "manager",
    f"rtconf --json {STD}": "configuration",
    f"rtconf --json -a {STD} list": "configuration",
    f"rtconf --json {STD} get param": "parameter",
    f"rtconf --json {MANAGER}": "properties",
    f"rtconf --json {MANAGER} get manager.name": "parameter",
    f"rtmgr --json -g {MANAGER}": "properties",
    f"rtmgr --json -r {MANAGER}": "instance",
    f"rtmgr --json -l /mods/a.py:aInit -m {MANAGER}": "component-type",
    "rtpwd --json": "working-directory",
    "rttype list --json": "known-type",
    "rttype show --json TimedLong Add Img::ColorFormat": "data-type",
    "rttype find-ports --json TimedLong Add": "typed-port",
    f"rtwait --json {STD} inactive": "goal",
}
ELSEWHERE = {
    "activity": "system/test_observers.py",
    "call": "system/test_services.py",
    "certificate": "unit/cli/test_rtkeys.py",
    "operation": "system/test_services.py",
    "bug-run": "unit/bug/test_records.py",
    "bug-word": "unit/bug/test_rtbug.py",
    "built-file": "unit/cli/test_build.py",
    "built-difference": "unit/cli/test_build_choices.py",
    "development": "system/test_rtdev.py",
    "diagnosis": "unit/cli/test_doctor.py",
    "deviation": "unit/cli/test_system.py",
    "event": "system/test_observers.py",
    "host": "system/test_hosts.py",
    "host-check": "system/test_hosts.py",
    "log-record": "system/test_observers.py",
    "package": "system/test_package_repositories.py",
    "plan": "unit/cli/test_planning.py",
    "step": "unit/cli/test_planning.py",
    "replay": "unit/cli/test_rtmgr_replay.py",
    "schema-file": "unit/cli/test_profile_schema.py",
    "setting": "unit/cli/test_rtconfig.py",
    "settings-file": "unit/cli/test_rtconfig.py",
    "status": "system/test_status.py",
    "system-state": "unit/cli/test_system_states.py",
    "converted-component": "unit/openrtm/convert/test_idioms.py",
    "absent-name": "unit/cli/test_profile_from.py",
    "migrated-file": "unit/openrtm/migrate/test_files.py",
    "terminal": "system/test_terminals.py",
    "transition": "unit/cli/test_system_states.py",
    "property": "system/test_live_properties.py",
    "property-event": "system/test_live_properties.py",
}
"""Kinds that other tests hold against their schemas."""

WITHOUT = {
    "rtact", "rtcomp", "rtcon", "rtdeact", "rtdel", "rtdis", "rtexit",
    "rtinject", "rtproxy", "rtreset", "rtserve", "rtset",  # change, and tell nothing
    "rtcwd",  # prints what a shell is to evaluate
    "rthost", "rtkeys", "rtopenrtm", "rtpkg", "rtprofile",  # their words have it
    "rtdoc", "rtstodot",  # write documents of other forms
    "rtgui",  # for a terminal only
    "rtweb",  # for a browser, which asks it for JSON
}  # fmt: skip


@pytest.mark.parametrize("line", ASKED)
def test_records_are_as_their_schema_says(run: Run, line: str) -> None:
    done = run(line)
    records = jsonrecords.checked(done.out)
    assert (done.status, done.err) == (0, "")
    assert {jsonrecords.kind_of(record) for record in records} == {ASKED[line]}


def test_every_schema_is_met_and_explained(met: set[str]) -> None:
    text = (ROOT / "docs" / "json.md").read_text(encoding="utf-8")
    for file in jsonrecords.FOLDER.iterdir():
        kind = file.name.removesuffix(".1.schema.json")
        assert f"`{kind}`" in text
        jsonrecords.validator(kind).check_schema(json.loads(file.read_text(encoding="utf-8")))
        where = ELSEWHERE.get(kind)
        is_met = kind in met if where is None else _mentions(where, kind)
        assert is_met, f"no test has a record of {kind}"


def _mentions(where: str, kind: str) -> bool:
    text = (ROOT / "tests" / where).read_text(encoding="utf-8")
    return "jsonrecords.checked(" in text and kind in text


@pytest.fixture
def met() -> set[str]:
    """Kinds of records that tests of this file meet, or cases: those are checked, too."""
    own = Path(__file__).read_text(encoding="utf-8")
    kinds = {file.name.removesuffix(".1.schema.json") for file in jsonrecords.FOLDER.iterdir()}
    cases = "".join(file.read_text(encoding="utf-8") for file in CASES.glob("*.txt"))
    return {
        kind for kind in kinds if f'"{kind}"' in own or f'\n{{"schema": "rtkit.{kind}/' in cases
    }


def test_every_command_that_reads_has_json() -> None:
    lacking = {
        name
        for name in COMMANDS.values()
        if name not in WITHOUT and not any("--json" in each.opts for each in _options(name))
    }
    assert lacking == set()


def _options(name: str) -> list[click.Parameter]:
    return list(load(name).command.params)


def test_the_words_of_rtmgr(capsys: pytest.CaptureFixture[str]) -> None:
    from rtkit.cli.managers.words import _print_status
    from rtkit.tree.managers import Status

    for address in ("", "localhost:2810"):
        _print_status("manager", Status(1, 2.5, 3, 1, "/run/x", address), True)
    records = jsonrecords.checked(capsys.readouterr().out)
    assert {jsonrecords.kind_of(record) for record in records} == {"manager-status"}


def test_a_state_machine(world: FakeManager, run: Run) -> None:
    world.update(
        "Std0", fsm_states={"off": {"toggle": "on"}, "on": {}}, fsm_events={"toggle": "RTC::X"}
    )
    (record,) = jsonrecords.checked(run(f"rtfsm --json {STD} getstate").out)
    assert jsonrecords.kind_of(record) == "state-machine"
    assert (record["state"], list(record["states"])) == (None, ["off", "on"])


def test_differences_and_exports(run: Run) -> None:
    (record,) = jsonrecords.checked(run(f"rtconf --json {STD} diff set1").out)
    assert jsonrecords.kind_of(record) == "configuration-difference"
    record = json.loads(run(f"rtconf {STD} export").out)
    assert jsonrecords.kind_of(record) == "configuration"
    assert not list(jsonrecords.validator("configuration").iter_errors(record))


def test_profiles(run: Run) -> None:
    files = Path(__file__).parent / "files"
    checked = jsonrecords.checked(run(f"rtprofile validate --json {files}").out)
    checked += jsonrecords.checked(run(f"rtprofile check --json {files / 'systems'}").out)
    assert {jsonrecords.kind_of(record) for record in checked} == {"checked"}
    line = f"rtprofile diff --json {files / 'pair.xml'} {files / 'pair2.xml'}"
    found = jsonrecords.checked(run(line).out)
    assert {jsonrecords.kind_of(record) for record in found} == {"profile-difference"}


def test_recordings(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "run.mcap"
    with file.open("wb") as stream, RecordingWriter(stream) as writer:
        for name in ("full", "empty"):
            writer.add_channel(RecordedStream(name, "IDL:RTC/TimedLong:1.0", ("/a",)), TimedLong)
        for number in range(3):
            payload = codec_for(TimedLong).encode(TimedLong(Time(number, 5), number))
            stamp = number * 1_000_000_000 + 5
            writer.write(RecordedValue("full", stamp, 7_000_000_000 + number, payload))
    (record,) = jsonrecords.checked(run(f"rtlog --info --json -f {file}").out)
    assert jsonrecords.kind_of(record) == "recording"
    assert (record["first"], record["last"]) == (
        "1970-01-01T00:00:00.000000005Z",
        "1970-01-01T00:00:02.000000005Z",
    )
    full, empty = record["channels"]
    assert (full["entries"], full["first_index"], full["last_index"]) == (3, 0, 2)
    assert (empty["entries"], empty["first"], empty["last_index"]) == (0, None, None)


def test_exports(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "run.mcap"
    with file.open("wb") as stream, RecordingWriter(stream) as writer:
        writer.add_channel(RecordedStream("s", "IDL:RTC/TimedPose2D:1.0", ("/a",)), TimedPose2D)
        for number in range(3):
            pose = TimedPose2D(Time(number, 5), Pose2D(Point2D(number, -1), 0.5))
            payload = codec_for(TimedPose2D).encode(pose)
            writer.write(RecordedValue("s", number * 10**9 + 5, 7 * 10**9 + number, payload))
    records = jsonrecords.checked(run(f"rtlog --export json -f {file}").out)
    assert [record["value"]["data"]["position"]["x"] for record in records] == [0, 1, 2]
    assert records[0]["received"] == "1970-01-01T00:00:07.000000000Z"
    lines = run(f"rtlog --export csv -i -s 1 -e 1 -f {file}").out.splitlines()
    times = "1970-01-01T00:00:07.000000001Z,1970-01-01T00:00:01.000000005Z"
    assert lines == [
        "received,stamp,stream,field,value",
        f"{times},s,data.position.x,1.0",
        f"{times},s,data.position.y,-1.0",
        f"{times},s,data.heading,0.5",
    ]
    text = run(f"rtlog --export text -i -e 1 -f {file}").out
    assert text.startswith("0.000000005\t('s', {")
    done = run(f"rtlog --export csv -i -s 9 -f {file}")
    told = "out of bounds: the recording has"
    assert (done.status, done.err) == (1, f"rtlog: Start index {told} 0 to 2\n")
    assert run(f"rtlog --export csv -s 2000000000 -f {file}").err == (
        f"rtlog: Start time {told} 0.000000005 to 2.000000005\n"
    )
    done = run(f"rtlog --export csv -i -e 0 -f {file}")
    assert (done.status, done.out, done.err) == (
        0,
        "",
        f"rtlog: warning: End index {told} 0 to 2\n",
    )
    assert run(f"rtlog --export csv -d -f {file}").status == 2
    done = run(f"rtlog --export csv -f {file} In0.rtc:out")
    assert (done.status, done.out) == (2, "")
    assert "--export takes no ports" in done.err


def test_values_and_their_statistics() -> None:
    from rtkit.cli.data.printing import json_line
    from rtkit.probe.port_spec import Stream
    from rtkit.probe.stats import Stats, stamp_reader
    from rtkit.probe.stream_report import record_of

    codec = codec_for(TimedDouble)
    stats = Stats(stamp_reader(TimedDouble))
    for number in (1.5, float("nan"), float("inf"), float("-inf")):
        arrival = Arrival("s", 1_700_000_000_000_000_001, codec.encode(TimedDouble(Time(), number)))
        (record,) = jsonrecords.checked(json_line(Stream("s", ()), codec.decode, ())(arrival))
        assert jsonrecords.kind_of(record) == "value"
        assert record["received"] == "2023-11-14T22:13:20.000000001Z"
        data = Literal(TimedDouble, json.dumps(record["value"])).at(Time()).data
        assert repr(data) == repr(number)
        stats.take(arrival)
    line = json_records.line("stream-stats", record_of(Stream("s", ()), stats.summary(), 0))
    (record,) = jsonrecords.checked(line)
    assert jsonrecords.kind_of(record) == "stream-stats"


def test_a_record_cannot_steer_a_terminal() -> None:
    text = json_records.line("parameter", {"name": "a\x9b31m", "value": "ü"})
    assert text.isprintable()
    assert json.loads(text)["name"] == "a\x9b31m"
    assert "ü" in json_records.line("parameter", {"name": "a", "value": "ü"})
