"""Systems over several hosts: brought up by one profile, saved, stopped, taken down, refused."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import rts_text
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, accept_key, give_home, hosts_named
from forked import Commands
from shells import Shell, opened_shell

pytestmark = NEEDS_HOSTS
TYPE = "RTC:rtkit:example:{}:1.0"
HERE, THERE = "/localhost/In1.rtc", "/robot1/Out1.rtc"


hosts = hosts_named("robot1")


@pytest.fixture
def shell(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell that knows robot1 and has no manager; one there is ended afterwards."""
    with opened_shell(commands) as shell:
        give_home(shell, hosts)
        shell.ok(f"rthost add robot1 root@{hosts[0].address}")
        accept_key(shell, "robot1")
        yield shell
        hosts[0].link("up")
        shell.run("rtmgr stop --host robot1")
        shell.run("rtmgr stop")


def profile(path: Path, far: str = "robot1") -> str:
    """Write a source here, and a sink on another host, which are connected."""
    components = [
        rts_text.component(
            name, {"create": kind}, type_id=TYPE.format(kind), port=port, folder=folder, rate=10.0
        )
        for kind, name, port, folder in (
            ("ConsoleIn", "In1", "out", "localhost"),
            ("ConsoleOut", "Out1", "in", far),
        )
    ]
    types = [TYPE.format(each) for each in ("ConsoleIn", "ConsoleOut")]
    wire = rts_text.wire("w1", "In1.out", "Out1.in", types)
    path.write_text(rts_text.system("Two", *components, wire))
    return str(path)


def states(shell: Shell) -> dict[str, str]:
    """Return the states of all components, by host and name."""
    rows = (line.split() for host in ("/localhost", "/robot1") for line in lines(shell, host))
    return {row[-1]: row[0] for row in rows if row and row[-1].endswith(".rtc")}


def lines(shell: Shell, host: str) -> list[str]:
    return shell.ok(f"rtls -lR {host}").splitlines()


def test_a_profile_brings_hosts_up_and_is_saved_from_them(shell: Shell) -> None:
    file = profile(shell.folder / "two.xml")
    shown = shell.run(f"rtplan {file}")
    assert "start manager manager@robot1" in shown.out
    assert "no link to host robot1" in shown.err
    assert shell.run(f"rtapply {file}").status == 0
    assert states(shell) == {"In1.rtc": "Active", "Out1.rtc": "Active"}
    assert shell.run(f"rtplan --detailed-exitcode {file}").status == 0
    shell.ok(f"rtcheck {file}")

    saved = shell.ok("rtcryo /localhost /robot1")
    assert 'pathUri="robot1/Out1.rtc"' in saved
    assert 'connectorId="w1"' in saved

    assert shell.run(f"rtstop {file}").status == 0
    assert set(states(shell).values()) == {"Inactive"}
    assert shell.run(f"rtstart {file}").status == 0
    assert set(states(shell).values()) == {"Active"}
    assert shell.run(f"rtteardown --exit {file}").status == 0
    assert states(shell) == {}
    (shell.folder / "saved.xml").write_text(saved)
    assert shell.run("rtresurrect saved.xml").status == 0
    assert states(shell).keys() == {"In1.rtc", "Out1.rtc"}
    assert shell.run("rtteardown --exit saved.xml").status == 0


def test_a_host_that_does_not_answer_is_named_and_nothing_is_left(
    shell: Shell, hosts: list[FarHost]
) -> None:
    file = profile(shell.folder / "two.xml")
    hosts[0].link("down")
    refused = shell.run(f"rtapply {file}")
    assert refused.status == 1
    assert "robot1 (" in refused.err
    here = shell.run("rtls /localhost")
    assert (here.status, here.out) == (1, ""), here
    assert "is not running" in here.err
    assert shell.run(f"rtapply --rollback {file}").status == 1


def test_a_component_that_cannot_be_made_there_leaves_nothing_here(shell: Shell) -> None:
    file = Path(profile(shell.folder / "two.xml"))
    file.write_text(file.read_text().replace("ConsoleOut", "Nonsense"))
    shell.ok("rtmgr start --host robot1")
    refused = shell.run(f"rtapply {file}")
    assert refused.status == 1
    assert "Nonsense" in refused.err
    assert states(shell) == {}


def test_a_host_that_nobody_knows_is_named(shell: Shell) -> None:
    refused = shell.run(f"rtapply {profile(shell.folder / 'two.xml', 'robot7')}")
    assert refused.status == 1
    assert "no such host: robot7" in refused.err


def test_a_mapped_host_is_not_asked(shell: Shell) -> None:
    shell.ok("rtmgr start")
    file = profile(shell.folder / "two.xml")
    script = f"rtkit.connect().plan({file!r}, hosts={{'robot1': 'localhost'}}).apply()"
    words = [*shell.prefix, sys.executable, "-c", f"import rtkit; {script}"]
    subprocess.run(words, env=shell.environment, timeout=30, check=True)
    assert [*states(shell)] == ["In1.rtc", "Out1.rtc"]
    assert shell.run(f"rtapply --map robot1=localhost {file}").status == 0
    assert shell.run(f"rtplan --detailed-exitcode --map robot1=localhost {file}").status == 0
    assert "not linked" in shell.ok("rthost list")
