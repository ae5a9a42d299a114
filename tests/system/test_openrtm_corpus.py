"""Components of public repositories for OpenRTM-aist-Python are accepted as they lie."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import pytest
from openrtm_acceptance import accept
from openrtm_corpus import COMPONENTS, needs_components

_EXAMPLES = "OpenRTM__OpenRTM-aist-Python/OpenRTM_aist/examples/CSPStaticFsmSample"
REFUSED = {
    # It imports MicrowaveFsm_pyfsm and then says MicrowaveFsm.
    f"{_EXAMPLES}/Microwave_pyfsm.py": "NameError: name 'MicrowaveFsm' is not defined",
    # Its ini file was not published.
    "HiroakiMatsuda__MultiTypeConsoleIn/MultiTypeConsoleIn.py": "No section: 'DATA'",
}
"""Components that are not accepted, and the reason that is told."""


def components() -> list[str]:
    """Return the files of all components of the corpus, below its folder."""
    manifest = COMPONENTS / "MANIFEST.tsv"
    if not manifest.is_file():
        return []
    with open(manifest, encoding="utf-8", newline="") as stream:
        rows = csv.DictReader(stream, delimiter="\t")
        return [row["file"] for row in rows if row["kind"] == "component"]


@needs_components
@pytest.mark.parametrize("name", components())
def test_a_component_is_accepted(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    repository = name.partition("/")[0]
    shutil.copytree(COMPONENTS / repository, tmp_path / repository)
    monkeypatch.chdir((tmp_path / name).parent)  # as their users do, for files named relatively
    found = accept(tmp_path / name)
    if name in REFUSED:
        assert any(REFUSED[name] in why for why in found.failures.values()), found
    else:
        assert not found.failures
