"""Packages of components: wheels built, checked, published, found and installed."""
