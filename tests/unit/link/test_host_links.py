"""State of links: what their files tell, and when their processes cannot tell any more."""

from __future__ import annotations

import os

import pytest

from rtkit.hosts.link_process import pause_until
from rtkit.link import host_links
from rtkit.link.host_links import HostLink


@pytest.fixture(autouse=True)
def runtime(monkeypatch, tmp_path):
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))


def test_a_file_of_a_process_that_is_no_more_does_not_tell_of_a_link():
    for pid in (2**22 + 1, os.getpid()):  # nobody's, and one of another process since
        host_links.write(HostLink("robot1", "manager", "manager", "", pid))
        assert host_links.read("robot1").why == "the process of the link has ended"


def test_only_its_own_files_are_removed_by_a_process():
    host_links.write(HostLink("robot1", "manager", "manager", "", 17))
    host_links.remove("robot1", 18)
    assert host_links.is_linked("robot1")
    host_links.remove("robot1", 17)
    assert not host_links.is_linked("robot1")


def test_who_was_just_lost_is_looked_for_often_and_who_is_long_away_seldom():
    assert pause_until(0, 0.0, is_denied=False) <= 0.05
    assert all(pause_until(tries, 30.0, is_denied=False) <= 1.0 for tries in range(30))
    assert pause_until(500, 600.0, is_denied=False) == 10.0
    assert pause_until(5000, 1e5, is_denied=False) == 30.0


def test_who_is_not_let_in_does_not_hammer():
    pauses = [pause_until(tries, 0.0, is_denied=True) for tries in range(6)]
    assert pauses == [2.0, 4.0, 8.0, 16.0, 30.0, 30.0]
