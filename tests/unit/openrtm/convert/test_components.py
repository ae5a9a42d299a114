"""Existing components converted to native ones: how many, and whether they do the same."""

from __future__ import annotations

import ast
import csv
import json
import subprocess
import sys
import warnings
from functools import cache
from pathlib import Path

import pytest
from openrtm_corpus import COMPONENTS, needs_components
from openrtm_pairs import native, original, record

from rtkit.component import Component, InPort, OutPort
from rtkit.errors import RtkitError
from rtkit.openrtm.convert.conversion import Conversion, convert
from rtkit.openrtm.convert.draft import API, FOREIGN, ModuleDraft
from rtkit.openrtm.migrate.source import mended, read_source, with_spaces
from rtkit.openrtm.migrate.to_python3 import converted

pytestmark = needs_components
FIRST_TIER = {
    "DataFlowComponentBase", "Delete", "InPort", "Manager", "OutPort", "Properties",
    "instantiateDataType", "setTimestamp",
}  # fmt: skip
"""Names of the API that make up the first tier, beside data types and return codes."""
BEYOND = {
    "addConnectorDataListener", "addConnectorListener", "addPort", "get_owned_contexts",
    "_configsets", "_properties", "_rtcout", "getLogbuf",
}  # fmt: skip
"""Members by which a component is of the second tier."""
LEAST = 0.8
"""Share of the first tier that is converted without a hand."""


def paths() -> list[Path]:
    """Return the files of components, as the manifest lists them."""
    if not COMPONENTS.is_dir():
        return []
    with open(COMPONENTS / "MANIFEST.tsv", encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
    return [COMPONENTS / row[0] for row in rows if row[1] == "component"]


@cache
def python3(path: Path) -> bytes:
    """Return a source as Python 3."""
    source = path.read_bytes()
    made = converted(source, str(path))
    return made.data if made else source


@cache
def conversion(path: Path) -> Conversion | None:
    """Return the conversion of a component; None where it is refused."""
    try:
        return convert(path.read_bytes(), str(path))
    except RtkitError:
        return None


@cache
def tier(path: Path) -> int:
    """Return 1 for a component that uses the first tier of the API only, else 2."""
    text = with_spaces(read_source(mended(python3(path), str(path))).text)
    draft = ModuleDraft(text.lstrip("\ufeff"), str(path.parent))
    for node in ast.walk(draft.source.tree):
        if isinstance(node, ast.Attribute) and node.attr in BEYOND:
            return 2
        if isinstance(node, (ast.Attribute, ast.Name)) and not _is_first(draft, node):
            return 2
    return 2 if draft.stubs else 1


def _is_first(draft: ModuleDraft, node: ast.Attribute | ast.Name) -> bool:
    scope, _, rest = draft.qualified(node).partition(".")
    if not rest or scope not in FOREIGN:
        return True
    if scope == API:
        return rest.partition(".")[0] in FIRST_TIER
    known = draft.data_class(f"{scope}.{rest.removeprefix('_d_')}") is not None
    return known or rest in ("RTC_OK", "RTC_ERROR", "RTObject", "TimedBool", "TimedBoolSeq")


def clean() -> list[Path]:
    """Return the components that are converted without a hand."""
    return [each for each in paths() if (made := conversion(each)) and not made.marks]


def name_of(path: Path) -> str:
    """Return a short name for a test."""
    return path.relative_to(COMPONENTS).as_posix().replace(" ", "_")


def test_most_of_the_first_tier_needs_no_hand() -> None:
    first = [each for each in paths() if tier(each) == 1]
    done = set(clean())
    for each in first:
        if each not in done:
            made = conversion(each)
            why = [f"{m.line}: {m.reason}" for m in made.marks] if made else ["refused"]
            sys.stdout.write(f"{name_of(each)}\n  " + "\n  ".join(why) + "\n")
    share = sum(each in done for each in first) / len(first)
    sys.stdout.write(f"{share:.0%} of {len(first)} components\n")
    assert len(first) >= 20
    assert share >= LEAST


@pytest.mark.parametrize("path", [p for p in paths() if conversion(p)], ids=name_of)
def test_each_conversion_compiles_and_has_its_marks_at_their_places(path: Path) -> None:
    made = conversion(path)
    assert made is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the author's texts
        compile(made.text, str(path), "exec")
    assert made.text.count("# rtkit convert: ") >= len(made.marks)
    lines = python3(path).splitlines()
    assert all(0 < mark.line <= len(lines) for mark in made.marks)


def test_conversions_have_no_finding_of_pyflakes(tmp_path: Path) -> None:
    for number, path in enumerate(clean()):
        made = conversion(path)
        assert made is not None
        (tmp_path / f"m{number}_{path.name}").write_text(made.text, encoding="utf-8")
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "F"]
    done = subprocess.run(
        [*command, "--output-format", "json", str(tmp_path)], capture_output=True, check=False
    )
    assert json.loads(done.stdout) == []


@pytest.mark.parametrize("path", clean(), ids=name_of)
def test_a_converted_component_does_what_the_old_one_does(path: Path, tmp_path: Path) -> None:
    made = conversion(path)
    assert made is not None
    old_class = original(path, tmp_path / "old", python3(path))
    new_class = native(path, tmp_path / "new", made)
    assert outside(new_class("A0")) == outside(old_class("A0"))
    assert identity(new_class) == identity(old_class)
    for seed in range(3):
        old = record(old_class, tmp_path / "old", seed)
        assert record(new_class, tmp_path / "new", seed) == old


def outside(component: Component) -> object:
    """Return ports, data types and configuration sets of a component, as others see them."""
    component.on_initialize()
    ports = {
        name: (type(port).__name__, port.properties["dataport.data_type"])
        for name, port in component.ports.items()
        if isinstance(port, (InPort, OutPort))
    }
    sets = component.configuration.sets
    return ports, {k: sorted(v) for k, v in sets.items() if not k.startswith("__")}


def identity(cls: type[Component]) -> tuple[str, ...]:
    """Return what a component says of its type."""
    profile = cls.type_profile()
    names = ("type_name", "vendor", "category", "version", "description")
    return tuple(getattr(profile, name) for name in names)
