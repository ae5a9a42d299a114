"""What a GET tells as JSON can be given back by a PUT, as it is or with another value."""

from __future__ import annotations

import json

import pytest

from rtkit.property.messages import Answer, Payload
from rtkit.wires.http.request import JSON, payload_of, response

PAYLOADS: tuple[Payload, ...] = (
    "7", "0.25", "-inf", "nan", "true", "idle", '"two words"', '"7"', "()", "(1 2.0)",
    '(a "b" (1 nan))', "plain (text",
    "<marker><location>(1 2)</location><color>red</color></marker>", b"\x00\xff{}",
)  # fmt: skip


@pytest.mark.parametrize("payload", PAYLOADS)
def test_what_was_told_means_the_same_when_it_is_given_back(payload: Payload) -> None:
    told = response(Answer(payload), "/ps/a/b", is_get=True, accepts=JSON, revision=1).body
    assert payload_of(told, JSON, is_text=False) == payload


def test_a_value_that_was_changed_counts_more_than_its_old_text() -> None:
    told = response(Answer("7"), "/ps/a/b", is_get=True, accepts=JSON, revision=1).body
    changed = json.loads(told) | {"value": 8}
    assert payload_of(json.dumps(changed).encode(), JSON, is_text=False) == "8"
