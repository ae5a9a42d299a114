"""Listings tell which managers did not answer: silence is not taken for "nothing there"."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from fake_tree import fake_tree

from rtkit.cli.shared.commands import load
from rtkit.tree import place

SERVER = "/localhost:9 was not"


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Nothing runs but a property service."""
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    for key in ("RTKIT_SERVERS", "RTCTREE_NAMESERVERS"):
        monkeypatch.delenv(key, raising=False)
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(str(tmp_path / "arm.ps"))
        end.listen()
        yield


def typed(line: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    command, *words = line.split()
    status: int = load(command)(words)
    captured = capsys.readouterr()
    return status, captured.out, captured.err


@pytest.mark.parametrize(
    "line", ["rtls /localhost", "rtls", "rtls -l", "rtls -R --json", "rtfind /localhost"]
)
def test_the_manager_that_was_chosen_is_missed(
    service: None,
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    status, out, _ = typed(line, capsys)
    assert (status, bool(out)) == (0, True)  # the default one was never started
    monkeypatch.setenv("RTKIT_MANAGER", "nosuch")
    status, out, err = typed(line, capsys)
    assert (status, bool(out)) == (1, True)
    assert err.startswith(f"{line.split()[0]}: manager 'nosuch' is not running (start it with: ")


def test_entries_of_servers_that_are_no_addresses_are_warned_of(
    service: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("RTKIT_SERVERS", "robot2")
    status, out, err = typed("rtls /localhost", capsys)
    assert (status, bool(out)) == (0, True)
    assert err == "rtls: warning: RTKIT_SERVERS: not HOST:PORT: 'robot2'\n"


def test_a_default_manager_that_was_killed_is_missed(
    service: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(tmp_path / "manager.sock"))
    status, out, err = typed("rtls /localhost", capsys)
    assert (status, out) == (1, "arm/\n")
    assert "nobody is behind its socket" in err


def test_servers_that_do_not_answer_are_told(
    service: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("RTCTREE_NAMESERVERS", "localhost:9")
    assert typed("rtls /", capsys) == (0, "localhost/\nlocalhost:9/\n", "")  # nobody was asked
    for line, done in (("rtls -R /", "listed"), ("rtfind / -t c", "searched")):
        status, _, err = typed(line, capsys)
        assert (status, err[:40]) == (
            1,
            f"{line.split()[0]}: {SERVER} {done}: no manager of this"[:40],
        )
    assert [why[:27] for why in place.silent_servers(1.0)] == ["no manager of this user lis"]


def test_a_working_directory_that_is_gone_is_named(run) -> None:
    told = "the working directory /no/dir is not there: rtcwd, RTKIT_CWD change it"
    for line in ("rtls", "rtls .", "rtls x", "rtcat x/y"):
        name = line.split()[1] if " " in line else "."
        outcome = run(f"RTKIT_CWD=/no/dir {line}")
        assert outcome.err == f"{line.split()[0]}: No such object: {name} ({told})\n"
    for line in ("RTKIT_CWD=/localhost rtls x", "RTKIT_CWD=/no rtls /x", "RTKIT_CWD=/no rtls ../x"):
        assert "working directory" not in run(line).err


def test_a_directory_that_is_to_be_described_is_listed_by_another_command(run) -> None:
    told = "rtcat: No such object: /localhost (it is a directory: rtls /localhost lists it)\n"
    assert run("rtcat /localhost") == (1, "", told)


def test_unique_shows_each_component_once(run, world) -> None:
    listing = fake_tree(world).listing()
    paths = run("rtfind / -t cz").out.split()
    once = run("rtfind / -t cz --unique").out.split()
    assert len(paths) > len(once) == len(listing.rows)
    assert set(once) <= set(paths)
    assert all("manager.mgr" not in path for path in once)
    below = run("rtfind /localhost/manager.mgr -t cz --unique").out.split()
    assert len(below) == len(once)  # where no name is, the managers are
    shown = run("rtls -R --unique /").out.split()
    assert sorted(word.strip("*") for word in shown if word.endswith(".rtc")) == sorted(
        path.rpartition("/")[2] for path in once
    )
