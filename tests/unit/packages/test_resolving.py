"""Wheels that pip chooses: safe names, for this Python and for that of another host."""

from __future__ import annotations

import platform
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from wheelkit import made

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.packages.repository import Repositories
from rtkit.packages.resolving import Chosen, fetch, resolve
from rtkit.packages.wheel_target import WheelKind, WheelTarget

ARM = WheelTarget(WheelKind("3.13", "aarch64", "2.36"), {"rtkit": "0.1.0", "click": "8.5.1"})
NATIVE = "native-1.0-cp313-cp313-manylinux_2_28_aarch64.whl"


@pytest.fixture
def wheels(tmp_path: Path) -> Path:
    """A folder of wheels: what native is made for, and packages that need something."""
    folder = tmp_path / "simple" / "native"
    made(folder, "native", "1.0").rename(folder / NATIVE)
    for name, needed in {"gain": "native", "clash": "click<8", "plain": "rtkit"}.items():
        made(folder, name, "1.0", requires=(needed,))
    return folder


@pytest.fixture
def index(wheels: Path) -> Iterator[str]:
    """The address of a simple index that has native."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_words: object) -> None:
            pass

    with ThreadingHTTPServer(
        ("127.0.0.1", 0), partial(Quiet, directory=wheels.parents[1])
    ) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/simple/"
        server.shutdown()


def test_an_escaped_slash_leads_nowhere_else() -> None:
    assert Chosen("a", "1", "file:///r/a-1-py3-none-..%2F..%2Fx.whl", "").file == "x.whl"


def test_what_is_needed_only_on_the_host_is_chosen_too(wheels: Path) -> None:
    for marker in ("platform_machine == 'aarch64'", "python_version >= '3.13'"):
        there = Repositories({"w": str(wheels)}, [])
        made(wheels, "mark", "1.0", requires=(f"native>=1; {marker}",))
        chosen = resolve(Requirement("mark"), there, ARM)
        assert [each.file for each in chosen] == ["mark-1.0-py3-none-any.whl", NATIVE]
        if "machine" in marker and platform.machine() != "aarch64":
            assert len(resolve(Requirement("mark"), there)) == 1


def test_wheels_are_chosen_for_the_host_that_they_are_for(wheels: Path) -> None:
    there = Repositories({"w": str(wheels)}, [])
    chosen = resolve(Requirement("gain"), there, ARM)
    assert [each.file for each in chosen] == ["gain-1.0-py3-none-any.whl", NATIVE]
    with pytest.raises(NotFound, match="no repository has native, which gain needs"):
        resolve(Requirement("gain"), there)
    older = ARM._replace(kind=WheelKind("3.13", "aarch64", "2.27"))
    with pytest.raises(NotFound, match=r"native for cp313-glibc2\.27-aarch64, which gain needs"):
        resolve(Requirement("gain"), there, older)


def test_what_a_host_has_is_neither_chosen_nor_contradicted(wheels: Path) -> None:
    there = Repositories({"w": str(wheels)}, [])
    chosen = resolve(Requirement("plain"), there, ARM)
    assert [each.name for each in chosen] == ["plain"]
    with pytest.raises(Refused, match=r"clash 1\.0 depends on click<8; the rtkit there has click"):
        resolve(Requirement("clash"), there, ARM)


def test_a_wheel_for_another_host_is_fetched_from_an_index(
    wheels: Path, index: str, tmp_path: Path
) -> None:
    (chosen,) = resolve(Requirement("native"), Repositories({}, [index]), ARM)
    assert fetch(chosen, str(tmp_path), ARM).file == NATIVE


def test_a_wheel_fits_by_its_tags() -> None:
    kind = ARM.kind
    assert kind.fits([NATIVE, "a-1-py3-none-any.whl", "a-1-cp39-abi3-manylinux2014_aarch64.whl"])
    for tags in ("cp312-cp312-manylinux_2_28_aarch64", "cp313-cp313-manylinux_2_28_x86_64"):
        assert not kind.fits([NATIVE, f"a-1-{tags}.whl"])
    assert not kind.fits(["a-1-cp313-cp313-manylinux_2_39_aarch64.whl"])


def test_a_page_that_pip_cannot_read_is_told_in_a_sentence(wheels: Path, index: str) -> None:
    (wheels / "index.html").write_bytes(b"<a href='http://[/native-1.0-py3-none-any.whl'>x</a>")
    with pytest.raises(Malformed) as told:
        resolve(Requirement("native"), Repositories({}, [index]))
    assert (
        str(told.value) == f"native: pip cannot read what {index} has: ValueError: Invalid IPv6 URL"
    )


@pytest.mark.parametrize("cut", [True, False])
def test_a_damaged_newest_wheel_is_told_with_how_to_have_an_older_one(
    wheels: Path, tmp_path: Path, cut: bool
) -> None:
    there = Repositories({"w": str(wheels)}, [])
    made(wheels, "gear", "1.0")
    newest = made(wheels, "gear", "1.1", {"gear/a.py": ""}, lies=("gear/a.py",))
    if cut:
        newest.write_bytes(b"PK")
    with pytest.raises(Refused, match=r"gear-1\.1-py3.*ask for another: 'gear!=1\.1'"):
        fetch(resolve(Requirement("gear"), there)[0], str(tmp_path))
    (older,) = resolve(Requirement("gear!=1.1"), there)
    assert fetch(older, str(tmp_path)).version == "1.0"
