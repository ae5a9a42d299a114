"""Modules on real processes: found, refused, listed; none runs before somebody asks for it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
MODULE = '''
from pathlib import Path
Path("{canary}").write_text("ran")
from rtkit.component import Component, Parameter

class {name}(Component):
    """A test."""
    vendor = "me"
    depth = Parameter(3)

def {name}Init(manager):
    manager.register_factory({name})
'''


def write(shell: Any, name: str, folder: Path | None = None) -> Path:
    folder = folder or shell.modules
    folder.mkdir(exist_ok=True)
    file = folder / f"{name}.py"
    file.write_text(MODULE.format(canary=shell.folder / "canary", name=name))
    return file


def ran(shell: Any) -> bool:
    return bool((shell.folder / "canary").exists())


def refused(shell: Any, line: str, why: str) -> None:
    status, out, err = shell.run(f"rtmgr {line} {MANAGER}")
    assert (status, out) == (1, ""), line
    assert why in err
    assert err.count("\n") == 1
    assert not ran(shell), line


def test_what_could_be_loaded_is_listed_without_running_it(manager: Any) -> None:
    file = write(manager, "Deep")
    (manager.modules / "Broken.py").write_text("def BrokenInit(")
    write(manager, "Open").chmod(0o666)
    (manager.modules / "Away.py").symlink_to(write(manager, "Away", manager.folder / "away"))
    status, out, err = manager.run(f"rtmgr -m {MANAGER}")
    assert status == 0
    assert "RTC:me::Deep:Python:" in out.splitlines()
    assert "RTC:rtkit:example:ConsoleIn:Python:1.0" in out.splitlines()
    told = sorted(line.partition(" (")[::2] for line in err.splitlines())
    assert [line for line, _ in told] == [
        f"rtmgr: module cannot be read: {name}.py" for name in ("Away", "Broken", "Open")
    ]
    for (_, why), word in zip(told, ("leaves", "SyntaxError", "everybody"), strict=True):
        assert word in why
    lines = manager.run(f"rtmgr -m --json {MANAGER}").out.splitlines()
    records = [json.loads(line) for line in lines]
    assert ("RTC:me::Deep:Python:", str(file)) in [(r["type"], r["module"]) for r in records]
    assert not ran(manager)
    manager.ok(f"rtmgr -c Deep {MANAGER}")
    assert ran(manager)


def test_names_stay_inside_the_load_paths(shell: Any) -> None:
    manager = shell
    manager.ok("rtmgr start -o manager.modules.load_path:modules")
    write(manager, "Away", manager.folder / "away")
    (manager.modules / "Link.py").symlink_to(manager.folder / "away" / "Away.py")
    (manager.modules / "folder").symlink_to(manager.folder / "away")
    refused(manager, "-l x/../../away/Away.py:AwayInit", "leaves the load paths")
    refused(manager, "-l Link.py:AwayInit", "is a link that leaves the load path")
    refused(manager, "-l folder/Away.py:AwayInit", "is a link that leaves the load path")
    refused(manager, "-c Link", "is a link that leaves the load path")
    refused(manager, "-c Link?manager_name=s1", "is a link that leaves the load path")
    refused(manager, "-c ../away/Away?instance_name=X", "not known")


def test_absolute_paths_only_where_they_are_allowed(shell: Any) -> None:
    inside, outside = write(shell, "Inside"), write(shell, "Outside", shell.folder / "away")
    more = "-o manager.modules.load_path:modules"
    shell.ok(f"rtmgr start -o manager.modules.abs_path_allowed:NO {more}")
    refused(shell, f"-l {outside}:OutsideInit", "manager.modules.abs_path_allowed is NO")
    refused(shell, "-l ./away/Outside.py:OutsideInit", "manager.modules.abs_path_allowed is NO")
    shell.ok(f"rtmgr -l {inside}:InsideInit -c Inside?manager_name=s1 {MANAGER}")
    shell.ok(f"rtmgr -s manager.modules.abs_path_allowed=YES -l {outside}:OutsideInit {MANAGER}")


def test_what_strangers_may_write_is_refused(manager: Any) -> None:
    file = write(manager, "Open")
    file.chmod(0o646)
    refused(manager, "-l Open.py:OpenInit", "may be written by everybody")
    file.chmod(0o644)
    manager.modules.chmod(0o757)
    refused(manager, "-l Open.py:OpenInit", f"folder {manager.modules} may be written by everybody")
    manager.modules.chmod(0o700)
    manager.folder.chmod(0o777)
    refused(manager, "-c Open?manager_name=s1", f"folder {manager.folder} may be written by")
    manager.folder.chmod(0o700)
    manager.ok(f"rtmgr -c Open {MANAGER}")


def test_load_paths_are_properties(shell: Any) -> None:
    write(shell, "Near", shell.folder / "near")
    write(shell, "Far", shell.folder / "far")
    shell.ok("rtmgr start -o manager.modules.load_path:near")
    shell.ok(f"rtmgr -c Near {MANAGER}")
    os.unlink(shell.folder / "canary")
    refused(shell, "-c Far", "Far is not known")
    shell.ok(f"rtmgr -c Near?manager_name=s1 -s manager.modules.load_path=near,far {MANAGER}")
    shell.ok(f"rtmgr -c Far -c Far?manager_name=s1 -c Far?manager_name=s2 {MANAGER}")
    properties = json.loads(shell.ok(f"rtmgr -g --json {MANAGER}"))["properties"]
    listed = properties["manager.modules.load_path"]
    assert listed.startswith(f"{shell.folder}/near,{shell.folder}/far,{shell.modules},/")


def test_without_search_types_have_to_be_loaded(shell: Any) -> None:
    write(shell, "Deep")
    shell.ok("rtmgr start -o manager.modules.search_auto:NO")
    refused(shell, "-c Deep", "Deep is not known")
    refused(shell, "-c Deep?manager_name=s1", "Deep is not known")
    shell.ok(f"rtmgr -l Deep.py:DeepInit -c Deep?manager_name=s1 {MANAGER}")


STANDARD = ("json", "logging", "os", "queue", "random", "selectors", "socket", "threading", "zenoh")


def test_names_of_standard_modules_break_nothing(shell: Any) -> None:
    evil = f"from pathlib import Path\nPath('{shell.folder}/canary').write_text('ran')\n"
    for folder in (shell.folder, shell.modules):
        for name in STANDARD:
            (folder / f"{name}.py").write_text(f"{evil}def {name}Init(manager): pass\n")
    # The tests run commands in a way that takes modules from the folder, unlike installed ones.
    shell.environment["PYTHONSAFEPATH"] = "1"
    shell.environment["PYTHONPATH"] = str(Path(__file__).parents[2])
    shell.ok("rtmgr start")
    shell.ok(f"rtmgr -c ConsoleIn -c ConsoleOut?manager_name=s1 {MANAGER}")
    shell.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in")
    shell.ok("rtact /localhost/ConsoleIn0.rtc")
    assert not ran(shell)
    shell.ok(f"rtmgr -l random.py:randomInit {MANAGER}")
    assert ran(shell)
    uses = "import random, json\nassert random.random() < 1 and json.dumps(1)\n"
    file = write(shell, "User")
    file.write_text(uses + file.read_text())
    shell.ok(f"rtmgr -c User -c User?manager_name=s1 -c User?manager_name=s2 {MANAGER}")


@pytest.mark.parametrize("place", ["", "?manager_name=s1"])
def test_a_module_imports_what_lies_beside_it(manager: Any, place: str) -> None:
    (manager.modules / "rtkit_test_helper.py").write_text("NAME = 'me'\n")
    file = write(manager, "User")
    file.write_text("from rtkit_test_helper import NAME\n" + file.read_text())
    manager.ok(f"rtmgr -c User{place} {MANAGER}")
