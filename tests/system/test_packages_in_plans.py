"""Plans with install steps: shown, carried out, taken back; from folders and bundles."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from wheelkit import MODULE, made

SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:pair:1" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00"
 rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts">
{components}</rts:RtsProfile>
"""
COMPONENT = """<rts:Components rts:id="RTC:me:test:{type}:{version}" rts:isRequired="true"
 rts:instanceName="{name}" rts:pathUri="localhost/{name}.rtc" rts:compositeType="None"/>
"""
BOTH = (("Gain", "1.0", "g"), ("Loss", "1.0", "l"))
"""Types of two packages that need versions of a third that exclude each other."""


def profile(folder: Path, *components: tuple[str, str, str]) -> str:
    told = (COMPONENT.format(type=t, version=v, name=n) for t, v, n in components)
    (folder / "pair.xml").write_text(SYSTEM.format(components="".join(told)))
    return "pair.xml"


@pytest.fixture
def wheels(manager: Any, tmp_path: Path) -> Path:
    """A repository that the settings name: gain needs third<2, loss needs third 2."""
    folder = tmp_path / "wheels"
    manager.environment["XDG_DATA_HOME"] = str(tmp_path / "data")
    manager.environment["RTKIT_REPOSITORIES"] = str(folder)
    manager.ok("rtmgr stop")
    manager.ok("rtmgr start")
    for version in ("1.0", "2.0"):
        made(folder, "third", version, {"third.py": f"VERSION = {version!r}\n"})
    made(folder, "gain", "1.0", type="Gain", requires=("third<2",))
    made(folder, "loss", "1.0", type="Loss", requires=("third==2.0",))
    return folder


def steps(manager: Any, file: str) -> list[str]:
    return [each["text"] for each in json.loads(manager.ok(f"rtplan --json {file}"))["steps"]]


def test_packages_that_need_versions_of_a_third_are_planned_and_installed(
    manager: Any, wheels: Path, tmp_path: Path
) -> None:
    file = profile(manager.folder, *BOTH)
    assert steps(manager, file)[:2] == [
        "install gain==1.0 on localhost",
        "install loss==1.0 on localhost",
    ]
    assert manager.ok("rtpkg list") == ""  # a plan installs nothing
    manager.ok(f"rtplan --out saved.plan {file}")
    assert manager.run("rtapply saved.plan").status == 0
    manager.ok(f"rtcheck {file}")
    data = tmp_path / "data/rtkit/packages"
    found = {each.read_text() for each in data.glob("*/*/third.py")}
    assert found == {"VERSION = '1.0'\n", "VERSION = '2.0'\n"}
    assert steps(manager, file) == []
    # All in one file, for a machine that knows no repository.
    manager.ok(f"rtpkg bundle {file}")
    manager.ok(f"rtteardown --exit {file}")
    manager.ok("rtpkg uninstall gain --force")
    del manager.environment["RTKIT_REPOSITORIES"]
    assert steps(manager, "pair.rtbundle")[0] == "install gain==1.0 on localhost"
    assert "install loss" not in manager.ok("rtplan pair.rtbundle")
    assert manager.run("rtapply pair.rtbundle").status == 0
    manager.ok("rtcheck pair.rtbundle")


def test_why_a_package_cannot_be_installed_is_told_before_anything_is_done(
    manager: Any, wheels: Path
) -> None:
    made(wheels, "odd", "1.0", type="Odd", requires=("third==2.0", "gain==1.0"))
    file = profile(manager.folder, BOTH[0], ("Odd", "1.0", "o"))
    refused = manager.run(f"rtapply {file}")
    assert (refused.status, "conflict: " in refused.err, "third" in refused.err) == (1, True, True)
    assert manager.ok("rtpkg list") == ""
    file = profile(manager.folder, ("Lack", "1.0", "k"))
    refused = manager.run(f"rtplan {file}")
    assert (refused.status, "RTC:me:test:Lack:1.0" in refused.err) == (1, True)
    manager.environment["RTKIT_REPOSITORIES"] = str(wheels / "none")
    refused = manager.run(f"rtplan {file}")
    assert (refused.status, f"no such repository: {wheels / 'none'}" in refused.err) == (1, True)


def test_a_step_that_fails_takes_the_packages_along_on_the_way_back(
    manager: Any, wheels: Path
) -> None:
    source = f"{MODULE}    raise ValueError('no more')\n"
    made(wheels, "broken", "1.0", type="Broken", source=source)
    file = profile(manager.folder, BOTH[0], ("Broken", "1.0", "b"))
    done = manager.run(f"rtapply --rollback {file}")
    assert done.status == 1
    assert "no more" in done.err
    assert "everything is as it was before" in done.err
    assert manager.ok("rtpkg list") == ""
    assert "g.rtc" not in manager.ok("rtls /localhost")


def test_a_saved_plan_refuses_wheels_that_have_changed(manager: Any, wheels: Path) -> None:
    file = profile(manager.folder, BOTH[0])
    manager.ok(f"rtplan --out saved.plan {file}")
    made(wheels, "third", "1.0", {"third.py": "VERSION = 'other'\n"})
    refused = manager.run("rtapply saved.plan")
    assert (refused.status, "component g would be made otherwise" in refused.err) == (1, True)
    assert manager.ok("rtpkg list") == ""


def test_what_a_system_needs_no_longer_is_uninstalled(manager: Any, wheels: Path) -> None:
    def listed() -> list[str]:
        return [" ".join(each.split()[:2]) for each in manager.ok("rtpkg list").splitlines()]

    made(wheels, "gain", "2.0", type="Gain")
    made(wheels, "mine", "1.0", type="Mine")
    manager.ok("rtpkg install mine")  # what a user has installed is the user's
    file = profile(manager.folder, *BOTH)
    assert manager.run(f"rtapply {file}").status == 0
    other = (manager.folder / file).read_text()
    other = other.replace("me:pair", "me:other").replace('"g"', '"og"').replace("/g.rtc", "/og.rtc")
    (manager.folder / "other.xml").write_text(other.replace('"l"', '"ol"').replace("/l.", "/ol."))
    assert manager.run("rtapply other.xml").status == 0
    manager.ok("rtteardown --exit other.xml")
    profile(manager.folder, BOTH[0])
    # Another system needs it, too, though it does not run.
    assert not [each for each in steps(manager, f"--prune {file}") if "uninstall" in each]
    (wheels.parent / "data/rtkit/packages/loss/1.0/.rtkit-systems.json").write_text(
        json.dumps(["RTSystem:me:pair:1"])
    )
    # Without --prune its component stays, and so does the package.
    assert steps(manager, file) == []
    assert steps(manager, f"--prune {file}")[-1] == "uninstall loss==1.0 from localhost"
    assert manager.run(f"rtapply --prune {file}").status == 0
    assert listed() == ["gain 1.0", "mine 1.0"]
    (wheels.parent / "data/rtkit/packages/gain/1.0/.rtkit-systems.json").write_text(
        json.dumps(["RTSystem:me:pair:1"])
    )
    profile(manager.folder, ("Gain", "2.0", "g"))
    assert manager.run(f"rtapply --replace {file}").status == 0
    assert "Version        2.0" in manager.ok("rtcat /localhost/g.rtc")
    assert listed() == ["gain 2.0", "mine 1.0"]
    assert steps(manager, file) == []
