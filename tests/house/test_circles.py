"""No circles of imports: each module is understood by what lies below it."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def imports(root: Path) -> dict[str, set[str]]:
    """Return what each module imports: at its top, for types only, and within functions."""
    files = {}
    for file in root.rglob("*.py"):
        parts = file.relative_to(root.parent).with_suffix("").parts
        files[".".join(parts).removesuffix(".__init__")] = file
    found = {}
    for module, file in files.items():
        names: set[str] = set()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names.update(each.name for each in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                inner = {each.name: f"{node.module}.{each.name}" for each in node.names}
                names.update(full if full in files else node.module for full in inner.values())
        found[module] = {name for name in names if name in files and name != module}
    return found


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(reversed(error.args[1]))
    return []


def test_no_module_imports_itself_by_way_of_others() -> None:
    """Imports within functions close circles, too, and there are none of them."""
    assert circle(imports(ROOT / "rtkit")) == []


@pytest.mark.parametrize(
    "text", ["import {}", "from {} import x", "def f():\n    import {}", "if 0:\n    import {}"]
)
def test_a_circle_is_found_wherever_an_import_stands(tmp_path: Path, text: str) -> None:
    package = tmp_path / "p"
    package.mkdir()
    (package / "a.py").write_text("from p import b")
    (package / "b.py").write_text(text.format("p.c"))
    (package / "c.py").write_text("")
    assert circle(imports(package)) == []
    (package / "c.py").write_text("import p.a")
    assert sorted(set(circle(imports(package)))) == ["p.a", "p.b", "p.c"]
