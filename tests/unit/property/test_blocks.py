"""Bytes in blocks: parts of them are got, and set one after the other."""

from __future__ import annotations

import pytest

from rtkit.property.blocks import blocks_of, joined_blocks
from rtkit.property.limits import LIMITS
from rtkit.property.service import Service
from tests.unit.property.test_objects import refused, served


class Camera:
    image: bytes = b"0123456789"
    name = "left"

    def get_raw(self, offset: int = 0) -> bytes:
        return b"from %d" % offset


def test_a_block_of_bytes_is_got() -> None:
    service = served(Camera())
    assert service.get("image?offset=2&length=3") == b"234"
    assert service.get("image?offset=8") == b"89"
    assert service.get("image?length=1") == b"0"
    assert service.get("image?offset=99&length=3") == b""
    assert service.get("raw?offset=3") == b"from 3"
    assert service.get("image.meta.size") == "10"
    assert refused(service, "image?offset=-1") == "bad-parameter"
    assert refused(service, "image?size=1") == "bad-parameter"
    assert refused(service, "name?offset=1") == "bad-parameter"


def test_a_block_is_put_over_what_is_there() -> None:
    camera = Camera()
    service = served(camera)
    service.set("image?offset=2", b"xy")
    service.set("image?offset=10", b"end")
    assert camera.image == b"01xy456789end"
    assert refused(service, "image?offset=99", "x") == "bad-value"
    assert refused(service, "raw?offset=0", "x") == "read-only"


def test_blocks_of_a_stated_size_are_in_force_after_the_last() -> None:
    camera = Camera()
    service = served(camera)
    service.set("image?offset=0&size=5", b"abc")
    assert refused(service, "image?offset=4&size=5", "e") == "conflict"
    assert camera.image == b"0123456789"
    service.set("image?offset=3&size=5", b"de")
    assert camera.image == b"abcde"
    assert refused(service, "image?offset=3&size=5", "de") == "conflict"
    assert refused(service, "image?offset=0&size=5", "abcdef") == "too-large"
    assert refused(service, f"image?offset=0&size={1 << 27}", "a") == "too-large"


@pytest.mark.parametrize("size", [0, LIMITS.text, LIMITS.text + 1, 3 * LIMITS.text])
def test_what_is_larger_than_a_request_travels_in_blocks(size: int) -> None:
    data = bytes(range(256)) * (size // 256) + b"x" * (size % 256)
    camera = Camera()
    service: Service = served(camera)

    def target(given: dict[str, int]) -> str:
        return "image?" + "&".join(f"{key}={each}" for key, each in given.items())

    for given, block in blocks_of(data):
        service.set(target(given).rstrip("?"), block)
    assert camera.image == data
    assert joined_blocks(lambda given: service.get(target(given))) == data
