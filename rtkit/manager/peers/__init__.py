"""Reaches the managers at the other ends of connectors, and notices their ends and returns."""
