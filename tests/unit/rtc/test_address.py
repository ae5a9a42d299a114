"""Direct addresses of managers."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed
from rtkit.rtc.manager_address import is_address, parse_address


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("corbaloc::localhost", ("localhost", 2810, "manager")),
        ("corbaloc::localhost:2811", ("localhost", 2811, "manager")),
        ("corbaloc::box/left", ("box", 2810, "left")),
        ("corbaloc:iiop:10.0.0.1:1/left", ("10.0.0.1", 1, "left")),
        ("localhost:2811", ("localhost", 2811, "")),
    ],
)
def test_what_can_be_read(text, address):
    assert parse_address(text) == address
    assert is_address(text)


@pytest.mark.parametrize(
    "text",
    [
        "corbaloc:",
        "corbaloc::",
        "corbaloc:localhost",
        "corbaloc::localhost:",
        "corbaloc::localhost:0",
        "corbaloc::localhost:65536",
        "corbaloc::localhost:x",
        "corbaloc::localhost/",
        "corbaloc::localhost/a/b",
        "corbaloc:ssliop:localhost",
        "corbaloc::/manager",
    ],
)
def test_what_cannot(text):
    with pytest.raises(Malformed, match=r"^Invalid corbaloc URL\.$"):
        parse_address(text)


@pytest.mark.parametrize("text", ["", "localhost", ":1", "a:", "a:b", "a:99999"])
def test_no_addresses(text):
    with pytest.raises(Malformed, match="not HOST:PORT"):
        parse_address(text)
