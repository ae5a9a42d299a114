"""``rtkeys``: a CA, what it issues, lists and revokes, and what it refuses."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

Run = Callable[[str], Any]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTKIT_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("RTKIT_HOSTNAME", "desk")
    return tmp_path


def _modes(folder: Path) -> set[int]:
    return {each.stat().st_mode & 0o777 for each in folder.rglob("*") if each.is_file()}


def test_a_ca_is_made_once_and_for_this_user_alone(run: Run, folder: Path) -> None:
    before = os.umask(0)
    try:
        assert run("rtkeys init --name owner1").status == 0
        assert run("rtkeys issue anna --role viewer").status == 0
    finally:
        os.umask(before)
    assert _modes(folder) == {0o600}
    assert {each.stat().st_mode & 0o777 for each in folder.rglob("*") if each.is_dir()} == {0o700}
    key = (folder / "keys" / "ca.key").read_bytes()
    again = run("rtkeys init")
    assert (again.status, "never overwritten" in again.err) == (1, True)
    assert (folder / "keys" / "ca.key").read_bytes() == key


def test_certificates_are_listed_with_role_and_time(run: Run) -> None:
    run("rtkeys init --name owner1")
    run("rtkeys issue anna --role viewer -o a")
    run("rtkeys issue bot --role component --host 10.0.0.7 --host bot.local --days 9")
    run("rtkeys revoke anna")
    done = run("rtkeys list --json")
    found = jsonrecords.checked(done.out)
    assert [
        (each["name"], each["role"], each["revoked"] is None, each["hosts"]) for each in found
    ] == [
        ("anna", "viewer", False, []),
        ("bot", "component", True, ["bot.local", "10.0.0.7"]),
        ("owner1", "administrator", True, ["localhost", "desk", "127.0.0.1", "::1"]),
    ]  # fmt: skip
    assert "warning: bot ends in 8 days" in done.err
    shown = run("rtkeys list").out.splitlines()
    assert "revoked" in shown[0]
    assert "good" in shown[1]
    (own,) = jsonrecords.checked(run("RTKIT_KEYS=a rtkeys show --json").out)
    assert own["name"] == "anna"


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("rtkeys issue nobody --role viewer", "a name that users"),
        ("rtkeys issue rtkit-0 --role viewer", "a name that users"),
        ("rtkeys issue 'a*' --role viewer", "not a name"),
        ("rtkeys issue ../x --role viewer", "not a name"),
        ("rtkeys issue b --role viewer --host 'a b'", "not the name or address"),
        ("rtkeys issue b --role viewer --days 9999", "the CA itself ends"),
        ("rtkeys issue b --role viewer -o /nowhere/x", "no such folder: /nowhere"),
        ("rtkeys issue owner1 --role viewer", "owner1 is administrator"),
        ("rtkeys revoke owner", "did you mean owner1?"),
        ("RTKIT_KEYS=none rtkeys issue b --role viewer", "rtkeys init"),
        ("RTKIT_KEYS=none rtkeys list", "no keys:"),
    ],
)
def test_what_is_refused_leaves_nothing_behind(run: Run, folder: Path, line: str, why: str) -> None:
    run("rtkeys init --name owner1")
    before = sorted(folder.rglob("*"))
    done = run(line)
    assert (done.status, why in done.err) == (1, True), done.err
    assert sorted(folder.rglob("*")) == before


def test_a_key_of_the_ca_that_others_can_read_is_refused(run: Run, folder: Path) -> None:
    run("rtkeys init")
    (folder / "keys" / "ca.key").chmod(0o644)
    done = run("rtkeys issue b --role viewer")
    assert "others can read it (mode 644)" in done.err
    assert "PRIVATE" not in done.err


def test_each_long_listing_tells_what_is_insecure(
    run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from rtkit.link import insecure

    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(folder / "run"))
    assert "insecure" not in run("rtls -l").err
    forget = insecure.note("tcp:desk:4711")
    try:
        for line in ("rtls -l", "rtls -l /", "rtls -lR"):
            assert "rtls: insecure: tcp:desk:4711" in run(line).err
        assert "insecure" not in run("rtls").err
    finally:
        forget()
    (folder / "run" / "x-1.insecure").write_text("tcp:gone:1")
    assert "insecure" not in run("rtls -l").err
    assert list((folder / "run").iterdir()) == []


def test_the_roles_are_told_in_words_where_none_is_given(run: Run) -> None:
    told = run("rtkeys issue anna").err.splitlines()[-1]
    roles = "administrator, operator, viewer, component"
    assert told == f"rtkeys issue: Missing option '--role'. Known: {roles}"
