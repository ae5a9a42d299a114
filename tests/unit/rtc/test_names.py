"""Paths and names."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed
from rtkit.rtc.names import Path, check_instance_name, check_port_name, is_local_host, parse_path


@pytest.mark.parametrize(
    ("typed", "cwd", "path"),
    [
        ("/", "/", "/"),
        ("", "/localhost", "/localhost"),
        (".", "/localhost", "/localhost"),
        ("..", "/localhost", "/"),
        ("../../..", "/localhost", "/"),
        ("/../a", "/", "/a"),
        ("a//b", "/", "/a/b"),
        ("A.rtc", "/localhost/x/", "/localhost/x/A.rtc"),
        ("/a/./b/../c", "/", "/a/c"),
        ("/localhost/A.rtc:in", "/", "/localhost/A.rtc:in"),
        ("/localhost:2810", "/", "/localhost:2810"),
        ("localhost:2810", "/", "/localhost:2810"),
        ("/localhost:2810/A.rtc:2810", "/", "/localhost:2810/A.rtc:2810"),
        ("A.rtc:2810", "/localhost", "/localhost/A.rtc:2810"),
        ("/localhost:in", "/", "/localhost:in"),
    ],
)
def test_paths(typed: str, cwd: str, path: str) -> None:
    assert str(parse_path(typed, cwd)) == path
    assert parse_path(typed, cwd).typed == typed


@pytest.mark.parametrize("typed", ["a/", "/", "a/.", "a/..", ""])
def test_a_trailing_slash_is_kept_in_mind(typed: str) -> None:
    assert parse_path(typed).is_directory


def test_a_port_of_what_looks_like_a_directory() -> None:
    assert parse_path("a/b/:in") == Path("a/b/:in", ("a", "b"), "in", True)


@pytest.mark.parametrize("typed", ["a:b:c", "a/b:", "a:", "a/b:c:", "a\x00b", "a\nb", "\x7f"])
def test_bad_paths(typed: str) -> None:
    with pytest.raises(Malformed, match=r"^Bad path: "):
        parse_path(typed)


@pytest.mark.parametrize("name", ["Motor0", "größe", "部品", "a b", "a.b", "a*b", "a" * 255])
def test_instance_names(name: str) -> None:
    assert check_instance_name(name) == name


@pytest.mark.parametrize(
    "name",
    [
        "",
        " a",
        "*a",
        "*",
        "a ",
        ".",
        "..",
        "a/b",
        "a:b",
        "a?b",
        "a&b",
        "a=b",
        "a,b",
        "a@b",
        "a\nb",
        "é" * 128,
    ],
)
def test_names_that_are_refused(name: str) -> None:
    with pytest.raises(Malformed, match=r"^instance name "):
        check_instance_name(name)


@pytest.mark.parametrize(
    ("host", "is_local"),
    [
        ("localhost", True),
        ("localhost:2810", True),
        ("127.0.0.1:2810", True),
        ("::1", True),
        ("[::1]:2810", True),
        ("box.lan", True),
        ("box", True),
        ("box:1", True),
        ("lan", False),
        ("boxes", False),
        ("", False),
    ],
)
def test_hosts(host: str, is_local: bool) -> None:
    assert is_local_host(host, "box.lan") is is_local


@pytest.mark.parametrize("name", ["a/b", "a:b", "\x1b[2J", " a", "a ", "", "a\nb"])
def test_names_that_no_port_may_bear(name: str) -> None:
    with pytest.raises(Malformed, match=r"port name .* (not allowed|with a blank)"):
        check_port_name(name)


@pytest.mark.parametrize("name", ["in", "Arm0.out", "a b", "Größe", "a-b(1)"])
def test_names_that_ports_may_bear(name: str) -> None:
    assert check_port_name(name) == name
