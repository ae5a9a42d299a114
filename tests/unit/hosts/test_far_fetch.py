"""The program that fetches wheels on a host: from an index that means harm."""

from __future__ import annotations

import hashlib
import json
import signal
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from rtkit.hosts import far_fetch

WHEEL = b"wheel" * 99


class _Harmful(BaseHTTPRequestHandler):
    """An index with a wheel that is good, one without end, one elsewhere, and one byte by byte."""

    is_left = threading.Event()

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        *_, project, name = self.path.split("/")
        if not name:
            place = "file:///etc/" if project == "away" else ""
            self.wfile.write(f"<a href='{place}{project}-1-py3-none-any.whl'>".encode() * 9)
        elif name.startswith("slow"):
            self.wfile.write(WHEEL[:1])
            self.is_left.wait()
        else:
            self.wfile.write(WHEEL * (2 if name.startswith("long") else 1))

    def log_message(self, format: str, *words: object) -> None:
        """Say nothing."""


@pytest.fixture
def index() -> Iterator[str]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), _Harmful)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    former = signal.getsignal(signal.SIGALRM)
    yield f"http://127.0.0.1:{server.server_port}"
    signal.signal(signal.SIGALRM, former)
    _Harmful.is_left.set()
    server.shutdown()
    thread.join()
    server.server_close()


def test_each_wheel_that_is_not_the_right_one_is_told_and_kept_nowhere(
    index: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    names = {each: f"{each}-1-py3-none-any.whl" for each in ("away", "good", "long", "none")}
    names |= {each: f"{each}-1-py3-none-any.whl" for each in ("slow", "then")}
    names["none"] = "none-2-py3-none-any.whl"
    wheels = {each: (hashlib.sha256(WHEEL).hexdigest(), len(WHEEL)) for each in names.values()}
    wanted = {"index": index, "wheels": wheels, "folder": str(tmp_path), "mark": "answer: "}
    monkeypatch.setattr(far_fetch, "_BEGIN_S", 1)
    monkeypatch.setattr(sys, "argv", ["-", json.dumps(wanted)])
    far_fetch.main()
    answer = capsys.readouterr().out.rpartition("answer: ")[2]
    slow = "no answer of the index: it sends too slowly"
    assert json.loads(answer) == {
        names["away"]: "its link leads elsewhere",
        names["long"]: "it has too many bytes",
        names["none"]: "it is not there",
        names["slow"]: slow,
        names["then"]: slow,
    }
    assert [each.name for each in tmp_path.iterdir()] == [names["good"]]
    assert (tmp_path / names["good"]).read_bytes() == WHEEL
