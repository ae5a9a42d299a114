"""Units of systemd: what is written into them, what systemd reads of that, what was changed."""

from __future__ import annotations

import shutil
import stat
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.errors import Malformed
from rtkit.manager.unit_file import ManagerService, is_as_written, unit_name

ODD = "a b%h$HOME\"q'\\x;#1 é"
PLAIN = ManagerService("manager", ["/bin/rtmgr"], [], "/", {})


def setting(text: str, key: str) -> list[str]:
    lines = [line.partition("=") for line in text.split("\n") if line[:1] != "#"]
    return [value for name, _, value in lines if name == key]


def words_of(line: str) -> list[str]:
    """Split a line as systemd.syntax(7) and systemd.service(5) say, specifiers and ``$$`` last."""
    words, word, quote, letters = [], None, "", iter(line)
    for letter in letters:
        if letter == "\\":
            word = (word or "") + next(letters)
        elif quote and letter == quote:
            quote = ""
        elif not quote and letter in "\"'" and word is None:
            quote, word = letter, ""
        elif letter == " " and not quote:
            words, word = [*words, *([] if word is None else [word])], None
        else:
            word = (word or "") + letter
    assert not quote
    words += [] if word is None else [word]
    return [each.replace("%%", "%").replace("$$", "$") for each in words]


def test_what_keeps_slaves_and_their_sockets_when_a_manager_ends() -> None:
    for user in ("", "robot"):
        text = PLAIN._replace(user=user).text()
        assert setting(text, "Type") == ["notify"]
        assert setting(text, "KillMode") == ["process"]
        assert setting(text, "Restart") == ["on-failure"]
        assert setting(text, "OOMPolicy") == ["continue"]
        assert setting(text, "RuntimeDirectoryPreserve") == ["yes"]
        assert setting(text, "NoNewPrivileges") == ["yes"]
        assert setting(text, "WatchdogSec") == ["30s"]
        assert setting(text, "ExecStart") == ["/bin/rtmgr run manager"]
        assert setting(text, "ExecStop") == ["-/bin/rtmgr stop --keep manager"]
        # Both would be removed, or made anew, under slaves that outlive their manager.
        assert not setting(text, "PrivateTmp")
        assert not setting(text, "ProtectClock"), "it closes all devices"


def test_a_service_of_the_machine_has_folders_of_its_own() -> None:
    text = PLAIN._replace(user="robot", folder="/home/robot").text()
    assert setting(text, "User") == ["robot"]
    assert "RTKIT_RUNTIME_DIR=/run/rtkit-robot RTKIT_STATE_DIR=/var/lib/rtkit-robot" in text
    assert setting(text, "RuntimeDirectory") == ["rtkit-robot", "rtkit-robot/tmp"]
    assert setting(text, "StateDirectory") == ["rtkit-robot"]
    assert setting(text, "BindPaths") == ["/run/rtkit-robot/tmp:/tmp"]
    assert setting(text, "ProtectSystem") == ["full"]
    assert setting(text, "CapabilityBoundingSet") == [""]
    assert setting(text, "WantedBy") == ["multi-user.target"]
    assert not setting(PLAIN._replace(user="root").text(), "CapabilityBoundingSet")


@pytest.mark.parametrize("in_tmp", [{"folder": "/tmp/w"}, {"options": ["-f", "/tmp/rtc.conf"]}])
def test_what_is_in_tmp_is_seen_by_a_service_of_the_machine(in_tmp: dict[str, object]) -> None:
    assert not setting(PLAIN._replace(user="robot", **in_tmp).text(), "BindPaths")


def test_a_service_of_a_user_is_where_commands_look() -> None:
    assert setting(PLAIN.text(), "RuntimeDirectory") == ["rtkit"]
    elsewhere = PLAIN._replace(environment={"RTKIT_RUNTIME_DIR": "/tmp/r"}).text()
    assert setting(elsewhere, "RuntimeDirectory") == []
    assert setting(elsewhere, "Environment") == ["RTKIT_RUNTIME_DIR=/tmp/r"]


@pytest.mark.parametrize(("systemd", "expected"), [(0, []), (252, []), (254, ["rtkit-manager"])])
def test_limits_are_control_groups_where_systemd_can_start_it_again(
    systemd: int, expected: list[str]
) -> None:
    assert setting(PLAIN._replace(systemd=systemd).text(), "DelegateSubgroup") == expected


@given(st.lists(st.text(st.characters(min_codepoint=32, exclude_categories=["Cs"]), min_size=1)))
def test_words_are_read_as_they_were_typed(words: list[str]) -> None:
    text = PLAIN._replace(options=words).text()
    (start,) = setting(text, "ExecStart")
    assert words_of(start) == ["/bin/rtmgr", "run", "manager", *words]


def test_what_no_line_can_hold_is_refused() -> None:
    with pytest.raises(Malformed, match="cannot be written into a unit"):
        PLAIN._replace(folder="/a\nExecStart=/bin/evil").text()
    with pytest.raises(Malformed, match="no program with quotes"):
        PLAIN._replace(program=["/a'b/rtmgr"]).text()


def test_a_change_is_noticed() -> None:
    text = PLAIN.text()
    assert is_as_written(text)
    assert not is_as_written(text.replace("30s", "60s"))
    assert not is_as_written("[Service]\n")


@pytest.mark.parametrize("user", ["", "root"])
def test_systemd_finds_nothing_wrong(tmp_path: Path, user: str) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        pytest.skip("systemd-analyze is not installed")
    program = tmp_path / "a b%h$HOME;#1 é" / "rtmgr"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    odd = {"options": [ODD], "folder": f"/{ODD}", "environment": {"ODD": ODD}}
    file = tmp_path / unit_name("left arm")
    service = ManagerService("left arm", [str(program)], user=user, **odd)  # type: ignore[arg-type]
    file.write_text(service.text())
    # Of the units of users it knows the same settings, but wants a session of theirs.
    done = subprocess.run(
        [analyze, "verify", "--man=no", str(file)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
