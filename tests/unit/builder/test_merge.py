"""Generating again: code of users is kept, changes to the generated part are told."""

from __future__ import annotations

import pytest

from rtkit.builder.merge import MergeOutcome, merge
from rtkit.builder.regions import CODE_STAMP, FILE_STAMP, region, split, stamp_of, stamped
from rtkit.errors import Malformed


def code(*blocks, names=("a",)):
    lines = [CODE_STAMP, *blocks]
    for name in names:
        lines += region(name, "    ", ["    pass"])
    return "\n".join([*lines, "end", ""])


def again(old, new, *, has_regions=True):
    return merge(old, new, has_regions=has_regions)


def test_a_new_file_is_written_with_its_stamp():
    merged = again(None, code())
    assert merged.assignment is MergeOutcome.WRITE
    assert stamp_of(merged.text) not in ("", "0" * 12)
    assert again(merged.text, code()).assignment is MergeOutcome.SAME


def test_code_between_the_marks_is_kept():
    mine = stamped(code("one"), has_regions=True).replace("    pass", "    mine = 1\n\n    # 日本")
    merged = again(mine, code("one"))
    assert (merged.assignment, merged.text) == (MergeOutcome.SAME, mine)
    changed = again(mine, code("two"))
    assert changed.assignment is MergeOutcome.WRITE
    assert "    mine = 1\n\n    # 日本\n" in changed.text
    assert "two" in changed.text
    assert again(changed.text, code("two")).assignment is MergeOutcome.SAME


def test_what_was_emptied_stays_empty():
    mine = stamped(code("one"), has_regions=True).replace("    pass\n", "")
    assert "pass" not in again(mine, code("two")).text


def test_a_change_to_the_generated_part_is_a_conflict():
    mine = (
        stamped(code("one", "two"), has_regions=True).replace("two", "2").replace("pass", "x = 1")
    )
    merged = again(mine, code("one", "two"))
    assert (merged.assignment, merged.line) == (MergeOutcome.CONFLICT, 3)
    assert merged.why == "the generated part was changed"
    assert "x = 1" in merged.text
    assert "two" in merged.text


def test_code_without_a_place_is_a_conflict():
    mine = stamped(code(names=("a", "b")), has_regions=True)
    assert again(mine, code()).assignment is MergeOutcome.WRITE
    used = mine.replace("<user code b>\n    pass", "<user code b>\n    mine = 1")
    merged = again(used, code())
    assert merged.assignment is MergeOutcome.CONFLICT
    assert merged.why == "there is no place any more for your code b"
    assert used.split("\n")[merged.line - 1] == "    # <user code b>"


def test_a_file_of_somebody_else_is_a_conflict():
    merged = again("x = 1\n", code())
    assert (merged.assignment, merged.why) == (MergeOutcome.CONFLICT, "it was not made by rtbuild")


@pytest.mark.parametrize(
    ("before", "after", "why"),
    [
        ("# </user code a>", "", "the mark </user code a> is missing"),
        ("# <user code a>", "", "the mark <user code a> is missing before this line"),
        ("end", "# <user code a>\n# </user code a>", "the mark <user code a> is there twice"),
        ("    pass", "# <user code b>", "the mark </user code a> is missing before it"),
    ],
)
def test_broken_marks_are_a_conflict(before, after, why):
    mine = stamped(code(), has_regions=True).replace(before, after, 1)
    merged = again(mine, code())
    assert merged.assignment is MergeOutcome.CONFLICT
    assert merged.why == why
    assert merged.line > 1


def test_whole_files_are_the_user_s_once_changed():
    text = f"{FILE_STAMP}\none\n"
    made = again(None, text, has_regions=False).text
    assert again(made, text, has_regions=False).assignment is MergeOutcome.SAME
    assert again(made, f"{FILE_STAMP}\ntwo\n", has_regions=False).assignment is MergeOutcome.WRITE
    changed = again(made.replace("one", "mine"), text, has_regions=False)
    assert (changed.assignment, changed.why) == (MergeOutcome.KEEP, "it was changed")
    other = again("other\n", text, has_regions=False)
    assert (other.assignment, other.why) == (MergeOutcome.KEEP, "it was not made by rtbuild")


def test_marks_in_whole_files_mean_nothing():
    made = again(None, f"{FILE_STAMP}\none\n", has_regions=False).text
    mine = made + "# <user code a>\n"
    assert again(mine, f"{FILE_STAMP}\none\n", has_regions=False).assignment is MergeOutcome.KEEP


def test_regions_are_split_with_their_lines():
    parts = split("x\n  # <user code a>\n    1\n\n  # </user code a>\ny")
    assert parts.regions == {"a": ["    1", ""]}
    assert parts.numbers == [1, 2, 5, 6]
    with pytest.raises(Malformed, match=r"^1: the mark </user code a> is missing$"):
        split("# <user code a>")
