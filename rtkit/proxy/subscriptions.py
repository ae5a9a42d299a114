"""Subscriptions through a proxy: one at the owner serves all that have the same options.

The queue of each listener is here, so a slow one costs the length of its queue and delays no other.
A later listener first receives the last event of the others, once the owner has confirmed that it
is in force.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from rtkit.property.codes import PASSING, PropertyError
from rtkit.property.messages import DONE, Answer, PropertyEvent
from rtkit.property.naming import write_parameters
from rtkit.property.reading import read
from rtkit.property.requests import VIA, Requester
from rtkit.property.subscription import (
    LONGEST_LEASE_S,
    LONGEST_QUEUE,
    Listener,
    SubscriptionOptions,
)
from rtkit.property.values import is_number
from rtkit.wires.provider_connection import Answering, ProviderConnection

if TYPE_CHECKING:
    from rtkit.proxy.uplink import Uplink

_MOST_OF_CALLER = 1024
_ALIKE = {"queue", "initial", VIA}
"""Options with which all listeners get the same events, whenever they began."""
_AGAIN_S = 1.0
"""After which time the owner is asked anew that was there but could not say yes or no [s]."""


class RelayedOptions(NamedTuple):
    """Options of a subscription, as far as a proxy understands them.

    Attributes:
        text: Parameters that the owner is asked with.
        is_alike: Others may share the listening.
    """

    text: str
    queue: int
    lease_s: float
    has_initial: bool
    is_alike: bool


def relayed_options(parameters: dict[str, str | None]) -> RelayedOptions:
    """Read options; those that cannot be understood are left to the owner, which refuses them."""
    given = dict(parameters)
    lease = _number(given.get("lease"), 0.0)
    if 0 <= lease <= LONGEST_LEASE_S:
        given.pop("lease", None)
    else:
        lease = 0.0
    queue = int(_number(given.get("queue"), 1.0))
    initial = given.get("initial", "1")
    return RelayedOptions(
        write_parameters(given),
        max(1, min(queue, LONGEST_QUEUE)),
        lease,
        initial not in ("0", "false"),
        given.keys() <= _ALIKE,
    )


def _number(text: str | None, default: float) -> float:
    if text is None:
        return default
    try:
        value = read(text)
    except PropertyError:
        return -1.0
    return float(value) if is_number(value) and abs(value) < 1e300 else -1.0  # type: ignore[arg-type]


class RelayedListener(Listener):
    """Listener through the proxy: holds what the owner sent until it can be sent on."""

    __slots__ = ("text",)

    caller: Requester

    def __init__(self, name: str, options: RelayedOptions, caller: Requester, now: float) -> None:
        kept = SubscriptionOptions(queue=options.queue, is_all=True, lease_s=options.lease_s)
        super().__init__(name, (), kept, caller)
        self.text = options.text
        self.renew(now)


class RelayedSubscription:
    """Subscription at the owner, and the listeners here that it serves.

    Attributes:
        contact: At which the owner was asked; None while nothing is in force.
        has_begun: The owner has said yes.
        is_asked: The owner has not answered yet.
        again_at: From when on it may be asked anew [s, monotonic].
        last: Last value that the owner sent; an empty one if it went before it sent any.
    """

    def __init__(self, name: str, options: RelayedOptions) -> None:
        self.name = name
        self.options = options
        self.connection: ProviderConnection | None = None
        self.has_begun = False
        self.is_asked = False
        self.again_at = 0.0
        self.last: PropertyEvent | None = None
        self.relayed: list[RelayedListener] = []
        self.waiting: list[tuple[RelayedListener, Answering]] = []
        self.joining: list[RelayedListener] = []

    @property
    def is_used(self) -> bool:
        """Return whether anybody listens, or is about to."""
        return bool(self.relayed or self.waiting or self.joining)


class RelayedSubscriptions:
    """All subscriptions through one proxy.

    Args:
        outward: Gives the name by which events are known here.
        clock: Seconds of a clock that never goes back.
    """

    def __init__(
        self, uplink: Uplink, outward: Callable[[str], str], clock: Callable[[], float]
    ) -> None:
        self._uplink = uplink
        self._outward = outward
        self._clock = clock
        self._alike: dict[tuple[str, str], RelayedSubscription] = {}
        self._all: set[RelayedSubscription] = set()
        self._of: dict[Requester, dict[str, tuple[RelayedListener, RelayedSubscription]]] = {}

    # Asked for

    def begin(
        self, name: str, parameters: dict[str, str | None], caller: Requester, answer: Answering
    ) -> None:
        """Register a caller as listener; an existing one gets the new options and lease."""
        options = relayed_options(parameters)
        mine = self._of.get(caller, {})
        known = mine.get(name)
        if known is not None and known[0].text == options.text:
            known[0].options = known[0].options._replace(lease_s=options.lease_s)
            known[0].renew(self._clock())
            answer(DONE)
            return
        if len(mine) >= _MOST_OF_CALLER:
            answer(Answer(f"more than {_MOST_OF_CALLER} listeners", "denied"))
            return
        relayed = RelayedListener(name, options, caller, self._clock())
        listening = self._alike.get((name, options.text)) if options.is_alike else None
        if listening is None:
            listening = RelayedSubscription(name, options)
            self._all.add(listening)
            if options.is_alike:
                self._alike[name, options.text] = listening
            listening.waiting.append((relayed, answer))
            self._start(listening)
        elif not listening.has_begun:
            listening.waiting.append((relayed, answer))
            if not listening.is_asked:
                self._start(listening, is_again=True)
        else:
            self._join(listening, relayed, answer)

    def remove(self, name: str, caller: Requester, answer: Answering) -> None:
        """Take off a listener of a caller."""
        known = self._of.get(caller, {}).get(name)
        if known is None:
            answer(Answer(f"not listened to: {self._outward(name)}", "unknown"))
            return
        self._end(*known)
        answer(DONE)

    def forget(self, caller: Requester) -> None:
        """End the listening of a caller."""
        for relayed, listening in list(self._of.pop(caller, {}).values()):
            self._end(relayed, listening)
        for listening in list(self._all):
            listening.waiting = [each for each in listening.waiting if each[0].caller is not caller]
            listening.joining = [each for each in listening.joining if each.caller is not caller]
            self._leave_unused(listening)

    def tick(self) -> None:
        """End the leases that are over; ask anew for what has failed in passing."""
        now = self._clock()
        if self._uplink.is_up:
            self._go_on(now)
        over = [
            each
            for mine in self._of.values()
            for each in mine.values()
            if each[0].ends_at is not None and each[0].ends_at <= now
        ]
        for each in over:
            self._end(*each)

    # At the owner

    def _start(self, listening: RelayedSubscription, *, is_again: bool = False) -> None:
        listening.is_asked = True

        def placed(connection: ProviderConnection | PropertyError) -> None:
            if isinstance(connection, PropertyError):
                self._answered(listening, Answer(str(connection), connection.code))
                return
            listening.connection = connection
            connection.listen(
                listening.name,
                _with_initial(listening.options.text) if is_again else listening.options.text,
                lambda event: self._on_event(listening, connection, event),
                lambda reply: self._answered(listening, reply),
            )

        self._uplink.place(listening.name, placed)

    def _answered(self, listening: RelayedSubscription, reply: Answer) -> None:
        """Take the owner's answer to the request to listen."""
        listening.is_asked = False
        if listening not in self._all:
            return
        waiting, listening.waiting = listening.waiting, []
        if reply.error and listening.relayed and reply.error not in PASSING:
            self._finish(listening, reply.error)
        listening.has_begun = not reply.error
        if reply.error:
            listening.connection, listening.again_at = None, self._clock() + _AGAIN_S
        for relayed, answer in waiting:
            if not reply.error:
                self._attach(listening, relayed, answer)
            else:
                answer(reply)
        self._leave_unused(listening)

    def _join(
        self, listening: RelayedSubscription, relayed: RelayedListener, answer: Answering
    ) -> None:
        if not listening.options.has_initial or listening.last is None:
            self._attach(listening, relayed, answer)
            return

        def confirmed(reply: Answer) -> None:
            if relayed not in listening.joining:
                answer(Answer(f"no such property: {self._outward(listening.name)}", "unknown"))
                return
            listening.joining.remove(relayed)
            if reply.error:
                answer(reply)
                self._leave_unused(listening)
                return
            last = listening.last
            if last is not None and last.payload == reply.payload:
                relayed.push(last)
            # Else the event with the owner's answer is on its way.
            self._attach(listening, relayed, answer)

        listening.joining.append(relayed)
        self._uplink.ask(listening.name or "properties", None, "", confirmed)

    def _attach(
        self, listening: RelayedSubscription, relayed: RelayedListener, answer: Answering
    ) -> None:
        caller = relayed.caller
        try:
            caller.listen(relayed)
        except PropertyError as error:
            answer(Answer(str(error), error.code))
            return
        mine = self._of.setdefault(caller, {})
        before = mine.get(relayed.name)
        mine[relayed.name] = (relayed, listening)
        listening.relayed.append(relayed)
        if before is not None:
            self._drop(*before)
        answer(DONE)
        if relayed.pending:
            caller.wake()

    def _on_event(
        self, listening: RelayedSubscription, connection: ProviderConnection, event: PropertyEvent
    ) -> None:
        """Send on what the owner sent."""
        if listening not in self._all or listening.connection is not connection:
            return
        event = event._replace(name=self._outward(event.name))
        listening.last = event
        for relayed, _ in listening.waiting:
            relayed.push(event)
        for relayed in listening.relayed:
            relayed.push(event)
            relayed.caller.wake()
        if event.code:
            self._end_all(listening)

    # The connection

    def went(self) -> None:
        """Notify all listeners that their values are stale: the owner cannot be reached.

        Also those whose first value has not come: it may have been on its way when the owner went.
        """
        for listening in list(self._all):
            last = self._last_of(listening)
            if listening.connection is None and last.quality == "stale":
                continue  # it was sent before
            listening.connection, listening.has_begun = None, False
            listening.last = last._replace(quality="stale", dropped=0)
            for relayed in listening.relayed:
                relayed.push(listening.last)
                relayed.caller.wake()

    def _last_of(self, listening: RelayedSubscription) -> PropertyEvent:
        """Return the last event of the owner, an empty one as long as none has come."""
        return listening.last or PropertyEvent(self._outward(listening.name), "", 0.0, 0)

    def came(self) -> None:
        """Go on listening."""
        self._go_on(float("inf"))

    def _go_on(self, now: float) -> None:
        for listening in list(self._all):
            if (
                listening.connection is None
                and not listening.is_asked
                and listening.again_at <= now
            ):
                self._start(listening, is_again=True)

    # Ends

    def end(self, code: str) -> None:
        """Notify all listeners, with a code, that nothing further will come."""
        for listening in list(self._all):
            self._finish(listening, code)

    def _finish(self, listening: RelayedSubscription, code: str) -> None:
        """Notify that there is nothing to listen to any more."""
        at = self._last_of(listening)
        last = at._replace(payload="", quality="bad", dropped=0, code=code)
        for relayed in listening.relayed:
            relayed.push(last)
            relayed.caller.wake()
        self._end_all(listening)

    def _end_all(self, listening: RelayedSubscription) -> None:
        """Forget a listening that the owner has ended; queued events are still sent."""
        for relayed in listening.relayed:
            relayed.has_ended = True
            self._strike(relayed)
        listening.relayed, listening.joining = [], []
        self._leave_unused(listening)

    def _end(self, relayed: RelayedListener, listening: RelayedSubscription) -> None:
        self._strike(relayed)
        self._drop(relayed, listening)

    def _strike(self, relayed: RelayedListener) -> None:
        mine = self._of.get(relayed.caller)
        if mine is not None:
            mine.pop(relayed.name, None)
            if not mine:
                del self._of[relayed.caller]

    def _drop(self, relayed: RelayedListener, listening: RelayedSubscription) -> None:
        relayed.has_ended = True
        listening.relayed = [each for each in listening.relayed if each is not relayed]
        relayed.caller.unlisten(relayed)
        self._leave_unused(listening)

    def _leave_unused(self, listening: RelayedSubscription) -> None:
        if listening.is_used or listening not in self._all:
            return
        self._all.discard(listening)
        key = (listening.name, listening.options.text)
        if self._alike.get(key) is listening:
            del self._alike[key]
        if listening.connection is not None:
            listening.connection.leave(listening.name)


def _with_initial(text: str) -> str:
    """Return options that ask for the first value too: after a gap it is what was missed."""
    return "&".join(each for each in text.split("&") if not each.startswith("initial"))
