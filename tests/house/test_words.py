"""The words of the code base, held to `docs/glossary.md`: one name for one thing."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TWICE = {
    "CameraImage": "two OMG modules, Img and RTC, each define a structure of that name",
    "Wire": "a protocol for properties, and in a drawing a line between two ports",
    "Tree": "a connection to a manager; that of scripts is derived from it",
    "Scene": "walls and objects of the simulated world, and in a drawing a whole system",
    "Path": "a path of the property tree, and in the public planner one through its states",
}
"""Public class names that stand for two things, with the reason."""

FOREIGN = ("openrtm/api", "openrtm/corba", "openrtm/csp")
"""Folders whose classes have the names that components written for OpenRTM-aist call."""


def class_names() -> dict[str, list[str]]:
    found = defaultdict(set)
    folder = ROOT / "rtkit"
    files = [*folder.rglob("*.py"), *folder.rglob("*.pyi")]
    for file in sorted(each for each in files if not str(each.parent).endswith(FOREIGN)):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found[node.name].add(str(file.relative_to(ROOT).with_suffix(".py")))
    return {name: sorted(files) for name, files in found.items()}


def test_a_public_class_name_stands_for_one_thing() -> None:
    twice = {name: files for name, files in class_names().items() if len(files) > 1}
    assert {name: files for name, files in twice.items() if name not in TWICE} == {}
    assert twice.keys() == TWICE.keys(), "an exception that is none any more goes"


@pytest.mark.parametrize("page", ["docs/glossary.md", "docs/architecture.md"])
def test_each_file_that_a_page_names_is_there(page: str) -> None:
    named = re.findall(r"`(rtkit/[\w/]+(?:\.\w+|/)?)`", (ROOT / page).read_text(encoding="utf-8"))
    assert named
    assert [name for name in named if not (ROOT / name).exists()] == []


CHATTY = re.compile(r"(^|_)(told|heard|hears?|says?|said|tells?|telling|saying)(_|$)")
AS_IT_IS = {
    "tell": "Python's own interface of a file calls it so",
    "is_heard": "dumps of managers have it as a key",
    "_is_heard": "dumps of managers have it as a key",
    "told": "dumps of managers have it as a key",
    "_told": "dumps of managers have it as a key",
    "_tell_by": "dumps of managers have it as a key",
}


def defined_names(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.id if isinstance(node, ast.Name) else node.attr


def test_names_say_what_is_reported_sent_or_received() -> None:
    chatty = []
    for file in sorted((ROOT / "rtkit").rglob("*.py")):
        names = set(defined_names(ast.parse(file.read_text(encoding="utf-8"))))
        if file.match("manager/core/*.py") or file.name == "recorder.py":
            names -= AS_IT_IS.keys()
        chatty += [f"{file.relative_to(ROOT)}: {n}" for n in sorted(names) if CHATTY.search(n)]
    assert chatty == []


HEADLESS = ("How", "What", "When", "Where", "Whether", "Which", "Who", "Whoever", "Whose", "Why")


def test_a_summary_names_its_subject() -> None:
    headless = []
    for file in sorted((ROOT / "rtkit").rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
        for node in (each for each in ast.walk(tree) if isinstance(each, kinds)):
            summary = (ast.get_docstring(node) or "").partition("\n")[0]
            if summary.split(" ")[0] in HEADLESS:
                headless.append(f"{file.relative_to(ROOT)}: {summary}")
    assert headless == []


def test_each_decision_that_code_names_is_there() -> None:
    there = {int(file.name[:4]) for file in (ROOT / "docs" / "decisions").glob("*.md")}
    texts = (file.read_text(encoding="utf-8") for file in (ROOT / "rtkit").rglob("*.py"))
    named = {int(number) for text in texts for number in re.findall(r"[Dd]ecisions? (\d+)", text)}
    assert named
    assert named <= there
