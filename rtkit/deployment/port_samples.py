"""Contract of samples: what a manager tells of ports that somebody looks at, many times a second.

A sample is plain data:

- ``count``: values written to an out port, or read from an in port;
- ``buffers``: of an in port, by connector: values that wait, how many fit, how many were dropped
  since somebody looks;
- ``age``: how long ago the last value came [s]; it, ``text`` and ``numbers`` are there once one has
  come since somebody looks;
- ``text``: that value in short;
- ``numbers``: its first numbers by field; None for one that is not finite.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from rtkit.errors import Malformed

SAMPLES = "samples"
"""The view of a manager, the operation of a container, and what it answers."""
MOST_PORTS = 2000
MOST_NUMBERS = 16
MOST_TEXT = 200

PortName = tuple[str, str]
"""Instance and port."""
Sample = dict[str, Any]


def ports_to_text(ports: Sequence[PortName]) -> str:
    """Return the question for samples of some ports."""
    return json.dumps(ports, separators=(",", ":"))


def ports_from_text(text: str) -> list[PortName]:
    """Read the question for samples.

    Raises:
        Malformed: It is none, or one for too many.
    """
    try:
        rows = json.loads(text)
        found = [(instance, port) for instance, port in rows]
    except (TypeError, ValueError) as error:
        raise Malformed(f"ports: pairs of instance and port are wanted: {error}") from None
    if not all(isinstance(each, str) for pair in found for each in pair):
        raise Malformed("ports: pairs of two texts are wanted")
    if len(found) > MOST_PORTS:
        raise Malformed(f"ports: {MOST_PORTS} at most")
    return found


def samples_from_text(text: str) -> dict[PortName, Sample]:
    """Read the answer; ports that are not there are not in it.

    Raises:
        Malformed: It cannot be read.
    """
    try:
        return {
            (str(instance), str(port)): dict(sample) for instance, port, sample in json.loads(text)
        }
    except (TypeError, ValueError) as error:
        raise Malformed(f"the manager's samples cannot be read: {error}") from error
