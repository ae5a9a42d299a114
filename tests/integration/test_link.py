"""The contract of a link, kept by each of its makes: calls to services, answers, failures."""

from __future__ import annotations

import os
import queue
import resource
import select
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from typing import NamedTuple

import pytest
from fake_link import InprocLink
from hypothesis import given
from hypothesis import strategies as st

from rtkit.errors import Malformed, NotFound, Refused, Unreachable
from rtkit.link import places, unix, zenoh_keys
from rtkit.link.requests.client import connect
from rtkit.link.requests.frames import GREETING
from rtkit.link.requests.manager_link import ManagerLink, open_link
from rtkit.link.requests.server import RequestServer
from rtkit.link.transport import Link
from rtkit.link.zenoh import ZenohLink, open_client, open_listener, unix_endpoint
from rtkit.property.exchange import Reply, Request

SERVICE = zenoh_keys.service("host", "manager")
AT_ONCE_S = 30.0
"""Bound on what comes at once [s]; no test waits for it."""


class Ends(NamedTuple):
    """Who serves and who calls."""

    owner: Link
    caller: Link


class Owner(ZenohLink):
    """What a manager is to commands: it serves over zenoh, and at a socket for requests."""

    _take: Callable[[Request], object] | None = None

    def open_requests(self) -> None:
        self._server = RequestServer(places.request_socket("manager"), self._enqueue)
        self._end, self._ended = os.pipe()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def serve(self, service_key: str, enqueue: Callable[[Request], object]) -> None:
        super().serve(service_key, enqueue)
        if service_key == SERVICE:
            self._take = enqueue

    def _enqueue(self, request: Request) -> None:
        if self._take is None:
            request.answer(Reply("nothing is served yet", Unreachable.kind))
        else:
            self._take(request)

    def _run(self) -> None:
        while self._end not in select.select([self._server, self._end], [], [])[0]:
            self._server.turn()

    def end_requests(self) -> None:
        os.close(self._ended)
        self._thread.join()
        os.close(self._end)
        self._server.close()

    def close(self) -> None:
        self.end_requests()
        super().close()


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        monkeypatch.setenv("RTKIT_RUNTIME_DIR", folder)
        yield folder


@pytest.fixture
def owner(folder: str) -> Iterator[Owner]:
    owner = Owner(open_listener(unix_endpoint(places.manager_socket("manager"))))
    owner.open_requests()
    yield owner
    owner.close()


@pytest.fixture(params=["inproc", "zenoh", "manager"])
def ends(request: pytest.FixtureRequest) -> Iterator[Ends]:
    if request.param == "manager":
        owner = request.getfixturevalue("owner")
        caller = open_link("manager", "host", AT_ONCE_S)
        assert isinstance(caller, ManagerLink)
        yield Ends(owner, caller)
        caller.close()
        return
    if request.param == "inproc":
        link = InprocLink()
        yield Ends(link, link)
        return
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        endpoint = unix_endpoint(f"{folder}/s")
        owner = ZenohLink(open_listener(endpoint))
        caller = ZenohLink(open_client(endpoint, AT_ONCE_S))
        yield Ends(owner, caller)
        caller.close()
        owner.close()


def serve(ends: Ends, answer: Callable[[Request], Reply], service: str = SERVICE) -> list[Request]:
    """Answer each request at once; return the list of what came."""
    seen: list[Request] = []

    def enqueue(request: Request) -> None:
        seen.append(request)
        request.answer(answer(request))

    ends.owner.serve(service, enqueue)
    return seen


def ok(text: str = "") -> Callable[[Request], Reply]:
    return lambda request: Reply(text)


def test_a_get_has_no_payload_and_a_set_has_one(ends: Ends) -> None:
    seen = serve(ends, lambda request: Reply(f"got {request.payload}"))
    key = zenoh_keys.property_key(SERVICE, "a.b")
    for payload in (None, "", "x", "0"):
        assert ends.caller.call(key, payload, AT_ONCE_S) == Reply(f"got {payload}")
    assert [(r.name, r.payload, r.is_extension) for r in seen] == [
        ("a.b", None, False),
        ("a.b", "", False),
        ("a.b", "x", False),
        ("a.b", "0", False),
    ]


def test_extensions_are_apart(ends: Ends) -> None:
    seen = serve(ends, ok())
    ends.caller.call(zenoh_keys.extension_key(SERVICE, "part/a"), None, AT_ONCE_S)
    ends.caller.call(zenoh_keys.property_key(SERVICE, "part/a"), None, AT_ONCE_S)
    assert [(r.name, r.is_extension) for r in seen] == [("part/a", True), ("part/a", False)]


