"""Tells where profiles of other people are that tests read: beside this checkout, if anywhere."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORPUS = ROOT.parent / "shared" / "corpus"
TYPED = ROOT / "tests" / "unit" / "cli" / "files"
"""Profiles that the cases of commands speak of."""
needs_corpus = pytest.mark.skipif(not CORPUS.is_dir(), reason="corpus absent")


def corpus(*patterns: str) -> list[Path]:
    """Return the files of each pattern in order; none where the corpus is absent."""
    return [file for pattern in patterns for file in sorted(CORPUS.glob(pattern))]


def everything() -> list[str]:
    """Return all profiles of the corpus: components, systems, and those in YAML."""
    return list(map(str, corpus("rtc/*", "rts/*", "yaml/*")))
