"""Which inventory of hosts counts: the user's, one in the present folder, one beside a profile."""

from __future__ import annotations

from pathlib import Path

import pytest

import rtkit
from rtkit.errors import Malformed, Refused
from rtkit.hosts import inventory, wheels
from rtkit.hosts.host import Host, host_at
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_profile
from rtkit.settings import inventory_files


@pytest.fixture
def profile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A system profile in a folder below, a present folder, and a user, each with an inventory."""
    monkeypatch.setattr(inventory_files, "_beside", [])
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.chdir(tmp_path)
    places = {"config/rtkit": "user", ".": "present", "systems": "beside"}
    for at, (folder, name) in enumerate(places.items()):
        (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        tables = [f'[{each}]\naddress = "{name}"\n' for each in ("a", "b", "c")[: 3 - at]]
        (tmp_path / folder / "hosts.toml").write_text("".join(tables))
    now = "2026-11-28T12:00:00"
    robot = RtsProfile("RTSystem:Acme.Robot:1.0", "0.2", now, now)
    (tmp_path / "systems/robot.xml").write_bytes(write_profile(robot))
    return "systems/robot.xml"


def _addresses() -> dict[str, str]:
    return {name: host.address for name, host in inventory.read().items()}


def test_an_inventory_beside_the_profile_takes_precedence_once_that_is_read(profile: str) -> None:
    assert _addresses() == {"a": "present", "b": "present", "c": "user"}
    rtkit.load(profile)
    assert _addresses() == {"a": "beside", "b": "present", "c": "user"}


def test_an_inventory_that_others_can_write_is_refused_beside_a_profile_too(profile: str) -> None:
    Path("systems/hosts.toml").chmod(0o666)
    rtkit.load(profile)
    with pytest.raises(Refused, match=r"systems/hosts\.toml"):
        inventory.read()


def test_a_name_or_a_tag_with_a_blank_is_refused(profile: str) -> None:
    with pytest.raises(Malformed, match="name of a host has a blank: 'b d'"):
        host_at("b d", "10.0.0.7")
    before = Path("config/rtkit/hosts.toml").read_text()
    for tag in ("a b", "", "-x"):
        with pytest.raises(Malformed, match=f"a tag is one word: '{tag}'"):
            inventory.add(Host("z", "10.0.0.7", tags=("gpu", tag)))
    assert Path("config/rtkit/hosts.toml").read_text() == before
    Path("hosts.toml").write_text('[z]\naddress = "z"\ntags = ["a b"]\n')
    with pytest.raises(Malformed, match=r"hosts\.toml: z: a tag is one word: 'a b'"):
        inventory.read()


def test_extras_of_a_host_are_kept_and_those_that_rtkit_has_not_refused(profile: str) -> None:
    inventory.add(Host("z", "10.0.0.7", extras=("sim",)))
    assert inventory.read()["z"].extras == ("sim",)
    assert any(each.startswith("numpy") for each in wheels.requirements(["sim"]))
    assert not any("extra" in each for each in wheels.requirements(["sim"]))
    assert not any(each.startswith("numpy") for each in wheels.requirements())
    with pytest.raises(Malformed, match="rtkit has no extra simm; there are dev, "):
        inventory.add(Host("y", "10.0.0.7", extras=("simm",)))
    Path("hosts.toml").write_text('[z]\naddress = "z"\nextras = "sim"\n')
    with pytest.raises(Malformed, match=r"hosts\.toml: z: extras: not a list of texts"):
        inventory.read()


def test_an_index_of_a_host_is_an_address_without_a_secret(profile: str) -> None:
    index = "https://pypi.org/simple"
    inventory.add(Host("z", "10.0.0.7", index=index))
    assert inventory.read()["z"].index == index
    for wrong in ("ftp://a/simple", "simple", "http://", "http://[", "http://a:x", "http://a b"):
        with pytest.raises(Malformed, match="an index is http"):
            inventory.add(Host("y", "10.0.0.7", index=wrong))
    with pytest.raises(Malformed, match="a secret in the address of an index: that at a is") as it:
        inventory.add(Host("y", "10.0.0.7", index="http://me:word@a/simple"))
    assert "word" not in str(it.value)
    Path("hosts.toml").write_text('[z]\naddress = "z"\nindex = "/wheels"\n')
    with pytest.raises(Malformed, match=r"hosts\.toml: z: an index is http.*: '/wheels'"):
        inventory.read()


def test_hosts_that_are_equally_alike_are_told_in_the_order_of_their_names() -> None:
    told = " (did you mean robot1 or robot2 or robot3?)"
    assert inventory_files.hint("robot9", ["robot3", "robot1", "robot2"]) == told