@pytest.mark.parametrize(
    "text", ["", "a", "ä → ∀ 😀", "a\0b\r\n\t", '{"a":"\\ud800"}', "x" * 10**7]
)
def test_text_comes_as_it_is(ends: Ends, text: str) -> None:
    serve(ends, lambda request: Reply(request.payload or ""))
    reply = ends.caller.call(zenoh_keys.property_key(SERVICE, "p"), text, AT_ONCE_S)
    assert reply == Reply(text)


@pytest.mark.parametrize("name", ["a b", "a*b", "**", "$*", "a?b=c;d", "a#b", "a%b", "@", "é/ü"])
def test_a_name_of_any_characters_comes_as_one(ends: Ends, name: str) -> None:
    seen = serve(ends, ok())
    ends.caller.call(zenoh_keys.property_key(SERVICE, name), None, AT_ONCE_S)
    (request,) = seen
    assert "/".join(map(zenoh_keys.unescape, request.name.split("/"))) == name


@pytest.mark.parametrize(("error", "kind"), [(NotFound, "not-found"), (Refused, "refused")])
def test_an_error_comes_with_its_kind(ends: Ends, error: type[Exception], kind: str) -> None:
    serve(ends, lambda request: Reply("no such thing, with several words", kind))
    reply = ends.caller.call(zenoh_keys.property_key(SERVICE, "p"), None, AT_ONCE_S)
    assert reply == Reply("no such thing, with several words", kind)
    with pytest.raises(error, match="several words"):
        reply.value()


def test_who_serves_is_told_apart(ends: Ends) -> None:
    one, other = zenoh_keys.service("host", "a"), zenoh_keys.service("host", "a", "Motor0")
    serve(ends, ok("one"), one)
    serve(ends, ok("other"), other)
    for service, text in ((one, "one"), (other, "other")):
        key = zenoh_keys.property_key(service, "p")
        assert ends.caller.call(key, None, AT_ONCE_S).text == text


def test_nobody_serves_it(ends: Ends) -> None:
    serve(ends, ok())
    for manager in ("other", "manage", "manager2"):
        key = zenoh_keys.property_key(zenoh_keys.service("host", manager), "p")
        with pytest.raises(Unreachable):
            ends.caller.call(key, None, AT_ONCE_S)


def test_an_answer_that_does_not_come_in_time(ends: Ends) -> None:
    kept: list[Request] = []
    ends.owner.serve(SERVICE, kept.append)
    with pytest.raises(Unreachable, match=r"no answer within 0\.05 s"):
        ends.caller.call(zenoh_keys.property_key(SERVICE, "p"), None, 0.05)
    (request,) = kept
    request.answer(Reply("too late"))  # harms nobody
    serve(ends, ok("in time"), zenoh_keys.service("host", "other"))
    key = zenoh_keys.property_key(zenoh_keys.service("host", "other"), "p")
    assert ends.caller.call(key, None, AT_ONCE_S).text == "in time"


def test_an_answer_may_come_later_from_another_thread(ends: Ends) -> None:
    inbox: queue.SimpleQueue[Request] = queue.SimpleQueue()
    ends.owner.serve(SERVICE, inbox.put)
    thread = threading.Thread(target=lambda: inbox.get().answer(Reply("done")))
    thread.start()
    assert ends.caller.call(zenoh_keys.property_key(SERVICE, "p"), "x", AT_ONCE_S).text == "done"
    thread.join()


def test_calls_at_the_same_time_get_each_its_own_answer(ends: Ends) -> None:
    inbox: queue.SimpleQueue[Request] = queue.SimpleQueue()
    ends.owner.serve(SERVICE, inbox.put)
    answers: dict[int, str] = {}

    def call(number: int) -> None:
        key = zenoh_keys.property_key(SERVICE, "p")
        answers[number] = ends.caller.call(key, str(number), AT_ONCE_S).text

    callers = [threading.Thread(target=call, args=(number,)) for number in range(20)]
    for caller in callers:
        caller.start()
    for request in reversed([inbox.get() for _ in callers]):
        request.answer(Reply(f"re {request.payload}"))
    for caller in callers:
        caller.join()
    assert answers == {number: f"re {number}" for number in range(20)}


def test_after_it_was_closed_nobody_is_reached(ends: Ends) -> None:
    serve(ends, ok())
    ends.caller.close()
    with pytest.raises(Unreachable):
        ends.caller.call(zenoh_keys.property_key(SERVICE, "p"), None, AT_ONCE_S)


