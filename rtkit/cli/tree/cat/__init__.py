"""Describes entries for ``rtcat``: components with ports and connections, and managers."""
