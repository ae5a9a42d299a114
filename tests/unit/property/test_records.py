"""Dataclasses as elements: arguments, results, getters with setters, items of lists."""

from __future__ import annotations

import dataclasses
from typing import Annotated

import pytest

from rtkit import Marker, Range, Unit
from tests.unit.property.test_objects import refused, served


@dataclasses.dataclass(frozen=True)
class Part:
    name: str
    weight: Annotated[float, Unit("kg"), Range(0, 10)] = 1.0


@dataclasses.dataclass(frozen=True)
class Job:
    target: Marker
    parts: list[Part] = dataclasses.field(default_factory=list)
    first: Part | None = None
    after: float = 0.0

    def __post_init__(self) -> None:
        if self.after < 0:
            raise ValueError("after is in the past")


PART = "<part><name>bolt</name><weight>2</weight></part>"
PLACE = "<marker><location>(1 2)</location></marker>"
JOB = f"<job><target>{PLACE}</target><parts>{PART}{PART}</parts><first>{PART}</first></job>"


class Worker:
    parts: tuple[Part, ...] = ()

    def __init__(self) -> None:
        self._job = Job(Marker((0, 0)))
        self._did: list[Job] = []

    def get_job(self) -> Job:
        return self._job

    def set_job(self, job: Job) -> None:
        self._job = job

    def work(self, job: Job) -> Job:
        self._did.append(job)
        return dataclasses.replace(job, after=2.0)


WANTED = Job(Marker((1, 2)), [Part("bolt", 2.0)] * 2, Part("bolt", 2.0))


def test_a_dataclass_is_set_and_got_as_an_element() -> None:
    worker = Worker()
    service = served(worker)
    assert service.get("job.meta.type") == "element"
    service.set("job", JOB)
    assert worker._job == WANTED
    text = str(service.get("job"))
    service.set("job", text)
    assert worker._job == WANTED
    assert service.get("job") == text
    service.set("job.after", "3")
    assert worker._job.after == 3.0
    assert service.get("job.target.marker.location.0") == "1"
    service.set("parts", f"({PART})")
    assert worker.parts == (Part("bolt", 2.0),)


def test_a_dataclass_is_argument_and_result_of_an_action() -> None:
    worker = Worker()
    service = served(worker)
    answer = str(service.set("work?echo=1", JOB))
    assert worker._did == [WANTED]
    assert "&lt;after&gt;2.0&lt;/after&gt;" in answer


@pytest.mark.parametrize(
    ("job", "why"),
    [
        ("<job/>", "target: is missing"),
        (f"<task><target>{PLACE}</target></task>", "expected <job>"),
        (f"<job><target>{PART}</target></job>", "target: expected marker"),
        (JOB.replace(">2<", ">20<", 1), "parts: item 0: weight: 20 is above 10"),
        (JOB.replace("bolt", "(1 2)", 1), "parts: item 0: name: expected string"),
        (JOB.replace("<first>", "<last/><first>"), "last: is no field of job"),
        (JOB.replace("</job>", "<after>1</after><after>1</after></job>"), "after: is there twice"),
        (JOB.replace("</job>", "<after>-1</after></job>"), "in the past"),
        ("3", "expected"),
    ],
)
def test_what_does_not_fit_is_refused_by_the_name_of_the_field(job: str, why: str) -> None:
    worker = Worker()
    service = served(worker)
    for name in ("job", "work"):
        with pytest.raises(Exception, match=why):
            service.set(name, job)
        assert refused(service, name, job) == "bad-value"
    assert worker._did == []
    assert worker._job == Job(Marker((0, 0)))
