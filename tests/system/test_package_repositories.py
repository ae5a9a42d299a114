"""Packages from folder, simple index and git repository: installed, side by side, used, removed."""

from __future__ import annotations

import functools
import subprocess
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from wheelkit import made

MANAGER = "/localhost/manager.mgr"


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture
def index(tmp_path: Path) -> Iterator[tuple[str, Path]]:
    """A simple index that a real server serves, and its folder of the package gain."""
    folder = tmp_path / "index" / "gain"
    folder.mkdir(parents=True)
    handler = functools.partial(_Quiet, directory=str(folder.parent))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/", folder
        server.shutdown()


@pytest.fixture(autouse=True)
def _own_data(shell: Any, tmp_path: Path) -> None:
    shell.environment["XDG_DATA_HOME"] = str(tmp_path / "data")


def test_a_folder_is_built_published_found_and_installed(shell: Any) -> None:
    assert shell.run("rtnew Scale --vendor me").status == 0
    (built,) = jsonrecords.checked(shell.ok("rtpkg build Scale -o out --json"))
    assert built["types"] == ["RTC:me:Misc:Scale:1.0.0"]
    (shell.folder / "wheels").mkdir()
    for _ in range(2):  # again changes nothing
        shell.ok(f"rtpkg publish {built['place']} wheels")
    assert "Scale" in shell.ok("rtpkg search scale --repository wheels")
    assert shell.run("rtpkg search nothing --repository wheels").status == 1
    (found,) = jsonrecords.checked(shell.ok("rtpkg install rtc-scale --repository wheels --json"))
    assert found["wheels"] == built["wheels"]
    assert jsonrecords.checked(shell.ok("rtpkg list --json")) == [found]
    (shell.folder / "Scale" / "RTC.xml").write_text("<rtcProfile>")
    refused = shell.run("rtpkg build Scale -o other")
    assert "RTC.xml" in refused.err
    assert not list((shell.folder / "other").iterdir())


def test_two_versions_of_a_type_work_at_once_by_their_ids(manager: Any, tmp_path: Path) -> None:
    for version in ("1.0", "2.0"):
        made(tmp_path / "wheels", "gain", version, type="Gain")
    for wanted in ("gain<2", "gain"):
        manager.ok(f"rtpkg install '{wanted}' --repository {tmp_path / 'wheels'}")
    assert [each["version"] for each in jsonrecords.checked(manager.ok("rtpkg list --json"))] == [
        "2.0",
        "1.0",
    ]
    for slave, version in (("a", "1.0"), ("b", "2.0")):
        create = f"RTC:me:test:Gain:Python:{version}?manager_name={slave}&instance_name={slave}"
        manager.ok(f"rtmgr {MANAGER} -c '{create}'")
        assert f"Version        {version}" in manager.ok(f"rtcat /localhost/{slave}.rtc")
    # What rtcryo writes brings back these very versions; an id that is edited chooses another.
    manager.ok("rtcryo --all -o saved.xml")
    saved = (manager.folder / "saved.xml").read_text()
    assert saved.count("RTC:me:test:Gain:Python:1.0?") == saved.count("Gain==1.0:GainInit") == 1
    (manager.folder / "plain.xml").write_text(
        saved.replace("Gain==1.0:", "Gain.py:").replace("RTC:me:test:Gain:Python:1.0?", "Gain?")
    )
    for file in ("saved.xml", "plain.xml"):
        manager.ok("rtteardown --exit saved.xml")
        assert manager.run(f"rtapply {file}").status == 0
        manager.ok(f"rtcheck {file}")
        for name, version in (("a", "1.0"), ("b", "2.0")):
            assert f"Version        {version}" in manager.ok(f"rtcat /localhost/{name}.rtc")
    (manager.folder / "edited.xml").write_text(saved.replace(":Gain:1.0", ":Gain:2.0"))
    manager.ok("rtteardown --exit saved.xml")
    manager.ok("rtresurrect edited.xml")
    assert "Version        2.0" in manager.ok("rtcat /localhost/a.rtc")
    manager.ok("rtteardown --exit edited.xml")
    manager.ok("rtresurrect saved.xml")
    refused = manager.run("rtpkg uninstall gain==1.0")
    assert (refused.status, "in use by manager manager" in refused.err) == (1, True)
    (bundled,) = jsonrecords.checked(manager.ok("rtpkg bundle edited.xml --json"))
    assert (bundled["version"], bundled["place"]) == ("2.0", "edited.rtbundle")
    manager.ok("rtpkg bundle saved.xml")
    manager.ok("rtteardown --exit saved.rtbundle")
    manager.ok("rtpkg uninstall gain --force")
    assert manager.ok("rtpkg list") == ""
    # One file brings it back where nothing is installed, and no repository is named.
    assert manager.run("rtapply saved.rtbundle").status == 0
    manager.ok("rtcheck saved.rtbundle")
    assert manager.ok("rtpkg list").count("gain") > 1
    whole = (manager.folder / "saved.rtbundle").read_bytes()
    (manager.folder / "saved.rtbundle").write_bytes(whole.replace(b"GainInit", b"LossInit"))
    refused = manager.run("rtapply saved.rtbundle")
    assert (refused.status, "is not what was bundled: " in refused.err) == (1, True)


