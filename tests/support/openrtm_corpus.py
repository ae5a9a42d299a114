"""Existing components of OpenRTM-aist-Python beside the checkout, for tests."""

from pathlib import Path

import pytest
from corpus import ROOT

COMPONENTS = ROOT.parent / "shared" / "openrtm"

needs_components = pytest.mark.skipif(
    not COMPONENTS.is_dir(), reason="no existing components beside the checkout"
)


def sources() -> list[Path]:
    """Return every Python file of existing components."""
    return sorted(COMPONENTS.glob("**/*.py"))
