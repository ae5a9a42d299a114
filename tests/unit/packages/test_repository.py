"""Repositories: no secret in their names goes where others see it, and none holds a command up."""

from __future__ import annotations

import os
import threading
from contextlib import suppress
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


def test_a_page_that_does_not_end_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    class Dripping(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            with suppress(OSError):
                while True:
                    self.wfile.write(b" ")

        def log_message(self, *_words: object) -> None:
            pass

    monkeypatch.setattr(repository, "_ANSWER_S", 0.2)
    with ThreadingHTTPServer(("127.0.0.1", 0), Dripping) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with opened([f"http://127.0.0.1:{server.server_port}/"]) as found:
            (error,) = offers(found)
        server.shutdown()
    assert isinstance(error, Unreachable)
    assert "the page does not end" in str(error)
