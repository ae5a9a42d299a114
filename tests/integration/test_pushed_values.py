"""Values that an owner publishes are events at once, in order; over HTTP they are parts."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from http.client import HTTPConnection, HTTPResponse

import pytest
from waiting import until

from rtkit.link import secret
from rtkit.wires.http import digest
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve

BOUND_S = 10.0
JPEG = b"\xff\xd8\xff\xe0 not all of a picture"


class Source:
    """A source of blocks that counts how often its getter is called."""

    block: bytes = b""
    image: bytes = JPEG
    text: str = "one"

    def __init__(self) -> None:
        self._asked = 0

    def __served__(self, publish: Callable[[str, object], None]) -> None:
        self.publish: Callable[[str, object], None] = publish
        self._publish = publish

    def get_computed(self) -> int:
        self._asked += 1
        return self._asked


@pytest.fixture
def source() -> Source:
    return Source()


@pytest.fixture
def served(place: str, source: Source) -> Iterator[ServedObject]:
    with serve(source, "source", is_on_zenoh=False, http=0) as served:
        yield served


def test_each_value_comes_in_order_also_the_equal_ones(
    served: ServedObject, source: Source
) -> None:
    with connect_unix(served.socket, BOUND_S) as client:
        client.listen("block?queue=1000&mode=all")
        assert client.event(BOUND_S)
        assert served.service.is_polled  # until its owner has published it
        blocks = [b"\xff%d" % (each // 2) for each in range(200)]  # each twice
        sender = threading.Thread(target=lambda: [source.publish("block", each) for each in blocks])
        sender.start()
        got = []
        while len(got) < len(blocks):
            if len(got) == 50:
                assert client.ask("block").value()  # a GET in between disturbs nothing
            event = client.event(BOUND_S)
            assert event is not None
            assert not event.dropped
            got.append(event.payload)
        sender.join()
        assert got == blocks
        assert not served.service.is_polled
        assert client.event(0.05) is None  # nor does polling send one twice
        assert client.ask("block").value() == blocks[-1] == source.block


def test_a_name_that_is_hidden_is_set_and_sent_to_nobody(place: str, source: Source) -> None:
    with serve(source, "source", is_on_zenoh=False, hide=["text"]) as served:
        source.publish("text", "two")
        with connect_unix(served.socket, BOUND_S) as client:
            assert "text" not in str(client.ask("properties").value())
    assert source.text == "two"


def test_an_owner_may_publish_until_it_is_left(place: str) -> None:
    class Busy:
        count: int = 0

        def __served__(self, publish: Callable[[str, object], None]) -> None:
            self._publish = publish

        def __enter__(self) -> None:
            self._ended, self._after = threading.Event(), threading.Event()
            self._thread = threading.Thread(target=self._run)
            self._thread.start()

        def _run(self) -> None:
            while not self._ended.is_set():
                self._publish("count", self.count + 1)
                self._after.set()

        def __exit__(self, *raised: object) -> None:
            self._after.clear()
            assert self._after.wait(BOUND_S)  # nothing is served any more
            self._ended.set()
            self._thread.join()

    for _ in range(5):
        with (
            serve(Busy(), "busy", is_on_zenoh=False) as served,
            connect_unix(served.socket, BOUND_S) as client,
        ):
            client.listen("count")
            assert client.event(BOUND_S)


# parts


@contextmanager
def viewer(served: ServedObject, query: str, accept: str = "image/*,*/*") -> Iterator[HTTPResponse]:
    """Ask as a browser does: first as nobody, then with the secret."""
    uri = f"/ps/source/{query}"
    with closing(HTTPConnection("localhost", served.http or 0, timeout=BOUND_S)) as client:
        client.request("GET", uri)
        refused = client.getresponse()
        refused.read()
        nonce = re.findall('nonce="(.*?)"', refused.headers["WWW-Authenticate"])[0]
        shown = digest.authorization(secret.read(), "GET", uri, nonce, 1, "own")
        client.request("GET", uri, headers={"Accept": accept, "Authorization": shown})
        with client.getresponse() as answer:
            yield answer


class Parts:
    """Parts of a stream; each is there as soon as the head of the next one is."""

    def __init__(self, stream: HTTPResponse) -> None:
        kind, _, mark = stream.headers["Content-Type"].partition("; boundary=")
        assert kind == "multipart/x-mixed-replace"
        self._stream, self._mark = stream, f"--{mark}\r\n".encode()
        assert self._content() == b""
        self._kind = self._head()

    def __call__(self) -> tuple[str, bytes]:
        """Return type and content of the next part that is not empty."""
        while True:
            kind, content = self._kind, self._content()
            self._kind = self._head()
            if content:
                return kind, content

    def _content(self) -> bytes:
        lines = []
        while (line := self._stream.readline()) != self._mark:
            assert line
            lines.append(line)
        return b"".join(lines).removesuffix(b"\r\n")

    def _head(self) -> str:
        kind = self._stream.readline().decode().removeprefix("Content-Type: ").strip()
        assert self._stream.readline() == b"\r\n"
        return kind


@pytest.mark.parametrize(
    ("query", "accept"),
    [("image?stream", "image/*"), ("image?every=0.001", "multipart/x-mixed-replace")],
)
def test_pictures_are_streamed_as_parts(
    served: ServedObject, source: Source, query: str, accept: str
) -> None:
    with viewer(served, query, accept) as stream:
        part = Parts(stream)
        assert part() == ("image/jpeg", JPEG)
        source.publish("image", JPEG + b"2")
        assert part() == ("image/jpeg", JPEG + b"2")
        source.publish("image", b"\x89PNG\r\n\x1a\n--rtkit\r\n")
        assert part() == ("image/png", b"\x89PNG\r\n\x1a\n--rtkit\r\n")
        source.publish("image", b"<svg>")
        assert part() == ("application/octet-stream", b"<svg>")


def test_values_are_streamed_as_parts_of_text(served: ServedObject) -> None:
    with viewer(served, "text?stream") as stream:
        assert Parts(stream)() == ("text/plain; charset=utf-8", b'"one"')


def test_one_picture_says_what_it_is(served: ServedObject) -> None:
    with viewer(served, "image") as answer:
        assert (answer.headers["Content-Type"], answer.read()) == ("image/jpeg", JPEG)


@pytest.mark.parametrize(
    ("query", "status", "text"),
    [
        ("image?stream&width=3", 400, b"bad-parameter not a parameter of listen: width\n"),
        ("nope?stream", 404, b"unknown no such property: nope\n"),
    ],
)
def test_what_cannot_be_streamed_is_refused(
    served: ServedObject, query: str, status: int, text: bytes
) -> None:
    with viewer(served, query) as refused:
        assert (refused.status, refused.read()) == (status, text)


def test_a_viewer_that_does_not_read_gets_the_latest_and_delays_nobody(
    served: ServedObject, source: Source
) -> None:
    frames = [JPEG + b"%06d" % each + bytes(300_000) for each in range(120)]
    with viewer(served, "image?stream") as slow, viewer(served, "image?stream") as quick:
        late, early = Parts(slow), Parts(quick)
        assert late() == early()
        for frame in frames:
            source.publish("image", frame)
            assert early()[1] == frame  # the quick one has each, at once
        seen = []
        while not seen or seen[-1] != frames[-1]:
            seen.append(late()[1])
        order = [frames.index(each) for each in seen]
        assert order == sorted(order)
        assert len(seen) < len(frames) / 2


def test_a_viewer_that_goes_is_forgotten(served: ServedObject, source: Source) -> None:
    with viewer(served, "image?stream") as stream:
        assert Parts(stream)()
        assert served.service.listeners.is_any
    until(lambda: not served.service.listeners.is_any, "the viewer is forgotten")
