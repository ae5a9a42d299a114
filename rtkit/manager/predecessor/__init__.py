"""Processes that an earlier manager left: found again and adopted, or ended."""
