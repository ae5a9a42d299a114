"""`rtweb` where something is missing: the page, the extra, the port."""

from __future__ import annotations

import socket
import sys
from pathlib import Path

import pytest

import rtkit.web
from rtkit.cli.system import rtweb
from rtkit.errors import Refused, Unreachable


def test_an_installation_without_the_page_says_how_it_is_had(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="install rtkit from a wheel, or make web"):
        rtweb.check_built(str(tmp_path))
    (tmp_path / "index.html").touch()
    rtweb.check_built(str(tmp_path))


def test_without_the_extra_it_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(rtkit, "web", rtkit.web)  # what is imported below is forgotten again
    for name in [each for each in sys.modules if each.startswith("rtkit.web")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "starlette.applications", None)
    assert rtweb.main(["--no-browser"]) == 1
    assert "pip install 'rtkit[web]'" in capsys.readouterr().err


def test_a_port_that_is_taken_is_named() -> None:
    from rtkit.web.reach import HERE, reach_of

    with socket.socket() as other:
        other.bind((HERE, 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(Unreachable, match=f"port {port}: Address already in use"):
            reach_of(HERE, port, "", "")
