"""OpenSSH's configuration: which way to a host it says, and what of it does not count."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rtkit.errors import Malformed, Refused
from rtkit.hosts import ssh_config
from rtkit.hosts.host import host_at
from rtkit.hosts.ssh_config import SshRoute


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home of its own, and a machine without configuration."""
    (tmp_path / ".ssh").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("RTKIT_SSH_CONFIG", raising=False)
    monkeypatch.setenv("SSH_AUTH_SOCK", "/agent")
    monkeypatch.setattr(ssh_config, "SYSTEM_FILE", str(tmp_path / "system" / "ssh_config"))
    return tmp_path


def _way(config: str, address: str = "robot") -> SshRoute:
    Path("~/.ssh/config").expanduser().write_text(config)
    return ssh_config.way_to(host_at("r", address))


def test_files_are_included_where_their_block_counts(home: Path) -> None:
    (home / ".ssh" / "conf.d").mkdir()
    (home / ".ssh" / "conf.d" / "b").write_text("User second\nPort 7\n")
    (home / ".ssh" / "conf.d" / "a").write_text("Host other\nUser x\nHost robot\nUser first\n")
    (home / "port").write_text("Port 9\n")
    config = "Host other\nInclude ~/port\nHost robot\nInclude conf.d/*\nHostName 10.0.0.1\n"
    way = _way(config)
    assert (way.user, way.port, way.address) == ("first", 7, "10.0.0.1")
    assert _way(config, "other").port == 9


def test_a_circle_of_includes_is_told(home: Path) -> None:
    (home / ".ssh" / "a").write_text("Include config\n")
    with pytest.raises(Malformed, match=r"circle.*config > .*/a > "):
        _way("Include a\n")


def test_tokens_stand_for_host_port_user_and_home(home: Path) -> None:
    way = _way(
        "HostName %h.lan\nIdentityFile %d/k_%h_%p_%r\nUserKnownHostsFile ~/a_%h '/b c'\n"
        "CertificateFile ~/c_%r\nHostKeyAlias Key_%h\n",
        "pi@robot:77",
    )
    assert way.identities == (f"{home}/k_robot.lan_77_pi",)
    assert way.known_hosts[:2] == (f"{home}/a_robot.lan", "/b c")
    assert way.certificates == (f"{home}/c_pi",)
    assert way.place == "key_robot.lan"


@pytest.mark.parametrize(
    ("value", "agent"),
    [("none", ""), ("SSH_AUTH_SOCK", "/agent"), ("$OTHER", "/o"), ("~/s", "{home}/s")],
)
def test_an_agent_is_named(
    value: str, agent: str, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OTHER", "/o")
    assert _way(f"IdentityAgent {value}\n").agent == agent.format(home=home)


def test_hosts_in_between_have_settings_of_their_own() -> None:
    way = _way(
        "Host robot\nProxyJump a,me@b:5\nHost b\nProxyJump other\nIdentityFile /kb\n"
        "Host a\nHostName 10.0.0.1\nUser ann\n"
    )
    assert way.through is not None
    assert (way.through.user, way.through.place) == ("me", "[b]:5")
    assert way.through.identities == ("/kb",)
    assert way.through.through is not None
    assert (way.through.through.user, way.through.through.place) == ("ann", "10.0.0.1")
    assert way.through.through.through is None
    with pytest.raises(Malformed, match="more than 8"):
        _way("ProxyJump robot\n")


def test_what_does_not_count_is_named_for_the_host_for_which_it_is_set(home: Path) -> None:
    config = "Host x\nCiphers a\nHost robot\nProxyCommand nc\nSendEnv LANG\nCiphers aes\n"
    assert _way(config).unused == (
        f"ProxyCommand ({home}/.ssh/config:4)",
        f"Ciphers ({home}/.ssh/config:6)",
    )
    assert _way("ProxyCommand none\n").unused == ()


def test_no_command_of_a_match_is_run(home: Path) -> None:
    way = _way(f'Match exec "touch {home}/run"\nUser x\nMatch host robot\nUser y\n')
    assert way.user == "y"
    assert not (home / "run").exists()
    assert "nothing is run" in way.unused[0]


def test_what_matches_in_the_end_comes_last(home: Path) -> None:
    config = "Match final all\nUser late\nPort 7\nMatch !final originalhost robot\nUser first\n"
    way = _way(config)
    assert (way.user, way.port, way.unused) == ("first", 7, ())
    assert _way("Match canonical all\nPort 7\n").port == 22


def test_a_word_of_match_that_is_not_known_is_not_met_and_named(home: Path) -> None:
    for line in ("localnetwork 10.0.0.0/8", "host robot tagged x", "!sessiontype shell"):
        way = _way(f"Match {line}\nPort 7\nHost *\nUser u\n")
        (told,) = way.unused
        assert (way.port, way.user) == (22, "u")
        assert "config:1), which is taken for not met" in told


def test_a_match_that_makes_no_sense_is_told_with_its_line(home: Path) -> None:
    with pytest.raises(Malformed, match=r"config:2: Missing parameter"):
        _way("Port 7\nMatch host\nPort 8\n")


def test_the_file_of_the_machine_comes_last(home: Path) -> None:
    (home / "system").mkdir()
    (home / "system" / "ssh_config").write_text("Include more\nUser no\n")
    (home / "system" / "more").write_text("User machine\nPort 5\n")
    way = _way("Host other\nUser x\nHost robot\nPort 6\n")
    assert (way.user, way.port) == ("machine", 6)


@pytest.mark.parametrize("line", ["Port x", "Port 70000", "Hostname", "Host 'a"])
def test_what_makes_no_sense_is_refused(line: str) -> None:
    with pytest.raises(Malformed):
        _way(f"{line}\n")


def test_a_file_that_others_may_write_is_refused(home: Path) -> None:
    file = home / ".ssh" / "config"
    file.touch()
    file.chmod(0o666)
    with pytest.raises(Refused):
        _way("User x\n")


def test_the_library_of_ssh_leaves_out_what_is_never_run() -> None:
    program = (
        "import sys; import rtkit.hosts.connection; idle = {'invoke', 'asyncio', 'unittest'};"
        "print(*idle & {*sys.modules}); import invoke; import paramiko;"
        "print(paramiko.config.invoke)"
    )
    told = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert told == "\nNone\n"
