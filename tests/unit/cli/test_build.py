"""``rtbuild``: files on disk, written whole or not at all, and never over what users wrote."""

from __future__ import annotations

import os
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

from rtkit.cli.profiles import generated_project, project_changes
from rtkit.errors import InvalidDocument

IDL = Path(__file__).parents[2] / "idl"
PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:id="RTC:me:test:Echo:1.0" rtc:version="0.3"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext"
    xmlns:rtcDoc="http://www.openrtp.org/namespaces/rtc_doc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo xsi:type="rtcExt:basic_info_ext" rtc:name="Echo" rtc:componentType="STATIC"
      rtc:activityType="PERIODIC" rtc:componentKind="DataFlowComponent" rtc:category="test"
      rtc:vendor="me" rtc:version="1.0" rtc:executionType="PeriodicExecutionContext"
      rtc:executionRate="10.0" rtc:creationDate="2020-01-01T00:00:00"
      rtc:updateDate="2020-01-01T00:00:00" rtc:description="Echoes"/>
  <rtc:Actions>
    <rtc:OnExecute xsi:type="rtcDoc:action_status_doc" rtc:implemented="true"/>
  </rtc:Actions>
  <rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="DataInPort" rtc:name="in"
      rtc:type="RTC::TimedLong" rtcExt:position="LEFT"/>
  <rtc:ServicePorts xsi:type="rtcExt:serviceport_ext" rtc:name="voice" rtcExt:position="LEFT">
    <rtc:ServiceInterface xsi:type="rtcExt:serviceinterface_ext" rtc:name="echo"
        rtc:direction="Provided" rtc:type="SimpleService::MyService"
        rtc:idlFile="C:\\idl\\MyService.idl"/>
  </rtc:ServicePorts>
