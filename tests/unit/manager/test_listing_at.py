"""Listings of a few paths: what is found in them is what the whole listing has there."""

from __future__ import annotations

import pytest
from fake_shell import FakeShell, wire

from rtkit.deployment.actions import Connect, Register
from rtkit.deployment.listing import Listing, listing_from_text
from rtkit.errors import NotFound, RtkitError
from rtkit.link import zenoh_keys
from rtkit.manager.query_server import ManagerQueryServer
from rtkit.property.exchange import Reply, Request
from rtkit.rtc.names import Path, parse_path
from rtkit.tree.resolve import component, find, manager, node_at, nodes_at


class Asked:
    """Manager whose views are asked for; counts the rows of all."""

    def __init__(self, shell: FakeShell) -> None:
        self.query_server = ManagerQueryServer(shell.state, shell.requests)
        self.rows: list[int] = []

    def listing(self) -> Listing:
        return self._view("listing")

    def listing_at(self, paths: list[Path]) -> Listing:
        which = "\n".join("/".join(path.elements) for path in paths)
        return self._view(f"listing/{zenoh_keys.escape(which)}")

    def _view(self, name: str) -> Listing:
        replies: list[Reply] = []
        self.query_server.take(Request(name, None, replies.append, is_extension=True))
        listing = listing_from_text(replies[0].value())
        self.rows.append(len(listing.rows))
        return listing


class Old(Asked):
    """Manager of a version that has no such listings."""

    def listing_at(self, paths: list[Path]) -> Listing:
        raise NotFound("no such view")


@pytest.fixture
def shell(shell):
    for name in ("A", "B"):
        shell.make(name)
    for name in ("C", "Z"):
        shell.make(name, slave=f"s{name}")
    shell.ask(Register("A", "localhost/arm/left/A.rtc"))
    shell.ask(Register("B", "box/B2.rtc"))
    shell.ask(Connect(wire("w")))
    shell.serve()
    shell.end(shell.state.containers["Z"])
    return shell


PATHS = (
    "/localhost/A.rtc", "/localhost/arm/left/A.rtc", "/localhost/manager.mgr/A.rtc",
    "/localhost/manager.mgr/sC.mgr/C.rtc", "/localhost/manager.mgr/sC.mgr/A.rtc",
    "/localhost/C.rtc:out", "/localhost/B2.rtc", "/localhost:2810/B.rtc", "/127.0.0.1/B.rtc",
    "/localhost/Z.rtc", "/localhost/manager.mgr", "/localhost/manager.mgr/sC.mgr", "/localhost/",
    "/localhost/arm", "/localhost/D.rtc", "/far/A.rtc", "/", "/localhost/A,B.rtc", "/localhost/A*",
)  # fmt: skip


def outcome(asked, how, *typed):
    try:
        nodes = nodes_at(asked, [parse_path(each) for each in typed], how)
    except RtkitError as error:
        return type(error), str(error)
    return [node and (node.path, node.kind, node.row, node.process) for node in nodes]


@pytest.mark.parametrize("typed", PATHS)
@pytest.mark.parametrize("how", [find, component, manager])
def test_what_is_found_is_what_the_whole_listing_has(shell, how, typed):
    assert outcome(Asked(shell), how, typed) == outcome(Old(shell), how, typed)


def test_no_more_is_asked_for_than_what_is_at_the_paths(shell):
    asked = Asked(shell)
    (node,) = nodes_at(asked, [parse_path("/localhost/A.rtc")], component)
    assert node.row is not None
    assert (node.instance, node.row.outs_connected) == ("A", 1)
    assert outcome(asked, component, "/localhost/A.rtc", "/localhost/C.rtc")
    assert node_at(asked, parse_path("/localhost/manager.mgr"), manager).process == "manager"
    assert asked.rows == [1, 2, 0]


def test_an_error_tells_what_may_have_been_meant(shell):
    shell.make("Motor")
    kind, why = outcome(Asked(shell), component, "/localhost/Moto.rtc")
    assert kind is NotFound
    assert "did you mean /localhost/Motor.rtc?" in why


def test_two_components_at_one_path_are_told_as_the_whole_listing_does(shell):
    shell.ask(Register("A", "localhost/X.rtc"))
    shell.ask(Register("B", f"{shell.state.host}/X.rtc"))
    shell.serve()
    asked = Asked(shell)
    assert outcome(asked, find, "/localhost/X.rtc") == outcome(Old(shell), find, "/localhost/X.rtc")
    assert asked.rows == [4]
