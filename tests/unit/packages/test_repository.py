"""Repositories: no secret in their names goes where others see it, and none holds a command up."""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from wheelkit import made

from rtkit.errors import Refused, Unreachable
from rtkit.packages import repository
from rtkit.packages.repository import Offer, offers, opened


@pytest.mark.parametrize(
    "address",
    [
        "https://anna:hunter2@example.org/simple", "http://hunter2@example.org/simple",
        "git+https://hunter2@example.org/p.git@v1", "git+ssh://git:hunter2@example.org/p.git",
    ],
)  # fmt: skip
def test_a_secret_in_the_address_of_a_repository_is_refused(address: str) -> None:
    """Whoever runs ps would see it, since pip and git are given it as an argument."""
    with pytest.raises(Refused, match="secret in the address") as found, opened([address]):
        pass
    assert "hunter2" not in str(found.value)
    assert "netrc" in str(found.value)


def test_what_is_called_as_a_wheel_and_is_a_pipe_is_told(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe-1.0-py3-none-any.whl")
    made(tmp_path, "gain", "1.0")
    with opened([str(tmp_path)]) as found:
        gain, pipe = offers(found)
    assert isinstance(gain, Offer)
    assert "pipe-1.0-py3-none-any.whl: it is no file" in str(pipe)


@contextmanager
def served(parts: Callable[[str], Iterable[bytes]]) -> Iterator[str]:
    """The address of an index whose pages are these parts, by their path."""

    class Index(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            with suppress(OSError):
                for part in parts(self.path):
                    self.wfile.write(part)

        def log_message(self, *_words: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Index) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.mark.parametrize("part", [b" ", b"<a href='gain/'>" * 9999])
def test_a_page_that_does_not_end_is_given_up(part: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(repository, "_ANSWER_S", 0.2 if part == b" " else 30.0)
    monkeypatch.setattr(repository, "_LARGEST_PAGE", 1 << 22)
    with served(lambda _path: itertools.repeat(part)) as index, opened([index]) as found:
        (error,) = offers(found)
    assert isinstance(error, Unreachable)
    assert "the page does not end" in str(error)


def test_links_of_all_forms_are_read_and_a_wrong_one_is_told() -> None:
    pages = {"/": [b"<A class='x'\nHREF = '/p/gain/'>g</a> <link href='style/'>"]}
    pages["/gain/"] = [
        b"<a href='/f/gain-1-py3-none-any.whl?x=/y#sha256=/z'> <a href='http://[/gain-2-py3-none-any.whl'>"
        b"<a href='gain.whl'> <a href=gain%2D3-py3-none-any.whl>" + b"<a " * 99_999
    ]
    with served(lambda path: pages[path]) as index, opened([index]) as found:
        there = [*offers(found)]
    assert [each.version for each in there if isinstance(each, Offer)] == ["1", "2", "3"]
    (wrong,) = (str(each) for each in there if not isinstance(each, Offer))
    assert "/gain/: not the name of a wheel: " in wrong


def test_an_index_of_very_much_is_given_up_in_a_bounded_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wheels = b"".join(b"<a href='gain-%d-py3-none-any.whl'>" % each for each in range(30))
    names = b"".join(b"<a href='p%d/'>" % each for each in range(30))
    monkeypatch.setattr(repository, "_MOST_WHEELS", 20)
    for top, told in ((b"<a href='gain/'>", "gain/ lists more than 20"), (names, "of 30 packages")):
        pages = {"/": [top], "/gain/": [wheels]}
        with served(lambda path, p=pages: p.get(path, [b""])) as index, opened([index]) as found:
            monkeypatch.setattr(repository, "_SEARCH_S", 30.0 if "gain" in told else -1.0)
            (error,) = offers(found)
        assert told in str(error)