</rtc:RtcProfile>
"""
WRITTEN = [
    "Echo.py",
    "Echo_idl.py",
    "tests/test_Echo.py",
    "README.md",
    "pyproject.toml",
    "system.xml",
    "RTC.xml",
    "idl/MyService.idl",
]
Run = Callable[[str], Any]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RTM_ROOT", raising=False)
    (tmp_path / "echo.xml").write_text(PROFILE)
    (tmp_path / "idl").mkdir()
    shutil.copy(IDL / "MyService.idl", tmp_path / "idl")
    return tmp_path


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def test_all_files_are_written_and_told(place: Path, run: Run) -> None:
    lines = "".join(f"written    out/{name}\n" for name in WRITTEN)
    assert run("rtbuild echo.xml -o out") == (0, lines, "")
    assert set(contents(place / "out")) == set(WRITTEN)
    assert not [file for file in (place / "out").rglob("*") if file.name.endswith(".new")]
    code = (place / "out" / "Echo.py").read_text()
    assert '    voice = rt.ServicePort.provided(idl.MyService, "echo"' in code
    assert "    def echo(self, msg: str) -> str:\n" in code


def test_nothing_changes_the_second_time(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    before = contents(place / "out")
    assert run("rtbuild echo.xml -o out") == (0, "", "")
    assert contents(place / "out") == before
    status, out, _ = run("rtbuild -v echo.xml -o out")
    assert (status, out) == (0, "".join(f"unchanged  out/{name}\n" for name in WRITTEN))


def test_what_it_made_can_be_made_from_its_own_profile(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    before = contents(place / "out")
    os.unlink("echo.xml")
    shutil.rmtree("idl")
    assert run("rtbuild out/RTC.xml") == (0, "", "")
    assert contents(place / "out") == before


def test_code_of_users_is_kept(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    file = place / "out" / "Echo.py"
    edit(
        file,
        "        # <user code on_execute>\n",
        "        # <user code on_execute>\n        x = 1\n",
    )
    edit(place / "echo.xml", 'rtc:name="in"', 'rtc:name="into"')
    status, out, err = run("rtbuild echo.xml -o out")
    assert (status, err) == (0, "")
    assert "written    out/Echo.py\n" in out
    assert "        x = 1\n" in file.read_text()
    assert "into = rt.InPort" in file.read_text()


def test_changes_to_generated_code_stop_everything(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    edit(place / "out" / "Echo.py", 'vendor = "me"', 'vendor = "you"')
    edit(place / "out" / "Echo_idl.py", "Return the text", "Give the text")
    edit(place / "echo.xml", 'rtc:name="in"', 'rtc:name="into"')
    before = contents(place / "out")
    told = (
        "rtbuild: out/Echo.py:24: the generated part was changed\n"
        "rtbuild: out/Echo_idl.py:27: the generated part was changed\n"
        "rtbuild: nothing was written; --force writes, and keeps these as NAME.bak;"
        " --keep, --replace and --merge FILE decide for one\n"
    )
    assert run("rtbuild echo.xml -o out") == (1, "", told)
    assert run("rtbuild --dry-run echo.xml -o out") == (1, "", told)
    assert contents(place / "out") == before


def test_force_keeps_what_was_there_aside(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    file = place / "out" / "Echo.py"
    readme = place / "out" / "README.md"
    edit(file, 'vendor = "me"', 'vendor = "you"')
    edit(file, "<user code on_execute>\n", "<user code on_execute>\n        mine = 1\n")
    edit(readme, "Echoes", "Mine")
    mine, my_readme = file.read_text(), readme.read_text()
    status, out, err = run("rtbuild -f echo.xml -o out")
    assert (status, err) == (0, "")
    assert out == (
        "written    out/Echo.py (the generated part was changed)\n"
        "written    out/README.md (it was changed)\n"
    )
    assert file.with_name("Echo.py.bak").read_text() == mine
    assert readme.with_name("README.md.bak").read_text() == my_readme
    assert 'vendor = "me"' in file.read_text()
    assert "mine = 1" in file.read_text()
    edit(file, 'vendor = "me"', 'vendor = "they"')
    run("rtbuild -f echo.xml -o out")
    assert file.with_name("Echo.py.bak").read_text() == mine
    assert 'vendor = "they"' in file.with_name("Echo.py.bak2").read_text()


def test_files_that_are_no_code_are_the_user_s_once_changed(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    edit(place / "out" / "README.md", "Echoes", "Mine")
    edit(place / "echo.xml", 'rtc:description="Echoes"', 'rtc:description="Says"')
    status, out, err = run("rtbuild echo.xml -o out")
    assert (status, err) == (0, "")
    assert "kept       out/README.md (it was changed)\n" in out
    assert "written    out/pyproject.toml\n" in out
    assert "Mine" in (place / "out" / "README.md").read_text()


def test_a_dry_run_writes_nothing(place: Path, run: Run) -> None:
    status, out, _ = run("rtbuild -n echo.xml -o out")
    assert status == 0
    assert out.count("written") == len(WRITTEN)
    assert not (place / "out").exists()


def test_json_has_an_object_for_each_file(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    edit(place / "out" / "README.md", "Echoes", "Mine")
    records = jsonrecords.checked(run("rtbuild --json echo.xml -o out").out)
    assert {jsonrecords.kind_of(record) for record in records} == {"built-file"}
    assert {record["path"]: record["fate"] for record in records} == {
        f"out/{name}": "kept" if name == "README.md" else "unchanged" for name in WRITTEN
    }


def test_idl_files_are_looked_for(place: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    (place / "idl").rename(place / "elsewhere")
    status, out, err = run("rtbuild echo.xml -o a")
    assert status == 0
    assert "Echo_idl.py" not in out
    assert err == (
        "note: port voice: SimpleService::MyService: MyService.idl was not found"
        " (-I DIR tells where IDL files are); described only\n"
    )
    assert "a/Echo_idl.py" not in out
    status, out, err = run("rtbuild echo.xml -o b -I nowhere -I elsewhere")
    assert (status, err) == (0, "")
    assert "written    b/Echo_idl.py\n" in out
    (place / "root" / "rtm").mkdir(parents=True)
    (place / "elsewhere").rename(place / "root" / "rtm" / "idl")
    monkeypatch.setenv("RTM_ROOT", str(place / "root"))
    assert "written    c/Echo_idl.py\n" in run("rtbuild echo.xml -o c").out


def test_types_are_found_though_no_profile_names_their_file(place: Path, run: Run) -> None:
    edit(place / "echo.xml", 'rtc:idlFile="C:\\idl\\MyService.idl"', "")
    edit(place / "echo.xml", 'rtc:type="RTC::TimedLong"', 'rtc:type="Robot::State"')
    (place / "own.idl").write_text("module Robot { struct State { long a; }; };")
    (place / "idl" / "broken.idl").write_text("struct {")
    status, out, err = run("rtbuild echo.xml -o out")
    assert (status, err) == (
        0,
        "note: own.idl: not named by the profile; types are taken from it\n"
        "note: idl/MyService.idl: not named by the profile; types are taken from it\n",
    )
    assert "written    out/idl/own.idl\n" in out
    assert "broken" not in out
    assert "in_ = rt.InPort(idl.State" in (place / "out" / "Echo.py").read_text()


def test_names_that_are_cut_are_told_and_none_hides_a_function(place: Path, run: Run) -> None:
    long = "distance_to_the_nearest_obstacle_in_front_of_the_robot"
    edit(place / "echo.xml", 'rtc:name="in"', f'rtc:name="{long}"')
    edit(place / "echo.xml", 'rtc:name="voice"', 'rtc:name="range"')
    _, _, err = run("rtbuild echo.xml -o out")
    made = "distance_to_the_nearest_obstacle_in_fron"
    assert err == f"note: port {long} is called {made} in the code, where names are cut\n"
    code = (place / "out" / "Echo.py").read_text()
    assert f"    {made} = rt.InPort(" in code
    assert "    range_ = rt." in code


def test_each_component_has_its_own_folder(place: Path, run: Run) -> None:
    assert run("rtbuild echo.xml").status == 0
    before = contents(place)
    shutil.copy(place / "echo.xml", place / "other.xml")
    edit(place / "other.xml", 'rtc:name="Echo"', 'rtc:name="Other"')
    assert run("rtbuild other.xml") == (
        1,
        "",
        "rtbuild: . is the folder of component Echo: -o DIR gives this one its own,"
        " --add puts it beside that one\n",
    )
    (place / "other.xml").rename(place.parent / "other.xml")
    assert contents(place) == before
    assert run(f"rtbuild {place.parent / 'other.xml'} -o o").status == 0
    assert run("rtbuild echo.xml").status == 0


@pytest.fixture
def two(place: Path) -> Path:
    """Two profiles, of which the second one needs no IDL."""
    other = PROFILE[: PROFILE.index("  <rtc:ServicePorts")] + "</rtc:RtcProfile>\n"
    (place / "other.xml").write_text(other.replace("Echo", "Other"))
    return place


def test_several_profiles_are_one_package(two: Path, run: Run) -> None:
    status, out, err = run("rtbuild echo.xml other.xml -o out")
    assert (status, err) == (0, "")
    written = {line.split("  ")[-1].removeprefix("out/") for line in out.splitlines()}
    assert written == {*WRITTEN, "Other.py", "tests/test_Other.py", "Other.xml"}
    told = tomllib.loads((two / "out" / "pyproject.toml").read_text())
    assert told["project"]["name"] == "rtc-echo"
    assert told["project"]["entry-points"]["rtkit.components"] == {
        "Echo": "rtc_echo.Echo:EchoInit",
        "Other": "rtc_echo.Other:OtherInit",
    }
    assert told["tool"]["setuptools"]["package-data"] == {"rtc_echo": ["*.xml", "idl/*.idl"]}
    assert 'instanceName="Other0"' in (two / "out" / "system.xml").read_text()
    readme = (two / "out" / "README.md").read_text()
    assert [line for line in readme.splitlines() if line.startswith(("# ", "## "))] == [
        "# rtc-echo",
        "## Echo",
        "## Other",
    ]
    assert "rtbuild Other.xml" in readme
    before = contents(two)
    for line in (
        "rtbuild echo.xml other.xml -o out",
        "rtbuild out/RTC.xml",
        "rtbuild out/Other.xml",
    ):
        assert run(line) == (0, "", "")
    assert contents(two) == before


def test_a_component_is_added_and_all_that_is_there_is_kept(two: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    code, project = two / "out" / "Echo.py", two / "out" / "pyproject.toml"
    edit(code, "raise NotImplementedError", "return 'mine'")
    edit(project, 'dependencies = ["rtkit"]', 'dependencies = ["rtkit", "numpy"]')
    mine = code.read_bytes()
    assert run("rtbuild other.xml -o out").status == 1
    status, out, err = run("rtbuild other.xml -o out --add")
    assert (status, err) == (0, "")
    assert "written    out/pyproject.toml (what is yours is kept)\n" in out
    assert code.read_bytes() == mine
    text = project.read_text()
    assert '"numpy"' in text
    assert list(tomllib.loads(text)["project"]["entry-points"]["rtkit.components"]) == [
        "Other",
        "Echo",
    ]
    before = contents(two)
    kept = "kept       out/pyproject.toml (it was changed)\n"
    assert run("rtbuild other.xml -o out") == (0, kept, "")
    assert contents(two) == before


def test_the_readme_names_the_package_that_all_are_in(two: Path, run: Run) -> None:
    run("rtbuild echo.xml other.xml -o out")
    told = [line for line in (two / "out" / "README.md").read_text().splitlines() if "-e '" in line]
    assert told == ["pip install -e '.[dev]'   # rtc-echo"] * 2


def test_two_components_in_one_file_are_refused(two: Path, run: Run) -> None:
    edit(two / "other.xml", 'rtc:name="Other"', 'rtc:name="Echo_idl"')
    assert run("rtbuild echo.xml other.xml -o out") == (
        1, "", "rtbuild: other.xml: Echo_idl.py would be of Echo and of Echo_idl\n"
    )  # fmt: skip
    assert not (two / "out").exists()


def test_entry_points_that_have_no_place_are_told(two: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    project = two / "out" / "pyproject.toml"
    edit(project, '[project.entry-points."rtkit.components"]', "[project.urls]")
    _, _, err = run("rtbuild other.xml -o out --add")
    assert err == (
        'note: out/pyproject.toml: yours; [project.entry-points."rtkit.components"]:'
        ' "Echo" = "rtc_echo.Echo:EchoInit"; "Other" = "rtc_echo.Other:OtherInit"\n'
    )


def test_nothing_is_added_to_what_was_not_generated(two: Path, run: Run) -> None:
    (two / "out").mkdir()
    shutil.copy(two / "echo.xml", two / "out" / "RTC.xml")
    assert run("rtbuild other.xml -o out --add") == (
        1, "", "rtbuild: out/RTC.xml: Echo is not generated there yet: rtbuild it first\n"
    )  # fmt: skip
    assert run("rtbuild echo.xml other.xml -o out --mirror").err == (
        "rtbuild: --mirror is for one component\n"
    )


def test_types_are_found_in_installed_packages(
    two: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    site = two / "site"
    shutil.move(two / "idl", site / "rtc_far" / "idl")
    (site / "rtc_far" / "Far.py").write_text("")
    (site / "rtc_far-1.dist-info").mkdir()
    entries = "[rtkit.components]\nFar = rtc_far.Far:FarInit\n"
    (site / "rtc_far-1.dist-info" / "entry_points.txt").write_text(entries)
    monkeypatch.syspath_prepend(site)
    status, out, _ = run("rtbuild echo.xml -o out")
    assert status == 0
    assert "out/idl/MyService.idl" in out


def test_a_mistake_in_an_idl_file_is_told_with_its_line(place: Path, run: Run) -> None:
    edit(place / "idl" / "MyService.idl", "in string msg", "string msg")
    assert run("rtbuild echo.xml -o out") == (
        1,
        "",
        "rtbuild: idl/MyService.idl:19: unexpected 'string'; expected in, out or inout or ')'\n",
    )
    assert not (place / "out").exists()


def test_an_idl_file_alone_gives_its_types(place: Path, run: Run) -> None:
    shutil.copy(IDL / "Arm.idl", place)
    status, out, err = run("rtbuild Arm.idl -o out")
    assert (status, out) == (0, "written    out/Arm_idl.py\n")
    assert err == (
        "note: Arm.idl:72: Robot::Arm::Strange is left out:"
        " operation get: any has no form in CDR here\n"
    )
    (place / "none.idl").write_text("interface I { any f(); };")
    status, out, err = run("rtbuild none.idl")
    assert (status, out) == (1, "")
    assert err.startswith("rtbuild: none.idl: nothing in it can be carried: none.idl:1: I is left")


def test_an_idl_file_of_built_in_types_needs_nothing(place: Path, run: Run) -> None:
    (place / "BasicDataType.idl").write_text(
        "module RTC { struct Time { unsigned long sec, nsec; };"
        " struct TimedLong { Time tm; long data; }; };"
    )
    assert run("rtbuild BasicDataType.idl -o out") == (
        0,
        "",
        "note: BasicDataType.idl: its 2 types are built in"
        " (from rtkit import component as rt; rt.Time …); there is nothing to generate\n",
    )
    assert not (place / "out").exists()


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("rtbuild", "rtbuild: One RTC profile or IDL file has to be given."),
        ("rtbuild a b", "rtbuild: cannot read a: No such file or directory"),
        ("rtbuild a.idl b", "rtbuild: a.idl: an IDL file is generated alone"),
        (
            "rtbuild echo.xml echo.xml",
            "rtbuild: echo.xml: another file given describes the same component type",
        ),
        ("rtbuild nix.xml", "rtbuild: cannot read nix.xml: No such file or directory"),
        ("rtbuild nix.idl", "rtbuild: cannot read nix.idl: No such file or directory"),
        ("rtbuild echo.xml -o echo.xml", "rtbuild: File exists: echo.xml"),
    ],
)
def test_what_cannot_be_done_is_told(place: Path, run: Run, line: str, why: str) -> None:
    before = contents(place)
    status, out, err = run(line)
    assert (status, out) == (1, "")
    assert err == f"{why}\n"
    assert contents(place) == before


def test_a_system_profile_is_none_of_a_component(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    status, _, err = run("rtbuild out/system.xml -o other")
    assert status == 1
    assert "RtsProfile" in err
    assert not (place / "other").exists()


def test_where_a_file_cannot_be_written_none_is(place: Path, run: Run) -> None:
    (place / "out" / "system.xml").mkdir(parents=True)
    status, out, err = run("rtbuild echo.xml -o out")
    assert (status, out) == (1, "")
    assert "system.xml" in err
    assert contents(place / "out") == {}


def test_modes_and_line_ends_of_users_are_respected(place: Path, run: Run) -> None:
    run("rtbuild echo.xml -o out")
    file = place / "out" / "Echo.py"
    file.chmod(0o640)
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    edit(place / "echo.xml", 'rtc:vendor="me"', 'rtc:vendor="you"')
    status, _, err = run("rtbuild echo.xml -o out")
    assert (status, err) == (0, "")
    assert 'vendor = "you"' in file.read_text()
    assert file.stat().st_mode & 0o777 == 0o640


def test_a_profile_from_stdin(place: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    with open("echo.xml", encoding="utf-8") as stream:
        monkeypatch.setattr("sys.stdin", stream)
        status, out, _ = run("rtbuild - -o out")
    assert status == 0
    assert "written    out/Echo.py\n" in out


def test_a_machine_drawn_beside_the_profile_is_taken(place: Path, run: Run) -> None:
    port = (
        '<rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="EventPort" rtc:name="e"'
        ' rtc:type="Any" rtcExt:position="LEFT"/></rtc:RtcProfile>'
    )
    edit(place / "echo.xml", "</rtc:RtcProfile>", port)
    text = (place / "echo.xml").read_text()
    # Data ports stand before service ports in the strict order; any order is read.
    (place / "echo.xml").write_text(text)
    (place / "EchoFSM.scxml").write_text(
        '<scxml xmlns="http://www.w3.org/2005/07/scxml" initial="A">'
        '<state id="A"><transition event="go" target="B"/></state><state id="B"/></scxml>'
    )
    assert run("rtbuild echo.xml -o out").status == 0
    assert '"A": {"go": "B"},' in (place / "out" / "Echo.py").read_text()


def test_types_of_an_idl_file_are_made_anew_where_they_were_made(place: Path) -> None:
    idl = place / "Robot.idl"
    idl.write_text("struct Wheel { double speed; };")
    assert project_changes.renew_types(str(idl)) == []  # nobody has made any
    project = generated_project.read([str(idl)], None, [])
    project_changes.write(project_changes.compare(project), is_forced=False)
    idl.write_text("struct Wheel { double speed; long ticks; };")
    assert project_changes.renew_types(str(idl)) == [str(place / "Robot_idl.py")]
    assert "ticks: rt.Long" in (place / "Robot_idl.py").read_text()
    idl.write_text("struct Wheel {\n  double\n};")
    with pytest.raises(InvalidDocument, match=r"Robot\.idl:3"):
        project_changes.renew_types(str(idl))


def test_types_of_all_components_of_a_project_are_made_anew(place: Path, run: Run) -> None:
    shutil.copy(place / "echo.xml", place / "again.xml")
    edit(place / "again.xml", 'rtc:name="Echo"', 'rtc:name="Again"')
    assert run("rtbuild echo.xml again.xml -o out").status == 0
    idl = place / "out" / "idl" / "MyService.idl"
    edit(idl, "in string msg", "in long msg")
    made = [str(place / "out" / f"{name}_idl.py") for name in ("Echo", "Again")]
    assert project_changes.renew_types(str(idl)) == made
    assert project_changes.renew_types(str(idl)) == []
