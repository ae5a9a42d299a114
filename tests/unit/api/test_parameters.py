"""Scripts load system profiles with values and prefixes."""

from __future__ import annotations

from pathlib import Path

import pytest

import rtkit
from rtkit.errors import InvalidDocument, Malformed

FILES = Path(__file__).parents[1] / "cli" / "files" / "systems"
PAIRS = FILES / "pairs.yaml"


def test_values_and_a_prefix_are_given() -> None:
    made = rtkit.load(PAIRS, values={"limit": 3, "right": False}, prefix="x.")
    assert made.components == ["x.left.Range0", "x.left.Motor0"]
    assert made.profile.components[0].configuration_sets[0].data[0].data == "3"
    assert rtkit.load(made) is made
    assert made.check().is_valid
    assert repr(made) == f"<SystemProfile {PAIRS}: 2 components>"


def test_a_profile_that_includes_others_is_whole_without_values() -> None:
    assert len(rtkit.load(PAIRS).components) == 4


def test_a_loaded_profile_gets_a_prefix() -> None:
    plain = rtkit.load(FILES / "parts" / "pair.xml")
    made = rtkit.load(plain, values={"Range0.limit": 7}, prefix="b.")
    assert made.components == ["b.Range0", "b.Motor0"]
    assert plain.components == ["Range0", "Motor0"]


def test_a_value_for_nothing_is_refused() -> None:
    with pytest.raises(Malformed, match=r"^no variable limt \(did you mean limit\?\)"):
        rtkit.load(PAIRS, values={"limt": 3})
    with pytest.raises(InvalidDocument, match=r"pairs.yaml:14: '\$\{right\}' is 'perhaps'"):
        rtkit.load(PAIRS, values={"right": "perhaps"})
