"""Packages of another host: pushed over SSH, listed, used, removed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import jsonrecords
import pytest
from farkit import FarHost, far_hosts
from fleetkit import NEEDS_HOSTS, linked
from forked import Commands
from shells import Shell
from wheelkit import made

pytestmark = NEEDS_HOSTS
FAR = "/root/.local/share/rtkit/packages"


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FarHost]:
    with far_hosts(tmp_path_factory.mktemp("far"), "robot1") as hosts:
        yield hosts[0]


@pytest.fixture(scope="module")
def fleet(commands: Commands, host: FarHost) -> Iterator[Shell]:
    """A shell that is linked to robot1; gain needs another third than loss."""
    with linked(commands, [host]) as shell:
        wheels = Path(shell.folder) / "wheels"
        for version in ("1.0", "2.0"):
            made(wheels, "third", version, {"third.py": f"VERSION = {version!r}\n"})
        made(wheels, "gain", "1.0", type="Gain", requires=("third<2",))
        made(wheels, "loss", "1.0", type="Loss", requires=("third==2.0",))
        made(wheels, "lack", "1.0", type="Lack", requires=("pytest",))
        shell.environment["RTKIT_REPOSITORIES"] = str(wheels)
        shell.environment["XDG_DATA_HOME"] = str(Path(shell.folder) / "data")
        yield shell


def test_packages_are_pushed_used_and_removed(fleet: Shell, host: FarHost) -> None:
    assert fleet.ok("rtpkg list --host robot1") == ""
    for _ in range(2):  # again changes nothing
        told = fleet.ok("rtpkg install --host robot1 gain 'loss<2' --json")
        assert [each["place"] for each in jsonrecords.checked(told)] == [
            f"robot1:{FAR}/gain/1.0",
            f"robot1:{FAR}/loss/1.0",
        ]
    for name, version in (("gain", "1.0"), ("loss", "2.0")):
        assert host.read(f"{FAR}/{name}/1.0/third.py") == f"VERSION = '{version}'\n"
    assert fleet.ok("rtpkg list") == ""
    fleet.ok("rtmgr /robot1/manager.mgr -c 'RTC:me:test:Gain:Python:1.0?instance_name=g'")
    assert "Version        1.0" in fleet.ok("rtcat /robot1/g.rtc")
    refused = fleet.run("rtpkg uninstall --host robot1 gain")
    assert (refused.status, "robot1: gain==1.0 is in use by manager" in refused.err) == (1, True)
    assert fleet.ok("rtpkg list --host robot1").count("gain") > 0
    fleet.ok("rtexit /robot1/g.rtc")
    fleet.ok(refused.err.partition(" (")[2].partition(" unloads it")[0])
    told = fleet.ok("rtpkg uninstall --host robot1 gain loss")
    assert told == "robot1: gain==1.0, loss==1.0 removed\n"
    assert fleet.ok("rtpkg list --host robot1") == ""


def test_the_signer_of_what_a_host_has_is_shown(fleet: Shell, host: FarHost) -> None:
    fleet.ok("rtkeys init --name ann")
    wheels = Path(fleet.folder) / "wheels"
    third = made(wheels, "third", "3.0", {"third.py": ""})
    gain = made(wheels, "high", "1.0", type="High", requires=("third==3.0",))
    fleet.ok(f"rtpkg sign {gain}")
    fleet.ok("rtpkg install --host robot1 high")
    assert "signed by" not in fleet.ok("rtpkg list --host robot1")  # what it needs is not
    fleet.ok("rtpkg uninstall --host robot1 high")
    fleet.ok(f"rtpkg sign {third}")
    fleet.ok("rtpkg install --host robot1 high")
    assert fleet.ok("rtpkg list --host robot1").endswith("signed by ann\n")
    kept = f"{FAR}/high/1.0/.wheels/{gain.name}"
    host.run("python3", "-c", f"open({kept!r}, 'ab').write(b'#')")
    assert "signed by" not in fleet.ok("rtpkg list --host robot1")
    fleet.ok("rtpkg uninstall --host robot1 high")


def test_a_host_without_room_or_cut_off_keeps_nothing(fleet: Shell, host: FarHost) -> None:
    fill = "f = open('/root/big', 'wb', 0)\nwhile f.write(bytes(1 << 20)): pass"
    host.run("python3", "-c", f"try:\n exec({fill!r})\nexcept OSError: pass")
    refused = fleet.run("rtpkg install --host robot1 gain")
    host.run("rm", "/root/big")
    assert (refused.status, "robot1: " in refused.err) == (1, True)
    assert "No space left on device" in refused.err
    assert fleet.ok("rtpkg list --host robot1") == ""
    host.link("down")
    refused = fleet.run("rtpkg install --host robot1 loss")
    host.link("up")
    assert (refused.status, "robot1 (" in refused.err) == (1, True)
    for done in ("installed", "there already"):
        assert fleet.ok("rtpkg install --host robot1 loss") == f"robot1: loss==1.0 {done}\n"
    fleet.ok("rtpkg uninstall --host robot1 --force loss")


def test_what_cannot_be_pushed_is_told_and_leaves_nothing(fleet: Shell) -> None:
    for name, why in (
        ("lack", "robot1: no repository has pytest for cp3"),  # which this Python has
        ("none", "robot1: no repository has none for cp3"),
        ("third==2.0", "robot1: third 2.0 is no package of components: no entry point"),
    ):
        refused = fleet.run(f"rtpkg install --host robot1 {name}")
        assert (refused.status, why in refused.err) == (1, True), refused.err
    assert "no such host: robot9" in fleet.run("rtpkg list --host robot9").err
    assert fleet.run("rtpkg install --host robot1 --lock x gain").status == 2
    assert fleet.ok("rtpkg list --host robot1") == ""
