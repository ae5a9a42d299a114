"""The rtkit of another host: where it is, and how it is started there."""

from __future__ import annotations

from rtkit.hosts.connection import Connection


def python(connection: Connection) -> list[str]:
    """Return the words that run the Python of the rtkit of a host, with its name in the tree."""
    return ["env", f"RTKIT_HOSTNAME={connection.host.name}", connection.host.python, "-P"]
