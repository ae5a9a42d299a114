"""Measures the floor of commands: a bare Python process that asks the same question."""

from __future__ import annotations

import sys

from rtkit.link import places, zenoh_keys
from rtkit.tree.client import Tree

FLOOR_IS = "python -c: import click and zenoh, open a client session, one query, close"
PROFILE_IS = f"{FLOOR_IS}; import lxml and parse the same profile"
_SCRIPT = """
import click, zenoh
{more}
c = zenoh.Config()
for k, v in (
    ("mode", '"client"'),
    ("connect/endpoints", '["unixsock-stream/{socket}"]'),
    ("scouting/multicast/enabled", "false"),
    ("scouting/gossip/enabled", "false"),
    ("connect/timeout_ms", "0"),
):
    c.insert_json5(k, v)
s = zenoh.open(c)
for r in s.get(
    "{key}",
    handler=zenoh.handlers.FifoChannel(16),
    consolidation=zenoh.ConsolidationMode.NONE,
    timeout=5.0,
):
    print(len(r.ok.payload.to_string()))
s.close()
"""


def floor(tree: Tree, profile: str = "") -> list[str]:
    """Return the command line that asks for the listing and prints its size.

    With a profile it parses that first, as commands must that read one.
    """
    key = zenoh_keys.extension_key(zenoh_keys.service(tree.host, tree.manager), "listing")
    more = f"import lxml.etree; lxml.etree.parse({profile!r})" if profile else ""
    script = _SCRIPT.format(socket=places.manager_socket(tree.manager), key=key, more=more)
    return [sys.executable, "-c", script]
