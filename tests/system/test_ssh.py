"""SSH to other hosts: keys of hosts and of users, hosts in between, clocks, with real sshd."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import jsonrecords
import pytest
from farkit import FarHost, far_hosts
from fleetkit import NEEDS_HOSTS
from shells import Shell
from terminal import opened

from rtkit.hosts.connection import connect
from rtkit.hosts.host import Host

pytestmark = NEEDS_HOSTS


@pytest.fixture(scope="module")
def far(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FarHost]:
    with far_hosts(tmp_path_factory.mktemp("far"), "robot1") as (host,):
        host.run("ssh-keygen", "-q", "-t", "ecdsa", "-N", "", "-f", "/root/ecdsa")
        host.sshd(2201, "PubkeyAuthentication=no", "KbdInteractiveAuthentication=yes")
        host.sshd(2202, "HostKey=/root/ecdsa", "LogLevel=DEBUG1")
        host.sshd(2203, key="/root/ecdsa")
        yield host


@pytest.fixture
def me(shell: Shell, far: FarHost) -> Shell:
    """A shell of a user with a key, who knows the key of the host at all its ports."""
    home = shell.folder / "home"
    (home / ".ssh").mkdir(parents=True, mode=0o700)
    (home / ".ssh" / "id_ed25519").write_bytes(far.key.read_bytes())
    (home / ".ssh" / "id_ed25519").chmod(0o600)
    key = " ".join((far.folder / "hostkey.pub").read_text().split()[:2])
    names = ",".join([far.address, *(f"[{far.address}]:{port}" for port in (2201, 2202, 2203))])
    (home / ".ssh" / "known_hosts").write_text(f"{names} {key}\n")
    shell.environment["HOME"] = str(home)
    for name in ("XDG_CONFIG_HOME", "SSH_AUTH_SOCK"):
        shell.environment.pop(name, None)
    shell.ok(f"rthost add robot1 root@{far.address}")
    return shell


def _config(shell: Shell, text: str) -> None:
    (shell.folder / "home" / ".ssh" / "config").write_text(text)


def _known(shell: Shell) -> Path:
    return shell.folder / "home" / ".ssh" / "known_hosts"


def test_a_host_is_known_by_the_type_of_key_that_is_known(me: Shell, far: FarHost) -> None:
    kind, data = far.run("cat", "/root/ecdsa.pub").split()[:2]
    _known(me).write_text(f"[{far.address}]:2202 {kind} {data}\n")
    me.ok(f"rthost add both root@{far.address}:2202")
    me.ok("rthost check both")


def test_somebody_in_between_is_refused_and_learns_nothing(me: Shell, far: FarHost) -> None:
    me.ok(f"rthost add mallory root@{far.address}:2203")
    told = me.run("rthost check mallory").err
    assert "its key has changed: ecdsa-sha2-nistp256 SHA256:" in told
    shown = re.findall(r"SHA256:[^ ,]+", told)[0]
    before = _known(me).read_bytes()
    assert "its key has changed" in me.run(f"rthost accept mallory {shown}").err
    assert _known(me).read_bytes() == before
    assert "its key has changed" in me.run("rtmgr start --host mallory").err
    me.ok("rtmgr stop")


def test_a_revoked_key_is_refused(me: Shell) -> None:
    line = _known(me).read_text()
    _known(me).write_text(f"{line}@revoked * {line.split(' ', 1)[1]}")
    assert "its key is revoked" in me.run("rthost check robot1").err


def test_a_key_is_accepted_once_hashed_and_on_a_line_of_its_own(me: Shell, far: FarHost) -> None:
    _config(me, "HashKnownHosts yes\n")
    _known(me).write_text("# no line end")
    command = me.run("rthost check robot1").err.strip().rpartition("if that is it: ")[2]
    me.ok(command)
    me.ok(command)
    first, *lines = _known(me).read_text().splitlines()
    assert first == "# no line end"
    assert [line[:3] for line in lines] == ["|1|"]
    me.ok("rthost check robot1")


def test_the_way_goes_over_hosts_in_between(me: Shell, far: FarHost) -> None:
    _config(
        me,
        f"Host inner\nHostName {far.address}\nPort 2202\nProxyJump outer,middle\n"
        f"Host outer\nHostName {far.address}\nHost middle\nHostName 127.0.0.1\n"
        "HostKeyAlias mid\nHost *\nUser root\nCiphers aes128-ctr\n",
    )
    me.ok("rthost add deep inner")
    told = me.run("rthost check deep").err
    assert "the key of mid is not known" in told
    assert told.count("does not count: Ciphers") == 1
    _config(me, (me.folder / "home/.ssh/config").read_text().replace("Ciphers", "# Ciphers"))
    me.ok(told.strip().rpartition("if that is it: ")[2])
    assert "Host name    robot1" in me.ok("rthost check deep")


def test_what_keeps_a_user_out_is_told(me: Shell, far: FarHost) -> None:
    me.ok(f"rthost add passwords root@{far.address}:2201")
    assert "takes no keys, but only" in me.run("rthost check passwords").err
    me.ok(f"rthost add stranger nobody@{far.address}")
    assert "user nobody is not let in: it takes none" in me.run("rthost check stranger").err
    _config(me, "IdentityFile ~/.ssh/gone\n")
    told = me.run("rthost check robot1").err
    assert "there is no key to try; no such key file: " in told
    _config(me, "IdentityAgent ~/gone\n")
    me.ok("rthost check robot1")


def test_a_key_with_a_passphrase_is_taken_from_the_agent_only(me: Shell, tmp_path: Path) -> None:
    key = me.folder / "home" / ".ssh" / "id_ed25519"
    agent = tmp_path / "agent"
    process = subprocess.Popen(["ssh-agent", "-D", "-a", str(agent)], stdout=subprocess.DEVNULL)
    try:
        environment = os.environ | {"SSH_AUTH_SOCK": str(agent)}
        while not agent.exists():
            assert process.poll() is None
        subprocess.run(["ssh-add", "-q", str(key)], env=environment, check=True)
        subprocess.run(["ssh-keygen", "-q", "-p", "-N", "secret", "-f", str(key)], check=True)
        told = me.run("rthost check robot1").err
        assert f"{key} has a passphrase and no agent holds it: ssh-add {key}" in told
        _config(me, f"IdentityAgent {agent}\n")
        me.ok("rthost check robot1")
    finally:
        process.terminate()
        process.wait()


def test_a_passphrase_is_asked_for_once_and_its_refusal_told_for_each_host(
    me: Shell, far: FarHost
) -> None:
    key = me.folder / "home" / ".ssh" / "id_ed25519"
    subprocess.run(["ssh-keygen", "-q", "-p", "-N", "secret", "-f", str(key)], check=True)
    me.ok(f"rthost add robot2 root@{far.address}")
    for typed in ("wrong\n", "\x04", "secret\n"):
        with opened(me.command("rthost check"), me.environment, me.folder) as terminal:
            terminal.until(f"Passphrase of {key}: ")
            terminal.type(typed)
            told = terminal.rest()
        assert "Passphrase" not in told
        assert "\x1b" not in told
        assert told.count(f"that is not the passphrase of {key}") == 2 * (typed != "secret\n")
        assert told.count("Host name    robot1") == 2 * (typed == "secret\n")


def test_the_first_question_on_a_connection_waits_for_no_late_acknowledgement(
    me: Shell, far: FarHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", me.environment["HOME"])
    host = Host("robot1", far.address, "root")
    pings = []
    for _ in range(5):
        with connect(host) as connection:
            pings.append(connection.ping())
    assert min(pings) < 0.03


def test_the_clock_of_a_host_is_told_within_its_bound(me: Shell, far: FarHost) -> None:
    far.run("mkdir", "-p", "/root/skew")
    program = "import time; real = time.time; time.time = lambda: real() + 30"
    far.run("sh", "-c", f"echo '{program}' > /root/skew/sitecustomize.py")
    line = '#!/bin/sh\\nPYTHONPATH=/root/skew exec python3 "$@"\\n'
    far.run("sh", "-c", f"printf '{line}' > /root/ahead; chmod 755 /root/ahead")
    me.ok(f"rthost add ahead root@{far.address} --python /root/ahead")
    (record,) = jsonrecords.checked(me.ok("rthost check ahead --json"))
    assert abs(record["clock_offset_s"] - 30) <= record["clock_bound_s"] + 1e-4
    assert 0 < record["clock_bound_s"] < 0.015
    assert "+30.0" in me.ok("rthost check ahead")
    assert "Clock        -0.0000 s" not in me.ok("rthost check robot1")


def test_silent_hosts_cost_one_time_out_together(me: Shell, far: FarHost) -> None:
    text = "".join(f'[silent{n}]\naddress = "{far.address}:24{n:02}"\n' for n in range(5))
    (me.folder / "hosts.toml").write_text(
        text + "".join(f'[live{n}]\naddress = "root@{far.address}"\n' for n in range(3))
    )
    far.run("sh", "-c", _LISTENERS)
    began = time.monotonic()
    told = me.run("rthost check --timeout 2 --json")
    assert time.monotonic() - began < 6.0
    assert re.findall(r"(silent\d) .*no answer in time", told.err) == [
        f"silent{n}" for n in range(5)
    ]
    names = [each["name"] for each in jsonrecords.checked(told.out)]
    assert names == ["live0", "live1", "live2", "robot1"]


_LISTENERS = """exec setsid python3 -c '
import os, socket
held = [socket.create_server(("", 2400 + n)) for n in range(5)]
if os.fork(): os._exit(0)
os.closerange(0, 3)
import signal; signal.pause()
'"""


