"""Who has the lease of a manager, and when it ends."""

import json

import pytest

from rtkit.deployment.lease import Lease, LeaseHolder, holder_from_text
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
def lease(lives):
    def watch(pid):
        if pid > 9:
            raise ProcessLookupError(3, "No such process")
        return lives.setdefault(pid, Life())

    return Lease(watch)


def wanted(number, command="rtapply a.xml"):
    return LeaseHolder(f"id{number}", command, "ann", "box", number, 0.0)


def take(lease, number):
    return lease.asked(json.dumps({"take": encode(wanted(number))}))


def give(lease, number):
    return lease.asked(json.dumps({"give": f"id{number}"}))


def test_one_has_it_until_he_gives_it_back(lease, lives):
    assert holder_from_text(lease.asked(None)) is None
    assert take(lease, 1) == ""
    assert holder_from_text(lease.asked(None)) == wanted(1)
    with pytest.raises(Refused, match=r"rtapply a.xml \(ann, pid 1 on box, since "):
        take(lease, 2)
    give(lease, 2)
    assert lease.holder == wanted(1)
    give(lease, 1)
    assert lives[1].is_closed
    assert lease.holder is None
    take(lease, 2)


def test_it_ends_with_the_process(lease, lives):
    take(lease, 1)
    lives[1].is_over = True
    assert holder_from_text(lease.asked(None)) is None
    assert lives[1].is_closed
    take(lease, 2)
    give(lease, 1)
    assert lease.holder == wanted(2)


def test_nobody_has_it_who_cannot_be_watched(lease):
    with pytest.raises(Malformed, match=r"process 10 cannot be watched: .*No such process"):
        take(lease, 10)
    take(lease, 1)


@pytest.mark.parametrize(
    "text", ["", "no", "1", "[]", "{}", '{"take": 1}', '{"take": {"id": "a"}}', '{"have": "id1"}']
)
def test_what_is_no_request_is_refused(lease, text):
    take(lease, 1)
    with pytest.raises(Malformed):
        lease.asked(text)
    assert lease.holder == wanted(1)
