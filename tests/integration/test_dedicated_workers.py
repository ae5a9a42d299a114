"""A client that asks one thing after another is served by a thread of its own, and served alike."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from conformance import check_answers, check_events
from property_endpoints import BOUND_S, Lines

from rtkit.errors import Unreachable
from rtkit.property.service import Service
from rtkit.serving import dedicated_worker, workers
from rtkit.wires.line import server_connection
from rtkit.wires.line.client import LineClient, connect_tcp, connect_unix
from rtkit.wires.line.server_connection import Connection
from rtkit.wires.serve import ServedObject, serve

_IDLE = '= <call state="idle"/>\n'


@pytest.fixture
def served(place: str, service: Service) -> Iterator[ServedObject]:
    with serve(service, "robot", port=0, is_on_zenoh=False) as served:
        yield served
    assert _workers() == 0


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each client has an attendant from its first request on, and again after each other one."""
    monkeypatch.setattr(server_connection, "IN_A_ROW", 1)
    monkeypatch.setattr(dedicated_worker, "PAUSE_S", 0.2)


def _workers() -> int:
    return sum(each.name == "attendant" for each in threading.enumerate())


def _until(holds: Callable[[], bool]) -> None:
    deadline = time.monotonic() + BOUND_S
    while not holds():
        assert time.monotonic() < deadline
        threading.Event().wait(0.002)


def _ask_on(client: LineClient) -> None:
    """Ask until it has an attendant."""
    deadline = time.monotonic() + BOUND_S
    while not _workers():
        assert client.ask("speed").error == ""
        assert time.monotonic() < deadline


@pytest.fixture(params=["unix", "tcp"])
def endpoint(request: pytest.FixtureRequest, eager: None, served: ServedObject) -> Iterator[Lines]:
    port = served.port or 0
    made = Lines(
        lambda: (
            connect_unix(served.socket, BOUND_S)
            if request.param == "unix"
            else connect_tcp("127.0.0.1", port, BOUND_S)
        )
    )
    yield made
    made.close()


def test_it_answers_like_any_door(endpoint: Lines) -> None:
    check_answers(endpoint)


def test_it_lets_listen_like_any_door(
    endpoint: Lines, served: ServedObject, service: Service
) -> None:
    check_events(endpoint, service, served.owned)


class Arm:
    """Tells on which thread its code is called; one getter waits until it is let go."""

    def __init__(self) -> None:
        self.threads: set[str] = set()
        self.is_begun = threading.Event()
        self.may_go = threading.Event()
        self._angle = 0.5

    @property
    def angle(self) -> float:
        self.threads.add(threading.current_thread().name)
        return self._angle

    @angle.setter
    def angle(self, value: float) -> None:
        self.threads.add(threading.current_thread().name)
        self._angle = value

    @property
    def slow(self) -> float:
        self.is_begun.set()
        assert self.may_go.wait(BOUND_S)
        return 1.0


@pytest.fixture
def arm(place: str) -> Iterator[tuple[Arm, ServedObject]]:
    arm = Arm()
    with serve(arm, "arm", hide=["threads", "is_begun", "may_go"], is_on_zenoh=False) as served:
        yield arm, served
        arm.may_go.set()


@pytest.mark.usefixtures("eager")
def test_code_of_users_is_called_by_the_thread_that_reads(arm: tuple[Arm, ServedObject]) -> None:
    with connect_unix(arm[1].socket, BOUND_S) as client:
        client.ask("angle")
        client.ask("angle")
        arm[0].threads.clear()
        for index in range(20):
            assert client.ask("angle", str(float(index))).error == ""
            assert client.ask("angle").payload == str(float(index))
        assert arm[0].threads == {"attendant"}
        assert client.ask("angle", "red").error == "bad-value"


@pytest.mark.usefixtures("eager")
def test_slow_code_of_one_client_holds_up_nobody(arm: tuple[Arm, ServedObject]) -> None:
    with connect_unix(arm[1].socket, BOUND_S) as other, socket.socket(socket.AF_UNIX) as end:
        end.settimeout(BOUND_S)
        end.connect(arm[1].socket)
        replies = end.makefile()
        for _ in range(3):
            end.sendall(b"GET angle\n")
            assert replies.readline() == "= 0.5\n"
        assert _workers() == 1
        end.sendall(b"GET slow\n")
        assert arm[0].is_begun.wait(BOUND_S)
        assert other.ask("angle").payload == "0.5"
        # Its own further requests are read too: with an id they need not wait for their turn.
        end.sendall(b"GET angle\n#1 GET angle\n")
        assert replies.readline() == "#1 = 0.5\n"
        arm[0].may_go.set()
        assert [replies.readline() for _ in range(2)] == ["= 1.0\n", "= 0.5\n"]
        replies.close()


