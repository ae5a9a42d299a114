"""The site is built without a warning, and is read without a network."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import html

ROOT = Path(__file__).parents[2]
LOADING = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src"}
"""Elements that have a browser load what an attribute names."""
REMOTE = re.compile(r"^\s*(https?:)?//")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    options = [
        "--quiet",
        "--fail-on-warning",
        "--keep-going",
        "--doctree-dir",
        str(folder / "read"),
    ]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, "docs", str(folder / "html")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "html"


def pages(site: Path) -> Iterator[tuple[str, html.HtmlElement]]:
    for file in sorted(site.rglob("*.html")):
        yield str(file.relative_to(site)), html.fromstring(file.read_bytes())


@pytest.mark.timeout(240)
def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    remote = [
        (name, element.get(attribute))
        for name, page in pages(site)
        for tag, attribute in LOADING.items()
        for element in page.iter(tag)
        if REMOTE.match(element.get(attribute) or "") and element.get("rel") != "canonical"
    ]
    assert remote == []
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        loaded = re.findall(r"(?:url\(|@import)\s*['\"]?([^'\")\s]+)", text)
        assert [each for each in loaded if REMOTE.match(each)] == [], style


@pytest.mark.timeout(240)
def test_each_page_has_its_place_in_the_site(site: Path) -> None:
    names = {name for name, _ in pages(site)}
    sources = {file.relative_to(ROOT / "docs") for file in (ROOT / "docs").rglob("*.md")}
    own = {str(file.with_suffix(".html")) for file in sources if file.parts[0] != "generated"}
    assert own - names == set()
    manual = {f"generated/man/{file.stem}.html" for file in (ROOT / "man").glob("*.1")}
    assert manual <= names


@pytest.mark.timeout(240)
def test_links_between_pages_lead_somewhere(site: Path) -> None:
    broken = []
    for name, page in pages(site):
        for link in page.iter("a"):
            target = (link.get("href") or "").partition("#")[0]
            is_here = target and not re.match(r"\w+:", target)
            if is_here and not (site / name).parent.joinpath(target).exists():
                broken.append((name, target))
    assert broken == []