def test_what_is_no_ssh_server_is_told_in_words_of_the_user(me: Shell) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def hang_up() -> None:
            listener.accept()[0].close()

        thread = threading.Thread(target=hang_up)
        thread.start()
        port = listener.getsockname()[1]
        me.ok(f"rthost add web 127.0.0.1:{port}")
        told = me.run("rthost check web")
        thread.join()
    me.ok("rthost remove web")
    why = "no SSH server answers there, or it hung up at once"
    assert told.err == f"rthost check: web ([127.0.0.1]:{port}): {why}\n"
    assert told.status == 1


def test_two_who_add_at_once_lose_nothing(me: Shell) -> None:
    file = me.folder / "home" / ".config" / "rtkit" / "hosts.toml"
    file.write_text(f"# mine\n{file.read_text()}")
    program = str(Path(sys.executable).with_name("rthost"))
    environment = os.environ | me.environment
    adding = [
        subprocess.Popen([program, "add", f"many{n}", f"10.0.0.{n}"], env=environment)
        for n in range(1, 7)
    ]
    assert [each.wait() for each in adding] == [0] * 6
    text = file.read_text()
    assert text.startswith("# mine\n")
    assert all(f"[many{n}]" in text for n in range(1, 7))
    assert me.run(f"rthost add {os.uname().nodename} x").status == 1
    assert me.run("rthost add Motor0.rtc x").status == 1
