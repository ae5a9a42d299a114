"""The inbox of a client: what is kept for a consumer that takes events slowly."""

from __future__ import annotations

import pytest

from rtkit.property.line import read_event
from rtkit.wires.property_client import Inbox


def left(inbox: Inbox, *values: str) -> list[object]:
    for value in values:
        inbox.put(read_event("speed", value, ""))
    return [event.payload for event in iter(inbox.take, None)]


@pytest.mark.parametrize("target", ["speed", "robot/speed", "arm/left.rtc/speed"])
def test_the_latest_is_kept_whatever_service_was_named(target: str) -> None:
    inbox = Inbox()
    inbox.expect(target, "")
    assert left(inbox, "1", "2", "3") == ["3"]


def test_with_a_queue_all_are_kept() -> None:
    inbox = Inbox()
    inbox.expect("robot/speed", "queue=2")
    assert left(inbox, "1", "2", "3") == ["1", "2", "3"]


def test_of_two_services_that_have_the_name_all_are_kept() -> None:
    inbox = Inbox()
    inbox.expect("robot/speed", "")
    inbox.expect("arm/speed", "")
    assert left(inbox, "1", "2", "3") == ["1", "2", "3"]
