"""Ports of components, and what keeps values on their way between two of them."""
