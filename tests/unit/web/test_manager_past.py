"""The past of a manager, by its dump: what it held, also while somebody subscribed to it."""

from __future__ import annotations

import pytest
from fake_shell import FakeShell

from rtkit.manager.core import events as ev
from rtkit.manager.core.dump import Dump, to_lines
from rtkit.web.flow.manager_past import past_of


@pytest.mark.parametrize("is_subscribed", [False, True])
def test_what_a_manager_held_is_known_step_by_step(is_subscribed: bool) -> None:
    shell = FakeShell(ring_size=1000)
    if is_subscribed:
        shell.feed(ev.SnapshotRequested(shell.requests.add(lambda _reply: None)))
    shell.make("A")
    shell.make("B")
    header = {"clock": "1000.0", "monotonic": "0.0"}
    past = past_of("\n".join(to_lines(Dump(header, shell.ring.capture()))))
    held = [tuple(each.instance for each in step.facts.components) for step in past.steps]
    assert list(dict.fromkeys(held)) == [(), ("A",), ("A", "B")]
    appeared = [e.instance for step in past.steps for e in step.events if e.event == "APPEARED"]
    assert appeared == ["A", "B"]
