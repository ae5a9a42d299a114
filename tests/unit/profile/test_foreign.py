"""Content that no profile format knows is kept wherever there is an element to keep it in."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree

from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile
from rtkit.profile.write import write_profile
from rtkit.profile.xmlnames import NAMESPACES, split

NEW = "urn:new"
TEXT_ONLY = ("VersionUpLogs", "Literal", "LowerBoundary", "UpperBoundary", "osVersions", "cpus")
SAMPLES = {name: Path(__file__).parent / "samples" / f"{name}.xml" for name in ("rtc", "rts")}


def places() -> list[tuple[str, int, str]]:
    """Every element of the samples, with every namespace that may bring something new there."""
    found = []
    for kind, file in SAMPLES.items():
        names = (NEW, *(uri for prefix, uri in NAMESPACES.items() if prefix.startswith(kind)))
        for number, element in enumerate(etree.parse(file).iter()):
            local = split(element.tag)[1]
            extensions = [name for name in names if not name.endswith(kind)]
            if local not in TEXT_ONLY:
                found += [(kind, number, name) for name in extensions]
    return found


@pytest.mark.parametrize(("kind", "number", "namespace"), places())
def test_what_is_new_is_kept(kind: str, number: int, namespace: str) -> None:
    root = etree.parse(SAMPLES[kind]).getroot()
    element = list(root.iter())[number]
    element.set(f"{{{namespace}}}newer", "a\n<b>")
    added = etree.SubElement(element, f"{{{namespace}}}Newer", {"plain": "1"})
    added.text = "some "
    etree.SubElement(added, "{urn:deeper}x").tail = " more"
    reading = read_profile(etree.tostring(root))
    assert all(note.rule == "foreign-kept" for note in reading.notes), reading.notes
    for form in FORMS:
        again = read_profile(write_profile(reading.profile, form)).profile
        assert again == reading.profile
    written = etree.fromstring(write_profile(reading.profile))
    (kept,) = written.iter(f"{{{namespace}}}Newer")
    assert kept.getparent().tag == element.tag
    assert kept.getparent().get(f"{{{namespace}}}newer") == "a\n<b>"
    assert (kept.text, kept.get("plain"), kept[0].tail) == ("some ", "1", " more")
