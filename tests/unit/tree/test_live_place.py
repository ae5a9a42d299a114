"""Which part of a path is a component or manager, and which the name of a property."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtkit.cli.tree.service_listing import no_service_at
from rtkit.link.places import services
from rtkit.property.codes import PropertyError
from rtkit.tree.live_place import name_of_host, split
from rtkit.tree.property_connections import place_here
from rtkit.tree.property_targets import no_service, parse


@pytest.mark.parametrize(
    ("typed", "node", "name"),
    [
        ("/localhost/Motor0.rtc.state", "/localhost/Motor0.rtc", "state"),
        ("/localhost/Motor0.rtc", "/localhost/Motor0.rtc", ""),
        ("/localhost/Motor0.rtc/ports/in", "/localhost/Motor0.rtc", "ports.in"),
        ("/localhost/a.mgr/M.rtc.a.b", "/localhost/a.mgr/M.rtc", "a.b"),
        ("/localhost/manager.mgr.pid", "/localhost/manager.mgr", "pid"),
        ("M.rtc.x", "/localhost/dir/M.rtc", "x"),
        ("/localhost/robot.speed", "", ""),
        ("/localhost", "", ""),
    ],
)
def test_the_last_node_of_the_path_ends_it(typed: str, node: str, name: str) -> None:
    assert split(typed, "/localhost/dir") == (node, name)


@pytest.mark.parametrize(
    ("typed", "name"),
    [
        ("/localhost", ""),
        ("/box/load", "load"),
        ("localhost.load", "load"),
        ("/robot.load", None),
        ("/", None),
    ],
)
def test_a_host_has_properties_too(typed: str, name: str | None) -> None:
    assert name_of_host(typed, "/", "box") == name


@pytest.mark.parametrize(
    ("typed", "service", "name"),
    [
        ("robots/r1.location.x", "robots/r1", "location.x"),
        ("/localhost/robots/r1/location/x", "robots/r1", "location.x"),
        ("/box/robots/r1", "robots/r1", ""),
        ("robots/r10.x", "robots", "r10.x"),
        ("robot.x", "", "robot.x"),
        ("robots.x", "robots", "x"),
        ("/other/robots.x", "", "/other/robots.x"),
    ],
)
def test_the_longest_service_that_fits_is_meant(typed: str, service: str, name: str) -> None:
    assert parse(typed, "/", ["robots", "robots/r1"], "box")[1:3] == (service, name)
    assert parse(f"{typed}?a=1", "/", ["robots", "robots/r1"], "box")[3] == "a=1"


def test_an_error_names_all_services_or_of_many_those_like_it() -> None:
    for known, told in (
        ([], "there is none"),
        (["a", "b"], "there is a b"),
        ([f"robots/r{at}" for at in range(100)], "there are 100, such as robots/r23"),
        ([f"x{at}" for at in range(100)], "there are 100"),
    ):
        text = str(no_service("robts/r23.speed", known))
        assert text.startswith(f"no service named robts/r23 ({told}"), text
        assert len(text) < 120


@pytest.fixture
def one_of_two_lives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Services d/one, which was killed, and d/two, which lives."""
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("RTKIT_MANAGER", raising=False)
    tmp_path.chmod(0o700)
    with socket.socket(socket.AF_UNIX) as dead, socket.socket(socket.AF_UNIX) as living:
        dead.bind(str(tmp_path / "d%2Fone.ps"))
        living.bind(str(tmp_path / "d%2Ftwo.ps"))
        living.listen()
        yield


@pytest.mark.usefixtures("one_of_two_lives")
def test_an_error_names_living_services_only() -> None:
    assert services() == ["d/one", "d/two"]
    for typed in ("d/three.on", "/localhost/d/three", "/nohost/d/three.on"):
        with pytest.raises(PropertyError, match="d/two") as raised:
            place_here(typed, "/", services())
        assert "d/one" not in str(raised.value)


@pytest.mark.usefixtures("one_of_two_lives")
def test_a_listing_misses_a_service_where_only_services_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for typed in ("d/thre", "/localhost/d/thre"):
        assert f"{typed}: no-service: no service named d/thre (there is d/two" in str(
            no_service_at(typed)
        )
    for typed in ("Motor0.rtc", "/localhost/manager.mgr", "/nohost/a", "d/two"):
        assert no_service_at(typed) is None
    monkeypatch.setenv("RTKIT_MANAGER", "mine")
    assert no_service_at("d/thre") is None
