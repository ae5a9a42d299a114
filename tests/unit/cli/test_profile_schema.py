"""The catalogue of schemas: for editors and xmllint; each name in a schema is explained."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from lxml import etree

from rtkit.profile_tools.catalogue import schemas
from rtkit.resources import resource

XS = "{http://www.w3.org/2001/XMLSchema}"
SYSTEM = Path(resource("profiles", "systems", "sensor-controller-motor.xml"))


@pytest.mark.skipif(shutil.which("xmllint") is None, reason="xmllint is not installed")
def test_xmllint_checks_by_the_catalogue_without_a_network(shell: Any, tmp_path: Path) -> None:
    told = shell.run(f"rtprofile schema -o {tmp_path}")
    assert (
        told.err == f"written  {tmp_path}/catalog.xml\nwritten  {tmp_path}/.vscode/settings.json\n"
    )
    good = SYSTEM.read_text()
    environment = {**os.environ, "XML_CATALOG_FILES": f"{tmp_path}/catalog.xml"}
    for text, status in ((good, 0), (good.replace('isRequired="true"', 'isRequired="x"'), 3)):
        (tmp_path / "system.xml").write_text(text)
        space = next(each.namespace for each in schemas() if each.namespace.endswith("rts"))
        command = ["xmllint", "--noout", "--nonet", "--schema", space, tmp_path / "system.xml"]
        done = subprocess.run(command, env=environment, capture_output=True, check=False)
        assert done.returncode == status, done.stderr


def test_settings_of_an_editor_keep_what_they_had(shell: Any, tmp_path: Path) -> None:
    settings = tmp_path / ".vscode" / "settings.json"
    settings.parent.mkdir()
    settings.write_text('{"a": 1, "xml.catalogs": ["own.xml"]}')
    for _ in range(2):
        assert shell.run(f"rtprofile schema -o {tmp_path}").status == 0
        wanted = {"a": 1, "xml.catalogs": ["own.xml", "catalog.xml"]}
        assert json.loads(settings.read_text()) == wanted


@pytest.mark.parametrize("text", ["{ // a comment\n}", "[]", '{"xml.catalogs": 3}'])
def test_settings_that_cannot_be_merged_stay_as_they_are(
    shell: Any, tmp_path: Path, text: str
) -> None:
    settings = tmp_path / ".vscode" / "settings.json"
    settings.parent.mkdir()
    settings.write_text(text)
    told = shell.run(f"rtprofile schema -o {tmp_path}")
    assert told.status == 1
    assert '"xml.catalogs": ["catalog.xml"]' in told.err
    assert settings.read_text() == text
    assert not (tmp_path / "catalog.xml").exists()


def test_schemas_are_listed(shell: Any) -> None:
    records = jsonrecords.checked(shell.ok("rtprofile schema --json"))
    assert [each["form"] for each in records] == ["XML", "JSON"] * 2
    assert all(each["schema"] == "rtkit.schema-file/1" for each in records)
    assert all(Path(each["path"]).is_file() for each in records)
    assert shell.run("rtprofile schema -o nowhere").err == (
        "rtprofile schema: no such folder: nowhere\n"
    )


def test_each_name_in_a_schema_is_explained_to_who_points_at_it() -> None:
    for file in Path(resource("schemas")).glob("*.xsd"):
        for kind in ("element", "attribute", "complexType", "simpleType"):
            for each in etree.parse(file).iter(f"{XS}{kind}"):
                has_text = each.find(f"{XS}annotation/{XS}documentation") is not None
                assert has_text or "ref" in each.attrib, (file, dict(each.attrib))
