"""What owners of a service meet: registration, changes, refusals."""

from __future__ import annotations

import pytest

from rtkit.errors import Refused
from rtkit.guard import GuardedResult
from rtkit.property.codes import CODES, PropertyError, code_of
from rtkit.property.functional import FunctionalProperty
from rtkit.property.messages import Answer, failed
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.service import Service
from rtkit.property.types import parse_type
from rtkit.property.user_code import result_of


@pytest.mark.parametrize("name", ["a.b", "a%2Eb", "%61", "ä".encode().hex("%", 1)])
def test_a_name_in_another_spelling_is_taken(name: str) -> None:
    name = f"%{name}" if name == "c3%a4" else name
    service = Service()
    service.add(name, 1)
    other = (
        name.replace("a", "%61", 1) if name.startswith("a") else name.lower().replace("%61", "a")
    )
    with pytest.raises(PropertyError, match="exists"):
        service.add(other, 2)


def test_an_escaped_dot_parts_nothing() -> None:
    service = Service()
    service.add("a%2Eb", 1)
    service.add("a.b", 2)
    assert service.get("a%2eb") == "1"
    assert service.get("properties") == "(a%2Eb a)"


@pytest.mark.parametrize(
    "name", ["meta", "a.listen", "gui.x", "properties", "%6Deta", "a.history.b"]
)
def test_reserved_names_are_not_shadowed(name: str) -> None:
    with pytest.raises(PropertyError, match="reserved"):
        Service().add(name, 1)


@pytest.mark.parametrize("name", ["", "a b", "a..b", "ä", "a/b", "%zz", "%C3", "a\n"])
def test_bad_names_are_refused(name: str) -> None:
    with pytest.raises(PropertyError):
        Service().add(name, 1)


def test_what_is_removed_goes_with_all_below_it() -> None:
    service = Service()
    for name in ("arm.a.x", "arm.a.y", "arm.b", "leg"):
        service.add(name, 1)
    service.remove("arm.a")
    assert service.get("properties?all") == "(arm arm.b leg)"
    service.remove("arm.b")
    assert service.get("properties?all") == "(leg)"
    with pytest.raises(PropertyError, match="no such property"):
        service.remove("arm")


def test_names_that_read_as_numbers_are_quoted_in_lists() -> None:
    service = Service()
    for name in ("1", "nan", "true", "e5", "-"):
        service.add(name, 1)
    assert service.get("properties") == '("1" "nan" "true" e5 -)'
    assert service.get('properties?names=("1"%20"nan")&values') == '(("1" 1) ("nan" 1))'


def test_a_refused_bulk_set_takes_back_what_it_did() -> None:
    log = []

    def write(value, given):  # type: ignore[no-untyped-def]
        log.append(value)
        if value == 13:
            raise ValueError("unlucky")

    service = Service()
    service.add("a", 1, "number", write=write)
    service.add("b", 2, "number", write=write)
    with pytest.raises(PropertyError, match="b: unlucky"):
        service.set("properties", "((a 5) (b 13))")
    assert log == [5, 13, 1]
    assert service.get("properties?values") == "((a 1) (b 2))"


def test_a_lost_update_is_refused() -> None:
    service = Service()
    service.add("x", 1)
    revision = int(str(service.get("x.meta.revision")))
    service.set(f"x?if={revision}", "2")
    with pytest.raises(PropertyError, match="revision of x is") as refused:
        service.set(f"x?if={revision}", "3")
    assert refused.value.code == "conflict"
    assert service.get("x") == "2"


def test_the_same_value_is_no_change() -> None:
    service = Service()
    service.add("x", float("nan"))
    before = service.get("x.meta.revision")
    service.set("x", "nan")
    assert service.get("x.meta.revision") == before
    service.set("x", "0.0")
    service.set("x", "-0.0")
    assert int(str(service.get("x.meta.revision"))) == int(str(before)) + 2


def test_a_request_with_an_id_acts_once_and_waits_with_the_first() -> None:
    begun = []
    service = Service()
    service.add(
        "go", function=FunctionalProperty(lambda: None, run=lambda work, end: begun.append(end))
    )
    answers: list[Answer] = []
    for _ in range(3):
        service.handle(PropertyRequest("go?echo&id=9", "", answers.append))
    assert (len(begun), answers) == (1, [])
    begun[0](None, None)
    assert [answer.payload for answer in answers] == ['<call state="done"/>'] * 3
    caller = Requester("c")
    service.add("n", 0)
    for payload in ("1", "2", "1"):
        service.handle(PropertyRequest("n", payload, answers.append, caller, "5"))
    assert service.get("n") == "2"


def test_a_running_action_is_busy() -> None:
    service = Service()
    service.add("go", function=FunctionalProperty(lambda: None, run=lambda work, end: None))
    service.set("go", "")
    with pytest.raises(PropertyError) as busy:
        service.set("go", "")
    assert busy.value.code == "busy"
    assert service.get("go") == '<call state="running"/>'
    with pytest.raises(PropertyError, match="cannot be stopped"):
        service.set("go.stop", "true")


def test_what_yields_can_be_stopped() -> None:
    steps, work_of = [], []

    def walk():  # type: ignore[no-untyped-def]
        for step in range(10):
            steps.append(step)
            if step == 2:
                service.set("walk.stop", "true")
            yield

    service = Service()
    service.add(
        "walk", function=FunctionalProperty(walk, run=lambda work, end: work_of.append((work, end)))
    )
    service.set("walk", "")
    work, end = work_of[0]
    end(work(), None)
    assert steps == [0, 1, 2]
    assert service.get("walk.state") == "stopped"


@pytest.mark.parametrize(
    ("payload", "expected"), [("(1 2)", (1, 2)), ("((1 2))", (1, 2)), ("()", ())]
)
def test_a_group_may_be_the_only_argument(payload: str, expected: tuple[int, ...]) -> None:
    taken = []
    function = FunctionalProperty(
        lambda v: taken.append(v), (RequestParameter("v", parse_type("vector")),)
    )
    service = Service()
    service.add("f", function=function, spec=PropertySpec(is_functional=True))
    service.set("f", payload)
    assert taken == [expected]


def test_foreign_errors_have_codes_too() -> None:
    from rtkit import errors

    kinds = (errors.Malformed, errors.Refused, errors.NotFound, errors.Unreachable)
    assert [code_of(kind("x")) for kind in kinds] == [
        "bad-value", "conflict", "unknown", "no-service"]  # fmt: skip
    assert code_of(KeyError("x")) == "internal"
    assert set(CODES) > {"unknown", "timeout", "checksum"}
    assert PropertyError("timeout", "x").detail == 5


def test_an_error_that_travelled_keeps_its_words() -> None:
    assert failed(RuntimeError("no sensor")) == Answer("RuntimeError: no sensor", "internal")
    again = PropertyError("internal", "RuntimeError: no sensor")
    assert failed(again) == Answer("RuntimeError: no sensor", "internal")


def test_what_user_code_refuses_is_a_conflict_in_its_own_words() -> None:
    with pytest.raises(PropertyError, match=r"^in a wall$") as caught:
        result_of(GuardedResult(None, Refused("in a wall")))
    assert caught.value.code == "conflict"
    with pytest.raises(PropertyError, match=r"^KeyError: 'x'$") as caught:
        result_of(GuardedResult(None, KeyError("x")))
    assert caught.value.code == "internal"
