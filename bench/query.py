"""Measures the floor of commands: a bare Python process that asks the same question."""

from __future__ import annotations

import sys

from rtkit.link import places
from rtkit.tree.client import Tree

FLOOR_IS = "python -c: import click and socket, connect to the manager, one request, close"
PROFILE_IS = f"{FLOOR_IS}; import lxml and parse the same profile"
_SCRIPT = """
import click, socket, struct
{more}
end = socket.socket(socket.AF_UNIX)
end.connect("{path}")
greeting = end.recv(8)
name, deadline = b"@x/listing", struct.pack("@16sdd", b"", 0.0, 5.0)
body = struct.pack("<I?32sI", 1, False, deadline, len(name)) + name
end.sendall(struct.pack("<I", len(body)) + body)
size, reply = struct.unpack("<I", end.recv(4))[0], b""
while len(reply) < size:
    reply += end.recv(65536)
print(len(reply[5:].decode()))
end.close()
"""


def floor(tree: Tree, profile: str = "") -> list[str]:
    """Return the command line that asks for the listing and prints its size.

    With a profile it parses that first, as commands must that read one.
    """
    more = f"import lxml.etree; lxml.etree.parse({profile!r})" if profile else ""
    script = _SCRIPT.format(path=places.request_socket(tree.manager), more=more)
    return [sys.executable, "-c", script]
