"""Asks the server of the page as the page does, without a browser."""

from __future__ import annotations

import json
import re
import socket
import ssl
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPSConnection
from pathlib import Path
from typing import Any, NamedTuple

from shells import Shell

_BOUND_S = 20.0


class Answer(NamedTuple):
    status: int
    headers: Mapping[str, str]
    body: Any


class WebClient:
    """A client of one server; `token` is what its address had.

    Attributes:
        site: The address of the page, without the token.
        log: What the server has written to stderr, once it has ended.
    """

    def __init__(self, port: int, token: str, tls: ssl.SSLContext | None = None) -> None:
        self.port = port
        self.token = token
        self.site = f"{'https' if tls else 'http'}://127.0.0.1:{port}/"
        self.log = ""
        self._tls = tls

    def ask(
        self, method: str, path: str, body: object = None, headers: Mapping[str, str] | None = None
    ) -> Answer:
        """Send a request; headers given here come on top, and empty ones are left out."""
        sent = {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json"}
        sent |= headers or {}
        connection = self._connection()
        text = body if isinstance(body, str | bytes | None) else json.dumps(body)
        connection.request(method, path, text, {k: v for k, v in sent.items() if v})
        response = connection.getresponse()
        data = response.read()
        connection.close()
        found = {name.lower(): value for name, value in response.getheaders()}
        is_json = found.get("content-type", "").startswith("application/json")
        return Answer(response.status, found, json.loads(data) if is_json else data.decode())

    def _connection(self) -> HTTPConnection:
        if self._tls is None:
            return HTTPConnection("127.0.0.1", self.port, timeout=_BOUND_S)
        return HTTPSConnection("127.0.0.1", self.port, timeout=_BOUND_S, context=self._tls)

    def post(self, path: str, body: object) -> Any:
        answer = self.ask("POST", path, body)
        assert answer.status == 200, answer
        return answer.body

    def do(self, *actions: object) -> Any:
        """Have actions done; all must be."""
        outcome = self.post("/api/do", {"actions": actions})
        assert all(step["ok"] for step in outcome["steps"]), outcome
        return outcome

    @contextmanager
    def stream(self, page: str = "") -> Iterator[Stream]:
        """Open the stream of a page that calls itself so."""
        connection = self._connection()
        connection.connect()
        with connection.sock as end:
            head = f"GET /api/stream?page={page} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n"
            end.sendall(f"{head}Authorization: Bearer {self.token}\r\n\r\n".encode())
            yield Stream(end)


class Stream:
    """Server-sent events, as a browser reads them; it folds those that change the picture."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._text = ""
        self.components: dict[str, Any] = {}
        self.connectors: dict[str, Any] = {}
        self.managers: dict[str, Any] = {}
        self.processes: dict[str, Any] = {}
        self.events: list[Any] = []

    def next(self, *kinds: str) -> Any:
        """Return the data of the next event of some kinds."""
        while True:
            while (found := re.search(r"event: (\w+)\ndata: (.*)\n\n", self._text)) is None:
                piece = self._end.recv(65536)
                assert piece, "the stream has ended"
                # Lengths of chunks stand between; they are no event.
                self._text += re.sub(r"(^|\r\n)[0-9a-f]+\r\n", "", piece.decode()).replace(
                    "\r\n", ""
                )
            self._text = self._text[found.end() :]
            data = json.loads(found[2])
            self._fold(found[1], data)
            if found[1] in kinds:
                return data

    def until(self, condition: Any) -> None:
        """Read until a condition on this is true."""
        while not condition(self):
            self.next("picture", "change")

    def _fold(self, kind: str, data: Any) -> None:
        for name in ("components", "connectors", "managers", "processes"):
            if kind in ("picture", "change"):
                known = {} if kind == "picture" else getattr(self, name)
                for gone in data.get("gone", {}).get(name, ()):
                    known.pop(gone, None)
                known |= {each["id"]: each for each in data[name]}
                setattr(self, name, known)
        self.events += data.get("events", []) if kind == "change" else []


def certified(folder: Path) -> tuple[Path, Path]:
    """Make a certificate for this host's names, and its key."""
    cert, key = folder / "page.crt", folder / "page.key"
    subject = ["-subj", "/CN=page", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"]
    made = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
    subprocess.run(
        [*made, "-nodes", "-days", "2", *subject, "-out", str(cert), "-keyout", str(key)],
        check=True, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    key.chmod(0o600)
    return cert, key


@contextmanager
def served(
    shell: Shell, options: str = "", pair: tuple[Path, Path] | None = None
) -> Iterator[WebClient]:
    """Run ``rtweb`` and return a client of it, by TLS with a certificate and its key.

    Ctrl-C ends it in order.
    """
    by_tls = "--cert {} --key {}".format(*pair) if pair else ""
    process = shell.open(f"rtweb --no-browser {by_tls} {options}")
    assert process.stdout is not None
    line = process.stdout.readline()
    address = re.fullmatch(r"https?://127\.0\.0\.1:(\d+)/#token=(\S+)\n", line)
    assert address is not None
    tls = ssl.create_default_context(cafile=str(pair[0])) if pair else None
    client = WebClient(int(address[1]), address[2], tls)
    try:
        yield client
    finally:
        process.send_signal(2)
        ended = shell.end_of(process)
        client.log = ended.err
        assert ended.status in (0, 130, -2)
