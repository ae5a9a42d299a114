"""Texts of views: whatever changed since the last one, they are what all facts say."""

from __future__ import annotations

import json

import pytest
from fake_shell import FakeShell, wire

from rtkit.deployment.actions import ActivateSet, Connect, Delete, Disconnect, Register
from rtkit.deployment.listing import listing_of, listing_to_text
from rtkit.fast_dataclass import replace
from rtkit.manager import view_texts
from rtkit.manager.view_texts import ViewTexts
from rtkit.rtc.serde import encode


class Viewer:
    """Looks at a state by the same texts each time."""

    def __init__(self, shell: FakeShell) -> None:
        self.shell = shell
        self.texts = ViewTexts(shell.state)

    def check(self) -> None:
        snapshot = self.shell.state.snapshot()
        assert self.texts.listing(snapshot) == listing_to_text(listing_of(snapshot))
        assert json.loads(self.texts.snapshot(snapshot)) == encode(snapshot)


@pytest.fixture
def viewer(shell):
    return Viewer(shell)


def test_texts_follow_what_is_done(shell, viewer):
    viewer.check()
    shell.make("A")
    shell.make("B", slave="s")
    viewer.check()
    for action in (
        Connect(wire("w")),
        Register("A", "localhost/x.rtc"),
        ActivateSet("A", "default"),
        Disconnect("w"),
        Connect(wire("v")),
    ):
        shell.ask(action)
        shell.serve()
        viewer.check()
    shell.end(shell.state.containers["B"])
    viewer.check()
    shell.ask(Delete("A"))
    shell.serve()
    viewer.check()


def test_half_a_connection_is_remarked(shell, viewer):
    shell.make("A")
    shell.make("B")
    shell.ask(Connect(wire("w")))
    shell.serve()
    viewer.check()
    shell.state.connectors["w"] = replace(shell.state.connectors["w"], trouble="other is away")
    viewer.check()


def test_composites_show_what_their_members_have(shell, viewer):
    shell.make("A")
    shell.make("B")
    shell.make("Whole")
    viewer.check()
    shell.state.update("Whole", members=("A",))
    shell.ask(Connect(wire("w")))
    shell.serve()
    viewer.check()


def test_only_what_has_changed_is_made_again(shell, viewer, monkeypatch):
    for name in ("A", "B", "C"):
        shell.make(name)
    viewer.check()
    made = []
    encoded = view_texts.encode
    monkeypatch.setattr(view_texts, "encode", lambda value: (made.append(value), encoded(value))[1])
    shell.state.update("B", cause="broken")
    viewer.check()
    assert [getattr(each, "instance", "") for each in made] == ["B", ""]
