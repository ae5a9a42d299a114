"""Pages about every profile there is: nothing runs, nothing is loaded, every text is as it was."""

from __future__ import annotations

import os.path
from dataclasses import replace
from typing import Any

import pytest
from corpus import ROOT, TYPED, everything
from lxml import etree
from markdown_it import MarkdownIt

from rtkit.profile.read import read_file
from rtkit.profile.rtc_model import DataPortDoc, RtcProfile
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile_tools.component_page import component_page
from rtkit.profile_tools.page import Page, PageTable, Section, section
from rtkit.profile_tools.rendering import rendered
from rtkit.profile_tools.system_page import system_page

HTML = "{http://www.w3.org/1999/xhtml}"
NASTY = "<script>alert(1)</script> | `a` *b* _c_ [d](http://e) &amp; # \\ ~~f~~ 日本"


def files() -> list[str]:
    shipped = sorted((ROOT / "profiles").glob("*.xml")) + sorted(
        (ROOT / "profiles/systems").iterdir()
    )
    return [*everything(), *map(str, shipped)]


def page_of(profile: RtcProfile | RtsProfile) -> Page:
    return system_page(profile) if isinstance(profile, RtsProfile) else component_page(profile)


def checked(text: str) -> Any:
    """Parse a page, which may neither run nor load anything."""
    root = etree.fromstring(text.encode())
    for element in root.iter():
        name = etree.QName(element).localname
        assert name not in ("script", "link", "img", "iframe", "object", "base", "form", "a")
        assert not any(
            key.startswith("on") or "href" in key or key == "src" for key in element.attrib
        )
    policy = root.find(f".//{HTML}meta[@http-equiv]")
    assert policy.get("content").startswith("default-src 'none'")
    return root


def words(root: Any) -> str:
    return " ".join("".join(root.find(f"{HTML}body").itertext()).split())


@pytest.mark.parametrize("file", files(), ids=os.path.basename)
def test_every_profile_has_its_pages(file: str) -> None:
    profile = read_file(file).profile
    page = page_of(profile)
    root = checked(rendered(page, "html"))
    told = words(root)
    marked = rendered(page, "markdown", picture_file="a.svg")
    if isinstance(profile, RtcProfile):
        names = [port.name for port in (*profile.data_ports, *profile.service_ports)]
    else:
        names = [component.instance_name for component in profile.components]
    for name in names:
        assert " ".join(name.split()) in told
    renderer = MarkdownIt("commonmark", {"html": False}).enable("table").render(marked)
    shown = " ".join("".join(etree.HTML(renderer).itertext()).split())
    for name in names:
        assert " ".join(name.split()) in shown
    assert ("<svg" in rendered(page, "html")) == bool(page.picture)


def sensor() -> RtcProfile:
    profile = read_file(str(TYPED / "sensor.xml")).profile
    assert isinstance(profile, RtcProfile)
    return profile


def test_what_a_profile_documents_is_on_the_page() -> None:
    told = words(checked(rendered(component_page(sensor()), "html")))
    for text in (
        "Measures distances & filters them",
        "MIT",
        "The device is open",
        "(none,median)",
        "Calibration.idl",
        "at most 4",
        "PeriodicExecutionContext 50 Hz",
    ):
        assert text in told


def nasty() -> RtcProfile:
    profile = sensor()
    assert profile.basic_info is not None
    ports = tuple(
        replace(port, name=NASTY, type=NASTY, doc=DataPortDoc(description=NASTY, semantics=NASTY))
        for port in profile.data_ports
    )
    info = replace(profile.basic_info, name=NASTY, description=NASTY, comment=NASTY)
    return replace(profile, basic_info=info, data_ports=ports)


def test_any_text_is_shown_as_it_is() -> None:
    page = component_page(nasty())
    root = checked(rendered(page, "html"))
    assert root.find(f".//{HTML}h1").text == NASTY
    assert words(root).count(NASTY) >= 8
    renderer = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"])
    tree = etree.HTML(renderer.render(rendered(page, "markdown")))
    assert tree.find(".//h1").text == NASTY
    assert tree.find(".//script") is None
    assert tree.find(".//em") is tree.find(".//a") is tree.find(".//s") is None
    cells = [cell.text for cell in tree.iter("td")]
    assert cells.count(NASTY) >= 6


def test_line_breaks_of_builders_are_line_breaks() -> None:
    table = PageTable(("a", "b"), (("one<br/>two", ""), ("three<BR>four\r\nfive", "")))
    texts = ("one<br />two\n\n\nthree\nfour",)
    page = Page("T", "", (), "", "", (Section("S", texts, table),))
    root = checked(rendered(page, "html"))
    assert [list(p.itertext()) for p in root.iter(f"{HTML}p")] == [
        ["one", "two"],
        ["three", "four"],
    ]
    cells = [list(cell.itertext()) for cell in root.iter(f"{HTML}td")]
    assert cells == [["one", "two"], [], ["three", "four", "five"], []]
    assert rendered(page, "markdown") == (
        "# T\n\n## S\n\none\\\ntwo\n\nthree\\\nfour\n\n"
        "| a | b |\n| --- | --- |\n| one<br>two |  |\n| three<br>four<br>five |  |\n"
    )


def test_texts_that_look_like_markdown_are_texts() -> None:
    lines = (
        "# no heading",
        "- no item",
        "+ no item",
        "1. no item",
        "2) no item",
        "===",
        "    no code",
    )
    page = Page("T", "", (), "", "", tuple(Section("S", (line,)) for line in lines))
    tree = etree.HTML(MarkdownIt("commonmark").render(rendered(page, "markdown")))
    assert [paragraph.text for paragraph in tree.iter("p")] == [line.strip() for line in lines]


def test_what_is_empty_is_left_out() -> None:
    assert section("S", ["", None, " "], PageTable(("a",), ()), [None]) is None
    made = section("S", table=PageTable(("a", "b", "c"), (("1", "", "2"), ("3", " ", "4"))))
    assert made is not None
    assert made.table == PageTable(("a", "c"), (("1", "2"), ("3", "4")))


def test_the_picture_of_a_markdown_page_is_beside_it() -> None:
    page = component_page(sensor())
    assert "![The ports of Range](my%20file.svg)" in rendered(
        page, "markdown", picture_file="my file.svg"
    )
    assert "![" not in rendered(page, "markdown")
