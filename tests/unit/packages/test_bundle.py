"""Bundles: the same bytes for the same content, and a changed byte is refused, wherever it is."""

from __future__ import annotations

import hashlib
import zipfile
from pathlib import Path

import pytest
from wheelkit import made, unpacked

from rtkit.errors import InvalidDocument, NotFound, Refused, RtkitError
from rtkit.packages import bundle
from rtkit.packages.bundling import gather
from rtkit.packages.installed import install_bundle, installed, kept_wheels, remove
from rtkit.packages.repository import Repositories, opened, publish
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, RtsProfile

ID = "RTC:me:test:Gain:1.0"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A bundle of one package and what that needs."""
    gain = made(tmp_path / "w", "gain", "1.0", type="Gain", requires=("third",))
    third = made(tmp_path / "w", "third", "2")
    path = tmp_path / "robot.rtbundle"
    bundle.write(str(path), b"<system/>", {"gain==1.0": [str(gain), str(third)]})
    return path


def changed(file: Path, change: dict[str, bytes | None], *, links: str = "") -> Path:
    """Write a bundle again as somebody would who means harm: with digests that fit."""
    with zipfile.ZipFile(file) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
        parts |= {name: data for name, data in change.items() if data is not None}
        parts = {name: data for name, data in parts.items() if change.get(name, b"") is not None}
    path = file.parent / "changed.rtbundle"
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in parts.items():
            info = zipfile.ZipInfo(name)
            info.external_attr = (0o120777 if name == links else 0o100644) << 16
            archive.writestr(info, data)
        archive.comment = hashlib.sha256(parts["bundle.json"]).hexdigest().encode()
    return path


def test_what_was_bundled_comes_back(file: Path) -> None:
    with bundle.unpacked(str(file)) as found:
        assert found.system == b"<system/>" == bundle.read_system(str(file))
        assert [*found.packages["gain==1.0"]] == [
            "gain-1.0-py3-none-any.whl",
            "third-2-py3-none-any.whl",
        ]
        assert {each.name for each in Path(found.wheels).iterdir()} == {
            *found.packages["gain==1.0"]
        }


def test_the_same_content_is_the_same_bytes(file: Path) -> None:
    with bundle.unpacked(str(file)) as found:
        wheels = [f"{found.wheels}/{each}" for each in found.packages["gain==1.0"]]
        again = file.with_name("again.rtbundle")
        bundle.write(str(again), found.system, {"gain==1.0": wheels[::-1]})
    assert again.read_bytes() == file.read_bytes()


def test_every_changed_byte_is_refused(file: Path) -> None:
    whole = file.read_bytes()
    for place in range(0, len(whole), 29):
        data = bytearray(whole)
        data[place] ^= 1
        file.write_bytes(data)
        with pytest.raises(RtkitError, match=r"robot\.rtbundle"), bundle.unpacked(str(file)):
            pass


@pytest.mark.parametrize(
    "change", [lambda data: data + b"x", lambda data: b"x" + data, lambda data: data[:-1]]
)
def test_bytes_around_it_are_refused(file: Path, change: object) -> None:
    file.write_bytes(change(file.read_bytes()))  # type: ignore[operator]
    with pytest.raises(RtkitError), bundle.unpacked(str(file)):
        pass


def test_the_changed_part_is_named(file: Path) -> None:
    name = "wheels/third-2-py3-none-any.whl"
    with (
        pytest.raises(Refused, match=f"{name} has another SHA-256"),
        bundle.unpacked(str(changed(file, {name: b"other"}))),
    ):
        pass
    with (
        pytest.raises(Refused, match=f"{name} is too much, or missing"),
        bundle.unpacked(str(changed(file, {name: None}))),
    ):
        pass


@pytest.mark.parametrize(
    "name",
    ["../evil.py", "/tmp/evil.py", "wheels/../../evil.whl", "wheels/a/b.whl", "x"],
)
def test_paths_that_no_bundle_has_are_refused(file: Path, name: str) -> None:
    with (
        pytest.raises(Refused, match="a part that no bundle has"),
        bundle.unpacked(str(changed(file, {name: b"x"}))),
    ):
        pass
    assert not list(file.parent.parent.rglob("evil*"))


def test_links_are_refused(file: Path) -> None:
    path = changed(
        file, {"wheels/l-1-py3-none-any.whl": b"/etc"}, links="wheels/l-1-py3-none-any.whl"
    )
    with pytest.raises(Refused, match="a part that no bundle has"), bundle.unpacked(str(path)):
        pass


@pytest.mark.parametrize("data", [b"", b"PK", b"rubbish" * 99])
def test_rubbish_is_no_bundle(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "r.rtbundle"
    with pytest.raises(NotFound), bundle.unpacked(str(path)):
        pass
    path.write_bytes(data)
    with pytest.raises(InvalidDocument, match="is no bundle"), bundle.unpacked(str(path)):
        pass


def test_an_installed_package_is_bundled_from_the_wheels_it_came_of(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    (package,) = install_bundle(str(file))
    component = ComponentInstance(id=ID, path_uri="localhost/g.rtc", instance_name="g")
    composite = ComponentInstance(
        id="RTC:OpenRTM:c:GroupingComposite:1", path_uri="localhost/c.rtc", instance_name="c"
    )
    stand_in = ComponentInstance(
        id="RTC:a:b:C:1",
        path_uri="localhost/s.rtc",
        instance_name="s",
        properties=(ExtensionProperty("rtkit.stand-in", "yes"),),
    )
    parts = (component, composite, stand_in)
    profile = RtsProfile("RTSystem:me:s:1", "0.2", "", "", components=parts)
    nowhere = Repositories({}, [])
    assert gather(profile, nowhere, str(tmp_path)) == {"gain==1.0": kept_wheels(package)}
    Path(kept_wheels(package)[0]).write_bytes(file.read_bytes())
    with pytest.raises(RtkitError, match=r"gain-1\.0"):
        kept_wheels(package)
    remove(package)
    assert installed() == []
    with pytest.raises(NotFound, match=f"component g: no installed package has {ID}"):
        gather(profile, nowhere, str(tmp_path))
    with opened([str(file)]) as there:  # a bundle is a repository of what is in it
        found = gather(profile, there, str(tmp_path))
    assert [Path(each).name for each in found["gain==1.0"]] == [*package.wheels]
    with pytest.raises(Refused, match="a bundle takes no wheels"):
        publish("x.whl", str(file))


def test_what_only_this_python_has_is_not_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    wheel = made(tmp_path / "w", "gain", "1.0", type="Gain", requires=("pytest", "packaging"))
    place = unpacked(tmp_path, wheel)
    (place / ".wheels").mkdir()
    wheel.rename(place / ".wheels" / wheel.name)
    component = ComponentInstance(id=ID, path_uri="localhost/g.rtc", instance_name="g")
    profile = RtsProfile("RTSystem:me:s:1", "0.2", "", "", components=(component,))
    with pytest.raises(NotFound, match=r"gain==1\.0 needs pytest, which this Python has"):
        gather(profile, Repositories({}, []), str(tmp_path))
