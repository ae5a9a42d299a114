"""``rtget`` of several targets, of which some cannot be got."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.cli.properties.rtget import main


@pytest.fixture(autouse=True)
def nothing_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 0, 2), (2, 1, 0)])
def test_what_cannot_be_got_keeps_from_nothing_else(
    order: tuple[int, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    targets = ["localhost.name", "nosuch.a", "other.b"]
    assert main([targets[each] for each in order]) == 1
    out, err = capsys.readouterr()
    assert out.strip()
    assert sorted(err.splitlines()) == [
        "rtget: nosuch.a: no-service: no service named nosuch (there is none)",
        "rtget: other.b: no-service: no service named other (there is none)",
    ]
