"""The past: folded from kept changes it is what it was, however few of them are kept."""

from __future__ import annotations

import json
import random
from typing import Any

from rtkit.api.live_records import SystemRecords, change_between
from rtkit.web.flow.kept_changes import KeptChanges


def moment(rng: random.Random) -> SystemRecords:
    """Return some components and connectors of a few."""
    found = SystemRecords.nothing()
    for name, records in found._asdict().items():
        for number in range(4):
            if rng.random() < 0.5:
                id = f"{name}{number}"
                records[id] = {"id": id, "state": rng.randrange(3)}
    return found


def told(past: KeptChanges, count: int) -> list[tuple[float, SystemRecords]]:
    """Return moments with what was then; each change is kept by `past`."""
    rng, now, known = random.Random(7), SystemRecords.nothing(), []
    for number in range(count):
        after = moment(rng)
        change = change_between(now, after)
        fresh = {name: list(each.values()) for name, each in change.fresh._asdict().items()}
        events = [{"time": past.since + number + 1}]
        record: dict[str, Any] = {
            "revision": number + 1, **fresh, "gone": change.gone, "events": events,
        }  # fmt: skip
        past.stamp(record)
        known.append((record["time"], after))
        now = after
    return known


def test_each_moment_is_as_it_was() -> None:
    past = KeptChanges()
    known = told(past, 50)
    for time_s, records in known:
        assert past.at(time_s) == records
        assert past.at(time_s + 0.5) == records
    assert past.at(past.since) == SystemRecords.nothing()


def test_what_is_forgotten_is_in_the_picture_before_the_rest() -> None:
    past = KeptChanges(most=10)
    known = told(past, 50)
    assert past.since == known[39][0]
    assert past.before == known[39][1]
    for time_s, records in known[39:]:
        assert past.at(time_s) == records
    answer = json.loads(b"".join(past.pieces({"host": "box"})))
    assert [change["revision"] for change in answer["changes"]] == list(range(41, 51))
    assert (answer["picture"]["revision"], answer["picture"]["host"]) == (40, "box")


def test_large_changes_are_forgotten_sooner() -> None:
    past = KeptChanges(most_bytes=2000)
    told(past, 50)
    assert sum(len(piece) for piece in past.pieces({})) < 6000


def test_times_do_not_run_backwards() -> None:
    past = KeptChanges()
    gone: dict[str, list[str]] = {name: [] for name in SystemRecords._fields}
    rows: dict[str, Any] = {name: [] for name in SystemRecords._fields}
    times = []
    for time_s in (past.since + 5, past.since + 3):
        change = {"revision": 1, **rows, "gone": gone, "events": [{"time": time_s}]}
        past.stamp(change)
        times.append(change["time"])
    assert times == [past.since + 5, past.since + 5]


def test_an_earlier_past_is_put_before_what_is_kept() -> None:
    whole, later = KeptChanges(), KeptChanges()
    known = told(whole, 50)
    answer = json.loads(b"".join(whole.pieces({})))
    begun, first_look = known[29]
    later.begin(first_look, 30)
    later.since = begun
    for change in answer["changes"][30:]:
        later.stamp(change)
    changes = answer["changes"][:30]
    for each in changes:
        del each["revision"]
    assert later.reach_back(whole.since, whole.before, changes)
    assert later.since == whole.since
    for time_s, records in known:
        assert later.at(time_s) == records
    told_then = json.loads(b"".join(later.pieces({})))
    assert [each["revision"] for each in told_then["changes"]] == list(range(1, 51))
    assert told_then["picture"]["revision"] == 0


def test_an_earlier_past_that_no_longer_fits_is_left() -> None:
    past = KeptChanges(most=10)
    known = told(past, 50)
    assert not past.reach_back(0.0, SystemRecords.nothing(), [])
    assert past.at(known[45][0]) == known[45][1]
