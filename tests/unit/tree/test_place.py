"""Which manager a path leads to, and what shows beside the one that is asked."""

from __future__ import annotations

import fcntl
import os
import socket
import threading
from pathlib import Path

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.errors import Unreachable
from rtkit.rtc.names import parse_path
from rtkit.tree import place
from rtkit.tree.place import servers, strange_servers
from rtkit.tree.view import NodeKind, TreeNode


@pytest.fixture
def running(monkeypatch, tmp_path):
    """The runtime folder of managers `other` and `third`; `dead` left its files behind."""
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    for key in ("RTKIT_MANAGER", "RTKIT_SERVERS", "RTCTREE_NAMESERVERS"):
        monkeypatch.delenv(key, raising=False)
    for name in ("other", "third", "dead"):
        for suffix in (".sock", ".sock.lock", ".lock"):
            (tmp_path / f"{name}{suffix}").touch()
    monkeypatch.setattr(place, "_others", lambda manager: iter(["other", "third"]))
    return tmp_path


@pytest.mark.parametrize(
    ("path", "manager"),
    [
        ("/", ""),
        ("/localhost", ""),
        ("/localhost/A.rtc", ""),
        ("/localhost/manager.mgr/A.rtc", ""),
        ("/localhost/other.mgr", "other"),
        ("/localhost/other.mgr/s1.mgr/A.rtc:in", "other"),
        (f"/{os.uname().nodename}/other.mgr", "other"),
        ("/far/other.mgr", ""),
        ("/localhost/absent.mgr", ""),
        ("/localhost:2811", "localhost:2811"),
        ("/localhost:2811/A.rtc", "localhost:2811"),
        ("/far:2811/other.mgr", "far:2811"),
    ],
)
def test_the_manager_of_a_path(running, path, manager):
    assert place.manager_of(parse_path(path)) == manager


def test_the_usual_manager_may_be_another_one(running, monkeypatch):
    monkeypatch.setenv("RTKIT_MANAGER", "other")
    (running / "manager.sock").touch()
    assert place.manager_of(parse_path("/localhost/other.mgr")) == ""
    assert place.manager_of(parse_path("/localhost/manager.mgr")) == "manager"


def test_servers_come_from_the_environment(running, monkeypatch):
    assert place.servers() == []
    monkeypatch.setenv("RTCTREE_NAMESERVERS", "a:1; b:2;nonsense;c:x;")
    assert place.servers() == ["a:1", "b:2"]
    monkeypatch.setenv("RTKIT_SERVERS", "c:3")
    assert place.servers() == ["c:3"]


@pytest.mark.parametrize(
    ("path", "shown"),
    [
        ("/", ["localhost", "a:1"]),
        ("/localhost", ["localhost"]),
        ("/localhost:2811", ["localhost"]),
    ],
)
def test_what_is_shown_beside(running, monkeypatch, path, shown):
    monkeypatch.setenv("RTKIT_SERVERS", "a:1")
    root, _ = place.root_for(lambda: fake_tree(FakeManager([])), parse_path(path), is_deep=False)
    assert list(root.children) == shown
    others = ["other.mgr", "third.mgr"] if path != "/localhost:2811" else []
    assert list(root.children["localhost"].children) == ["manager.mgr", *others]


def test_nothing_is_added_where_it_would_not_be_seen(running):
    path = parse_path("/localhost/manager.mgr")
    root, _ = place.root_for(lambda: fake_tree(FakeManager()), path, is_deep=True)
    assert list(root.children["localhost"].children) == ["manager.mgr"]


def nobody():
    raise Unreachable("manager 'manager' is not running")


