"""Signatures of packages and bundles: whose count, and what is refused with which sentence."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from wheelkit import made

from rtkit.errors import Refused, RtkitError
from rtkit.keys import authority
from rtkit.packages import bundle
from rtkit.packages.installed import install, install_bundle, installed
from rtkit.packages.repository import Repositories
from rtkit.packages.resolving import requirement
from rtkit.packages.signing import VARIABLE, shown_signer, sign_wheel, signer_of
from rtkit.packages.wheel import read_wheel


@pytest.fixture(autouse=True)
def _keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("RTKIT_KEYS", str(tmp_path / "keys"))
    monkeypatch.delenv(VARIABLE, raising=False)
    authority.init("ann")


def as_(name: str, role: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Be somebody else, who knows the same CA."""
    monkeypatch.setenv("RTKIT_KEYS", str(tmp_path / "keys"))
    authority.issue(name, role, (), 10, str(tmp_path / name))
    monkeypatch.setenv("RTKIT_KEYS", str(tmp_path / name))


def ca(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTKIT_KEYS", str(tmp_path / "keys"))


def wheel(tmp_path: Path, **how: object) -> Path:
    return made(tmp_path / "wheels", "gain", "1.0", type="Gain", **how)  # type: ignore[arg-type]


def refusal(path: Path) -> str:
    with pytest.raises(RtkitError) as caught:
        signer_of(read_wheel(str(path)))
    return str(caught.value)


def test_who_has_signed_is_told_also_by_who_signs_again(tmp_path: Path) -> None:
    path = wheel(tmp_path)
    assert "is not signed (rtpkg sign signs it)" in refusal(path)
    assert shown_signer(read_wheel(str(path))) is None
    before = read_wheel(str(path))
    for _ in range(2):
        sign_wheel(str(path))
        after = read_wheel(str(path))
        assert signer_of(after) == "ann"
        assert after.record == before.record
    with zipfile.ZipFile(path) as archive:
        assert archive.namelist().count("gain-1.0.dist-info/RECORD.jws") == 1
    assert [each.name for each in path.parent.iterdir()] == [path.name]


def test_a_changed_byte_is_refused_even_where_record_says_so_too(tmp_path: Path) -> None:
    path = wheel(tmp_path)
    sign_wheel(str(path))
    with zipfile.ZipFile(path) as archive:
        signature = archive.read("gain-1.0.dist-info/RECORD.jws").decode()
    other = wheel(tmp_path, files={"more.py": ""})
    with zipfile.ZipFile(other, "a") as archive:
        archive.writestr("gain-1.0.dist-info/RECORD.jws", signature)
    assert refusal(other).endswith("is not what ann has signed")


@pytest.mark.parametrize("where", [0, 20, -60, -1])
def test_a_changed_signature_is_none(tmp_path: Path, where: int) -> None:
    path = wheel(tmp_path)
    sign_wheel(str(path))
    found = read_wheel(str(path))
    letters = bytearray(found.signature)
    letters[where] = ord("A") if letters[where] != ord("A") else ord("B")
    with pytest.raises(Refused):
        signer_of(found._replace(signature=bytes(letters)))


@pytest.mark.parametrize("rubbish", [b"x", b"..", b"a.b.c", b"\xff", b"e30.e30.e30", b"." * 99999])
def test_rubbish_is_no_signature(tmp_path: Path, rubbish: bytes) -> None:
    found = read_wheel(str(wheel(tmp_path)))._replace(signature=rubbish)
    with pytest.raises(Refused, match="has no signature of rtkit"):
        signer_of(found)


def test_a_signature_of_a_bundle_is_none_of_a_wheel(tmp_path: Path) -> None:
    from rtkit.packages.signing import BUNDLE, signed

    found = read_wheel(str(wheel(tmp_path)))
    with pytest.raises(Refused, match="has no signature of rtkit"):
        signer_of(found._replace(signature=signed(found.record, BUNDLE).encode()))


def test_only_operators_sign_and_are_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = wheel(tmp_path)
    as_("eve", "viewer", tmp_path, monkeypatch)
    with pytest.raises(Refused, match="eve, who is viewer, not operator"):
        sign_wheel(str(path))
    as_("bob", "operator", tmp_path, monkeypatch)
    sign_wheel(str(path))
    ca(tmp_path, monkeypatch)
    assert signer_of(read_wheel(str(path))) == "bob"
    authority.revoke("bob")
    assert refusal(path).endswith("is signed by bob, whose certificate is revoked")


def test_who_is_of_another_ca_is_not_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = wheel(tmp_path)
    monkeypatch.setenv("RTKIT_KEYS", str(tmp_path / "strange"))
    authority.init("ann")  # the same name, which proves nothing
    sign_wheel(str(path))
    ca(tmp_path, monkeypatch)
    assert refusal(path).endswith("is signed by CN=ann, whom the CA here does not know")


def test_what_is_required_is_required_of_all_that_a_package_needs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = wheel(tmp_path, requires=("third",))
    third = made(tmp_path / "wheels", "third", "1.0", {"third.py": ""})
    there = Repositories({"wheels": str(tmp_path / "wheels")}, [])
    sign_wheel(str(path))
    with pytest.raises(Refused, match=f"{third.name} is not signed"):
        install(requirement("gain"), there, must_be_signed=True)
    assert installed() == []
    install(requirement("gain"), there)
    monkeypatch.setenv(VARIABLE, "1")
    with pytest.raises(Refused, match=f"{third.name} is not signed"):
        install(requirement("gain"), there)  # it is there already, and no better for that


def test_a_signed_bundle_vouches_for_all_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = str(tmp_path / "robot.rtbundle")
    bundle.write(path, b"<x/>", {"gain==1.0": [str(wheel(tmp_path))]})
    monkeypatch.setenv(VARIABLE, "1")
    with pytest.raises(Refused, match=r"robot\.rtbundle is not signed"):
        bundle.read_system(path)
    bundle.sign(path)
    signed = Path(path).read_bytes()
    bundle.sign(path)
    assert len(Path(path).read_bytes()) == len(signed)
    (found,) = install_bundle(path)
    assert found.text == "gain==1.0"
    for place in (100, len(signed) // 2, len(signed) - 700, len(signed) - 3):
        changed = bytearray(signed)
        changed[place] ^= 1
        Path(path).write_bytes(changed)
        with pytest.raises(RtkitError):
            bundle.read_system(path)
    Path(path).write_bytes(signed)
    authority.revoke("ann")
    with pytest.raises(Refused, match="is signed by ann, whose certificate is revoked"):
        bundle.read_system(path)


def test_nothing_is_required_where_the_settings_say_no(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "0")
    wheel(tmp_path)
    there = Repositories({"wheels": str(tmp_path / "wheels")}, [])
    assert install(requirement("gain"), there).text == "gain==1.0"
