"""A listing as a tree."""

from __future__ import annotations

from rtkit.deployment.listing import Listing, ListingRow
from rtkit.tree.view import NodeKind, TreeNode, build, shown_path


def row(
    instance: str,
    *names: str,
    process: str = "manager",
    zombie: str = "",
    trouble: str = "",
    is_stand_in: bool = False,
    cause: str = "",
) -> ListingRow:
    counts = (1, 0, 1, 0, 0, 0)
    known = (process, zombie, trouble, is_stand_in, names, "0", cause)
    return ListingRow(instance, "Inactive", *counts, *known)


def tree(*rows: ListingRow, slaves: tuple[tuple[str, str, str], ...] = ()) -> TreeNode:
    names = ("localhost/manager.mgr",)
    return build(Listing("box", "manager", 1, slaves, rows, names))


def paths(root: TreeNode) -> list[str]:
    return [node.path for node in root.walk()]


def test_a_manager_without_components_is_shown() -> None:
    assert paths(tree()) == ["/", "/localhost", "/localhost/manager.mgr"]


def test_a_component_shows_at_its_names_and_below_its_manager() -> None:
    root = tree(row("M0", "localhost/M0.rtc", "localhost/a.host_cxt/b/Motor.rtc"))
    assert paths(root) == [
        "/",
        "/localhost",
        "/localhost/M0.rtc",
        "/localhost/a.host_cxt",
        "/localhost/a.host_cxt/b",
        "/localhost/a.host_cxt/b/Motor.rtc",
        "/localhost/manager.mgr",
        "/localhost/manager.mgr/M0.rtc",
    ]


def test_a_component_of_a_slave_shows_below_the_slave_too() -> None:
    root = tree(row("M0", process="s1"), slaves=(("s1", "up", ""),))
    slave = root.children["localhost"].children["manager.mgr"].children["s1.mgr"]
    assert paths(slave) == [
        "/localhost/manager.mgr/s1.mgr",
        "/localhost/manager.mgr/s1.mgr/M0.rtc",
    ]
    assert (slave.kind, slave.is_slave, slave.process) == (NodeKind.MANAGER, True, "s1")
    assert not root.children["localhost"].children["manager.mgr"].is_slave


def test_names_of_this_host_are_below_localhost_others_below_theirs() -> None:
    root = tree(row("A", "box/A.rtc"), row("B", "127.0.0.1:2810/B.rtc"), row("C", "far:2810/C.rtc"))
    assert sorted(root.children) == ["far:2810", "localhost"]
    assert {"A.rtc", "B.rtc"} <= set(root.children["localhost"].children)
    assert root.children["far:2810"].kind is NodeKind.HOST


def test_a_name_without_host_is_passed_over() -> None:
    assert paths(tree(row("A", "A.rtc", "")))[-1] == "/localhost/manager.mgr/A.rtc"


def test_entries_are_sorted_by_name() -> None:
    root = tree(row("b", "localhost/b.rtc"), row("a", "localhost/a.rtc"))
    names = [node.name for node in root.children["localhost"].entries()]
    assert names == ["a.rtc", "b.rtc", "manager.mgr"]


def test_remarks() -> None:
    root = tree(
        row("A", zombie="signal 9"),
        row("B", trouble="stopped", is_stand_in=True),
        row("C", is_stand_in=True),
        row("D"),
        row("E", cause="ValueError: x (e.py:1)"),
        row("F", cause="ValueError: x (f.py:1)", trouble="stopped", is_stand_in=True),
        row("G", cause="ValueError: x (g.py:1)", zombie="signal 9"),
        slaves=(("s1", "lost", "signal 11"), ("s2", "stopped", "stopped"), ("s3", "starting", "")),
    )
    manager = root.children["localhost"].children["manager.mgr"]
    assert {name: node.remark for name, node in manager.children.items()} == {
        "A.rtc": "signal 9",
        "B.rtc": "stopped, stand-in",
        "C.rtc": "stand-in",
        "D.rtc": "",
        "E.rtc": "ValueError: x (e.py:1)",
        "F.rtc": "stopped, ValueError: x (f.py:1), stand-in",
        "G.rtc": "signal 9",
        "s1.mgr": "lost: signal 11",
        "s2.mgr": "stopped",
        "s3.mgr": "starting",
    }
    assert manager.children["A.rtc"].kind is NodeKind.ZOMBIE
    assert manager.remark == ""


def test_a_manager_shows_at_each_of_its_names_with_all_that_it_holds() -> None:
    names = ("localhost/manager.mgr", "box/box.host_cxt/manager.mgr", "nowhere")
    root = build(Listing("box", "manager", 1, (("s1", "up", ""),), (row("A"),), names))
    below = ["/A.rtc", "/s1.mgr"]
    for place in ("/localhost/manager.mgr", "/localhost/box.host_cxt/manager.mgr"):
        found = [path for path in paths(root) if path.startswith(place)]
        assert found == [place, *(place + leaf for leaf in below)]


def test_a_manager_without_a_name_is_not_shown() -> None:
    root = build(Listing("box", "manager", 1, (("s1", "up", ""),), (row("A", "localhost/A.rtc"),)))
    assert paths(root) == ["/", "/localhost", "/localhost/A.rtc"]


def test_names_show_where_they_are_found() -> None:
    assert shown_path("box/a/M.rtc", "box") == "/localhost/a/M.rtc"
    assert shown_path("far:2810/M.rtc", "box") == "/far:2810/M.rtc"
