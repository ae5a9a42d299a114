"""Which part of a path is a component or manager, and which the name of a property."""

from __future__ import annotations

import pytest

from rtkit.tree.live_place import name_of_host, split
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