@pytest.mark.parametrize("key", ["", "rt/a", "rt/a/@/", "rt//@/p", "/@/p"])
def test_what_is_no_key(ends: Ends, key: str) -> None:
    with pytest.raises((Malformed, Unreachable)):
        ends.caller.call(key, None, AT_ONCE_S)


def test_nobody_listens() -> None:
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        with pytest.raises(Unreachable, match="cannot reach"):
            open_client(unix_endpoint(f"{folder}/none"), AT_ONCE_S)
        with pytest.raises(Unreachable, match="cannot listen"):
            open_listener(unix_endpoint(f"{folder}/no/such/folder"))


@given(st.text(max_size=20))
def test_escaping_can_be_undone_and_leaves_nothing_special(chunk: str) -> None:
    escaped = zenoh_keys.escape(chunk)
    assert zenoh_keys.unescape(escaped) == chunk
    assert escaped
    assert not set(escaped) & set("/*$?#@ \n")


@given(st.text(alphabet="%0123456789abcXYZ/", max_size=20))
def test_undoing_an_escape_never_fails(chunk: str) -> None:
    assert isinstance(zenoh_keys.unescape(chunk), str)


def test_a_line_is_heard_by_all_who_listen_and_costs_nothing_without_them(ends: Ends) -> None:
    key = zenoh_keys.line_key(SERVICE, "news")
    listened: queue.SimpleQueue[bool] = queue.SimpleQueue()
    heard: queue.SimpleQueue[tuple[int, str]] = queue.SimpleQueue()
    tell = ends.owner.announce(key, listened.put)
    tell("to nobody")
    serve(ends, ok())
    stops = [ends.caller.listen(key, lambda text, n=n: heard.put((n, text))) for n in (1, 2)]
    assert listened.get(timeout=AT_ONCE_S)
    for text in ("one", "two"):
        tell(text)
    told = sorted(heard.get(timeout=AT_ONCE_S) for _ in range(4))
    assert told == [(1, "one"), (1, "two"), (2, "one"), (2, "two")]
    for stop in stops:
        stop()
    assert not listened.get(timeout=AT_ONCE_S)
    tell("to nobody")
    assert heard.empty()


@pytest.fixture
def caller(owner: Owner) -> Iterator[Link]:
    caller = open_link("manager", "host", AT_ONCE_S)
    yield caller
    caller.close()


KEY = zenoh_keys.property_key(SERVICE, "p")


def test_a_command_that_asks_opens_no_zenoh(owner: Owner, caller: Link) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    owner.withdraw()  # over zenoh nobody answers any more
    assert caller.call(KEY, None, AT_ONCE_S) == Reply("here")


def test_an_older_manager_is_asked_over_zenoh(owner: Owner) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    os.unlink(places.request_socket("manager"))
    with closing(open_link("manager", "host", AT_ONCE_S)) as link:
        assert link.call(KEY, None, AT_ONCE_S) == Reply("here")


def test_a_manager_that_was_started_again_is_reached_again(owner: Owner, caller: Link) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    assert caller.call(KEY, None, AT_ONCE_S) == Reply("here")
    owner.end_requests()
    with pytest.raises(Unreachable, match="nobody answers"):
        caller.call(KEY, None, AT_ONCE_S)
    owner.open_requests()
    assert caller.call(KEY, None, AT_ONCE_S) == Reply("here")


def test_a_reply_that_nobody_awaits_does_not_hide_the_end_of_the_manager(
    owner: Owner, caller: Link
) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    unread = caller.send(KEY, None, AT_ONCE_S)
    with closing(open_link("manager", "host", AT_ONCE_S)) as other:
        other.call(KEY, None, AT_ONCE_S)  # by now the first one is answered
    owner.end_requests()
    with pytest.raises(Unreachable, match="nobody answers"):
        caller.call(KEY, None, AT_ONCE_S)
    owner.open_requests()
    assert caller.call(KEY, None, AT_ONCE_S) == Reply("here")
    with pytest.raises(Unreachable):
        unread()  # its connection has been given up


def test_a_reply_that_was_awaited_when_the_manager_ended(owner: Owner, caller: Link) -> None:
    asked = threading.Event()
    owner.serve(SERVICE, lambda _request: asked.set())
    awaited = caller.send(KEY, "x", AT_ONCE_S)
    assert asked.wait(AT_ONCE_S)
    owner.end_requests()
    with pytest.raises(Unreachable, match="nobody answers"):
        awaited()
    owner.open_requests()


