"""Known hosts: which key is taken, and what is said of all others."""

from __future__ import annotations

from pathlib import Path

import paramiko
import pytest

from rtkit.errors import Malformed, Refused
from rtkit.hosts.host import Host
from rtkit.hosts.known_hosts import KnownKeys, UnknownKey
from rtkit.hosts.ssh_config import SshRoute

RSA = paramiko.RSAKey.generate(1024)
ONE, OTHER = paramiko.ECDSAKey.generate(), paramiko.ECDSAKey.generate()
HOST = Host("r", "robot")


def _line(names: str, key: paramiko.PKey = ONE, marker: str = "") -> str:
    return f"{marker}{names} {key.get_name()} {key.get_base64()} comment\n"


def _check(folder: Path, text: str, key: paramiko.PKey = ONE, port: int = 22) -> None:
    (folder / "known").write_text(text)
    way = SshRoute("robot", port, "me", (str(folder / "known"), "/nowhere", "/dev/null"))
    KnownKeys(way).check(HOST, key)


@pytest.mark.parametrize("names", ["robot", "x,robot", "ro*", "ROBOT", "{hash}"])
def test_a_key_is_known_by_each_way_to_write_a_name(names: str, tmp_path: Path) -> None:
    hashed = paramiko.HostKeys.hash_host("robot")
    _check(tmp_path, "# so\n\n" + _line(names.format(hash=hashed)))


@pytest.mark.parametrize("names", ["robot,[robot]:2222", "{hash}"])
def test_another_port_is_another_place(names: str, tmp_path: Path) -> None:
    hashed = paramiko.HostKeys.hash_host("[robot]:2222")
    _check(tmp_path, _line(names.replace("{hash}", hashed)), port=2222)
    with pytest.raises(UnknownKey):
        _check(tmp_path, _line("robot"), port=2222)


@pytest.mark.parametrize("names", ["other", "*,!robot", "robot2", "[robot]"])
def test_a_key_of_another_host_is_none_of_this_one(names: str, tmp_path: Path) -> None:
    with pytest.raises(UnknownKey, match="rthost accept r SHA256:"):
        _check(tmp_path, _line(names))


def test_a_revoked_key_is_refused_though_it_is_known(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"revoked \(.*known:2\)"):
        _check(tmp_path, _line("robot") + _line("*", ONE, "@revoked "))


def test_an_authority_is_no_key_of_a_host(tmp_path: Path) -> None:
    with pytest.raises(UnknownKey, match=r"cert-authority in .*known:1 does not count"):
        _check(tmp_path, _line("robot", ONE, "@cert-authority "))


def test_another_key_of_any_type_is_a_changed_one(tmp_path: Path) -> None:
    for other in (OTHER, RSA):
        with pytest.raises(Refused, match="its key has changed") as told:
            _check(tmp_path, _line("robot"), other)
        assert not isinstance(told.value, UnknownKey)


def test_the_type_that_is_known_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "known").write_text(_line("robot", RSA))
    keys = KnownKeys(SshRoute("robot", 22, "me", (str(tmp_path / "known"),)))
    asked = keys.preferred(("ssh-ed25519", "rsa-sha2-256", "ecdsa-sha2-nistp256"))
    assert asked == ("rsa-sha2-256", "ssh-ed25519", "ecdsa-sha2-nistp256")


@pytest.mark.parametrize(
    "line",
    ["robot", "robot ssh-rsa", "robot ssh-rsa !!", "@odd robot ssh-rsa AAAA", "|1|x|y ssh-rsa AA==",
     "robot ssh-rsa AAAA"],
)  # fmt: skip
def test_a_line_that_cannot_be_read_is_told_with_its_number(line: str, tmp_path: Path) -> None:
    with pytest.raises(Malformed, match=r"known:2: cannot be read"):
        _check(tmp_path, f"{_line('robot')}{line}\n")
