"""What is served is entered before the first request, and left after the last."""

from __future__ import annotations

import pytest

import rtkit
from rtkit.errors import Refused


class Device:
    """Device that is open while it is served."""

    def __init__(self, fails: bool = False) -> None:
        self.calls: list[str] = []
        self._fails = fails

    def __enter__(self) -> Device:
        if self._fails:
            raise OSError("no such device")
        self.calls.append("open")
        self.speed = 1.5
        return self

    def __exit__(self, *raised: object) -> None:
        self.calls.append("closed")


def test_a_context_manager_is_entered_before_the_first_request_and_left_once(place: str) -> None:
    device = Device()
    with rtkit.Client() as client:
        with rtkit.serve(device, "device", is_on_zenoh=False) as served:
            assert client.get("device.calls") == ("open",)
            assert client.get("device.speed") == 1.5
            assert client.get("device.properties") == ("calls", "speed")
            with pytest.raises(Refused):
                rtkit.serve(Device(), "device")
        served.close()
    assert device.calls == ["open", "closed"]


def test_all_things_of_a_dictionary_are_served_under_their_keys(place: str) -> None:
    things = {"left": Device(), "right": Device()}
    with rtkit.serve(things, "both", is_on_zenoh=False), rtkit.Client() as client:
        assert client.get("both.right.speed") == 1.5
        client.set("both.left.speed", 2.5)
    assert things["left"].speed == 2.5
    assert [each.calls for each in things.values()] == [["open", "closed"]] * 2


def test_what_cannot_be_entered_is_not_served_and_the_others_are_left(place: str) -> None:
    things = {"left": Device(), "right": Device(fails=True)}
    with pytest.raises(OSError, match="no such device"):
        rtkit.serve(things, "both")
    assert things["left"].calls == ["open", "closed"]
    with rtkit.serve(things["left"], "both", is_on_zenoh=False):
        pass
