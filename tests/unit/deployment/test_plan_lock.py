"""Who has the lock of a manager, and when it ends."""

import json

import pytest

from rtkit.deployment.plan_lock import LockHolder, PlanLock, holder_from_text
from rtkit.errors import Malformed, Refused
from rtkit.rtc.serde import encode


class Life:
    def __init__(self):
        self.is_over = False
        self.is_closed = False

    def close(self):
        self.is_closed = True


@pytest.fixture
def lives():
    return {}


@pytest.fixture
def lock(lives):
    def watch(pid):
        if pid > 9:
            raise ProcessLookupError(3, "No such process")
        return lives.setdefault(pid, Life())

    return PlanLock(watch)


def wanted(number, command="rtapply a.xml"):
    return LockHolder(f"id{number}", command, "ann", "box", number, 0.0)


def take(lock, number):
    return lock.asked(json.dumps({"take": encode(wanted(number))}))


def give(lock, number):
    return lock.asked(json.dumps({"give": f"id{number}"}))


def test_one_has_it_until_he_gives_it_back(lock, lives):
    assert holder_from_text(lock.asked(None)) is None
    assert take(lock, 1) == ""
    assert holder_from_text(lock.asked(None)) == wanted(1)
    with pytest.raises(Refused, match=r"rtapply a.xml \(ann, pid 1 on box, since "):
        take(lock, 2)
    give(lock, 2)
    assert lock.holder == wanted(1)
    give(lock, 1)
    assert lives[1].is_closed
    assert lock.holder is None
    take(lock, 2)


def test_it_ends_with_the_process(lock, lives):
    take(lock, 1)
    lives[1].is_over = True
    assert holder_from_text(lock.asked(None)) is None
    assert lives[1].is_closed
    take(lock, 2)
    give(lock, 1)
    assert lock.holder == wanted(2)


def test_nobody_has_it_who_cannot_be_watched(lock):
    with pytest.raises(Malformed, match=r"process 10 cannot be watched: .*No such process"):
        take(lock, 10)
    take(lock, 1)


@pytest.mark.parametrize(
    "text", ["", "no", "1", "[]", "{}", '{"take": 1}', '{"take": {"id": "a"}}', '{"have": "id1"}']
)
def test_what_is_no_request_is_refused(lock, text):
    take(lock, 1)
    with pytest.raises(Malformed):
        lock.asked(text)
    assert lock.holder == wanted(1)
