"""The HTTP door as strangers meet it: curl, a browser, and who means no good."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Callable

import pytest

from rtkit.errors import Unreachable
from rtkit.link import places, secret
from rtkit.property.service import Service
from rtkit.wires.http import digest, server_connection
from rtkit.wires.http.client import HttpClient, connect_http
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve

BOUND_S = 30.0
OPEN = {"http": 0}


# curl


class Curl:
    """curl with the secret of the user, which it reads from a file."""

    def __init__(self, served: ServedObject, folder: str) -> None:
        known = secret.read()
        self._root = f"http://localhost:{served.http}"
        self._config = f"{folder}/curl.conf"
        with open(self._config, "w", encoding="ascii") as stream:
            stream.write(f'digest\nuser = "{known.user}:{known.password}"\n')

    def command(self, path: str, *options: str) -> list[str]:
        return ["curl", "-s", "-N", "--max-time", str(BOUND_S), "-K", self._config, *options,
                self._root + path]  # fmt: skip

    def __call__(self, path: str, *options: str) -> tuple[int, str]:
        """Return status and body."""
        line = self.command(path, "-w", "\n%{http_code}", *options)
        out = subprocess.run(line, capture_output=True, check=True).stdout.decode()
        body, _, status = out.rpartition("\n")
        return int(status), body


needs_curl = pytest.mark.skipif(shutil.which("curl") is None, reason="curl is not installed")


@needs_curl
def test_curl_gets_sets_and_listens(served: ServedObject, service: Service, place: str) -> None:
    curl = Curl(served, place)
    assert curl("/ps") == (200, "(robot)")
    assert curl("/ps/robot/arm") == (200, "(angle joint)")
    assert curl("/ps/robot") == (200, curl("/ps/robot/properties")[1])
    assert curl("/ps/robot/speed") == (200, "0.25")
    assert curl("/ps/robot/pose?frame=robot") == (200, "(1.0 2.0 0.5)")
    assert curl("/ps/robot/speed", "-X", "PUT", "-d", "0.5") == (204, "")
    assert curl("/ps/robot/speed", "-X", "PUT", "-H", 'If-Match: "1"', "-d", "0.1")[0] == 409
    heads = curl("/ps/robot/speed", "-I", "-H", "X-Odd: 1")[1]
    assert 'etag: "2"' in heads.lower()
    assert curl("/ps/robot/speed", "-X", "PUT", "-H", 'If-Match: "2"', "-d", "0.1") == (204, "")
    assert curl("/ps/robot/double?echo", "-d", "21") == (
        200, '<call state="done"><result>42</result></call>')  # fmt: skip
    accepted = ("-H", "Accept: application/json")
    told = json.loads(curl("/ps/robot/location", *accepted)[1])
    assert told["value"] == [1.0, 2.0, 0.0, 0.0, 0.0, 0.5]
    as_json = ("-X", "PUT", "-H", "Content-Type: application/json", "-d")
    assert curl("/ps/robot/name", *as_json, '"two words"') == (204, "")
    assert curl("/ps/robot/name") == (200, '"two words"')
    assert curl("/ps/robot/notes", *as_json, '"two words"') == (204, "")
    assert curl("/ps/robot/notes") == (200, "two words")
    assert curl("/ps/robot/name", *as_json, '{"a": 1')[0] == 400
    stream = subprocess.Popen(
        curl.command("/ps/robot/count?queue=9", "-H", "Accept: text/event-stream"),
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert stream.stdout is not None
    assert [stream.stdout.readline() for _ in range(2)] == ["retry: 1000\n", "\n"]
    assert re.fullmatch(r"id: rev=1;time=[\d.]+;name=count\n", stream.stdout.readline())
    assert [stream.stdout.readline() for _ in range(2)] == ["data: 7\n", "\n"]
    served.owned(lambda: service.update("count", 8, "uncertain"))
    assert stream.stdout.readline().endswith(";quality=uncertain;name=count\n")
    assert stream.stdout.readline() == "data: 8\n"
    served.owned(lambda: service.remove("count"))
    rest = stream.stdout.read()
    assert rest.endswith("event: end\ndata: unknown\n\n")
    assert stream.wait(BOUND_S) == 0
    stream.stdout.close()


STATUSES = [
    ("/ps/robot/nope", (), 404, "unknown "),
    ("/ps/nobody/speed", (), 502, "no-service "),
    ("/elsewhere", (), 404, "unknown "),
    ("/ps/robot/serial", ("-X", "PUT", "-d", "X2"), 405, "read-only "),
    ("/ps/robot/door_code", (), 405, "write-only "),
    ("/ps/robot/count.listen", ("-X", "PUT", "-d", "tcp://x/y"), 403, "denied "),
    ("/ps/robot/count.listen", ("-X", "PUT", "-d", "self"), 403, "denied "),
    ("/ps/robot/speed", ("-X", "PUT", "-d", "(("), 400, "syntax "),
    ("/ps/robot/speed", ("-X", "PUT", "-d", "red"), 400, "bad-value "),
    ("/ps/robot/speed?x=1", (), 400, "bad-parameter "),
    ("/ps/robot/speed?if=9", ("-X", "PUT", "-d", "0"), 409, "conflict "),
    ("/ps/robot/broken", (), 500, "internal "),
    ("/ps/robot/speed", ("-X", "DELETE"), 405, "read-only "),
    ("/ps/robot/speed", ("-X", "PUT", "-d", "1", "-H", "If-Match: 1"), 400, "bad-parameter "),
    ("/ps/robot/nope", ("-H", "Accept: text/event-stream"), 404, "unknown "),
    ("/ps/robot/count?queue=0", ("-H", "Accept: text/event-stream"), 400, "bad-parameter "),
]


@needs_curl
def test_statuses_are_those_of_the_codes(served: ServedObject, place: str) -> None:
    curl = Curl(served, place)
    found = [(path, more, *curl(path, *more)) for path, more, _, _ in STATUSES]
    wrong = [
        each for each, (_, _, status, begin) in zip(found, STATUSES, strict=True)
        if each[2] != status or not each[3].startswith(begin)
    ]  # fmt: skip
    assert wrong == []
    assert os.path.dirname(server_connection.__file__) not in str(found)


def _clients(served: ServedObject) -> list[server_connection.HttpConnection]:
    handlers = list(served._host._handlers.values())
    return [each for each in handlers if isinstance(each, server_connection.HttpConnection)]


def _streams(served: ServedObject) -> list[server_connection.HttpConnection]:
    return [each for each in _clients(served) if each.is_stream]


# Several properties in one stream


def _events(curl: Curl, path: str, *names: str) -> list[str]:
    """Return the events of a stream, until all names have come."""
    told: list[str] = []
    stream = subprocess.Popen(curl.command(path, "-H", "Accept: text/event-stream"),
                              stdout=subprocess.PIPE, text=True)  # fmt: skip
    assert stream.stdout is not None
    while not all(re.search(f"name={each}(\\.properties)?\n", "\n".join(told)) for each in names):
        lines = []
        while (line := stream.stdout.readline().rstrip()) and not line.startswith("retry:"):
            lines.append(line)
        told.append("\n".join(lines))
    stream.terminate()
    stream.wait(BOUND_S)
    stream.stdout.close()
    return told


@needs_curl
def test_one_stream_tells_of_all_properties_or_of_the_named_ones(
    served: ServedObject, service: Service, place: str
) -> None:
    curl = Curl(served, place)
    of_all = curl("/ps/robot/properties?all=1")[1].strip("()").split()
    names = set(of_all) - {"door_code"}
    text = "\n".join(_events(curl, "/ps/robot/properties?values=1&all=1", *names))
    assert re.search(r"name=count\ndata: 7$", text, re.MULTILINE)
    assert re.search(r"name=blob\nevent: bytes\ndata: 5$", text, re.MULTILINE), "not their content"
    assert re.search(r"^id: name=broken\nevent: refused\ndata: internal RuntimeError", text,
                     re.MULTILINE)  # fmt: skip
    assert "door_code\nevent" not in text, "nothing is wrong with what can only be set"
    told = _events(curl, "/ps/robot/properties?values=1&names=(count%20speed)", "speed")
    assert [each.rpartition("name=")[2].split("\n")[0] for each in told if each] == [
        "properties", "count", "speed"]  # fmt: skip
    told = _events(curl, "/ps/robot/arm.properties?values=1&all=1", "arm.angle")
    assert "name=count" not in str(told)
    assert curl("/ps/robot/nope.properties?values=1", "-H", "Accept: text/event-stream")[0] == 404
    assert curl("/ps/robot/properties?values=1&queue=0&names=(nope)", "-H",
                "Accept: text/event-stream")[0] == 404  # fmt: skip


POLICY = "content-security-policy: "


@needs_curl
def test_pages_are_for_browsers_and_their_policy_lets_no_stranger_in(
    served: ServedObject, service: Service, place: str
) -> None:
    curl = Curl(served, place)
    html = ("-H", "Accept: text/html,*/*")
    for path in ("/", "/ps", "/ps/robot"):
        status, page = curl(path, *html)
        assert (status, "<rt-panel" in page) == (200, True)
    assert curl("/ps/robot")[1].startswith("("), "a program gets the names"
    assert curl("/ps/robot/speed", *html)[1] == "0.25"
    policy = curl("/", "-I")[1].lower().partition(POLICY)[2].partition("\n")[0]
    assert "default-src 'none'; script-src 'self'; style-src 'self';" in policy
    assert "unsafe" not in policy
    for path in re.findall('(?:src|href)="(/[^"]*)"', curl("/", *html)[1]):
        assert curl(path)[0] == 200
    served.owned(lambda: service.add("x.html", "<script>1</script>", "text"))
    of_frame = ("-D", "-", "-H", "Sec-Fetch-Dest: iframe", "-H", "Sec-Fetch-Site: same-origin")
    told = curl("/ps/robot/x.html", *of_frame)[1].lower()
    assert "content-type: text/html" in told
    policy = told.rpartition(POLICY)[2].partition("\n")[0]
    assert policy.startswith("sandbox allow-scripts; default-src 'none';")
    assert "connect-src" not in policy
    assert "content-type: text/plain" in curl("/ps/robot/x.html", "-D", "-")[1].lower()
    assert "content-type: text/plain" in curl("/ps/robot/notes", *of_frame)[1].lower()


# Who means no good


class Raw:
    """A connection on which anything can be said."""

    def __init__(self, served: ServedObject) -> None:
        self._port = served.http or 0
        self._end = socket.create_connection(("127.0.0.1", self._port), BOUND_S)
        self._nonce = ""
        self._times = 0

    def __enter__(self) -> Raw:
        return self

    def __exit__(self, *raised: object) -> None:
        self._end.close()

    def known(self, method: str, uri: str) -> str:
        """Return a header that shows who asks."""
        if not self._nonce:
            with socket.create_connection(("127.0.0.1", self._port), BOUND_S) as end:
                end.sendall(b"GET / HTTP/1.0\r\nHost: localhost\r\n\r\n")
                told = end.makefile(encoding="latin-1").read()
            self._nonce = re.search('nonce="(.*?)"', told)[1]  # type: ignore[index]
        self._times += 1
        return "Authorization: " + digest.authorization(
            secret.read(), method, uri, self._nonce, self._times, "own"
        )

    def request(self, method: str, uri: str, *headers: str, host: str = "localhost") -> bytes:
        lines = [f"{method} {uri} HTTP/1.1", f"Host: {host}", self.known(method, uri), *headers]
        return "\r\n".join([*lines, "", ""]).encode()

    def send(self, data: bytes) -> None:
        self._end.sendall(data)

    def rest(self) -> str:
        """Return all that is said until it hangs up."""
        data = b""
        while True:
            try:
                piece = self._end.recv(1 << 16)
            except ConnectionResetError:
                break
            if not piece:
                break
            data += piece
        return data.decode("latin-1")

    def statuses(self) -> list[str]:
        return re.findall(r"HTTP/1\.1 (\d{3}) ", self.rest())


GET = ("GET", "/ps/robot/speed")
LAST = "Connection: close"


def test_only_who_knows_the_secret_is_heard_and_only_once(served: ServedObject) -> None:
    with Raw(served) as raw:
        raw.send(
            b"GET /ps/robot/speed HTTP/1.1\r\nHost: localhost\r\n" + f"{LAST}\r\n\r\n".encode()
        )
        told = raw.rest()
        assert told.startswith("HTTP/1.1 401 ")
        assert "WWW-Authenticate: Digest " in told or "www-authenticate: digest" in told.lower()
        assert told.endswith(
            "denied user and password are those of door.secret (Digest; rtkit help security)\n"
        )
    with Raw(served) as raw:
        once = raw.request(*GET)
        raw.send(once)
        raw.send(once.replace(b"\r\n\r\n", f"\r\n{LAST}\r\n\r\n".encode()))
        assert raw.statuses() == ["200", "401"], "a proof is good for one request"
    with Raw(served) as raw:
        raw.send(
            raw.request("GET", "/ps/robot/speed", LAST).replace(b"/speed HTTP", b"/count HTTP")
        )
        assert raw.statuses() == ["401"], "and for one address"
    with Raw(served) as raw:
        raw.send(raw.request(*GET, LAST).replace(b'response="', b'response="0'))
        assert raw.statuses() == ["401"]
    path = secret.file()
    os.chmod(path, 0o600)
    with open(path, "w", encoding="ascii") as stream:
        stream.write("rtkit:another\n")
    client = connect_http(f"http://localhost:{served.http}", BOUND_S, "robot")
    with client:
        assert client.ask("speed").error == "denied"


STRANGERS = [
    (("Host: evil.example",), "evil.example"),
    (("Origin: http://evil.example",), "localhost"),
    (("Origin: null",), "localhost"),
    (("Origin: https://localhost",), "localhost"),
    (("Origin: http://localhost:1",), "localhost"),
    (("Sec-Fetch-Site: cross-site",), "localhost"),
    (("Sec-Fetch-Site: same-site",), "localhost"),
]


def test_pages_of_other_sites_are_denied(served: ServedObject) -> None:
    for headers, host in STRANGERS:
        with Raw(served) as raw:
            is_host = headers[0].startswith("Host")
            more = () if is_host else headers
            raw.send(raw.request(*GET, *more, LAST, host=headers[0][6:] if is_host else host))
            assert raw.statuses() == ["403"], headers
    for host in ("evil.example:80", "localhost.evil.example", "[::1]", "127.0.0.1.evil", "a b", ""):
        with Raw(served) as raw:
            raw.send(raw.request(*GET, LAST, host=host))
            assert raw.statuses()[0] in ("400", "403"), host
    with Raw(served) as raw:
        own = f"localhost:{served.http}"
        raw.send(raw.request(*GET, f"Origin: http://{own}", LAST, host=own))
        assert raw.statuses() == ["200"]


@pytest.mark.parametrize("path", [
    "/ps/robot/%2e%2e/%2e%2e/etc/passwd", "/ps/robot/..", "/ps/../ps/robot/speed",
    "/ps//robot/speed", "/ps/robot//speed", "/ps/robot/", "/ps/robot/speed%00", "/ps/robot/%",
    "/ps/robot/%ff", "/ps/robot/speed%2flocation", "/ps/robot\\speed", "/psrobot/speed",
    "//ps/robot", "/ps/%72obot/..%2fspeed", "/page.html", "/../page.js",
    "/ps/robot/speed.meta.meta.meta", "/ps/robot/" + "x" * 300, "/ps/robot/" + "a." * 40 + "a",
    "/ps/robot/speed?" + "a=1&" * 9 + "a=1",
])  # fmt: skip
def test_odd_paths_find_nothing(served: ServedObject, path: str) -> None:
    with Raw(served) as raw:
        raw.send(raw.request("GET", path, LAST))
        told = raw.rest()
    status, body = told[9:12], told.rpartition("\r\n\r\n")[2]
    assert status in ("400", "404", "413", "502"), told
    assert re.match(r"(syntax|unknown|no-service|too-large|bad-parameter) ", body)
    assert len(body) < 400


def test_escapes_are_one_spelling(served: ServedObject) -> None:
    with Raw(served) as raw:
        raw.send(raw.request("GET", "/ps/%72obot/%73peed", LAST))
        assert raw.rest().endswith("\r\n\r\n0.25")


PUT = "PUT /ps/robot/any HTTP/1.1\r\nHost: localhost\r\n{known}\r\n"
SMUGGLED = "GET /ps/robot/speed HTTP/1.1\r\nHost: localhost\r\n\r\n"
SHAPES = {
    "two lengths": "Content-Length: 1\r\nContent-Length: 2\r\n\r\n1" + SMUGGLED,
    "length and chunks": "Content-Length: 6\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
    + SMUGGLED,
    "odd coding": "Transfer-Encoding: xchunked\r\n\r\n0\r\n\r\n" + SMUGGLED,
    "two codings": "Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n\r\n0\r\n\r\n"
    + SMUGGLED,
    "coding with a blank": "Transfer-Encoding : chunked\r\n\r\n0\r\n\r\n" + SMUGGLED,
    "negative": "Content-Length: -1\r\n\r\n" + SMUGGLED,
    "signed": "Content-Length: +1\r\n\r\n1" + SMUGGLED,
    "hexadecimal": "Content-Length: 0x1\r\n\r\n1" + SMUGGLED,
    "list": "Content-Length: 1, 2\r\n\r\n1" + SMUGGLED,
    "size of a chunk": "Transfer-Encoding: chunked\r\n\r\n-1\r\n\r\n" + SMUGGLED,
    "end of a chunk": "Transfer-Encoding: chunked\r\n\r\n1\r\n1XX0\r\n\r\n" + SMUGGLED,
    "two hosts": "Host: localhost\r\nContent-Length: 0\r\n\r\n" + SMUGGLED,
    "two authorizations": "{again}\r\nContent-Length: 1\r\n\r\n1" + SMUGGLED,
    "NUL in a header": "X-Odd: \0\r\nContent-Length: 1\r\n\r\n1" + SMUGGLED,
    "line feed in a name": "X\n-Odd: 1\r\nContent-Length: 1\r\n\r\n1" + SMUGGLED,
    "long header": "X-Odd: " + "x" * 70_000 + "\r\n\r\n" + SMUGGLED,
    "many headers": "X-Odd: 1\r\n" * 9_000 + "\r\n" + SMUGGLED,
    "long body": "Content-Length: 99999999999\r\n\r\n",
    "endless chunks": "Transfer-Encoding: chunked\r\n\r\n"
    + ("10000\r\n" + "x" * 65536 + "\r\n") * 20,
}


@pytest.mark.parametrize("shape", SHAPES)
def test_what_could_be_read_in_two_ways_is_refused_and_ends_all(
    served: ServedObject, shape: str
) -> None:
    with Raw(served) as raw:
        known, again = raw.known("PUT", "/ps/robot/any"), raw.known("PUT", "/ps/robot/any")
        text = (PUT + SHAPES[shape].replace("{", "{{").replace("}", "}}").replace(
            "{{again}}", "{again}")).format(known=known, again=again)  # fmt: skip
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            raw.send(text.encode("latin-1"))  # or it was refused before all was said
        statuses = raw.statuses()
        # What hung up while much was on its way may take its answer with it.
        assert len(statuses) <= 1
        assert set(statuses) <= {"400", "413", "431", "501"}
    assert _any(served) == '(a (1 2) "b c")'


def _any(served: ServedObject) -> object:
    with connect_unix(served.socket, BOUND_S) as client:
        return client.ask("any").payload


@pytest.mark.parametrize("rubbish", [
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(range(256)) * 8,
    b"GET speed\n", b"\r\n" * 20_000, b"x" * 100_000, b"GET / HTTP/9.9\r\n\r\n",
    b"GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"CONNECT localhost:22 HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"OPTIONS * HTTP/1.1\r\nHost: localhost\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n",
    b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
])  # fmt: skip
def test_rubbish_is_answered_once_and_harms_nobody(served: ServedObject, rubbish: bytes) -> None:
    with Raw(served) as raw:
        raw.send(rubbish)
        raw._end.shutdown(socket.SHUT_WR)
        assert set(raw.statuses()) <= {"400", "401", "403", "431", "505"}
    assert _any(served) == '(a (1 2) "b c")'


def test_who_is_slow_is_not_waited_for(
    served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_connection, "REQUEST_S", 0.4)
    monkeypatch.setattr(server_connection, "PATIENCE_S", 0.4)
    monkeypatch.setattr(server_connection, "STUCK_S", 0.4)
    with Raw(served) as silent, Raw(served) as half, Raw(served) as bodiless, Raw(served) as deaf:
        half.send(b"GET /ps/robot/speed HT")
        bodiless.send(bodiless.request("PUT", "/ps/robot/any", "Content-Length: 9") + b"(1")
        served.owned(lambda: service.update("notes", "x" * 1_000_000))
        deaf.send(b"".join(deaf.request("GET", "/ps/robot/notes") for _ in range(30)))
        assert silent.rest() == ""
        assert half.rest().startswith("HTTP/1.1 408 ")
        assert bodiless.rest().startswith("HTTP/1.1 408 ")
        most = [0]

        def is_given_up() -> bool:
            most[0] = max([len(each._out) for each in _clients(served)] + most)
            return not _clients(served)

        # Nothing was read of `deaf`: one response is kept for it at most.
        _wait_until(served, is_given_up)
        assert most[0] < 1_100_000
    assert _any(served) == '(a (1 2) "b c")'


def test_a_slow_loris_has_no_more_time_than_others(
    served: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_connection, "REQUEST_S", 0.5)
    with Raw(served) as raw:
        raw._end.settimeout(0.05)
        said = 0
        for byte in raw.request(*GET) * 1000:
            try:
                raw.send(bytes([byte]))
                said += 1
                assert raw._end.recv(12) == b"HTTP/1.1 408"
                break
            except TimeoutError:
                continue
        assert said < len(raw.request(*GET))


def test_streams_are_bounded_and_alive(
    place: str, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_connection, "HEARTBEAT_S", 0.2)
    rules = "limit http door_listeners 2"
    served = serve(service, "robot", http=0, is_on_zenoh=False, rules=rules)
    address = f"http://localhost:{served.http}"
    with connect_http(address, BOUND_S, "robot") as client, Raw(served) as raw:
        client.listen("count")
        client.listen("arm.angle")
        told = [client.event(BOUND_S), client.event(BOUND_S)]
        assert sorted(each.name for each in told if each) == ["arm.angle", "count"]
        raw.send(raw.request("GET", "/ps/robot/count", "Accept: text/event-stream", LAST))
        assert raw.statuses() == ["403"]
        heartbeat = client._streams[0]
        begin = heartbeat.received_at
        while heartbeat.received_at == begin:
            client._receive(BOUND_S)
        assert client.event(0) is None
    served.close()
    with connect_http(address, BOUND_S, "robot") as gone, pytest.raises(Unreachable):
        gone.ask("speed")


def test_a_listener_that_comes_again_is_told_only_what_is_new(
    served: ServedObject, service: Service
) -> None:
    accepts = "Accept: text/event-stream"
    with Raw(served) as raw:
        raw.send(raw.request("GET", "/ps/robot/count", accepts))
        head = ""
        while not head.endswith("data: 7\n\n\r\n"):
            head += raw._end.recv(4096).decode()
        last = re.search("id: (.*)", head)[1]  # type: ignore[index]
    for expected, id in (("8", last), ("9", "nonsense"), ("10", last)):
        with Raw(served) as raw:
            raw.send(raw.request("GET", "/ps/robot/count?queue=9", accepts, f"Last-Event-ID: {id}"))
            _wait_until(served, lambda: bool(_streams(served)))
            served.owned(lambda value=int(expected): service.update("count", value))  # type: ignore[misc]
            told = ""
            while f"data: {expected}\n" not in told:
                told += raw._end.recv(4096).decode()
        values = re.findall("data: (.*)\n", told)
        before = {"8": [], "9": ["8"], "10": ["9"]}[expected]
        assert values == [*before, expected]


def _wait_until(served: ServedObject, is_so: Callable[[], bool]) -> None:
    end = time.monotonic() + BOUND_S
    while not is_so():
        assert time.monotonic() < end
        served.owned(lambda: None)


def test_the_secret_and_the_door_fit(place: str) -> None:
    with pytest.raises(Unreachable, match="no secret"):
        connect_http("http://localhost:1", 1.0)
    assert places.state_dir().startswith(place)


@pytest.mark.parametrize("trickle", [b"", b"HTTP/1.1 200 OK\r\n"])
@pytest.mark.parametrize(
    ("target", "payload", "until_s"),
    [("x", None, 0.3), ("x?timeout=0.3", None, 60.0), ("x?timeout=0.3", "1", 60.0)],
)
def test_a_silent_server_is_given_up_in_time(
    trickle: bytes, target: str, payload: str | None, until_s: float
) -> None:
    """All of a request ends in time, also where something comes again and again."""
    ended = threading.Event()

    def talk(end: socket.socket) -> None:
        with end, contextlib.suppress(OSError):
            end.sendall(trickle)
            while trickle and not ended.wait(0.05):
                end.sendall(b"x-more: 1\r\n")
            ended.wait(BOUND_S)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        serving = threading.Thread(target=lambda: talk(listener.accept()[0]))
        serving.start()
        port = listener.getsockname()[1]
        with HttpClient("127.0.0.1", port, secret.Secret("me", "it"), BOUND_S) as client:
            begin = time.monotonic()
            with pytest.raises(Unreachable, match=r"no answer within 0\.[34] s"):
                client.ask(target, payload, begin + until_s)
            assert time.monotonic() - begin < 1.5
            assert client.ask(target, payload, begin).error == "timeout"
        ended.set()
        serving.join()
