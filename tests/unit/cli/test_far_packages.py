"""``rtpkg … --host``: hosts are worked at side by side, and each has a line."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.cli.packages.rtpkg import main
from rtkit.errors import Refused
from rtkit.hosts import connection, far_packages
from rtkit.hosts.far_packager import PackageAnswer
from rtkit.hosts.host import Host
from rtkit.packages.records import Installed


@pytest.fixture(autouse=True)
def hosts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have an inventory of three hosts, to which connections lead."""
    text = "".join(f'[{name}]\naddress = "x"\n' for name in ("one", "two", "three"))
    (tmp_path / "hosts.toml").write_text(text)
    monkeypatch.chdir(tmp_path)

    @contextmanager
    def connect(host: Host, _timeout_s: float) -> Iterator[Any]:
        yield SimpleNamespace(host=host)

    monkeypatch.setattr(connection, "connect", connect)


def test_hosts_are_worked_at_side_by_side(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    all_at_work = threading.Barrier(3, timeout=10.0)

    def remove(at: Any, names: tuple[str, ...], *, is_forced: bool) -> PackageAnswer:
        all_at_work.wait()
        if at.host.name == "two":
            raise Refused("two: gain is in use")
        return PackageAnswer(tuple(Installed(each, "1.0", "", (), (), {}) for each in names))

    monkeypatch.setattr(far_packages, "remove", remove)
    words = [word for name in ("three", "two", "one", "three") for word in ("--host", name)]
    assert main(["uninstall", *words, "gain", "loss"]) == 1
    told = capsys.readouterr()
    line = "gain==1.0, loss==1.0 removed"
    assert told.out == f"three: {line}\none: {line}\n"
    assert told.err == "rtpkg uninstall: two: gain is in use\n"