@pytest.mark.usefixtures("eager")
def test_code_that_never_comes_back_is_given_up(
    arm: tuple[Arm, ServedObject], monkeypatch: pytest.MonkeyPatch
) -> None:
    with connect_unix(arm[1].socket, BOUND_S) as client:
        client.ask("angle")
        client.ask("angle")
        monkeypatch.setattr(workers, "LONGEST_S", 0.3)
        assert client.ask("slow").error == "timeout"
        assert client.ask("angle").payload == "0.5"
        arm[1].close()  # which waits for no code of users
        assert client.detach().recv(1) == b""


@pytest.mark.usefixtures("eager")
def test_replies_come_in_order_whatever_is_asked_between(served: ServedObject) -> None:
    with socket.socket(socket.AF_UNIX) as end:
        end.settimeout(BOUND_S)
        end.connect(served.socket)
        replies = end.makefile()
        for index in range(50):
            end.sendall(b"SET any %d\n" % index)
            assert replies.readline() == "=\n"
            # Whole lines, several at once, half ones, with an id, of what is computed.
            end.sendall(b"GET any\nGET double\nGE")
            end.sendall(b"T any\n#9 GET any\n")
            value = f"= {index}\n"
            assert [replies.readline() for _ in range(4)] == [value, _IDLE, value, f"#9 {value}"]
        replies.close()


def test_it_is_there_while_one_asks_and_gone_at_a_pause(
    served: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dedicated_worker, "PAUSE_S", 0.2)
    with connect_unix(served.socket, BOUND_S) as client:
        assert client.ask("speed").error == ""
        assert _workers() == 0
        _ask_on(client)
        _until(lambda: not _workers())
        client.listen("any?initial=0")
        _ask_on_while_listening(client)
        served.update("any", 12)
        event = client.event(BOUND_S)
        assert event is not None
        assert event.payload == "12"


def _ask_on_while_listening(client: LineClient) -> None:
    for _ in range(server_connection.IN_A_ROW * 2):
        assert client.ask("speed").error == ""
    assert _workers() == 0


def test_who_never_reads_is_left_and_told_all_later(served: ServedObject) -> None:
    with socket.socket(socket.AF_UNIX) as end, connect_unix(served.socket, BOUND_S) as other:
        end.settimeout(BOUND_S)
        end.connect(served.socket)
        text = "x" * 3000
        assert other.ask("notes", text).error == ""
        reply = f"= {text}\n".encode()
        _until(lambda: not _workers())
        replies = end.makefile("rb")
        while not _workers():
            end.sendall(b"GET notes\n")
            assert replies.readline() == reply
        for _ in range(200):  # more than there is room for
            end.sendall(b"GET notes\n")
        _until(lambda: not _workers())
        assert other.ask("speed").error == ""
        assert [replies.readline() for _ in range(200)] == [reply] * 200
        replies.close()


def test_those_for_whom_there_is_none_are_served_too(served: ServedObject) -> None:
    with ExitStack() as stack:
        clients = [
            stack.enter_context(connect_unix(served.socket, BOUND_S))
            for _ in range(dedicated_worker.MOST * 2)
        ]
        most = 0
        for index in range(server_connection.IN_A_ROW * 4):
            for client in clients:
                assert client.ask("any", str(index)).error == ""
                assert client.ask("any").payload == str(index)
            most = max(most, _workers())
        assert 1 <= most <= dedicated_worker.MOST


def test_who_hangs_up_is_forgotten(served: ServedObject) -> None:
    for _ in range(3):
        with connect_unix(served.socket, BOUND_S) as client:
            _ask_on(client)
        _until(lambda: not _workers())
    with connect_unix(served.socket, BOUND_S) as client:
        assert client.ask("speed").error == ""


@pytest.mark.usefixtures("eager")
def test_who_is_closed_while_attended_to_is_forgotten(served: ServedObject) -> None:
    with connect_unix(served.socket, BOUND_S) as client:
        _ask_on(client)
        host = served._host
        with host.lock:
            handlers = [each for each in host._handlers.values() if isinstance(each, Connection)]
            assert len(handlers) == 1
            handlers[0].close()
        with pytest.raises(Unreachable):
            client.ask("speed")
        _until(lambda: not _workers())
    with connect_unix(served.socket, BOUND_S) as client:
        _ask_on(client)


def test_the_end_of_the_service_is_heard(place: str, service: Service) -> None:
    with ExitStack() as stack:
        with serve(service, "robot", is_on_zenoh=False) as served:
            client = stack.enter_context(connect_unix(served.socket, BOUND_S))
            _ask_on(client)
        assert _workers() == 0
        assert client.detach().recv(1) == b""
