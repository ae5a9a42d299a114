"""Pages: each example is run, written to a file, replayed, or says why it is not."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest
from pagekit import ROOT, blocks, pages

from rtkit.wires.table import WIRES

RUN = ("sh", "python", "text")
MOST_LINES_OF_THE_README = 150


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_each_example_is_tried_or_says_why_not(page: Path) -> None:
    untried = [
        block.text
        for block in blocks(page)
        if not block.is_marked and block.language not in RUN and block.language[:1] != "{"
    ]
    assert untried == []
    text = page.read_text(encoding="utf-8")
    written = len(blocks(page)) - text.count("<!-- rows are run -->\n|")
    assert f"\n{text}".count("\n```") == 2 * written, "a fence without its end"


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_no_example_trusts_that_something_has_happened_by_now(page: Path) -> None:
    """Who wrote a value, or killed a process, waits for what others make of it."""
    script = [
        line
        for block in blocks(page)
        if not block.is_marked and block.language == "sh"
        for line in block.text.splitlines()
    ]
    hasty = [
        line
        for before, line in pairwise(["", *script])
        if line.startswith("sleep ")
        or (re.match(r"rtvlog --no-follow .*\|", line) and not before.startswith("until rtvlog"))
    ]
    assert hasty == []


def test_the_readme_is_short() -> None:
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= MOST_LINES_OF_THE_README


OF_PACKAGES = sorted({each.package for each in WIRES.values()})


@pytest.mark.parametrize(
    ("page", "place", "names"),
    [
        ("docs/architecture.md", r"^wires .*", OF_PACKAGES),
        ("docs/glossary.md", r"^\| wire, record .*", OF_PACKAGES),
        ("docs/concepts.md", r"several \*wires\*\n.*", OF_PACKAGES),
        ("docs/wires.md", r"^\| purpose (.|\n)*?\n\n", OF_PACKAGES),
        ("docs/howto/live-properties.md", r"^## Wires\n(.|\n)*?\n#", OF_PACKAGES),
        ("rtkit/cli/help/texts/security.txt", r"^The wire is [^.]*", list(WIRES)),
    ],
)
def test_pages_that_list_the_wires_have_each(page: str, place: str, names: list[str]) -> None:
    found = re.search(place, (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None
    text = found[0].lower()
    assert [each for each in names if not re.search(rf"\b{each}s?\b", text)] == []


def test_check_lists_name_files_that_are_there() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = re.findall(r"`((?:rtkit|tests|schemas|tools|docs)/[\w./]+)`", text)
    meant = {name for name in named if not re.search("[A-Z]{2,}|00NN", name)}
    assert len(meant) > 20
    assert [name for name in meant if not (ROOT / name).exists()] == []


def test_a_newcomers_light_and_robot_are_small() -> None:
    """Blank lines do not count."""
    page = (ROOT / "docs/howto/write-a-service.md").read_text(encoding="utf-8")
    files = re.findall(r"<!-- file: (\S+) -->\n```python\n(.*?)```", page, re.DOTALL)
    sizes = {name: sum(bool(line.strip()) for line in text.splitlines()) for name, text in files}
    assert sizes.keys() == {"light.py", "robot.py"}
    assert sizes["light.py"] <= 25
    assert sizes["robot.py"] <= 40
