"""Execution contexts: what drives components, and when."""
