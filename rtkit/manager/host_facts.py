"""Answers what the host of a manager has: free memory, devices, tags."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rtkit.errors import Malformed
from rtkit.link.devices import HostFacts, present
from rtkit.manager.limits.control_groups import free_memory
from rtkit.rtc.create import listed_names
from rtkit.rtc.serde import encode_text


def host_facts(question: str, tags: str) -> str:
    """Return the facts of this host, as text; of the devices in the question those that are there.

    Raises:
        Malformed: The question is no list of texts.
    """
    try:
        devices = json.loads(question)
        if not isinstance(devices, list) or not all(isinstance(each, str) for each in devices):
            raise ValueError("not a list of texts")
    except ValueError as error:
        raise Malformed(f"which devices are meant cannot be read: {error}") from None
    return encode_text(facts_of_host(devices, tags))


def facts_of_host(devices: Sequence[str], tags: str) -> HostFacts:
    """Return the facts of this host, with tags as the property ``rtkit.tags`` tells them."""
    return HostFacts(int(free_memory()), present(devices), listed_names(tags))
