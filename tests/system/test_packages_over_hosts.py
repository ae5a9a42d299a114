"""Plans that install on other hosts: shown, pushed, taken back, uninstalled, gone on with."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, accept_key, give_home, hosts_named
from forked import Commands
from shells import Shell, opened_shell
from wheelkit import MODULE, made

pytestmark = NEEDS_HOSTS
FAR = "/root/.local/share/rtkit/packages"
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:pair:1" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00"
 rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts">
{components}</rts:RtsProfile>
"""
COMPONENT = """<rts:Components rts:id="RTC:me:test:{type}:{version}" rts:isRequired="true"
 rts:instanceName="{name}" rts:pathUri="{host}/{name}.rtc" rts:compositeType="None"/>
"""
BOTH = (("Gain", "1.0", "localhost"), ("Loss", "1.0", "robot1"))
"""Types of two packages that need versions of a third that exclude each other, on two hosts."""


hosts = hosts_named("robot1")


@pytest.fixture
def shell(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell that knows robot1, which sees no repository, and has no manager."""
    with opened_shell(commands) as shell:
        give_home(shell, hosts)
        shell.environment["XDG_DATA_HOME"] = str(shell.folder / "data")
        shell.environment["RTKIT_REPOSITORIES"] = str(shell.folder / "wheels")
        shell.ok(f"rthost add robot1 root@{hosts[0].address}")
        accept_key(shell, "robot1")
        yield shell
        shell.run("rtmgr stop --host robot1")
        shell.run("rtmgr stop")
        hosts[0].run("rm", "-rf", FAR)


@pytest.fixture
def wheels(shell: Shell) -> Path:
    """A repository of this host: gain needs third<2, loss needs third 2."""
    folder = shell.folder / "wheels"
    for version in ("1.0", "2.0"):
        made(folder, "third", version, {"third.py": f"VERSION = {version!r}\n"})
    made(folder, "gain", "1.0", type="Gain", requires=("third<2",))
    made(folder, "loss", "1.0", type="Loss", requires=("third==2.0",))
    return folder


def profile(shell: Shell, *components: tuple[str, str, str]) -> str:
    """Write a system of components, each of a type, a version and a host."""
    told = (
        COMPONENT.format(type=type, version=version, host=host, name=type.lower())
        for type, version, host in components
    )
    (shell.folder / "pair.xml").write_text(SYSTEM.format(components="".join(told)))
    return "pair.xml"


def steps(shell: Shell, words: str) -> list[str]:
    done = shell.run(f"rtplan --json {words}")
    assert done.status == 0, done.err
    return [each["text"] for each in json.loads(done.out)["steps"]]


def installed(shell: Shell) -> list[str]:
    """Return what is installed there, as ``rtpkg`` shows it."""
    rows = shell.ok("rtpkg list --host robot1").splitlines()
    return [" ".join(each.split()[:2]) for each in rows]


def test_what_a_host_lacks_is_planned_pushed_and_used(
    shell: Shell, wheels: Path, hosts: list[FarHost]
) -> None:
    file = profile(shell, *BOTH)
    assert steps(shell, file)[:2] == [
        "install gain==1.0 on localhost",
        "install loss==1.0 on robot1",
    ]
    assert shell.run(f"rtapply {file}").status == 0
    assert installed(shell) == ["loss 1.0"]
    assert shell.ok("rtpkg list").split()[:2] == ["gain", "1.0"]
    assert hosts[0].read(f"{FAR}/loss/1.0/third.py") == "VERSION = '2.0'\n"
    assert steps(shell, file) == []
    shell.ok(f"rtcheck {file}")
    # What is there already is not pushed again, whether or not a manager runs there.
    shell.ok(f"rtteardown --exit {file}")
    assert not [each for each in steps(shell, file) if "install" in each]
    shell.ok("rtmgr stop --host robot1")
    assert not [each for each in steps(shell, file) if "install" in each]
    assert shell.run(f"rtapply {file}").status == 0
    assert shell.run(f"rtteardown --uninstall {file}").status == 2
    shown = shell.ok(f"rtteardown --exit --uninstall --dry-run {file}").splitlines()[-2:]
    assert shown == ["uninstall gain==1.0 from localhost", "uninstall loss==1.0 from robot1"]
    for _ in range(2):  # again changes nothing
        assert shell.run(f"rtteardown --exit --uninstall {file}").status == 0
        assert (shell.ok("rtpkg list"), installed(shell)) == ("", [])


def test_a_host_that_cannot_be_asked_is_named_before_anything_is_done(
    shell: Shell, wheels: Path, hosts: list[FarHost]
) -> None:
    file = profile(shell, *BOTH)
    hosts[0].link("down")
    planned, refused = shell.run(f"rtplan {file}"), shell.run(f"rtapply {file}")
    hosts[0].link("up")
    assert "install loss==1.0 on robot1" in planned.out
    assert "which packages robot1 has is not known: robot1 (" in planned.err
    assert (refused.status, "robot1 (" in refused.err) == (1, True)
    assert shell.ok("rtpkg list") == ""


def test_a_package_that_is_there_chooses_the_host(shell: Shell, wheels: Path) -> None:
    """A component that may be anywhere goes where nothing is to be installed, if it can."""
    file = profile(shell, ("Loss", "1.0", "*"))
    shell.ok("rtmgr start --host robot1")
    assert "install loss==1.0 on localhost" in steps(shell, file)
    text = (shell.folder / file).read_text()
    required = '<rtsExt:Properties rtsExt:name="rtkit.place.hosts" rtsExt:value="robot1"/>'
    there = text.replace('"None"/>', f'"None">{required}</rts:Components>').replace(
        " rts:updateDate",
        ' xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext" rts:updateDate',
    )
    (shell.folder / "there.xml").write_text(there)
    assert "install loss==1.0 on robot1" in steps(shell, "there.xml")
    shell.ok("rtpkg install --host robot1 loss")
    assert not any("install" in each for each in steps(shell, file))
    assert shell.run(f"rtapply {file}").status == 0
    assert "Version        1.0" in shell.ok("rtcat /robot1/loss.rtc")
    assert steps(shell, file) == []


@pytest.mark.timeout(240)  # rtkit is made on a bare host, and pip asked, on a busy machine
def test_a_bundle_brings_hosts_up_without_a_repository(shell: Shell, wheels: Path) -> None:
    file = profile(shell, *BOTH)
    shell.ok("rtmgr start --host robot1")
    shell.ok("rtpkg install gain loss")
    shell.ok(f"rtpkg bundle {file} -o pair.rtbundle")
    shell.ok("rtpkg uninstall gain loss")
    del shell.environment["RTKIT_REPOSITORIES"]
    assert "install loss==1.0 on robot1" in steps(shell, "pair.rtbundle")
    assert shell.run("rtapply pair.rtbundle").status == 0
    assert installed(shell) == ["loss 1.0"]
    shell.ok("rtcheck pair.rtbundle")
    shell.ok("rtteardown --exit --uninstall pair.rtbundle")
    assert shell.run("rtresurrect pair.rtbundle").status == 0
    shell.ok("rtcheck pair.rtbundle")


def test_a_step_that_fails_takes_far_packages_along_on_the_way_back(
    shell: Shell, wheels: Path
) -> None:
    source = f"{MODULE}    raise ValueError('no more')\n"
    made(wheels, "broken", "1.0", type="Broken", source=source)
    shell.ok("rtmgr start --host robot1")
    file = profile(shell, BOTH[1], ("Broken", "1.0", "robot1"))
    done = shell.run(f"rtapply --rollback {file}")
    assert (done.status, "no more" in done.err) == (1, True)
    assert "everything is as it was before" in done.err
    assert installed(shell) == []


def test_what_a_system_needs_no_longer_there_is_uninstalled(shell: Shell, wheels: Path) -> None:
    made(wheels, "loss", "2.0", type="Loss")
    assert shell.run(f"rtapply {profile(shell, *BOTH)}").status == 0
    file = profile(shell, BOTH[0], ("Loss", "2.0", "robot1"))
    assert "uninstall loss==1.0 from robot1" in steps(shell, f"--replace {file}")
    assert shell.run(f"rtapply --replace {file}").status == 0
    assert installed(shell) == ["loss 2.0"]
    assert "Version        2.0" in shell.ok("rtcat /robot1/loss.rtc")
    assert steps(shell, file) == []
    # What is installed here needs no repository to be pushed.
    shell.ok(f"rtteardown --exit {file}")
    del shell.environment["RTKIT_REPOSITORIES"]
    file = profile(shell, ("Gain", "1.0", "robot1"))
    assert shell.run(f"rtapply --prune {file}").status == 0
    assert installed(shell) == ["gain 1.0"]


def test_what_cannot_be_pushed_is_told_before_anything_is_done(shell: Shell, wheels: Path) -> None:
    made(wheels, "lack", "1.0", type="Lack", requires=("pytest",))
    refused = shell.run(f"rtapply {profile(shell, BOTH[0], ('Lack', '1.0', 'robot1'))}")
    assert refused.status == 1
    assert "no repository has pytest for cp3" in refused.err
    assert ", which lack needs" in refused.err
    assert (shell.ok("rtpkg list"), shell.run("rtls /robot1").status) == ("", 1)


def test_wheels_are_planned_for_the_machine_of_each_host(
    shell: Shell, wheels: Path, hosts: list[FarHost]
) -> None:
    """What the host says of its C library decides there, that of this machine here."""
    machine, glibc = platform.machine(), platform.libc_ver()[1].replace(".", "_")
    tags = f"py3-none-manylinux_{glibc}_{machine}"
    made(wheels, "fit", "1.0", type="Fit")
    for name, version in (("fit", "1.1"), ("only", "1.0")):
        source = MODULE.replace("{version}", "1.0")
        new = made(wheels, name, version, type=name.title(), source=source)
        new.rename(wheels / f"{name}-{version}-{tags}.whl")
    old = "import platform\nplatform.libc_ver = lambda: ('glibc', '2.31')"
    hosts[0].run("mkdir", "-p", "/root/old")
    hosts[0].write("/root/old/sitecustomize.py", old)
    hosts[0].write("/root/python", '#!/bin/sh\nPYTHONPATH=/root/old exec python3 "$@"\n')
    hosts[0].run("chmod", "+x", "/root/python")
    shell.ok(f"rthost add --force robot1 root@{hosts[0].address} --python /root/python")
    near, far = (("Fit", "1.0", host) for host in ("localhost", "robot1"))
    assert "install fit==1.1 on localhost" in steps(shell, profile(shell, near))
    file = profile(shell, far)
    assert "robot1/fit==1.0: fit-1.0-py3-none-any.whl\n" in shell.run(f"rtplan -v {file}").err
    refused = shell.run(f"rtapply {profile(shell, BOTH[0], ('Only', '1.0', 'robot1'))}")
    kind = f"for cp3{sys.version_info[1]}-glibc2.31-{machine}"
    assert (refused.status, f"no repository has only==1.0 {kind}" in refused.err) == (1, True)
    assert (shell.ok("rtpkg list"), shell.run("rtls /robot1").status) == ("", 1)
    # What is installed here fits as it is only where the machine is like this one.
    shell.ok("rtpkg install fit")
    assert shell.run(f"rtapply {profile(shell, far)}").status == 0
    assert installed(shell) == ["fit 1.0"]


@pytest.mark.parametrize("point", ["packages.push", "packages.pushed"])
def test_killed_while_it_installs_it_goes_on(
    shell: Shell, wheels: Path, tmp_path: Path, point: str
) -> None:
    tmp_path.chmod(0o700)
    (tmp_path / "orders").write_text(f"{point} 1 kill\n")
    file = profile(shell, *BOTH)
    shell.environment["RTKIT_FAULT"] = str(tmp_path)
    assert shell.run(f"rtapply {file}").status == -9
    del shell.environment["RTKIT_FAULT"]
    there = point == "packages.pushed"
    assert ("install loss==1.0 on robot1" in steps(shell, file)) != there
    assert shell.run(f"rtapply {file}").status == 0
    assert installed(shell) == ["loss 1.0"]
    shell.ok(f"rtcheck {file}")
    shell.ok(f"rtteardown --exit --uninstall {file}")
    assert not list((shell.folder / "data/rtkit/packages/.drafts").iterdir())