def test_a_lock_refuses_changed_bytes_of_an_index(shell: Any, index: tuple[str, Path]) -> None:
    url, folder = index
    made(folder, "gain", "1.0", type="Gain")
    made(folder, "gain", "3.0", type="Gain")
    asked = f"--repository {url} --lock robot.lock"
    assert [
        each["name"]
        for each in jsonrecords.checked(shell.ok(f"rtpkg search --json --repository {url}"))
    ] == ["gain"] * 2
    shell.ok(f"rtpkg install 'gain>=1,<2' {asked}")
    shell.ok("rtpkg uninstall gain")
    shell.ok(f"rtpkg install {asked}")
    shell.ok("rtpkg uninstall gain")
    made(folder, "gain", "1.0", {"more.py": ""}, type="Gain")
    refused = shell.run(f"rtpkg install {asked}")
    assert (refused.status, "the lock has SHA-256" in refused.err) == (1, True)
    assert shell.ok("rtpkg list") == ""


def test_a_git_repository_is_read_at_a_revision_and_published_to(
    shell: Any, tmp_path: Path
) -> None:
    shell.environment.update(
        {
            f"GIT_{who}_{what}": "a@b"
            for who in ("AUTHOR", "COMMITTER")
            for what in ("NAME", "EMAIL")
        }
    )
    bare, work = tmp_path / "g.git", tmp_path / "work"
    wheel = made(work / "pk", "gain", "1.0", type="Gain")

    def git(*words: str) -> None:
        named = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *named, *words], cwd=work, check=True, capture_output=True)

    git("init", "-q", "--bare", "-b", "main", str(bare))
    git("init", "-q", "-b", "main")
    git("add", ".")
    git("commit", "-q", "-m", "one")
    git("push", "-q", str(bare), "main:main", "main:old")
    place = f"git+file://{bare}"
    shell.ok(f"rtpkg install gain --repository '{place}@old#subdirectory=pk'")
    assert "1.0" in shell.ok("rtpkg list")
    refused = shell.run(f"rtpkg publish {wheel} '{place}#subdirectory=pk'")
    assert "no RTC profile" in refused.err
    left = shell.run(f"rtpkg search --repository '{place}#subdirectory=..'")
    assert "leaves the git repository" in left.err


def test_publishing_begins_an_empty_git_repository(shell: Any, tmp_path: Path) -> None:
    for who in ("AUTHOR", "COMMITTER"):
        shell.environment |= {f"GIT_{who}_NAME": "a", f"GIT_{who}_EMAIL": "a@b"}
    assert shell.run("rtnew Scale --vendor me").status == 0
    (built,) = jsonrecords.checked(shell.ok("rtpkg build Scale -o out --json"))
    for branch, at in (("trunk", ""), ("trunk", "@v1")):
        bare = tmp_path / f"g{at}.git"
        subprocess.run(["git", "init", "-q", "--bare", "-b", branch, bare], check=True)
        place = f"git+file://{bare}{at}#subdirectory=pk/new"
        empty = shell.run(f"rtpkg search --repository '{place}'")
        assert f"nothing is in the git repository yet: {place}" in empty.err
        for _ in range(2):  # again changes nothing
            shell.ok(f"rtpkg publish {built['place']} '{place}'")
        assert "Scale" in shell.ok(f"rtpkg search --repository '{place}'")


def test_a_place_that_does_not_answer_is_named(shell: Any) -> None:
    url = "http://127.0.0.1:9/"
    for words in ("search --repository", "install gain --repository"):
        refused = shell.run(f"rtpkg {words} {url}")
        assert (refused.status, f"no answer of {url}" in refused.err) == (1, True)


def test_conflicts_name_both_sides(shell: Any, tmp_path: Path) -> None:
    wheels = tmp_path / "wheels"
    for version in ("1", "2"):
        made(wheels, "third", version)
    made(wheels, "left", "1", requires=("third<2",))
    made(wheels, "gain", "1", type="Gain", requires=("left", "third>=2"))
    made(wheels, "fine", "1", {"f/F.py": ""}, type="Fine", requires=("third<2",))
    made(wheels, "old", "1", type="Old", requires=("packaging==1.0",))
    made(wheels, "packaging", "1.0")
    refused = shell.run(f"rtpkg install gain --repository {wheels}")
    assert "third>=2" in refused.err
    assert "left 1 depends on third<2" in refused.err
    found = jsonrecords.checked(shell.ok(f"rtpkg install fine --json --repository {wheels}"))
    assert [each["file"].partition("-")[0] for each in found[0]["wheels"]] == ["fine", "third"]
    other = shell.run(f"rtpkg install old --repository {wheels}")
    assert "conflict: old needs packaging 1.0, and the Python of rtkit has" in other.err


def test_hostile_wheels_are_told_and_leave_nothing(shell: Any, tmp_path: Path) -> None:
    wheels = tmp_path / "wheels"
    made(wheels, "gain", "1", {"../../evil.py": ""}, type="Gain")
    made(wheels, "good", "1", type="Good")
    seen = shell.run(f"rtpkg search --repository {wheels}")
    assert (seen.status, "leaves its folder" in seen.err, "good" in seen.out) == (1, True, True)
    refused = shell.run(f"rtpkg install gain --repository {wheels}")
    assert "leaves its folder" in refused.err
    assert not list(tmp_path.rglob("evil.py"))
    assert shell.ok("rtpkg list") == ""
