"""Paths to nodes, and the errors that users know."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.deployment.listing import Listing, ListingRow
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.rtc.names import parse_path
from rtkit.tree import resolve
from rtkit.tree.view import TreeNode, build


def row(instance: str, zombie: str = "") -> ListingRow:
    names = (f"localhost/{instance}.rtc",)
    return ListingRow(instance, "Inactive", 1, 0, 1, 0, 0, 0, "s1", zombie, "", False, names)


@pytest.fixture
def root() -> TreeNode:
    rows = (row("A"), row("Z", "signal 9"))
    names = ("localhost/manager.mgr",)
    return build(Listing("box.lan", "manager", 1, (("s1", "up", ""),), rows, names))


@pytest.mark.parametrize(
    "typed",
    [
        "/localhost/A.rtc",
        "localhost/A.rtc",
        "/localhost:2810/A.rtc",
        "/box.lan/A.rtc",
        "/box/A.rtc",
        "/box.lan:9/./x/../A.rtc",
        "/127.0.0.1/A.rtc",
        "/[::1]:2810/A.rtc",
    ],
)
def test_this_host_has_many_names(root: TreeNode, typed: str) -> None:
    node = resolve.find(root, parse_path(typed), "box.lan")
    assert node is not None
    assert node.path == "/localhost/A.rtc"


@pytest.mark.parametrize("typed", ["far/A.rtc", "/localhost/B.rtc", "/localhost/A.rtc/x"])
def test_what_is_not_there(root: TreeNode, typed: str) -> None:
    assert resolve.find(root, parse_path(typed), "box.lan") is None
    with pytest.raises(NotFound, match=f"^No such object: {typed}$"):
        resolve.entry(root, parse_path(typed), "box.lan")


@pytest.mark.parametrize(
    ("host", "told"),
    [
        ("fz", "no such host: fz (add it: rthost add fz USER@ADDRESS)"),
        ("robto1", "no such host: robto1 (did you mean robot1?)"),
        ("robot1", "host robot1 is not linked (rtmgr start --host robot1 links it)"),
    ],
)
def test_a_host_that_is_not_there_is_told_as_one(
    root: TreeNode, host: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("RTKIT_RUNTIME_DIR", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    (tmp_path / "hosts.toml").write_text('[robot1]\naddress = "x"\n')
    monkeypatch.chdir(tmp_path)
    for typed in (f"/{host}", f"/{host}/x", f"/{host}/manager.mgr"):
        why = resolve.absent(root, parse_path(typed), "box.lan")
        assert str(why) == f"{typed}: {told}"
    (tmp_path / "hosts.toml").write_text("[robot1")  # a command that goes there tells that
    assert "(add it: " in str(resolve.absent(root, parse_path("/robto1/x"), "box.lan"))


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("A.rtc", "/localhost/A.rtc"),
        ("/A.rtc", "/localhost/A.rtc"),
        ("A:in", "/localhost/A.rtc:in"),
        ("manager.mgr/s1.mgr", "/localhost/manager.mgr/s1.mgr"),
    ],
)
def test_what_lies_on_this_host_is_told(root: TreeNode, typed: str, meant: str) -> None:
    why = resolve.absent(root, parse_path(typed), "box.lan")
    assert str(why) == f"No such object: {typed} (did you mean {meant}?)"


@pytest.mark.parametrize(
    ("function", "typed", "error", "why"),
    [
        ("component", "/localhost/A.rtc", None, ""),
        ("component", "/localhost/B.rtc", NotFound, "No such object"),
        ("component", "/localhost/Z.rtc", Refused, "Zombie object"),
        ("component", "/localhost", Refused, "Not a component"),
        ("component", "/localhost/manager.mgr", Refused, "Not a component"),
        ("component", "/localhost/A.rtc/", Malformed, "Not a component"),
        ("component", "/localhost/A.rtc:in", Malformed, "Not a component"),
        ("component_of_port", "/localhost/A.rtc:in", None, ""),
        ("component_of_port", "/localhost/A.rtc/:in", NotFound, "No such object"),
        ("component_of_port", "/localhost/Z.rtc:in", Refused, "Zombie object"),
        ("component_of_port", "/localhost:in", Refused, "Not a component"),
        ("manager", "/localhost/manager.mgr", None, ""),
        ("manager", "/localhost/manager.mgr/", None, ""),
        ("manager", "/localhost/manager.mgr/s1.mgr", None, ""),
        ("manager", "/localhost/manager.mgr:in", Refused, "Not a manager"),
        ("manager", "/localhost/A.rtc", Refused, "Not a manager"),
        ("manager", "/localhost", Refused, "Not a manager"),
        ("manager", "/", Refused, "Not a manager"),
        ("manager", "/localhost/Z.rtc", Refused, "Zombie object"),
        ("manager", "/localhost/x.mgr", NotFound, "No such object"),
    ],
)
def test_kinds(
    root: TreeNode, function: str, typed: str, error: type[RtkitError] | None, why: str
) -> None:
    find = getattr(resolve, function)
    if error is None:
        assert find(root, parse_path(typed), "box.lan").name in typed
        return
    with pytest.raises(error, match=rf"^{why}: {typed}( \((signal 9|did you mean .*)\))?$"):
        find(root, parse_path(typed), "box.lan")
