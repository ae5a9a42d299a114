"""Every real system profile on live processes: up, started, checked, saved, stopped, down."""

from __future__ import annotations

import os.path
import shlex
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from stated import Stated, stated

from rtkit.cli.shared.commands import load
from rtkit.profile.read import read_rts
from rtkit.profile.rts_model import RtsProfile
from rtkit.tree.connect import connect

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDER = os.path.join(os.path.dirname(ROOT), "shared", "corpus", "rts")
FILES = sorted(os.listdir(FOLDER)) if os.path.isdir(FOLDER) else []

needs_corpus = pytest.mark.skipif(not FILES, reason="corpus absent")


def read(file: str) -> RtsProfile:
    with open(file, "rb") as stream:
        return read_rts(stream.read(), file).profile


def facts(file: str) -> Stated:
    return stated(read(file))


def as_stated(saved: Stated, original: Stated) -> Stated:
    """Return what was saved without data types of ports for which the original states none."""
    components = {}
    for instance, component in saved.components.items():
        told = original.components[instance].data_ports
        types = {port: kind if told[port] else "" for port, kind in component.data_ports.items()}
        components[instance] = component._replace(data_ports=types)
    return Stated(components, saved.connectors)


@pytest.fixture
def typed(
    manager: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Iterator[Callable[..., tuple[int, str, str]]]:
    """Type commands without a process for each: only the system's own processes are live."""
    for key, value in manager.environment.items():
        if key.startswith("RTKIT_"):
            monkeypatch.setenv(key, value)
    monkeypatch.chdir(manager.folder)
    with connect() as tree:

        def run(name: str, *arguments: str) -> tuple[int, str, str]:
            status = load(name)(arguments, tree=tree)
            return (status, *capsys.readouterr())

        yield run


@needs_corpus
def test_every_profile_lives(manager: Any, typed: Any) -> None:
    """One manager sees them all: what one leaves behind, the next one stumbles over."""
    assert len(FILES) >= 22
    for name in FILES:
        live_once(manager, typed, os.path.join(FOLDER, name))


def live_once(manager: Any, typed: Any, file: str) -> None:
    """Run a system twice in one manager, under prefixes and with values of their own."""
    ones = [each.instance_name for each in read(file).components[:1]]  # one profile is empty
    systems = [
        (*(f"--set={one}.added={prefix}" for one in ones), "--prefix", prefix, file)
        for prefix in ("a.", "b.")
    ]
    for system in systems:
        assert typed("rtresurrect", "--stand-in", *system) == (0, "", ""), file
        status, out, err = typed("rtstart", *system)
        assert (status, out) == (0, ""), (file, err)
        assert all(line.startswith("Executing {") for line in err.splitlines()), (file, err)
    assert typed("rtcryo", "--all", "-o", "saved.xml") == (0, "", ""), file
    saved = facts(str(manager.folder / "saved.xml"))
    for system in systems:
        assert typed("rtcheck", *system) == (0, "", ""), file
        assert typed("rtprofile", "resolve", *system, "resolved.xml") == (0, "", ""), file
        original = facts(str(manager.folder / "resolved.xml"))
        own = Stated(
            {name: saved.components[name] for name in original.components},
            {name: saved.connectors[name] for name in original.connectors},
        )
        assert as_stated(own, original) == original, file
    for system, other in zip(systems, systems[::-1], strict=True):
        assert typed("rtstop", *system)[0] == 0
        assert typed("rtcheck", "-s", "Inactive", *system) == (0, "", ""), file
        assert typed("rtteardown", "--exit", *system) == (0, "", ""), file
        if other is systems[1]:
            assert typed("rtcheck", *other) == (0, "", ""), file
    assert typed("rtls", "/localhost/manager.mgr") == (0, "", ""), file


@needs_corpus
@pytest.mark.parametrize("name", FILES[3:5] or ["none"])
def test_what_was_saved_lives_by_itself(manager: Any, name: str) -> None:
    file = shlex.quote(os.path.join(FOLDER, name))
    assert manager.run(f"rtresurrect --stand-in --transmit {file}") == (0, "", "")
    assert manager.run("rtcryo --all -o first.xml") == (0, "", "")
    assert manager.run("rtteardown --exit first.xml") == (0, "", "")
    assert manager.run("rtresurrect first.xml") == (0, "", "")
    assert manager.run("rtstart first.xml").status == 0
    assert manager.run("rtcheck first.xml") == (0, "", "")
    assert manager.run("rtcryo --all -o second.xml") == (0, "", "")
    first, second = (facts(str(manager.folder / f"{n}.xml")) for n in ("first", "second"))
    assert first == second
