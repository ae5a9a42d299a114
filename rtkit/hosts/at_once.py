"""Does work for several hosts at the same time; questions to the user are asked one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from queue import SimpleQueue
from typing import NoReturn, TypeVar

from rtkit.errors import RtkitError
from rtkit.hosts import ssh_login
from rtkit.hosts.host import Host
from rtkit.link.threads import start_thread

T = TypeVar("T")


def at_once(
    hosts: Sequence[Host],
    work: Callable[[Host], T],
    asking: Callable[[], AbstractContextManager[object]] = nullcontext,
) -> Iterator[tuple[Host, T | RtkitError]]:
    """Yield the outcome of some work for each host, as soon as it is there.

    Who interrupts waits for none: the work is done on threads that end with the process, but for
    questions to the user, which the caller's thread asks, inside of `asking`.
    """
    events: SimpleQueue[Callable[[], tuple[Host, T | RtkitError] | None]] = SimpleQueue()
    pending = len(hosts)

    def ask(prompt: str) -> str:
        answers: SimpleQueue[str | BaseException] = SimpleQueue()

        def answer() -> None:
            try:
                with asking():
                    answers.put(ssh_login.ask(prompt))
            except EOFError as error:
                answers.put(error)

        events.put(answer)
        found = answers.get()
        if isinstance(found, BaseException):
            raise found
        return found

    def one(host: Host) -> None:
        outcome: T | RtkitError
        try:
            outcome = work(host)
        except RtkitError as error:
            outcome = error
        except BaseException as error:
            events.put(partial(_raise, error))
            return
        events.put(lambda: (host, outcome))

    with ssh_login.asked_by(ask):
        for host in hosts:
            start_thread(lambda host=host: one(host), host.name)  # type: ignore[misc]
        while pending:
            if (found := events.get()()) is not None:
                pending -= 1
                yield found


def _raise(error: BaseException) -> NoReturn:
    raise error