def test_who_reads_no_answers_holds_up_nobody(owner: Owner, caller: Link) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("x" * 10**7)))
    unread = [caller.send(KEY, None, AT_ONCE_S) for _ in range(3)]
    with closing(open_link("manager", "host", AT_ONCE_S)) as other:
        assert len(other.call(KEY, None, AT_ONCE_S).text) == 10**7
    assert [len(each().text) for each in unread] == [10**7] * 3


def test_of_who_asks_and_reads_no_answers_little_is_taken(owner: Owner, caller: Link) -> None:
    asked, most = 0, threading.Semaphore(0)

    def take(request: Request) -> None:
        nonlocal asked
        asked += 1
        request.answer(Reply("x" * 10**6))
        most.release()

    owner.serve(SERVICE, take)
    # More than the kernel keeps for a socket: who sends them must not wait for who reads.
    awaited = [caller.send(KEY, None, AT_ONCE_S) for _ in range(1000)]
    assert most.acquire(timeout=AT_ONCE_S)
    with closing(open_link("manager", "host", AT_ONCE_S)) as other:
        other.call(KEY, None, AT_ONCE_S)
    assert asked < 10
    assert {len(each().text) for each in awaited} == {10**6}


def test_what_was_sent_before_a_listener_came_is_taken_before_what_follows(
    owner: Owner, caller: Link
) -> None:
    names: list[str] = []

    def take(request: Request) -> None:
        names.append(request.name)
        request.answer(Reply(""))

    owner.serve(SERVICE, take)
    first = caller.send(KEY, "x", AT_ONCE_S)
    caller.listen(zenoh_keys.line_key(SERVICE, "tree"), print)
    caller.call(zenoh_keys.property_key(SERVICE, "q"), "x", AT_ONCE_S)
    first()
    assert names == ["p", "manager.pid", "q"]


RUBBISH = [
    b"GET / HTTP/1.1\r\n\r\n",
    b"\xff" * 64,
    b"\0\0\0\0",
    b"\x29\0\0\0" + b"\xff" * 41,
]


@pytest.mark.parametrize("said", RUBBISH)
def test_rubbish_is_hung_up_on(owner: Owner, caller: Link, said: bytes) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    with unix.connect(places.request_socket("manager"), AT_ONCE_S) as end:
        end.sendall(said)
        assert end.recv(64) == GREETING
        assert end.recv(64) == b""
    assert caller.call(KEY, None, AT_ONCE_S) == Reply("here")


@pytest.mark.parametrize("name", ["", "@/", "@/a//b", "@/a*", "@x/**", "x/a", "@/a?b=c", "@/a b"])
def test_what_is_no_name_of_a_property(owner: Owner, name: str) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    connection = connect(places.request_socket("manager"), AT_ONCE_S)
    reply = connection.send(name, None, AT_ONCE_S)()
    assert reply == Reply(f"not a property: {name}", Malformed.kind)
    connection.close()


def test_a_payload_that_is_no_text(owner: Owner, caller: Link) -> None:
    owner.serve(SERVICE, lambda request: request.answer(Reply("here")))
    assert caller.call(KEY, "a\udcff", AT_ONCE_S).error == Malformed.kind


def test_a_manager_that_does_not_answer_at_once(folder: str) -> None:
    with unix.listen(places.request_socket("manager")):
        with pytest.raises(Unreachable, match=r"no answer within 0.01 s"):
            open_link("manager", "host", 0.01)
        with pytest.raises(Unreachable, match=r"no answer within 0.01 s"):
            open_link("manager", "host", 0.01)


def test_without_a_descriptor_a_command_is_turned_away_and_the_next_one_is_not(
    folder: str,
) -> None:
    path = places.request_socket("manager")
    server = RequestServer(path, lambda request: request.answer(Reply("here")))
    with closing(server), unix.connect(path, AT_ONCE_S) as first:
        with no_descriptor_left():
            server.turn()
        assert first.recv(64) == b""
        with unix.connect(path, AT_ONCE_S) as second:
            server.turn()
            assert second.recv(64) == GREETING


@contextmanager
def no_descriptor_left() -> Iterator[None]:
    usual = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = 1 + max(map(int, os.listdir("/proc/self/fd")))
    taken = []
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, usual[1]))
        with suppress(OSError):
            while True:
                taken.append(os.open(os.devnull, os.O_RDONLY))
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, usual)
        for each in taken:
            os.close(each)
