"""Shared parts of the property commands: options, connections, the display of values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from rtkit.cli.shared import json_records
from rtkit.cli.shared.app import App, working_directory
from rtkit.cli.shared.options import option, several
from rtkit.cli.shared.terminal import printable
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.property.messages import Payload
    from rtkit.tree.property_connections import PropertyConnections

PARAMETERS = several("-p --parameter KEY=VALUE", "A parameter of the request (repeatable).")
AT = option(
    "--at HOST:PORT",
    "Ask the services at this TCP endpoint, or one of another wire (rtkit help wires).",
)


@contextmanager
def connected(
    app: App, at: str | None, parameters: Sequence[str] = ()
) -> Iterator[PropertyConnections]:
    """Connect to owners of properties for as long as the context lasts.

    A time-out among the parameters of the requests bounds also what is asked before them.

    Raises:
        UsageError: ``--at`` is no address.
    """
    from rtkit.tree.property_connections import PropertyConnections

    if at is not None:
        from rtkit.wires.table import endpoint_of

        try:
            endpoint_of(at)
        except Malformed as error:
            raise click.BadParameter(str(error), param_hint="--at") from None
    timeout_s = app.timeout_s
    if parameters:
        from rtkit.wires.property_client import bound_in

        timeout_s = bound_in(joined(parameters), timeout_s)
    places = PropertyConnections(working_directory(), at or "", timeout_s)
    try:
        yield places
    finally:
        places.close()


def joined(parameters: Sequence[str]) -> str:
    """Return parameters as they follow a question mark."""
    from rtkit.property.naming import write_parameters

    given: dict[str, str | None] = {}
    for each in parameters:
        key, mark, value = each.partition("=")
        given[key] = value if mark else None
    return write_parameters(given)


def shown(payload: Payload) -> str:
    """Return a value as one line on a terminal; bytes in hexadecimal."""
    return payload.hex(" ") if isinstance(payload, bytes) else printable(payload)


def record(kind: str, typed: str, payload: Payload, **more: Any) -> str:
    """Return a value as a JSON record."""
    from rtkit.property.plain import payload_to_plain

    text = None if isinstance(payload, bytes) else payload
    fields = {"target": typed, "value": payload_to_plain(payload), "text": text, **more}
    return json_records.line(kind, fields)


def write_raw(payload: Payload) -> None:
    """Write a value as it is, without an end of line; a string without its quotes."""
    import sys

    data = raw(payload)
    sys.stdout.flush()
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


def raw(payload: Payload) -> bytes:
    """Return the bytes of a value as it is; of a string without its quotes."""
    from rtkit.property.codes import PropertyError
    from rtkit.property.limits import OF_REPLIES
    from rtkit.property.reading import read

    if isinstance(payload, str):
        try:
            value = read(payload, OF_REPLIES)
        except PropertyError:
            value = payload
        text = value if isinstance(value, str) and payload.startswith('"') else payload
        return text.encode("utf-8", "surrogateescape")
    return payload
