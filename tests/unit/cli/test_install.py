"""``rtmgr install`` and ``uninstall``: the unit that is written, and one that was changed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

from rtkit.cli.managers import service
from rtkit.manager.unit_file import is_as_written

Run = Callable[[str], Any]


@pytest.fixture
def units(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of the units of this user; systemd runs."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr(service, "_RUNNING", str(tmp_path))
    monkeypatch.setattr(service, "OF_MACHINE", str(tmp_path / "etc"))
    monkeypatch.chdir(tmp_path)
    return tmp_path / "systemd" / "user"


def test_a_unit_is_shown_and_nothing_is_written(run: Run, units: Path) -> None:
    done = run("rtmgr install --user --print -o manager.modules.load_path:'a b' robot")
    assert (done.status, done.err) == (0, "")
    assert is_as_written(done.out)
    assert 'rtmgr run robot -o "manager.modules.load_path:a b"\n' in done.out
    assert f"WorkingDirectory={units.parents[1]}\n" in done.out
    assert not units.parent.exists()


def test_a_unit_is_written_and_what_starts_it_is_told(run: Run, units: Path) -> None:
    file = units / "rtkit-manager.service"
    done = run("rtmgr install --user")
    assert (done.status, done.out) == (0, f"{file}\n")
    assert "rtmgr: next: systemctl --user enable --now rtkit-manager.service\n" in done.err
    assert "enable-linger" in done.err
    assert file.stat().st_mode & 0o777 == 0o644
    assert file.read_text() == run("rtmgr install --user --print").out
    # What nobody changed is replaced.
    again = run("rtmgr install --user -a")
    assert again.status == 0
    assert "daemon-reload && systemctl --user restart rtkit-manager.service" in again.err
    assert "-o manager.net_servant:NO" in file.read_text()
    assert [each.name for each in units.iterdir()] == [file.name]


def test_a_unit_that_is_written_is_told_as_a_record(run: Run, units: Path) -> None:
    done = run("rtmgr install --user --json")
    (record,) = jsonrecords.checked(done.out)
    assert jsonrecords.kind_of(record) == "built-file"
    assert (record["path"], record["fate"]) == (str(units / "rtkit-manager.service"), "written")
    assert is_as_written((units / "rtkit-manager.service").read_text())
    assert run("rtmgr install --user --json --print").status == 2


def test_a_unit_that_was_changed_is_neither_replaced_nor_removed(run: Run, units: Path) -> None:
    file = units / "rtkit-manager.service"
    assert run("rtmgr install --user").status == 0
    changed = file.read_text().replace("30s", "60s")
    file.write_text(changed)
    for word, done in (("install", "replaces"), ("uninstall", "removes")):
        refused = f"rtmgr: {file} was changed, or not written by rtmgr; --force {done} it\n"
        assert run(f"rtmgr {word} --user") == (1, "", refused)
        assert file.read_text() == changed
    assert run("rtmgr install --user --force").status == 0
    assert is_as_written(file.read_text())


def test_what_is_uninstalled_leaves_nothing(run: Run, units: Path) -> None:
    assert run("rtmgr install --user").status == 0
    wants = units / "default.target.wants"
    wants.mkdir()
    (wants / "rtkit-manager.service").symlink_to(units / "rtkit-manager.service")
    assert run("rtmgr uninstall --user") == (0, "", "rtmgr: next: systemctl --user daemon-reload\n")
    assert [*units.rglob("*")] == [wants]
    missing = run("rtmgr uninstall --user")
    assert missing.status == 1
    assert "manager 'manager' is not installed: no " in missing.err


def test_a_service_of_the_machine_runs_as_somebody(
    run: Run, units: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = run("rtmgr install --system --run-as root")
    assert done.out == f"{units.parents[1]}/etc/rtkit-manager.service\n"
    assert "next: systemctl enable --now" in done.err
    assert "export RTKIT_RUNTIME_DIR=/run/rtkit-root" in done.err
    assert "it runs as root" in done.err
    assert run("rtmgr install --run-as nobody-here") == (
        1,
        "",
        "rtmgr: no such user: nobody-here\n",
    )
    monkeypatch.setattr(os, "getuid", lambda: 0)
    monkeypatch.setenv("SUDO_USER", "daemon")
    assert "User=daemon\n" in run("rtmgr install --print").out


def test_without_systemd_it_is_said(run: Run, units: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service, "_RUNNING", "/nowhere")
    monkeypatch.setenv("PATH", "/nowhere")
    done = run("rtmgr install --user")
    assert done.status == 0
    assert done.err == (
        "rtmgr: note: systemd does not run here, so nothing reads this; rtmgr start does without\n"
    )


def test_a_bad_configuration_is_found_before_anything_is_written(run: Run, units: Path) -> None:
    (units.parents[1] / "bad.conf").write_text("nonsense")
    assert run("rtmgr install --user -f bad.conf").status == 1
    assert not units.exists()


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("rtmgr start --user", "--user is for rtmgr install and uninstall"),
        ("rtmgr stop --forget", "--forget is for rtmgr restart"),
        ("rtmgr -c Std --keep /localhost/manager.mgr", "--keep is for rtmgr stop"),
        ("rtmgr uninstall --run-as root", "--run-as is for rtmgr install"),
        ("rtmgr install --user --system", "--user excludes --system and --run-as"),
        ("rtmgr uninstall -p 0", "--allow-faults are not for uninstall"),
    ],
)
def test_options_are_for_some_words_only(run: Run, line: str, why: str) -> None:
    done = run(line)
    assert done.status == 2
    assert why in done.err