@pytest.mark.parametrize(
    ("path", "shown"), [("/", ["localhost", "a:1"]), ("/localhost", ["localhost"])]
)
def test_without_a_manager_the_others_are_shown(running, monkeypatch, path, shown):
    monkeypatch.setenv("RTKIT_SERVERS", "a:1")
    with socket.socket(socket.AF_UNIX) as service:
        service.bind(str(running / "arm.ps"))
        service.listen()
        root, _ = place.root_for(nobody, parse_path(path), is_deep=False)
    assert list(root.children) == shown
    local = root.children["localhost"]
    assert list(local.children) == ["arm", "other.mgr", "third.mgr"]
    assert local.remark == "manager 'manager' is not running; services: 1"
    with pytest.raises(Unreachable):
        place.root_for(nobody, parse_path("/localhost/d"), is_deep=False)


def test_a_manager_that_hangs_is_not_passed_over(running, monkeypatch):
    monkeypatch.setattr(place, "_others", lambda manager: iter(["manager", "other"]))
    for path in ("/", "/localhost"):
        with pytest.raises(Unreachable):
            place.root_for(nobody, parse_path(path), is_deep=False)
    monkeypatch.setenv("RTKIT_SERVERS", "a:1")
    root, _ = place.root_for(nobody, parse_path("/"), is_deep=False)
    assert list(root.children) == ["localhost", "a:1"]


def test_where_nothing_is_at_all_the_manager_is_missed(running, monkeypatch):
    monkeypatch.setattr(place, "_others", lambda manager: iter([]))
    with pytest.raises(Unreachable):
        place.root_for(nobody, parse_path("/"), is_deep=False)


@pytest.mark.parametrize(
    ("manager", "asked_at", "path"),
    [
        ("manager", "", "/localhost/d/A.rtc"),
        ("manager", "localhost:2810", "/localhost/d/A.rtc"),
        ("other", "other", ""),
        ("other", "localhost:2811", "/localhost:2811/d/A.rtc"),
    ],
)
def test_how_a_name_is_typed(running, manager, asked_at, path):
    assert place.shown("localhost/d/A.rtc", manager, asked_at) == path


def test_only_managers_that_hold_their_lock_run(running):
    from rtkit.link.running import managers

    assert managers() == []
    descriptor = os.open(running / "other.lock", os.O_RDWR)
    child = os.fork()
    if not child:  # the lock of a process is not seen by itself
        ready = os.open(running / "ready", os.O_WRONLY | os.O_CREAT)
        fcntl.lockf(descriptor, fcntl.LOCK_EX)
        os.close(ready)
        os.kill(os.getpid(), 19)
        os._exit(0)
    try:
        os.waitpid(child, os.WUNTRACED)
        assert managers() == ["other"]
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)
        os.close(descriptor)
    assert managers() == []


def test_others_are_asked_at_the_same_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))  # where nobody serves anything
    both = threading.Barrier(2, timeout=30.0)

    def connect(name: str, _timeout_s: float) -> None:
        both.wait()
        raise Unreachable(f"{name} is silent")

    monkeypatch.setattr("rtkit.tree.place.connect", connect)
    monkeypatch.setattr("rtkit.tree.place._others", lambda _manager: iter(["a", "b"]))
    root = TreeNode("", NodeKind.ROOT)
    local = root.add(TreeNode("localhost", NodeKind.HOST))
    place.add_others(root, fake_tree(FakeManager()), parse_path("/"), is_deep=True)
    assert local.trouble == "a is silent; b is silent"
    assert [node.trouble for node in local.children.values()] == ["a is silent", "b is silent"]


def test_entries_of_servers_that_are_no_addresses_are_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("RTCTREE_NAMESERVERS", "b;")
    assert strange_servers() == ["RTCTREE_NAMESERVERS: not HOST:PORT: 'b'"]
    monkeypatch.setenv("RTKIT_SERVERS", "a:1; rubbish;:7;;corbaloc::c:3")
    told = [f"RTKIT_SERVERS: not HOST:PORT: {each!r}" for each in ("rubbish", ":7")]
    assert strange_servers() == told
    assert servers() == ["a:1", "corbaloc::c:3"]
