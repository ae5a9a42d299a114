"""Serves the properties of this process: the loop that owns them, and its endpoints."""
