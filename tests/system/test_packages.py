"""Generated packages as real wheels, side by side: found by every check, and by every name."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

RUNS_PROCESSES = True
MANAGER = "/localhost/manager.mgr"
IDL = """module Robot {{
  enum Mode {{ IDLE, {mode} }};
  struct Level {{ double value; Mode mode; }};
}};
"""
SOURCE = '''
from rtkit import component as rt


class {name}(rt.Component):
    """Be {name}."""

    vendor = "me"
    category = "test"
    version = "1.0"
    rate = 100.0
    gain = rt.Parameter(1.0, constraint="0<=x<=2", sets={{"loud": 2}})
    {port}
'''
OUT, IN = "out = rt.OutPort(rt.TimedLong)", "into = rt.InPort(rt.TimedLong)"
SAVED = ("talker.Hearer", "judge.Judge", "talker.Talker")
WORK = "        self.out.write(idl.Level(helper.VALUE, idl.Mode.IDLE))"


def generated(shell: Any, folder: str, *components: tuple[str, str]) -> Path:
    """Generate a project of components, whose ports are of a type of an IDL file beside."""
    (shell.folder / "Robot.idl").write_text(IDL.format(mode="DRIVING"))
    files = []
    for name, port in components:
        (shell.folder / f"{name}.py").write_text(SOURCE.format(name=name, port=port))
        profile = shell.ok(f"rtprofile from {name}.py:{name}")
        profile = profile.replace('"RTC::TimedLong"', '"Robot::Level" rtc:idlFile="Robot.idl"')
        work = 'OnExecute xsi:type="rtcDoc:action_status_doc" rtc:implemented="'
        files.append(f"{name}.xml")
        (shell.folder / files[-1]).write_text(profile.replace(f"{work}false", f"{work}true"))
    shell.ok(f"rtbuild {' '.join(files)} -o {folder}")
    return Path(shell.folder / folder)


def with_helper(project: Path, name: str, value: str, body: str) -> None:
    """Write code of users: it imports a helper beside it, whose name is that of another one."""
    (project / "helper.py").write_text(f"VALUE = {value}\n")
    code = (project / f"{name}.py").read_text()
    for mark, text in (("imports", "import helper"), ("on_execute", body)):
        opening = f"# <user code {mark}>\n"
        assert opening in code
        code = code.replace(opening, f"{opening}{text}\n")
    (project / f"{name}.py").write_text(code)


def saved_text(folder: Path) -> str:
    return (folder / "saved.xml").read_text()


def install(shell: Any, *projects: Path) -> Path:
    """Install projects as users do, in a folder of their own; return that folder."""
    site = Path(shell.folder / "site")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation"]
    pip += ["--no-index", "--disable-pip-version-check", "--target", str(site)]
    subprocess.run([*pip, *map(str, projects)], check=True, capture_output=True, timeout=100)
    return site


def test_wheels_with_equal_names_inside_work_side_by_side(shell: Any) -> None:
    sender = generated(shell, "sender", ("Talker", OUT), ("Hearer", IN))
    other = generated(shell, "other", ("Judge", IN))
    with_helper(sender, "Talker", "2.5", WORK)
    with_helper(other, "Judge", "7", "        self.seen = (self.into.read(), helper.VALUE)")
    site = install(shell, sender, other)
    tops = {each.name for each in site.iterdir() if not each.name.endswith(".dist-info")}
    assert tops == {"rtc_talker", "rtc_judge"}
    assert {"RTC.xml", "Hearer.xml", "idl", "helper.py"} <= {
        each.name for each in (site / "rtc_talker").iterdir()
    }
    empty = shell.folder / "empty"
    empty.mkdir()
    shell.folder = empty
    shell.environment["PYTHONPATH"] += f":{site}"
    (empty / "rtc.conf").write_text("manager.modules.preload: rtc_talker.Hearer:HearerInit\n")
    shell.ok("rtmgr start")
    assert "Hearer" in shell.ok(f"rtmgr -m {MANAGER}")
    load = "-l rtc_talker.Talker:TalkerInit"  # the manager has one already, and finds the other
    made = " ".join(f"-c '{name}?manager_name=s'" for name in ("Talker", "Hearer", "Judge"))
    shell.ok(f"rtmgr {MANAGER} {load} {made}")
    shell.ok("rtcon /localhost/Talker0.rtc:out /localhost/Hearer0.rtc:into")
    shell.ok("rtcon /localhost/Talker0.rtc:out /localhost/Judge0.rtc:into")
    shell.ok("rtconf -s loud /localhost/Judge0.rtc act")
    shell.ok("rtact /localhost/Talker0.rtc /localhost/Hearer0.rtc /localhost/Judge0.rtc")
    assert "2.5" in shell.ok("rtprint -n 1 /localhost/Talker0.rtc:out")
    shell.ok("rtcryo --all -o saved.xml")
    modules = re.findall('rtkit[.]module" rtsExt:value="([^"]*)', saved_text(empty))
    assert modules == [f"rtc_{top}:{top.rpartition('.')[2]}Init" for top in SAVED]
    assert "Filepath: rtc_judge.Judge" in shell.ok(f"rtcat {MANAGER}")
    for check in ("rtprofile check", "rtcheck --static"):
        assert "3 components, 3 of known type" in shell.ok(f"{check} saved.xml")
    shell.ok("rtcheck saved.xml")
    # A profile of other tools says the types, and not of which module they are.
    plain = re.sub("<rtsExt:Properties [^>]*rtkit[.](module|create)[^>]*/>", "", saved_text(empty))
    (empty / "plain.xml").write_text(plain)
    shell.ok("rtteardown saved.xml")
    # A file of that name beside is not taken for it.
    shell.ok(f"rtmgr {MANAGER} -u rtc_judge.Judge")
    (empty / "Judge.py").write_text("raise SystemExit('another one')\n")
    shell.ok("rtresurrect saved.xml")
    (empty / "Judge.py").unlink()
    shell.ok("rtteardown saved.xml")
    shell.ok("rtresurrect plain.xml")
    assert shell.run("rtstart plain.xml").status == 0
    shell.ok("rtcheck plain.xml")
    status, _, err = shell.run(f"rtmgr {MANAGER} -l rtc_talker.Talkr:TalkerInit")
    assert status == 1
    assert "no module rtc_talker.Talkr (did you mean rtc_talker.Talker" in err
    told = "from rtc_talker import Hearer; print(Hearer.idl.Level().mode.name, Hearer.__name__)"
    python = [sys.executable, "-c", told]
    assert subprocess.check_output(python, env=shell.environment) == b"IDLE rtc_talker.Hearer\n"
    profile = (site / "rtc_judge" / "RTC.xml").read_text().replace("Judge", "Third")
    (empty / "third.xml").write_text(profile.replace(' rtc:idlFile="Robot.idl"', ""))
    status, out, err = shell.run("rtbuild third.xml -o third")
    assert (status, err.startswith("note: "), "third/Third_idl.py" in out) == (0, True, True)
    assert f"{site}/rtc_judge/idl/Robot.idl: not named by the profile; types are taken" in err
