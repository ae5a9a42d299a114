"""Client of property services: asks, sets, calls and listens over lasting connections."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import inf
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any

from rtkit.api.asked import UNSET, Ask, RequestsAtOnce, Rounds
from rtkit.closing import Closing
from rtkit.errors import RtkitError
from rtkit.property.blocks import as_bytes, blocks_of, joined_blocks
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import to_value
from rtkit.property.limits import OF_REPLIES
from rtkit.property.messages import Answer, Payload
from rtkit.property.naming import parse_parameters, write_parameters
from rtkit.property.reading import read
from rtkit.property.requests import UNDER_WAY, VIA
from rtkit.property.values import Element, Value
from rtkit.property.writing import quoted, write
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.tree.property_connections import printed_error
from rtkit.wires.property_client import failure

if TYPE_CHECKING:
    from rtkit.api.listening import Changes, Listening
    from rtkit.api.owners import Owner
    from rtkit.api.property_change import PropertyChange

_LOOK_S = 0.5
"""How long the loop may take for a look at all connections, once answers are late."""


class Client(Closing):
    """Asks, sets and calls properties, wherever their owners are; safe for any thread.

    A target is ``SERVICE.NAME``, or the path of a component, manager or host with the name behind
    a dot, or an address (``rtkit help wires``), as ``rtget`` takes them. One connection for each
    owner is kept, and made anew after it broke. No manager is needed for served objects.

    Values are numbers, booleans, texts, tuples, bytes, markers, and other elements as `Element`.

    Example::

        with rtkit.Client() as client:
            client.set("light.level", 0.5)
            client.call("robot.behaviors.moveto", marker)

    Args:
        timeout_s: Bound on each request that states no other [s].
    """

    def __init__(self, timeout_s: float = 2.0) -> None:
        from rtkit.api.owners import Owners

        self.timeout_s = timeout_s
        self._host = PropertyEventLoop()
        self._owners = Owners(self._host, timeout_s)
        self._start_lock = threading.Lock()
        self._rounds = Rounds(self._make)
        self._changes: Changes | None = None
        self._is_started = self._is_closed = False

    def get(self, target: str, **parameters: Any) -> Any:
        """Return the value of a property.

        Args:
            target: The property.
            parameters: Of the request; a text is a value as it is written, else a string.

        Raises:
            PropertyError: It cannot be got; its code tells how: ``too-large`` of a list or element
                whose text is longer than 64 MiB.
        """
        return _object(self.payload(Ask(target, parameters=parameters), self.timeout_s))

    def set(self, target: str, value: Any = "", **parameters: Any) -> None:
        """Set a property; a text is read as ``rtset`` does. It is in force when this returns.

        Raises:
            PropertyError: It cannot be set, or is not in time; its code tells how: ``too-large``
                where the text of a value is longer than 1 MiB. For bytes see `set_bytes`.
        """
        self.payload(Ask(target, value, parameters), self.timeout_s)

    def get_bytes(self, target: str, **parameters: Any) -> bytes:
        """Return the bytes of a property as they are, whatever they look like; many in blocks.

        Raises:
            PropertyError: They cannot be got; its code tells how.
        """
        try:
            return self._raw(target, parameters)
        except PropertyError as error:
            if error.code != "too-large" or "length" in parameters:
                raise
        return joined_blocks(lambda block: self._raw(target, {**parameters, **block}))

    def _raw(self, target: str, parameters: Mapping[str, Any]) -> bytes:
        return as_bytes(self.payload(Ask(target, parameters=parameters), self.timeout_s))

    def set_bytes(self, target: str, data: bytes, **parameters: Any) -> None:
        """Set a property to bytes; many go in blocks, and are in force after the last of them.

        Raises:
            PropertyError: It cannot be set; its code tells how.
        """
        for place, block in blocks_of(data):
            self.set(target, block, **parameters, **place)

    def call(self, target: str, *args: Any, timeout_s: float | None = None, **named: Any) -> Any:
        """Call an action, and return its result once it has ended; of a behaviour how it stands.

        Args:
            target: The action; or a property that tells how a behaviour stands, such as that of
                a group: the end of what a SET of it starts is waited for.
            args: Its arguments by place.
            timeout_s: How long it may take [s]; None for no bound. It goes on when that is over.
            named: Its arguments by name.

        Raises:
            PropertyError: It is busy, or refuses its arguments; ``timeout``; or as it failed.
        """
        bound_s = inf if timeout_s is None else timeout_s
        until = monotonic() + bound_s
        value = write(tuple(map(_value, args))) if args else ""
        answer = _object(self.payload(Ask(target, value, {**named, "echo": 1}), bound_s))
        if isinstance(answer, Element) and answer.attributes.get("state") == "running":
            answer = self._ended(target.partition("?")[0], until)
        if not isinstance(answer, Element) or "state" not in answer.attributes:
            return answer
        parts = {each.name: each for each in answer.children}
        if "error" in parts:
            code = parts["error"].attributes.get("code", "internal")
            raise printed_error(target, PropertyError(code, str(parts["error"].leaf)))
        if answer.name != "call":
            return answer
        result = parts.get("result")
        return None if result is None else _content(result)

    def _ended(self, target: str, until: float) -> Any:
        """Return what a property tells once it runs no longer.

        Raises:
            PropertyError: ``timeout``: it runs still; its owner has gone.
        """
        changes: SimpleQueue[PropertyChange] = SimpleQueue()
        with self.listen(f"{target}.state", changes.put):
            while True:
                left_s = until - monotonic()
                try:
                    change = changes.get(timeout=max(0.0, left_s) if left_s < inf else None)
                except Empty:
                    error = PropertyError("timeout", "it runs still")
                    raise printed_error(target, error) from None
                if change.code:
                    raise printed_error(target, PropertyError(change.code, "its owner has gone"))
                if change.value != "running":
                    return self.get(target)

    def ask_all(
        self, asks: Sequence[Ask], deadline_s: float, *, is_shared: bool = False
    ) -> list[Any]:
        """Make requests of any number of owners at once; none waits for another owner.

        Args:
            asks: What is got or set.
            deadline_s: When to wait no longer, from now on [s]. In code that answers a request
                it is at most what that has left, but for a tenth of a second to answer in.
            is_shared: They are GETs without parameters, and what others ask so at once is asked
                for all of them, at most 0.1 s later than else; from then on the answers are
                waited for. None is older than this call.

        Returns:
            For each request the value (empty for what was set) or its `PropertyError`: ``timeout``
            of an owner that has not answered by then; None of one asked in turn that could only
            have asked who waits for it.

        Raises:
            PropertyError: ``conflict``: this answers a request that its asker made in turn itself.
        """
        via, until = UNDER_WAY.get()
        latest = inf
        # What was begun for a request, as a task of asyncio, may go on when that is long answered.
        if 0.0 < (left_s := until - (now := monotonic())) < inf:
            bound_s = max(0.0, round(left_s - min(0.1, left_s * 0.2), 3))
            latest, deadline_s = now + bound_s, min(deadline_s, bound_s)
        asks = [_in_turn(each, via) if each.in_turn else each for each in asks]
        return [
            answer if answer is None or isinstance(answer, PropertyError) else _object(answer)
            for answer in self._answers(asks, deadline_s, latest if is_shared else 0.0)
        ]

    def listen(
        self, target: str, callback: Callable[[PropertyChange], object], **parameters: Any
    ) -> Listening:
        """Have a function called with the present value of a property, then with each change.

        That is done on one thread of the client, which asks again after the owner has returned;
        meanwhile the change says ``no-service``. While a function takes its time, only the latest
        value waits.

        Args:
            target: The property.
            callback: Gets a `PropertyChange`; what it raises is reported on stderr.
            parameters: Of the listening: ``queue every deadband mode initial``.

        Returns:
            What to close in order to hear no more.

        Raises:
            PropertyError: It cannot be listened to; its code tells how.
        """
        return self._listen(target, callback, _object, parameters)

    def listen_payloads(
        self, target: str, callback: Callable[[PropertyChange], object], **parameters: Any
    ) -> Listening:
        """Listen as `listen` does, with the values of changes as they travel: texts and bytes.

        Raises:
            PropertyError: It cannot be listened to; its code tells how.
        """
        return self._listen(target, callback, lambda payload: payload, parameters)

    def _listen(
        self,
        target: str,
        callback: Callable[[PropertyChange], object],
        object_of: Callable[[Payload], object],
        parameters: Mapping[str, Any],
    ) -> Listening:
        from rtkit.api.listening import Changes, Listening

        self._start()
        path, _, tail = target.partition("?")
        changed = lambda event: object_of(event.payload)  # noqa: E731
        with self._start_lock:
            if self._changes is None:
                self._changes = Changes(self._host)
        listening = Listening(target, callback, changed, self._changes)
        given = parse_parameters(tail) if tail else {}
        given |= {key: _parameter(each) for key, each in parameters.items()}
        try:
            place, owner = self._owners.find(path)
            self._changes.begin(owner.connect, place.target(), given, listening)
        except RtkitError as error:
            raise printed_error(target, error) from error
        if not listening.is_answered.wait(self.timeout_s):
            listening.answered(Answer(f"no answer within {self.timeout_s:g} s", "timeout"))
        outcome = self._outcome(Ask(target), listening.answer or Answer(""))
        if isinstance(outcome, PropertyError):
            listening.close()
            raise outcome
        return listening

    def payload(self, ask: Ask, timeout_s: float) -> Payload:
        """Return what a request leads to, as it travels.

        Raises:
            PropertyError: It cannot be done; its code tells why.
        """
        answer = self._answers((ask,), timeout_s)[0]
        if isinstance(answer, PropertyError):
            raise answer
        assert answer is not None
        return answer

    def close(self) -> None:
        """End all connections; requests under way are answered ``no-service``."""
        with self._start_lock:
            self._is_closed = True
            changes, self._changes = self._changes, None
        with self._host.lock:
            if changes is not None:
                changes.close()
            self._owners.close()
        self._host.close()
        self._owners.join(monotonic() + self.timeout_s)

    # Requests

    def _answers(
        self, asks: Sequence[Ask], bound_s: float, latest: float = 0.0
    ) -> list[Payload | PropertyError | None]:
        """Return the answers that come in time; with a latest one, in a round that is shared."""
        if not asks:
            return []
        self._start()
        until = monotonic() + bound_s
        asked: RequestsAtOnce
        if latest:
            asked, places = shared = self._rounds.join(asks)
            until = min(shared[0].sent_at + bound_s, latest)
        else:
            asked, places = RequestsAtOnce(asks), list(range(len(asks)))
            owners = self._make(asked, until)
            if len(owners) == len(asks) == 1:
                owners[0].receive_here(asked.is_complete.is_set, until)
        if not asked.is_complete.wait(None if bound_s == inf else max(0.0, until - monotonic())):
            self._take_in()
        with self._host.lock:
            answers = [asked.answers.get(each) for each in places]
        late = Answer(f"no answer within {bound_s:g} s", "timeout")
        return [self._outcome(ask, each or late) for ask, each in zip(asks, answers, strict=True)]

    def _take_in(self) -> None:
        """Take in the answers that are here: nobody is late because this process is."""
        for _ in range(2):  # the first time the loop may have looked at its sockets already
            has_looked = threading.Event()
            self._host.post(has_looked.set)
            has_looked.wait(_LOOK_S)

    def _make(self, asked: RequestsAtOnce, until: float = inf) -> list[Owner]:
        """Make requests; what cannot be sent is answered. Return who was asked from here."""
        ready: list[tuple[Owner, str, Payload | None, Callable[[Answer], None]]] = []
        written: tuple[Any, Payload | None] = (UNSET, None)
        for place, ask in asked.asks.items():
            take: Callable[[Answer], None] = partial(asked.take, place)
            path = ask.target.partition("?")[0]
            if self._owners.is_far(path):
                # Whoever is behind an address is asked for the services there: nobody waits.
                arguments = (ask, path, take, until)
                threading.Thread(target=self._ask_far, args=arguments, daemon=True).start()
                continue
            try:
                if ask.value is not written[0]:  # of a fan-out all have the same
                    written = ask.value, None if ask.value is UNSET else _payload(ask.value)
                ready.append((*self._prepared(ask, path), written[1], take))
            except RtkitError as error:
                with self._host.lock:
                    take(failure(error))
        with self._host.lock:
            for owner, target, payload, answer in ready:
                owner.ask(target, payload, answer, until)
        return [each[0] for each in ready]

    def _start(self) -> None:
        if self._is_started and not self._is_closed:
            return
        with self._start_lock:
            if self._is_closed:
                raise PropertyError("no-service", "the client has been closed")
            if not self._is_started:
                self._is_started = True
                self._host.start()

    def _ask_far(self, ask: Ask, path: str, take: Callable[[Answer], None], until: float) -> None:
        try:
            owner, target = self._prepared(ask, path)
            payload = None if ask.value is UNSET else _payload(ask.value)
        except RtkitError as error:
            with self._host.lock:
                take(failure(error))
            return
        with self._host.lock:
            owner.ask(target, payload, take, until)

    def _prepared(self, ask: Ask, path: str) -> tuple[Owner, str]:
        place, owner = self._owners.find(path)
        owner.begin()
        _, mark, tail = ask.target.partition("?")
        if ask.parameters:
            given = {key: _parameter(each) for key, each in ask.parameters.items()}
            tail = "&".join(filter(None, (tail, write_parameters(given))))
        return owner, place.target(tail) if tail or not mark else f"{place.target()}?"

    def _outcome(self, ask: Ask, answer: Answer) -> Payload | PropertyError | None:
        if not answer.error:
            return answer.payload
        if ask.in_turn and str(answer.payload).startswith(PropertyError.CAME_BACK):
            return None
        if answer.error in ("no-service", "unknown"):
            self._owners.forget(ask.target.partition("?")[0])
        try:
            answer.value()
        except RtkitError as error:
            return printed_error(ask.target, error)
        raise AssertionError


def _in_turn(ask: Ask, via: tuple[str, ...]) -> Ask:
    """Return a request that tells who waits for its answer.

    Raises:
        PropertyError: ``conflict``: who makes it waits already.
    """
    own = f"-{ask.in_turn}"  # ids of proxies have no such mark
    if own in via:
        raise PropertyError("conflict", f"{PropertyError.CAME_BACK} who waits for the answer")
    return ask._replace(parameters={**ask.parameters, VIA: ".".join((*via, own))})


def _parameter(given: Any) -> str:
    if not isinstance(given, str):
        return write(_value(given))
    try:
        read(given)
    except PropertyError:
        return quoted(given)
    return given


def _value(given: Any) -> Value:
    value = to_value(given)
    if isinstance(value, bytes):
        raise PropertyError("bad-value", "bytes stand alone")
    return value


def _payload(given: Any) -> Payload:
    if isinstance(given, str | bytes):
        return given
    value = to_value(given)
    return value if isinstance(value, bytes) else write(value)


def _object(payload: Payload) -> Any:
    """Return the object that a payload stands for; what is no value is a text."""
    if isinstance(payload, bytes):
        return payload
    try:
        return _of_value(read(payload, OF_REPLIES))
    except PropertyError as error:
        if len(payload) > OF_REPLIES.text and payload[:1] in "(<":
            raise PropertyError("too-large", f"a value that is {error}: get its bytes") from None
        return payload


def _of_value(value: Value) -> Any:
    if isinstance(value, tuple):
        return value if {*map(type, value)} <= {float} else tuple(map(_of_value, value))
    if isinstance(value, Element) and value.name == "marker":
        from rtkit.property.marker import Marker

        try:
            return Marker.from_element(value)
        except PropertyError:
            return value  # of another make
    return str(value) if isinstance(value, str) else value


def _content(holder: Element) -> Any:
    """Return what an element holds."""
    if holder.children:
        found = tuple(map(_of_value, holder.children))
        return found[0] if len(found) == 1 else found
    return None if holder.leaf is None else _of_value(holder.leaf)
