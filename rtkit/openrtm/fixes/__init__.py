"""Fixers for fissix, where its own are not enough; each module has one, as fissix wants it."""
