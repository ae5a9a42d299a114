"""An indexed table finds what a look at each of its rows would find, whatever was done to it."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.manager.core.checkpoint import copied
from rtkit.manager.core.indexed_table import IndexedTable

KEYS, TERMS = st.sampled_from("abcd"), st.sampled_from("xyz")
ROWS = st.lists(TERMS, max_size=3).map(tuple)
STEPS = st.lists(st.tuples(st.sampled_from(["put", "pop", "find", "copy"]), KEYS, ROWS))


def table() -> IndexedTable[str, Sequence[str]]:
    return IndexedTable(lambda row: row, {})


@given(STEPS)
def test_a_search_finds_the_rows_with_a_term_and_no_others(steps) -> None:
    indexed, plain = table(), {}
    for step, key, row in steps:
        if step == "put":
            indexed[key] = plain[key] = row
        elif step == "pop":
            assert indexed.pop(key, None) == plain.pop(key, None)
        elif step == "copy":
            indexed = copied(indexed)
        else:
            assert indexed.keys_with("x") >= set()  # from here on the index is kept up
    assert indexed == plain
    for term in "xyz":
        assert set(indexed.keys_with(term)) == {key for key, row in plain.items() if term in row}


def test_rows_are_found_in_the_order_of_their_arrival_also_when_they_are_replaced() -> None:
    indexed = table()
    indexed["b"], indexed["a"] = ("x",), ("x",)
    assert list(indexed.keys_with("x")) == ["b", "a"]
    indexed["b"] = ["x"]
    indexed["c"] = ("x",)
    assert list(indexed.keys_with("x")) == ["b", "a", "c"]


def test_a_row_that_is_not_there_cannot_be_removed() -> None:
    indexed = table()
    with pytest.raises(KeyError):
        del indexed["a"]
    with pytest.raises(KeyError):
        indexed.pop("a")
    assert indexed.pop("a", 1) == 1


@given(STEPS)
def test_a_journal_has_the_rows_that_were_put_or_removed_since_the_last_look(steps) -> None:
    indexed = table()
    indexed["a"] = ("x",)
    journal, all_of_it = indexed.begin_journal(), indexed.begin_journal()
    touched, ever = set(), set()
    for step, key, row in steps:
        if step == "put" or (step == "pop" and key in indexed):
            touched.add(key)
            ever.add(key)
        if step == "put":
            indexed[key] = row
        elif step == "pop":
            indexed.pop(key, None)
        elif step == "find":
            assert set(journal.take()) == touched
            touched.clear()
    assert set(journal.take()) == touched
    indexed.end_journal(journal)
    indexed["b"] = ()
    assert not journal.take()
    assert set(all_of_it.take()) == ever | {"b"}
