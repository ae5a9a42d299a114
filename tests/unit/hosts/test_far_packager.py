"""The far side of pushed packages: what fits is installed without pip, rubbish leaves nothing."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from wheelkit import made

from rtkit.hosts import far_packager
from rtkit.packages import bundle
from rtkit.packages.installed import installed


@pytest.fixture(autouse=True)
def _own_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("PATH", "")  # neither pip nor anything else is run


def answer(
    data: bytes, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> tuple[int, dict[str, object]]:
    """Return the status and the answer of the program that is given a bundle."""
    monkeypatch.setattr(sys, "argv", ["far_packager", "install"])
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(data)))
    status = far_packager.main()
    return status, json.loads(capsys.readouterr().out.partition(": ")[2])


def pushed(tmp_path: Path, *wheels: Path) -> bytes:
    path = tmp_path / "push.rtbundle"
    bundle.write(str(path), b"", {"gain==1.0": [str(each) for each in wheels]})
    return path.read_bytes()


def test_what_is_pushed_is_there_with_what_it_needs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {"gain-1.0.data/purelib/own.py": "X = 1\n", "gain-1.0.data/scripts/run": "#!python\n"}
    gain = made(tmp_path, "gain", "1.0", files, type="Gain", requires=("a_third",))
    third = made(tmp_path, "a_third", "1.0", {"a_third.py": ""})
    for _ in range(2):
        status, told = answer(pushed(tmp_path, third, gain), monkeypatch, capsys)
        assert (status, [each.text for each in installed()]) == (0, ["gain==1.0"])
    there = {each.name for each in Path(installed()[0].path).iterdir()}
    assert {"gain", "own.py", "a_third.py"} <= there
    assert not any(each.endswith(".data") for each in there)
    assert told["packages"][0]["types"] == ["RTC:me:test:Gain:1.0"]  # type: ignore[index]


@pytest.mark.parametrize("cut", [0, 1, 300, -1])
def test_what_was_cut_on_the_way_leaves_nothing(
    tmp_path: Path, cut: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    data = pushed(tmp_path, made(tmp_path, "gain", "1.0", type="Gain"))
    status, told = answer(data[:cut], monkeypatch, capsys)
    assert (status, installed()) == (1, [])
    assert "bundle" in str(told["error"])


def test_a_wheel_of_another_machine_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wheel = made(tmp_path, "gain", "1.0", type="Gain")
    other = wheel.rename(wheel.with_name("gain-1.0-cp38-cp38-win32.whl"))
    status, told = answer(pushed(tmp_path, other), monkeypatch, capsys)
    assert (status, installed()) == (1, [])
    assert told["error"] == f"{other.name} is for another kind of machine, or of Python"
