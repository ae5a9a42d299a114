"""``rtget`` of several targets, of which some cannot be got."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from rtkit.cli.properties.rtget import main
from rtkit.link import secret


@pytest.fixture(autouse=True)
def nothing_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))


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


def test_a_time_out_among_the_parameters_bounds_the_question_for_services(
    capsys: pytest.CaptureFixture[str],
) -> None:
    secret.make()
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        target = f"http://localhost:{silent.getsockname()[1]}/ps/robot/speed"
        assert main(["-p", "timeout=0.3", target]) == 1
    assert capsys.readouterr().err == f"rtget: {target}: timeout: no answer within 0.4 s\n"
