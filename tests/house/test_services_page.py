"""The page of the standard services names all that managers can load, and where classes are."""

from __future__ import annotations

import re
import tomllib
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "howto" / "services.md").read_text("utf-8")


def test_every_component_is_on_the_page() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    told = {name for row in PAGE.splitlines() if row.startswith("|")
            for name in re.findall(r"`(\w+)`", row.split("|")[3])}  # fmt: skip
    assert told == {*project["entry-points"]["rtkit.components"]}


def test_every_class_is_where_the_page_says() -> None:
    for module, name in re.findall(r"`(rtkit\.services[\w.]*):(\w+)`", PAGE):
        assert isinstance(getattr(import_module(module), name), type)


def test_the_first_light_has_25_lines_and_the_first_robot_40() -> None:
    page = (ROOT / "docs" / "howto" / "write-a-service.md").read_text("utf-8")
    for name, most in (("light", 25), ("robot", 40)):
        (code,) = re.findall(rf"<!-- file: {name}\.py -->\n```python\n(.*?)```", page, re.DOTALL)
        assert len([line for line in code.splitlines() if line.strip()]) <= most
