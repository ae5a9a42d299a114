"""Bytes of a mounted service, got and set over each wire: the mount's, and that of who asks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from queue import SimpleQueue
from typing import NamedTuple

import numpy as np
import pytest
from asking import code
from property_endpoints import BOUND_S, WirePlaces, params

import rtkit
from rtkit.proxy.bridge import bridge
from rtkit.wires.serve import serve
from rtkit.wires.table import WIRES, wire_of

SHORT = [
    b"", b"12", b"\n", b"a\r\nb\n", b"{3}\nabc", b" ~12AB\r\n", b"= 1\n! no\n", b"\x00\xff",
    bytes(range(256)), "grün".encode(), b'"', b"<a>", b"# 1", b"%20;&?=",
]  # fmt: skip


class Eye:
    """Service that has a picture."""

    def __init__(self) -> None:
        self.image = b""
        self._small = b""

    def get_small(self, format: str = "png") -> bytes:
        if format == "none":
            raise rtkit.PropertyError("bad-parameter", "format is png, not none")
        return self._small

    def set_small(self, data: bytes) -> None:
        if data == b"damaged":
            raise rtkit.PropertyError("bad-value", "the picture is damaged")
        self._small = data


class Way(NamedTuple):
    """Way to the picture of a service: as a client asks for it, through a mount."""

    client: rtkit.Client
    place: str
    eye: Eye


@pytest.fixture(params=params(*WIRES))
def way(request: pytest.FixtureRequest, place: str, ends: ExitStack) -> Iterator[Way]:
    """Have the wire between the owner and the mount, and between that and who asks."""
    wire, eye, places = wire_of(request.param), Eye(), WirePlaces(place, ends)
    ends.enter_context(serve(eye, "eye", is_on_zenoh=False))
    mount = rtkit.Mount(places.opened(wire, "eye"), timeout_s=BOUND_S)
    ends.enter_context(serve({"cam": mount}, "group", is_on_zenoh=False))  # type: ignore[arg-type]
    address = places.opened(wire, "group")
    at = f"{address}/cam."
    if wire.client is None or wire.scheme == "serial":  # one may open a device: a proxy shares it
        at = "near.cam."
        ends.enter_context(bridge(address, "near", allow_set=["*"], timeout_s=BOUND_S))
    elif wire.client.has_services and "/group" not in address:
        at = f"{address}/group/cam."
    client = ends.enter_context(rtkit.Client(timeout_s=BOUND_S))
    yield Way(client, at, eye)
    ends.close()


def test_bytes_of_a_mounted_service_are_the_same(way: Way) -> None:
    for data in SHORT:
        way.client.set_bytes(f"{way.place}small", data)
        assert way.eye.get_small() == data
        assert way.client.get_bytes(f"{way.place}small", format="png") == data
    size = 1_000_000
    picture = np.random.default_rng(1).bytes(size)
    way.eye.image = picture
    at = f"{way.place}image"
    assert way.client.get_bytes(at) == picture
    assert way.client.get_bytes(at, offset=size - 7, length=900) == picture[-7:]
    assert way.client.get_bytes(at, offset=1000, length=2000) == picture[1000:3000]
    assert way.client.get_bytes(at, offset=size, length=5) == b""
    other = picture[::-1]
    way.client.set_bytes(at, other)
    assert way.eye.image == other
    way.client.set(at, b"12", offset=5)
    assert way.eye.image == other[:5] + b"12" + other[7:]
    more = other * 2 + b"end"  # goes in blocks
    way.client.set_bytes(at, more)
    assert way.eye.image == way.client.get_bytes(at) == more


def test_bytes_of_a_mounted_service_are_listened_to(way: Way) -> None:
    changes: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
    picture = np.random.default_rng(2).bytes(200_000)
    with way.client.listen(f"{way.place}small", changes.put):
        assert changes.get(timeout=BOUND_S).value in (b"", "")
        way.client.set_bytes(f"{way.place}small", picture)
        assert changes.get(timeout=BOUND_S).value == picture


def test_a_refusal_of_a_mounted_service_is_the_same(way: Way) -> None:
    small = f"{way.place}small"
    way.client.set_bytes(small, b"whole")
    for refused, words in (
        (lambda: way.client.set_bytes(small, b"damaged"), "bad-value"),
        (lambda: way.client.get_bytes(small, format="none"), "bad-parameter"),
        (lambda: way.client.get_bytes(small, colour="red"), "bad-parameter"),
        (lambda: way.client.get_bytes(f"{way.place}none"), "unknown"),
        (lambda: way.client.get_bytes(f"{way.place}image", offset=-1), "bad-parameter"),
        (lambda: way.client.set(f"{way.place}image", b"x", offset=9**9), "too-large"),
    ):
        assert code(refused) == words
    assert way.eye.get_small() == b"whole"
