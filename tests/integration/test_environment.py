"""Environment model: what several sensors and models tell, asked as clients do."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import pytest

import rtkit
from rtkit import Marker
from rtkit.services.environment import Environment


class Robot:
    """Knows where it is."""

    location: tuple[float, ...] = (1.0, 2.0, 0.0, 0.0, 0.0, math.pi / 2)


@pytest.fixture
def client(place: str) -> Iterator[rtkit.Client]:
    with (
        rtkit.serve(Environment(drift=0.0), "map"),
        rtkit.serve(Environment(drift=0.0), "own/left"),
        rtkit.serve(Environment(drift=0.0), "own/right"),
        rtkit.serve(Robot(), "robots/r1"),
        rtkit.Client(20.0) as client,
    ):
        yield client


def code(client: rtkit.Client, target: str, *value: object, **parameters: object) -> str:
    with pytest.raises(rtkit.PropertyError) as caught:
        client.set(target, *value, **parameters) if value else client.get(target, **parameters)
    return caught.value.code


def test_two_robots_that_see_one_ball_make_one_marker(client: rtkit.Client) -> None:
    now = time.time()
    ahead = Marker((1.0, 0.0, 0.5), type="ball", variance=0.02, time=now, color=(1.0, 0.1, 0.1))
    client.set("map.observe", ahead.with_(frame="robots/r1"))
    client.set("map.observe", ahead.with_(location=(1.0, 3.1, 0.5), frame="world", time=now + 0.1))
    (thing,) = client.get("map.markers")
    assert thing.location == pytest.approx((1.0, 3.05, 0.5))
    assert thing.variance == pytest.approx(0.01)
    assert (thing.frame, thing.id, thing.features["count"]) == ("world", "ball-1", 2)
    assert thing.time == pytest.approx(now + 0.1)
    assert thing.features["color"] == (1.0, 0.1, 0.1)
    (seen,) = client.get("map.markers", frame="robots/r1")
    assert seen.location == pytest.approx((1.05, 0.0, 0.5))
    assert seen.frame == "robots/r1"
    client.set("map.observe", ahead.with_(time=now + 0.2), frame="robots/r1")
    assert client.get("map.markers")[0].features["count"] == 3
    assert code(client, "map.markers", frame="moon") == "bad-parameter"
    assert code(client, "map.observe", ahead.with_(frame="moon")) == "bad-parameter"


def test_own_models_and_a_shared_one_give_the_same_answer(client: rtkit.Client) -> None:
    now = time.time()
    looks = [
        Marker((0.1 * number, -0.05 * number), type="ball", frame="world", time=now,
               covariance=((0.02, 0.01), (0.01, 0.01 * (number + 1))))
        for number in range(4)
    ]  # fmt: skip
    for number, look in enumerate(looks):
        client.set("own/left.observe" if number % 2 else "own/right.observe", look)
        if number == 1:
            client.set("map.merge", "own/left")
    for model in ("own/left", "own/right", "own/left"):
        client.set("map.merge", model)
    (merged,) = client.get("map.markers")
    with rtkit.serve(Environment(drift=0.0), "shared"):
        for look in looks:
            client.set("shared.observe", look)
        (shared,) = client.get("shared.markers")
    assert merged.location == pytest.approx(shared.location)
    for one, other in zip(merged.covariance, shared.covariance, strict=True):
        assert one == pytest.approx(other)
    assert merged.features["count"] == shared.features["count"] == 4
    assert merged.time == shared.time
    assert code(client, "map.merge", "nobody") == "no-service"


def test_models_that_merge_in_a_ring_count_what_was_seen_once(client: rtkit.Client) -> None:
    ring = ("own/left", "own/right", "map")
    ball = Marker((1.0, 1.0), type="ball", variance=0.04, time=time.time())
    for number, model in enumerate(ring):
        client.set(f"{model}.observe", ball.with_(location=(1.0, 1.0 + 0.03 * number)))
        client.set(f"{model}.grids.heat.observe", (0.1, 0.1, 20.0 + number))
    for _ in range(3):
        for model, other in zip(ring, (*ring[1:], ring[0]), strict=True):
            client.set(f"{model}.merge", other)
    client.set("own/left.observe", ball.with_(location=(1.0, 1.09)))
    for model, other in (("map", "own/left"), ("own/right", "map"), ("map", "own/right")):
        client.set(f"{model}.merge", other)
    for model in ring:
        (thing,) = client.get(f"{model}.markers")
        assert thing.features["count"] == 4
        assert thing.location == pytest.approx((1.0, 1.045))
        assert thing.variance == pytest.approx(0.01)
        assert client.get(f"{model}.grids.heat.counts") == ((3,),)
        assert client.get(f"{model}.grids.heat", at=(0.1, 0.1)) == 21
    for wrong in ([("x", 5, 7)], 7, [("x", "many", ())]):
        with rtkit.serve(type("Other", (), {"shares": wrong})(), "other"):
            assert code(client, "map.merge", "other") == "bad-value"
    client.set("map.merge", "map")  # nothing that it does not know
    assert client.get("map.markers.0.count") == 4
    client.set("map.maxage", 1e-3)
    assert client.get("map.markers") == ()
    assert [len(each) for each in client.get("map.shares")] == [3]


def test_markers_are_selected(client: rtkit.Client) -> None:
    now = time.time()
    seen = [
        Marker((float(number), 0.0), type=("ball", "box")[number % 2], time=now - number)
        for number in range(4)
    ]
    client.set("map.observe", seen)

    def xs(**parameters: object) -> list[float]:
        return [each.location[0] for each in client.get("map.markers", **parameters)]

    assert sorted(xs()) == [0.0, 1.0, 2.0, 3.0]
    assert sorted(xs(type="ball")) == [0.0, 2.0]
    assert sorted(xs(near=(0.0, 0.0, 1.5))) == [0.0, 1.0]
    assert sorted(xs(since=now - 1.5)) == [0.0, 1.0]
    client.set("map.maxage", 2.5)
    assert sorted(xs()) == [0.0, 1.0, 2.0]
    assert code(client, "map.markers", near=1) == "bad-parameter"
    assert code(client, "map.maxage", -1) == "bad-value"
    assert code(client, "map.observe", 7) == "bad-value"
    assert code(client, "map.observe", "<marker><location>(1)</location></marker>") == "bad-value"


def test_changes_are_heard(client: rtkit.Client) -> None:
    from queue import SimpleQueue

    heard: SimpleQueue[object] = SimpleQueue()
    client.listen("map.markers", lambda change: heard.put(change.value))
    assert heard.get(timeout=20) == ()
    client.set("map.observe", Marker((1.0, 1.0), type="ball"))
    assert len(heard.get(timeout=20)) == 1  # type: ignore[arg-type]


def test_grids(client: rtkit.Client) -> None:
    for values in ("(0.1 0.1 20)", "(0.2 0.2 22)", "(1.2 0.1 5)"):
        client.set("own/left.grids.temperature.observe", values)
    assert client.get("own/left.grids.temperature", at=(0.4, 0.4)) == 21
    assert math.isnan(client.get("own/left.grids.temperature", at=(9, 9)))
    ((first, empty, last),) = client.get("own/left.grids.temperature")
    assert (first, last) == (21, 5)
    assert math.isnan(empty)
    assert client.get("own/left.grids.temperature.counts") == ((2, 0, 1),)
    assert client.get("own/left.grids.temperature.origin") == (0, 0, 0.5)
    assert client.get("own/left.grids.properties") == ("temperature",)
    client.set("map.grids.temperature.observe", (0.1, 0.1, 12))
    for _ in range(2):
        client.set("map.merge", "own/left")
    assert client.get("map.grids.temperature", at=(0.1, 0.1)) == 18
    assert code(client, "map.grids.temperature.observe", "(1 2)") == "bad-value"
    assert code(client, "map.grids.temperature.observe", "(1e9 1e9 1)") == "too-large"
    assert code(client, "map.grids.temperature", "(1 2 3)") == "read-only"
    assert code(client, "map.grids.humidity") == "unknown"
    assert code(client, "map.grids.humidity.other", "(1 2 3)") == "unknown"
