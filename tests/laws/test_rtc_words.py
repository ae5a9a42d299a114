"""Create strings, paths and records: written and read again they are the same."""

from __future__ import annotations

import json
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.deployment.actions import (  # noqa: F401 - hypothesis reads annotations that name them
    ComponentPattern,
    ConnectorProfile,
)
from rtkit.deployment.batch import Batch, batch_from_text, batch_to_text
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.listing import Listing, listing_from_text, listing_of, listing_to_text
from rtkit.errors import Malformed
from rtkit.rtc.create import CreateString, parse_create
from rtkit.rtc.names import parse_path
from rtkit.rtc.serde import decode, encode

FIELD = st.text(st.characters(exclude_characters=":?", exclude_categories=["Cs"]), max_size=8)
NAME = FIELD.filter(lambda text: text.strip() != "")
KEY = st.text(st.characters(exclude_characters="=&?"), min_size=1, max_size=8)
CREATE = st.builds(
    CreateString, NAME, FIELD, FIELD, FIELD, FIELD, st.dictionaries(KEY, st.text(max_size=8))
)
ELEMENT = st.text(st.characters(codec="utf-8", exclude_characters="/:\x7f", min_codepoint=32))
ELEMENTS = st.lists(ELEMENT.filter(lambda text: text not in ("", ".", "..")), max_size=5)


@given(CREATE)
def test_create_strings(create: CreateString) -> None:
    assert parse_create(str(create)) == create


@given(st.text())
def test_any_text_is_a_create_string_or_malformed(text: str) -> None:
    try:
        create = parse_create(text)
    except Malformed:
        return
    assert parse_create(str(create)) == create


@given(ELEMENTS)
def test_paths(elements: list[str]) -> None:
    path = parse_path("/" + "/".join(elements))
    assert path.elements == tuple(elements)
    assert parse_path(str(path)).elements == path.elements


@given(ELEMENTS, ELEMENTS)
def test_a_relative_path_is_meant_from_the_working_directory(
    directory: list[str], elements: list[str]
) -> None:
    cwd = "/" + "/".join(directory)
    absolute = parse_path(f"{cwd}/{'/'.join(elements)}").elements
    assert parse_path("/".join(elements), cwd).elements == absolute
    assert parse_path("../" * len(directory) + "x", cwd).elements == ("x",)


@given(st.text())
def test_any_text_is_a_path_or_malformed(text: str) -> None:
    try:
        path = parse_path(text, "/a/b")
    except Malformed:
        return
    assert path.typed == text
    assert not {"", ".", ".."} & set(path.elements)


@given(st.builds(Batch, timeout_s=st.floats(0.001, 86_400.0)))
@settings(max_examples=30, deadline=None)
def test_batches(batch: Batch) -> None:
    assert _plain(batch_from_text(batch_to_text(batch))) == _plain(batch)


@given(st.from_type(Snapshot))
@settings(max_examples=30, deadline=None)
def test_snapshots(snapshot: Snapshot) -> None:
    text = json.dumps(encode(snapshot))
    assert _plain(decode(Snapshot, json.loads(text))) == _plain(snapshot)


@given(st.from_type(Snapshot))
@settings(max_examples=30, deadline=None)
def test_listings(snapshot: Snapshot) -> None:
    listing = listing_of(snapshot)
    assert _plain(listing_from_text(listing_to_text(listing))) == _plain(listing)


@given(st.recursive(st.none() | st.integers() | st.text(), lambda x: st.lists(x, max_size=15)))
def test_anything_is_a_listing_or_malformed(data: object) -> None:
    try:
        assert isinstance(listing_from_text(json.dumps(data)), Listing)
    except Malformed:
        return


def _plain(record: object) -> object:
    if isinstance(record, tuple):
        return [_plain(item) for item in record]
    if isinstance(record, Mapping):
        return {key: _plain(value) for key, value in record.items()}
    if hasattr(record, "__dataclass_fields__"):
        return {name: _plain(getattr(record, name)) for name in record.__dataclass_fields__}
    return pytest.approx(record, nan_ok=True) if isinstance(record, float) else record
