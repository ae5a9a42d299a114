"""Two changes of one generated file come together, unless they are about the same lines."""

from __future__ import annotations

import random

from rtkit.builder.regions import CODE_STAMP, region, stamped
from rtkit.builder.three_way import merged_file, merged_lines


def code(*lines, names=("a",), content=("    pass",)):
    text = [CODE_STAMP, *lines]
    for name in names:
        text += region(name, "    ", content)
    return stamped("\n".join([*text, "end", ""]), has_regions=True)


def test_changes_at_different_lines_come_together():
    base = ["a", "b", "c", "d", "e"]
    assert merged_lines(base, ["a", "B", "c", "d", "e"], ["a", "b", "c", "e", "f"]) == [
        "a", "B", "c", "e", "f",
    ]  # fmt: skip
    assert merged_lines(base, base, ["x"]) == ["x"]
    assert merged_lines(base, [], base) == []


def test_the_same_change_counts_once_and_different_ones_do_not_fit():
    base = ["a", "b", "c"]
    assert merged_lines(base, ["a", "x", "c"], ["a", "x", "c"]) == ["a", "x", "c"]
    assert merged_lines(base, ["a", "x", "c"], ["a", "y", "c"]) is None


def test_one_sided_changes_of_any_kind_are_taken():
    random.seed(3)
    for _ in range(300):
        base = [random.choice("abcd") for _ in range(random.randrange(12))]
        other = [random.choice("abcd") for _ in range(random.randrange(12))]
        assert merged_lines(base, other, base) == other
        assert merged_lines(base, base, other) == other
        assert merged_lines(base, other, other) == other


def test_the_generated_part_of_users_is_merged_and_their_code_is_kept():
    base, new = code("one", "two", "three"), code("one", "two", "three", "four")
    mine = base.replace("one", "1").replace("    pass", "    mine = 1")
    merged = merged_file(base, mine, new, has_regions=True)
    assert merged == new.replace("one", "1").replace("    pass", "    mine = 1")
    again = merged_file(new, merged, code("one", "two", "four"), has_regions=True)
    assert "1\ntwo\nfour\n" in again


def test_what_was_generated_from_something_else_is_not_merged():
    base = code("one")
    assert merged_file(code("other"), base, code("two"), has_regions=True) == ""
    mine = code("one", names=("a", "b"), content=("    mine = 1",))
    assert merged_file(mine, mine, code("one"), has_regions=True) == ""
