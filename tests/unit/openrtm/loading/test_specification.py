"""Types of modules for OpenRTM-aist, told without running them."""

from __future__ import annotations

from pathlib import Path

import pytest
from openrtm_corpus import needs_components
from openrtm_files import MOTOR, write_component

from rtkit.errors import Malformed
from rtkit.modules.describing import describe


def test_a_module_tells_its_types_and_parameters(tmp_path: Path) -> None:
    file = write_component(tmp_path, "One", "\tpass", '"conf.default.gain", "4",')
    (offer,) = describe(file.read_bytes(), str(file)) or []
    assert offer.type.full_id == "RTC:me:example:One:Python:1.2"
    assert offer.parameters == {"gain": "4"}


def test_what_only_shows_when_it_runs_is_not_told(tmp_path: Path) -> None:
    file = write_component(tmp_path, "One", "pass")
    text = file.read_text(encoding="utf-8").replace("spec = [", "spec = list() or [")
    with pytest.raises(Malformed, match="known only when it runs"):
        describe(text.encode(), str(file))


@needs_components
def test_a_published_component_is_described() -> None:
    (offer,) = describe(MOTOR.read_bytes(), str(MOTOR)) or []
    assert offer.type.id == "RTC:Noriaki Ando, AIST:example:Motor:1.0"
