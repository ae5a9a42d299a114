"""A service, asked without any door, answers as the table says."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from conformance import check_answers, check_events, subject

from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.service import Service
from rtkit.property.subscription import Listener


class Direct(Requester):
    """A door without a wire."""

    def __init__(self, service: Service) -> None:
        super().__init__("test")
        self.service = service
        self.listeners: list[Listener] = []

    def listen_to(self, target: str) -> Answer:
        name, mark, tail = target.partition("?")
        return self.ask(f"{name}.listen{mark}{tail}", "self")

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        answers: list[Answer] = []
        self.service.handle(PropertyRequest(target, payload, answers.append, self))
        (answer,) = answers
        return answer

    def listen(self, listener) -> None:  # type: ignore[no-untyped-def]
        self.listeners.append(listener)


class Client:
    """What a client of such a door sees."""

    def __init__(self, service: Service) -> None:
        self.service = service
        self.caller = Direct(service)
        self.ask = self.caller.ask

    @contextmanager
    def listen(self, target: str) -> Iterator[Iterator[PropertyEvent]]:
        caller = Direct(self.service)
        assert caller.listen_to(target) == Answer("")
        (listener,) = caller.listeners

        def events() -> Iterator[PropertyEvent]:
            while (event := listener.take(self.service.values.clock())) is not None:
                yield event

        yield events()
        self.service.listeners.end_caller(caller)


def test_every_request_is_answered_as_the_table_says() -> None:
    check_answers(Client(subject()))


def test_every_event_comes_as_the_table_says() -> None:
    service = subject()
    check_events(Client(service), service, lambda work: work())


def test_who_is_not_known_may_look_but_not_touch() -> None:
    service, denied = subject(), []
    service.on_refusal = lambda *told: denied.append(told)
    caller = Direct(service)
    caller.identity = ""
    assert caller.ask("count") == Answer("7")
    assert caller.ask("count", "1").error == "denied"
    assert caller.ask("properties", "((count 1))").error == "denied"
    assert caller.ask("count.listen").error == "denied"
    assert caller.ask("count") == Answer("7")
    assert denied == [("", "SET", "count")] * 3
