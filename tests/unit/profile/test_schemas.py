"""The schemas are valid, documented, and say the same as the tables and as each other."""

from __future__ import annotations

import os.path
from collections.abc import Iterator

import pytest
import xmlschema
from lxml import etree

from rtkit.errors import NotFound
from rtkit.profile.rtc_spec import RTC_PROFILE
from rtkit.profile.rts_spec import RTS_PROFILE
from rtkit.profile.spec import ElementSpec
from rtkit.profile.xmlnames import NAMESPACES
from rtkit.resources import resource

XS = "{http://www.w3.org/2001/XMLSchema}"
FILES = (
    "RtcProfile.xsd",
    "RtcProfileDoc.xsd",
    "RtcProfileExt.xsd",
    "RtsProfile.xsd",
    "RtsProfileExt.xsd",
    "RtsProfileRtkit.xsd",
    "XmlAttributes.xsd",
)


def tree(name: str) -> etree._Element:
    return etree.parse(resource("schemas", name)).getroot()


@pytest.mark.parametrize("name", FILES)
def test_both_libraries_accept_the_schema(name: str) -> None:
    etree.XMLSchema(file=resource("schemas", name))
    assert xmlschema.XMLSchema10(resource("schemas", name)).validity == "valid"


@pytest.mark.parametrize("name", FILES)
def test_everything_is_documented(name: str) -> None:
    root = tree(name)
    wanted = ("schema", "element", "attribute", "complexType", "simpleType")
    for item in root.iter(*(f"{XS}{tag}" for tag in wanted)):
        if item.get("ref") is None:
            text = item.findtext(f"{XS}annotation/{XS}documentation")
            assert text, f"{name}:{item.sourceline}"
            assert text.strip().endswith("."), f"{name}:{item.sourceline}"


def specs(spec: ElementSpec, seen: set[int] | None = None) -> Iterator[ElementSpec]:
    seen = set() if seen is None else seen
    if id(spec) in seen:
        return
    seen.add(id(spec))
    yield spec
    for child in spec.children:
        if child.spec is not None:
            yield from specs(child.spec, seen)


@pytest.mark.parametrize(("root", "start"), [(RTC_PROFILE, "Rtc"), (RTS_PROFILE, "Rts")])
def test_tables_and_schemas_know_the_same_names(root: ElementSpec, start: str) -> None:
    declared: dict[str, set[str]] = {"element": set(), "attribute": set()}
    for name in FILES:
        if name.startswith(start):
            schema = tree(name)
            for tag, names in declared.items():
                for item in schema.iter(f"{XS}{tag}"):
                    if item.get("name") is not None:
                        names.add(f"{{{schema.get('targetNamespace')}}}{item.get('name')}")
    every = list(specs(root))
    elements = {child.name for spec in every for child in spec.children}
    elements.add(f"{{{NAMESPACES[start.lower()]}}}{start}Profile")
    assert elements == declared["element"]
    assert {item.name for spec in every for item in spec.attributes} == declared["attribute"]


@pytest.mark.parametrize("root", [RTC_PROFILE, RTS_PROFILE])
def test_every_type_that_is_written_is_declared(root: ElementSpec) -> None:
    for spec in specs(root):
        for namespace, local in (*spec.also_types, *([spec.xsi_type] if spec.xsi_type else [])):
            homes = [
                schema for schema in map(tree, FILES) if schema.get("targetNamespace") == namespace
            ]
            assert homes[0].find(f"{XS}complexType[@name='{local}']") is not None


def test_resource_names_what_is_missing() -> None:
    assert os.path.isdir(resource("schemas"))
    with pytest.raises(NotFound, match="schemas/None does not ship"):
        resource("schemas", "None")
