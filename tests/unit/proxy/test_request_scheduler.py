"""Which requests may be made at once over connections that answer one at a time."""

from __future__ import annotations

import pytest

from rtkit.wires.request_scheduler import RequestScheduler, ScheduledRequest


class Asked:
    """Requests by what they are: ``speed`` is a GET, ``speed=`` a SET."""

    def __init__(self, most: int = 8) -> None:
        self.turns = RequestScheduler(most)
        self.by_name: dict[str, ScheduledRequest] = {}

    def ask(self, *told: str) -> list[str]:
        for each in told:
            target = each.removesuffix("=")
            turn = ScheduledRequest(target, each.endswith("="), lambda: None)
            self.by_name[each] = turn
            self.turns.add(turn)
        return self.begun()

    def begun(self) -> list[str]:
        begun = self.turns.begin()
        return [each for each, turn in self.by_name.items() if turn in begun]

    def end(self, told: str) -> list[str]:
        self.turns.end(self.by_name[told])
        return self.begun()


@pytest.mark.parametrize(
    ("told", "begun"),
    [
        (("a", "b", "a.x", "properties"), ["a", "b", "a.x", "properties"]),
        (("a=", "b"), ["a=", "b"]),
        (("a=", "a.x"), ["a="]),
        (("a.x=", "a"), ["a.x="]),
        (("a", "a="), ["a"]),
        (("a=", "b="), ["a="]),
        (("a=", "properties"), ["a="]),
        (("a", "properties="), ["a"]),
        (("properties=", "a"), ["properties="]),
        (("a=", "b=", "b", "c"), ["a=", "c"]),
        # What may wait at the owner is passed, once it is on its way.
        (("a?echo=", "a.stop=", "a.state"), ["a?echo=", "a.stop="]),
        (("a=", "a?echo=", "a"), ["a="]),
    ],
)
def test_who_goes_first(told: tuple[str, ...], begun: list[str]) -> None:
    assert Asked().ask(*told) == begun


def test_who_waits_goes_on_when_it_can() -> None:
    asked = Asked()
    assert asked.ask("a=", "b=", "b", "a") == ["a="]
    assert asked.end("a=") == ["b=", "a"]
    assert asked.end("a") == []
    assert asked.end("b=") == ["b"]
    assert asked.end("b") == []


def test_there_are_so_many_at_once() -> None:
    asked = Asked(most=2)
    assert asked.ask("a", "b", "c", "d") == ["a", "b"]
    assert asked.end("b") == ["c"]
    assert asked.end("a") == ["d"]
