"""What needs no Ice: addresses of doors, and how a wish to listen is put."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed
from rtkit.property.subscription import leased, listen_target
from rtkit.wires.ice.address import IceAddress, read_address


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("ice://localhost:4711", IceAddress("localhost", 4711)),
        ("ice://127.0.0.1:1/arm", IceAddress("127.0.0.1", 1, "arm")),
        ("ice://a-b.example:65535/robots/arm/", IceAddress("a-b.example", 65535, "robots/arm")),
    ],
)
def test_addresses_are_read_and_written(text: str, address: IceAddress) -> None:
    assert read_address(text) == address
    assert str(address) == text.rstrip("/")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "ice://",
        "ice:localhost:4711",
        "ice://localhost",
        "ice://localhost:",
        "ice://localhost:65536",
        "ice://localhost:x",
        "ice://:4711",
        "ice://localhost -p 1 -h elsewhere:4711",
        "ice://local\nhost:4711",
        'ice://"localhost":4711',
        "http://localhost:4711",
    ],
)
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(Malformed, match="not ice://HOST:PORT"):
        read_address(text)


@pytest.mark.parametrize(
    ("target", "asked"),
    [
        ("count", "count.listen?lease=10"),
        ("", "listen?lease=10"),
        ("count?queue=3", "count.listen?queue=3&lease=10"),
        ("count?queue=3&lease=2", "count.listen?queue=3&lease=2"),
        ("count?remove", "count.listen?remove"),
    ],
)
def test_who_listens_has_a_lease(target: str, asked: str) -> None:
    name, _, options = target.partition("?")
    assert leased(listen_target(name, options)) == asked
